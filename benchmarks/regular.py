"""How regular are the weaves of one click, and of a number of ribbons that a maker asks for?

    python -m benchmarks.regular [--scans] [--rods FILE]... [--free] [NAME]...

Each model is woven with no parameter, some once more with a number of ribbons, in a process of its own; the
limits are those that the regular weave was planned with. What a row misses is said in its last cell. All
rows together, or those of all scans, are also written to the table beside this module, which is committed
and read by the notebook beyond1_phase. With
``--free`` each row is followed by that of the same weave whose families do not know of each other's phase.
``--scans`` weaves twenty scans from packages in place of the models (see benchmarks/scans.py). ``--rods``
adds weaves that others shared as elastic rods: what needs their surface is left empty there. The table is
written to build/bench/regular.md.
"""

from __future__ import annotations

import argparse
import csv
import json
import subprocess
import sys
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

import numpy as np

from benchmarks import scans
from geoweave.errors import GeoweaveError
from geoweave.meshing import evened
from geoweave.rods import read_rods
from geoweave.weave import inspected, violations, weave_pattern
from geoweave.weave.regularity import crossing_density, near_ideal, phase_order, piled

TABLE = Path("build/bench/regular.md")

KEPT = Path(__file__).with_name("regular.csv")
"""The committed table of all models; that of the scans lies beside it."""


STRAIGHT = 0.02
"""Mean curvature of straight ribbons, in bounding radii: a degree on the length of one.

The lines of a perfect icosahedron have 0.001, what rounding and the mesh leave; no ratio to it says anything.
"""


class Limits(NamedTuple):
    """What a row of the table must reach."""

    piled: float = 0.10
    bare: float = 0.005
    near_ideal: float = 0.97
    alternation: float | None = 0.985
    curvature: float = 1.2
    fewest_crossings: int | None = 4
    parts: int | None = 1


MADE = Limits(
    piled=0.20, near_ideal=0.92, curvature=1.35, alternation=None, fewest_crossings=None, parts=None
)
"""For weaves of so many ribbons as a maker makes."""


class Row(NamedTuple):
    """A model, and what is asked of its weave."""

    name: str
    ribbons: int | None
    curvature: float
    """Mean of today: with free phases and the clean-up of the paper, in bounding radii."""
    limits: Limits


ROWS = (
    Row("bunny", None, 0.444, Limits()),
    Row("spot", None, 0.366, Limits()),
    Row("armadillo", None, 0.830, Limits(piled=0.15, near_ideal=0.93)),
    Row("camel", None, 0.675, Limits()),
    Row("torus", None, 0.242, Limits()),
    Row("vessel", None, 0.373, Limits()),
    Row("icosahedron", None, 0.001, Limits()),
    Row("fertility", None, 0.417, Limits(near_ideal=0.95)),
    Row("rocker-arm", None, 0.449, Limits(piled=0.15, near_ideal=0.95)),
    Row("cow", None, 0.428, Limits(piled=0.15)),
    Row("bunny", 60, 0.448, MADE),
    Row("spot", 60, 0.390, MADE),
    Row("camel", 60, 0.704, MADE),
    Row("vessel", 60, 0.388, MADE),
    Row("torus", 20, 0.312, MADE),
)
"""The curvatures were measured before the phase was coupled and the clean-up mended (commit 1bb6a3a)."""

SCANS = (
    "blobby_3cc", "bones", "bull", "cactus", "couplingdown", "dino", "double-torus-3-holes", "eight",
    "elephant", "femur", "hand", "head", "homer", "knot1", "knot2", "lion-head", "man", "nefertiti", "pig",
    "retinal",
)  # fmt: skip
"""Twenty scans of `benchmarks.scans`; none was looked at when a number was chosen."""

MEDIANS = {"piled": 0.08, "bare": 0.003}
"""What the medians over the scans must reach."""


