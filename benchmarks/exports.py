"""Whether what is exported comes back: four objects, three presets, measured on the lines of the SVG.

    python -m benchmarks.exports [--only NAME...] [--keep]

A lampshade with a hoop at both openings, a cone, a torus and a bunny, 300 mm long, are woven and relaxed with
strips as thick as the material of each of three presets, and cut with it. The twin is made of the lines of
``pattern.svg`` alone, on all its sheets, and compared with the weave at rest that the strips are of. A row of
``benchmarks/exports.csv`` says how far the crossings are off, in shares of the diagonal, and whether the
object comes back; besides, how large the files are, how long ``cut`` computes for SVG and PDF, set beside
numpy's start on the same machine, and how far the hands go from step to step of the assembly. Weaves are kept
in build/bench/exports and made anew unless ``--keep`` is given. The bunny takes minutes.
"""

from __future__ import annotations

import argparse
import csv
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from geoweave.checkout import PACKAGE
from geoweave.errors import FieldError
from geoweave.fabrication import preset_of
from geoweave.meshing import write_mesh
from geoweave.models import shapes
from geoweave.pipeline import (
    CutRequest,
    MeshSource,
    WeaveRequest,
    cut_folder,
    earlier_report,
    twin_file,
    weave_file,
)
from geoweave.surface import TriMesh

PRESETS = ("polypropylene-laser", "bristol-a4", "plotter-roll")

TABLE = Path(__file__).with_suffix(".csv")

FOLDER = PACKAGE.parent / "build" / "bench" / "exports"

SIZE, HOOP = 300.0, 24.0
"""Longest side of every object, and what strips keep beyond the middle of a hoop, mm."""

SECONDS, DXF = 3.0, 3e6
"""Goals for the bunny: seconds of ``cut`` for SVG and PDF, and bytes of the DXF."""


def lampshade() -> TriMesh:
    """A cone cut off at both ends: radius 90 above, 150 below, 220 high, as the cases of a maker have it."""
    tube = shapes.cylinder(radius=1.0, height=1.0, faces=4_000)
    height = tube.vertices[:, 2] - tube.vertices[:, 2].min()
    radius = 150.0 - 60.0 * height
    flat = tube.vertices[:, :2] * radius[:, None]
    return TriMesh(np.column_stack([flat, 220.0 * height]), tube.faces)


MODELS: dict[str, tuple[Callable[[], TriMesh] | None, int, float]] = {
    "lampshade": (lampshade, 24, HOOP),
    "cone": (lambda: shapes.cone(faces=3_000), 20, 0.0),
    "torus": (lambda: shapes.torus(faces=4_000), 24, 0.0),
    "bunny": (None, 80, 0.0),
}
"""Surface (None: the data set of that name), number of ribbons, and what strips keep beyond a hoop."""


def woven(name: str, thickness: float, keep: bool) -> Path:
    """The folder of a weave at rest with strips of a thickness in mm, as docs/making.md advises."""
    folder = FOLDER / f"{name}-{thickness:g}mm"
    if keep and (folder / "relaxed.json").exists():
        return folder
    folder.mkdir(parents=True, exist_ok=True)
    build, ribbons, _ = MODELS[name]
    source = name
    if build is not None:
        source = str(FOLDER / f"{name}.obj")
        write_mesh(build(), source)
    wish = WeaveRequest(ribbons=ribbons, size=SIZE, thickness=thickness, formats=("json",))
    weave_file(MeshSource(source), folder, wish)
    return folder


def started(code: str, *words: str) -> float:
    """Seconds that a Python computes from its start to its end."""
    import resource

    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", code, *words], check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def row(name: str, preset: str, keep: bool) -> dict[str, Any]:
    """One object, cut with one preset."""
    thickness, hoops = preset_of(preset).thickness, MODELS[name][2]
    folder = woven(name, thickness, keep)
    wish = CutRequest(preset=preset, hoops=hoops, formats=("svg", "dxf", "pdf"))
    made = cut_folder(folder, FOLDER / f"{name}-{preset}", wish)
    sizes = {
        end: sum(p.stat().st_size for p in made.files.values() if p.suffix == end) for end in (".svg", ".dxf")
    }
    words = ["cut", str(folder), "--preset", preset, "--formats", "svg,pdf", "-o", str(FOLDER / "timed")]
    cutting = min(
        started("import sys; from geoweave.cli import main; main.main(sys.argv[1:])", *words) for _ in (0, 1)
    )
    numpys = min(started("import numpy") for _ in range(3))
    found: dict[str, Any] = {
        "object": name,
        "preset": preset,
        "thickness": thickness,
        "strips_of": made.cut.source,
        "strips": len(made.layout.pattern.strips),
        "crossings": len(made.layout.pattern.at),
        "svg_kB": round(sizes[".svg"] / 1e3),
        "dxf_kB": round(sizes[".dxf"] / 1e3),
        "cut_seconds": round(cutting, 2),
        "numpy_starts": round(cutting / numpys, 1),
        "mean_step_mm": earlier_report(made.files["report.json"].parent)["assembly"]["mean_step"],
    }
    drawing = min(path for path in made.files.values() if path.suffix == ".svg")
    clock = time.process_time()
    try:
        twin = twin_file(drawing)
    except FieldError as error:
        return found | {"comes_back": False, "reason": str(error).split(": ", 1)[-1]}
    far = next(iter(twin.likeness.values())).crossings
    return found | {
        "comes_back": not twin.reasons,
        "mean": round(far.mean, 5),
        "largest": round(far.largest, 5),
        "twin_seconds": round(time.process_time() - clock, 1),
        "reason": "; ".join(twin.reasons),
    }


COLUMNS = (
    *(
        "object",
        "preset",
        "thickness",
        "strips_of",
        "strips",
        "crossings",
        "svg_kB",
        "dxf_kB",
        "cut_seconds",
        "numpy_starts",
    ),
    *("mean_step_mm", "comes_back", "mean", "largest", "twin_seconds", "reason"),
)
"""Of the table."""


def written(rows: list[dict[str, Any]]) -> None:
    """Write the table; rows of objects that were not asked for stay."""
    fresh = {each["object"] for each in rows}
    before: list[dict[str, Any]] = []
    if TABLE.exists():
        with TABLE.open(encoding="utf-8", newline="") as file:
            before = [each for each in csv.DictReader(file) if each["object"] not in fresh]
    order = list(MODELS)
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, COLUMNS, restval="", lineterminator="\n")
        table.writeheader()
        table.writerows(sorted([*before, *rows], key=lambda each: order.index(each["object"])))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="*", choices=MODELS, default=list(MODELS))
    parser.add_argument("--keep", action="store_true", help="use the weaves of an earlier run")
    options = parser.parse_args()
    rows = []
    for name in options.only:
        made: set[float] = set()
        for preset in PRESETS:
            thickness = preset_of(preset).thickness
            rows.append(row(name, preset, options.keep or thickness in made))
            made.add(thickness)
            print(rows[-1], flush=True)
            written(rows)
    bunny = [each for each in rows if each["object"] == "bunny"]
    missed = [each for each in rows if not each["comes_back"]]
    missed += [each for each in bunny if each["dxf_kB"] > DXF / 1e3 or each["cut_seconds"] > SECONDS]
    raise SystemExit(int(bool(missed)))


if __name__ == "__main__":
    main()
