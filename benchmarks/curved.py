"""Weaves of straight and curved strips at rest: ``python -m benchmarks.curved [MESH RIBBONS ...]``.

For each mesh and number of ribbons: how far the weave at rest is from its surface in the mean, in shares of
the diagonal, with straight, designed and optimal strips; how far the twin of the optimal strips is from the
weave, in the shape of the least energy found and in that found from the flat strips alone; what friction the
crossings need. Half a thickness is what the centrelines must keep from the
surface at every crossing. Without arguments: the surfaces of *3D Weaving with Curved Ribbons* (Ren et al.
2021) and the bunny. Those surfaces are not part of this repository: ``--meshes`` names the folder where
``bean.obj`` and ``teardrop.obj`` lie (github.com/EPFL-LGG/CurvedWeaving), and they are left out where they do
not. They are woven with ribbons as wide and thick as theirs, and as the spacing gives; the bunny with the
latter.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path
from time import process_time

import numpy as np

from geoweave.arrays import Scalars
from geoweave.fabrication import pattern_of
from geoweave.pipeline.source import MeshSource, prepared_surface
from geoweave.rods.curved_weave import StripKind, curved
from geoweave.rods.slid_weave import elastic_rods, slide
from geoweave.rods.weave_at_rest import Relaxed, relax
from geoweave.twin import assembled, begun_at
from geoweave.weave import Weave
from geoweave.weave.design import weave_pattern

PUBLISHED = {"bean": "straight 2.26 %, after their first stage 0.52 %, at the end 0.19 %"}
"""Mean distances that Ren et al. report."""

THEIRS = {"bean": (0.0333, 0.00233), "teardrop": (0.0333, 0.00233)}
"""Width and thickness of their ribbons in the unit of the mesh, as they are written for the bean."""

JOBS = [("bean", 14), ("bean", 16), ("teardrop", 12), ("teardrop", 18), ("bunny", 60), ("bunny", 100)]
"""Surfaces and how many ribbons are asked for; 14 and 12 give few crossings (DEVIATIONS.md, curved)."""

KINDS: tuple[StripKind, ...] = ("straight", "designed", "optimal")
"""Strips that are compared, each in a column."""

FACES, SIZE = 8_000, 300.0
"""Triangles of the surfaces when they are woven; size of the object in mm, for the twin."""

FASTENED = 0.1
"""Share of the crossings that may be fastened before friction is judged."""


def friction_of_the_rest(friction: Scalars) -> float:
    """What 90 % of the crossings hold with, after the tenth in greatest need is fastened."""
    kept = np.sort(friction)[: len(friction) - int(FASTENED * len(friction))]
    return float(np.percentile(kept, 90, method="lower")) if len(kept) else 0.0


def woven(mesh: str, ribbons: int) -> Weave:
    """Weave a mesh once."""
    prepared = prepared_surface(MeshSource(mesh, faces=FACES), {}, lambda text: None)
    return weave_pattern(prepared.mesh, ribbons=ribbons)


def measure(name: str, weave: Weave, size: tuple[float, float] | None, kinds: tuple[StripKind, ...]) -> dict:
    """Let a weave come to rest with strips of each kind, and put the optimal strips together again."""
    if size is not None:
        weave = weave.sized(width=size[0], thickness=size[1])
    weave = weave.sized(SIZE)
    clock = process_time()
    slid = slide(elastic_rods(weave))
    seconds, rest = process_time() - clock, dict[str, Relaxed]()
    for kind in kinds:
        clock = process_time()
        rest[kind] = relax(curved(slid, kind))
        if kind == "optimal":
            seconds += process_time() - clock
    row = {
        "model": name,
        "ribbons": len(weave.ribbons),
        "crossings": len(slid.cut.contacts),
        "width %": 100 * weave.width / (diagonal := rest["optimal"].departure.diagonal),
        **{f"{kind} %": 100 * rest[kind].departure.to_surface.mean for kind in kinds},
        "optimal, largest %": 100 * rest["optimal"].departure.to_surface.largest,
        "half a thickness %": 50 * weave.thickness / diagonal,
    }
    document = rest["optimal"].document()
    alone = assembled(pattern_of(document))
    lower = begun_at(alone, document) or alone
    row["twin %"] = 100 * lower.compared(document).hausdorff
    row["twin begun from strips alone %"] = 100 * alone.compared(document).hausdorff
    said = rest["optimal"].metrics()["curved_strips"]
    row |= {
        "curvature x width": said["sharpest"],
        "converged": "yes" if said["converged"] else "no",
        "friction p90, a tenth fastened": friction_of_the_rest(rest["optimal"].forces.friction),
        "seconds": seconds,
    }
    return {key: float(f"{value:.4g}") if isinstance(value, float) else value for key, value in row.items()}


def found(meshes: Path) -> list[tuple[str, int]]:
    """The jobs whose surfaces are there; says which are not."""
    jobs = []
    for name, ribbons in JOBS:
        path = meshes / f"{name}.obj"
        if name in THEIRS and not path.is_file():
            print(f"{name}: left out; {path} is not there, see the head of benchmarks/curved.py")
        else:
            jobs.append((str(path) if name in THEIRS else name, ribbons))
    return jobs


def main() -> None:
    """Print the rows, and write them to a file if one is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("jobs", nargs="*", help="a mesh, its number of ribbons, ...")
    parser.add_argument("--meshes", type=Path, default=Path(), help="where bean.obj and teardrop.obj lie")
    parser.add_argument("--csv", type=Path, help="where the table goes; its rows of other weaves stay")
    given = parser.parse_args()
    jobs = list(zip(given.jobs[::2], map(int, given.jobs[1::2]), strict=True)) or found(given.meshes)
    for mesh, ribbons in jobs:
        name = Path(mesh).stem
        weave = woven(mesh, ribbons)
        for size in [THEIRS[name], None] if name in THEIRS else [None]:
            row = measure(name, weave, size, KINDS)
            print("  ".join(f"{key} {value}" for key, value in row.items()), flush=True)
            if given.csv:
                written(given.csv, row)
        if name in PUBLISHED:
            print(f"{name}: Ren et al. (2021), mean: {PUBLISHED[name]}")


def written(path: Path, row: dict) -> None:
    """Put a row into a table, in place of one of the same weave."""
    rows = list(csv.DictReader(path.open(encoding="utf-8"))) if path.is_file() else []
    same = [str(row[key]) for key in ("model", "ribbons", "width %")]
    rows = [each for each in rows if [each[key] for key in ("model", "ribbons", "width %")] != same]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, row, lineterminator="\n")
        writer.writeheader()
        writer.writerows([*rows, row])


if __name__ == "__main__":
    main()