def measure(name: str, ribbons: int | None, free: bool) -> dict:
    """Weave one surface and measure how regular it is."""
    start = perf_counter()
    try:
        mesh = evened(scans.surface(name), ribbons=ribbons, name=name).mesh
        weave = weave_pattern(mesh, ribbons=ribbons, **({"phase": "free"} if free else {}))
    except GeoweaveError as error:
        return {"name": name, "asked": ribbons, "free": free, "problem": f"{type(error).__name__}: {error}"}
    woven, metrics = perf_counter() - start, weave.metrics()
    found = inspected(weave)
    return {
        "name": name,
        "asked": ribbons,
        "free": free,
        "ribbons": len(weave.ribbons),
        "crossings": len(weave.ribbons.crossings),
        **found.regularity.document(),
        "alternation": weave.interlacing.alternation,
        "curvature": metrics["geodesic_curvature"]["mean"] * weave.placement.scale,
        "knots": found.counts["knot"],
        "broken": violations(weave.ribbons, weave.interlacing.over),
        "woven": woven,
    }


def of_rods(path: str) -> dict:
    """What can be said of a weave that is given as elastic rods, without its surface."""
    content = read_rods(path)
    passages = content.placed()
    lengths = np.array([rod.lengths.sum() for rod in content.rods])
    points, angles = [], []
    for one in content.crossings:
        ways = []
        for rod, segment in zip(one.rods, one.segments, strict=True):
            line = content.rods[rod].centerline
            a, step = line[segment], line[(segment + 1) % len(line)] - line[segment]
            ways.append(step / np.linalg.norm(step))
        points.append(a + one.places[-1] * step)
        angles.append(np.degrees(np.arccos(min(abs(float(ways[0] @ ways[1])), 1.0))))
    number = np.bincount(passages.ribbons.ravel(), minlength=len(lengths))
    # The spacing at which three even families cross as often as these.
    spacing = 0.5 * crossing_density(3) * lengths.sum() / len(passages)
    # These surfaces have no walls thinner than a spacing, so no normal keeps crossings apart.
    heap = piled(np.array(points), np.ones((len(points), 3)), float(spacing))
    return {
        "name": Path(path).name,
        "asked": None,
        "ribbons": len(lengths),
        "crossings": len(passages),
        "piled": float(heap.mean()),
        "phase_order": phase_order(passages, lengths),
        "near_ideal": float(near_ideal(np.array(angles), 3).mean()),
        "fewest_crossings": int(number.min()),
        "few_crossings": int((number < 4).sum()),
    }


def missed(row: dict, limits: Limits, today: float) -> list[str]:
    """The limits that a row does not reach."""
    found = [name for name in ("piled", "bare") if row[name] > getattr(limits, name)]
    found += ["angles"] if row["near_ideal"] < limits.near_ideal else []
    if limits.alternation is not None and row["alternation"] < limits.alternation:
        found.append("alternation")
    if limits.fewest_crossings is not None and row["fewest_crossings"] < limits.fewest_crossings:
        found.append("short ribbons")
    if limits.parts is not None and row["parts"] > limits.parts:
        found.append("parts")
    if today > 0 and row["curvature"] > max(limits.curvature * today, STRAIGHT):
        found.append("curvature")
    return found + (["valid"] if row["broken"] else [])


COLUMNS = {
    "ribbons": "{:,}",
    "crossings": "{:,}",
    "piled": "{:.1%}",
    "phase_order": "{:.2f}",
    "bare": "{:.2%}",
    "parts": "{}",
    "fewest_crossings": "{}",
    "near_ideal": "{:.1%}",
    "alternation": "{:.1%}",
    "interleaved": "{:.1%}",
    "triangles": "{:.0%}",
    "hexagons": "{:.0%}",
    "spacing_spread": "{:.2f}",
    "knots": "{}",
    "curvature": "{:.3f}",
    "times": "{:.2f}",
    "woven": "{:.0f}",
}
"""What is printed of a row, and how."""

HEAD = (
    "| weave | ribbons | crossings | piled | order | bare | parts | fewest crossings | 60 ± 20 | "
    "alternation | interleaved | triangles | hexagons | spread | knots | curvature | of today's | s "
    "| misses |"
)


