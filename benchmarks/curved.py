"""Weaves of straight and curved strips at rest: ``python -m benchmarks.curved MESH RIBBONS [...]``.

For each mesh and number of ribbons: how far the weave at rest is from its surface, in shares of the diagonal,
with straight, designed and optimal strips, and how far the twin from the flat strips alone is from the weave.
Half a thickness is what the centrelines must keep from the surface at every crossing. The surfaces of
*3D Weaving with Curved Ribbons* (Ren et al. 2021) are not part of this repository; beside a mesh called
``bean`` their figures are shown, which are for ribbons 0.0333 wide and 0.00233 thick. ``--width`` and
``--thickness`` give those of the ribbons, in the unit of the mesh; by default they follow the spacing.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path
from time import perf_counter

from geoweave.fabrication import pattern_of
from geoweave.pipeline.source import MeshSource, prepared_surface
from geoweave.rods.curved_weave import STRIPS
from geoweave.rods.weave_at_rest import relaxed_weave
from geoweave.twin import assembled
from geoweave.weave.design import weave_pattern

PUBLISHED = {"bean": "straight 2.26 %, after their first stage 0.52 %, at the end 0.19 %"}
"""Mean distances that Ren et al. report."""

FACES = 8_000


def measure(mesh: str, ribbons: int, width: float | None, thickness: float | None) -> list[dict]:
    """Weave a mesh once, let it come to rest with strips of each kind, and put the strips together again."""
    prepared = prepared_surface(MeshSource(mesh, faces=FACES), {}, lambda text: None)
    weave = weave_pattern(prepared.mesh, ribbons=ribbons)
    if width is not None or thickness is not None:
        weave = weave.sized(width=width, thickness=thickness)
    rows = []
    for strips in STRIPS[:3]:
        clock = perf_counter()
        found = relaxed_weave(weave, strips=strips)
        seconds = perf_counter() - clock
        far, said = found.departure.to_surface, found.metrics().get("curved_strips", {})
        document = found.document()
        back = assembled(pattern_of(document)).compared(document)
        rows.append(
            {
                "model": Path(mesh).stem,
                "ribbons": len(weave.ribbons),
                "strips": strips,
                "mean %": round(100 * far.mean, 4),
                "rms %": round(100 * far.rms, 4),
                "largest %": round(100 * far.largest, 3),
                "half a thickness %": round(50 * weave.thickness / found.departure.diagonal, 4),
                "curvature x width": round(said.get("sharpest", 0.0), 3),
                "converged": said.get("converged", found.converged),
                "twin mean %": round(100 * back.ribbons.mean, 3),
                "twin hausdorff %": round(100 * back.hausdorff, 3),
                "seconds": round(seconds, 1),
            }
        )
        print("  ".join(f"{name} {value}" for name, value in rows[-1].items()), flush=True)
    return rows


def main() -> None:
    """Print the rows, and write them to a file if one is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("jobs", nargs="*", default=["bunny", "60"], help="a mesh, its number of ribbons, ...")
    parser.add_argument("--width", type=float)
    parser.add_argument("--thickness", type=float)
    parser.add_argument("--csv")
    given = parser.parse_args()
    rows: list[dict] = []
    for mesh, ribbons in zip(given.jobs[::2], given.jobs[1::2], strict=True):
        rows += measure(mesh, int(ribbons), given.width, given.thickness)
        if Path(mesh).stem in PUBLISHED:
            print(f"{Path(mesh).stem}: Ren et al. (2021), mean: {PUBLISHED[Path(mesh).stem]}")
    if given.csv:
        with open(given.csv, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0])
            writer.writeheader()
            writer.writerows(rows)


if __name__ == "__main__":
    main()