def line(row: dict, misses: list[str]) -> str:
    """One line of the table."""
    name = row["name"] + (f", {row['asked']}" if row["asked"] else "") + (", free" if row.get("free") else "")
    if "problem" in row:
        return "| " + " | ".join([name, *[""] * len(COLUMNS), row["problem"]]) + " |"
    cells = [form.format(row[key]) if row.get(key) is not None else "" for key, form in COLUMNS.items()]
    return "| " + " | ".join([name, *cells, ", ".join(misses)]) + " |"


def kept(rows: list[dict], path: Path) -> None:
    """Write rows as they are committed: names, and numbers to four digits."""
    names = ["name", "asked", *(each for each in COLUMNS if each != "woven")]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*names, "misses"])
        for row in rows:
            values = [row.get(each) for each in names]
            rounded = [round(each, 4) if isinstance(each, float) else each for each in values]
            writer.writerow([*("" if each is None else each for each in rounded), " ".join(row["misses"])])


def woven(row: Row, free: bool = False) -> dict:
    """Weave in a process of its own."""
    command = [sys.executable, "-m", "benchmarks.regular", "--one", json.dumps([row.name, row.ribbons, free])]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)


def table(rows: list[Row], rods: list[str], *, free: bool, medians: bool, whole: bool) -> bool:
    """Weave all rows, print the table and keep it, committed if whole; whether every limit was reached."""
    lines = [HEAD, "|---|" + "---:|" * len(COLUMNS) + "---|"]
    print("\n".join(lines), flush=True)
    made, good = [], True
    for row in rows:
        for unaware in (False, True) if free else (False,):
            found = woven(row, unaware)
            if row.curvature > 0 and "curvature" in found:
                found["times"] = found["curvature"] / row.curvature
            # Only the medians of scans are asked for, and that each is valid.
            limits = Limits(1.0, 1.0, 0.0, 0.0, np.inf, 0, None) if medians else row.limits
            misses = [] if unaware or "problem" in found else missed(found, limits, row.curvature)
            good &= not misses and (unaware or "problem" not in found)
            lines.append(line(found, misses))
            print(lines[-1], flush=True)
            if not unaware and "problem" not in found:
                made.append(found | {"misses": misses})
    if whole:
        kept(made, KEPT.with_stem("regular_scans") if medians else KEPT)
    if medians and made:
        middle = {key: float(np.median([each[key] for each in made])) for key in MEDIANS}
        good &= all(middle[key] <= limit for key, limit in MEDIANS.items())
        said = (f"{key} {middle[key]:.2%} (at most {limit:.1%})" for key, limit in MEDIANS.items())
        lines += ["", f"Medians of {len(made)}: {', '.join(said)}"]
        print("\n".join(lines[-2:]))
    for path in rods:
        lines.insert(2 + len(rows) * (2 if free else 1), line(of_rods(path), []))
        print(lines[2 + len(rows) * (2 if free else 1)])
    TABLE.parent.mkdir(parents=True, exist_ok=True)
    name = TABLE.with_stem("regular_scans") if medians else TABLE
    name.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return good


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.regular")
    parser.add_argument("--one", metavar="ROW", help="weave this one here and print the row as JSON")
    parser.add_argument("--scans", action="store_true", help="twenty scans in place of the models")
    parser.add_argument("--rods", metavar="FILE", action="append", default=[], help="a weave of elastic rods")
    parser.add_argument("--free", action="store_true", help="and each weave with free phases")
    parser.add_argument("names", metavar="NAME", nargs="*", help="only these")
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure(*json.loads(options.one))))
        return 0
    if options.scans:
        scans.fetched()
    rows = [Row(name, None, 0.0, Limits()) for name in SCANS] if options.scans else [*ROWS]
    here = set(scans.BUILT) | {name for name in scans.datasets.names() if scans.datasets.available(name)}
    rows = [row for row in rows if options.scans or row.name in here]
    if options.names:
        rows = [row for row in rows if row.name in options.names]
    if not rows:
        raise SystemExit(f"no such row here: {', '.join(options.names)}")
    whole = len(rows) == len(SCANS if options.scans else ROWS)
    return int(not table(rows, options.rods, free=options.free, medians=options.scans, whole=whole))


if __name__ == "__main__":
    raise SystemExit(main())
