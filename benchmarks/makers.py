"""Do the strips that are cut make the weave that was designed? Six models, from the files a maker has.

    python -m benchmarks.makers [NAME]...

Each model is woven as by ``geoweave weave NAME --size 300 --ribbons N --formats json,pattern``, in a process
of its own. What the table says is read from the files: ``weave.json`` for the design, ``pattern.json`` for
the strips, ``report.json`` for the verdict. What breaks a rule is said below the table, and the exit status
is then 1. The table is written to build/bench/makers.md.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from itertools import pairwise
from operator import itemgetter
from pathlib import Path
from time import process_time
from typing import Any

from benchmarks.memory import peak_gigabytes
from geoweave.fabrication import Pattern, pattern_of
from geoweave.models import catalogue
from geoweave.pipeline import MeshSource, WeaveRequest, weave_file
from geoweave.twin import openings_of, surface_of

TABLE = Path("build/bench/makers.md")

SIZE = 300.0
"""Longest side of every object, mm."""

MODELS = {"cone": 10, "torus": 12, "bunny": 80, "spot": 80, "armadillo": 80, "camel": 80}
"""How many ribbons each model is woven of."""

HEAD = (
    "| model | ribbons | crossings | alternation: design | report | strips | other order | "
    "holes | openings | strips of | verdict | CPU s | GB |"
)


def met_by_ribbons(crossings: list[dict[str, Any]], pairs: str, at: str, over: str) -> dict[int, list[str]]:
    """The crossings along each ribbon: number of the crossing, and whether the ribbon lies above there.

    Parameters
    ----------
    crossings : of a ``weave.json`` or a ``pattern.json``
    pairs, at, over : names of their entries for the two ribbons, the places on them, and which lies above
    """
    along: dict[int, list[tuple[float, str]]] = {}
    for each in crossings:
        for side in (0, 1):
            said = f"{each['id']} {'over' if each[over] == side else 'under'}"
            along.setdefault(each[pairs][side], []).append((each[at][side], said))
    # Both ends of a loop may meet a ribbon in one place; then the order is that of the numbers.
    return {ribbon: [said for _, said in sorted(found, key=itemgetter(0))] for ribbon, found in along.items()}


def alternation(met: dict[int, list[str]], closed: list[bool]) -> float:
    """Share of the crossings next to each other on a ribbon between which the ribbon changes sides."""
    changes = steps = 0
    for ribbon, along in met.items():
        follow = list(pairwise(along))
        if closed[ribbon] and len(along) > 1:
            follow.append((along[-1], along[0]))
        steps += len(follow)
        changes += sum(one.split()[1] != other.split()[1] for one, other in follow)
    return changes / steps if steps else 1.0


def reordered(designed: dict[int, list[str]], strips: dict[int, list[str]], closed: list[bool]) -> int:
    """How many strips meet the others in another order, or otherwise above and below, than in the design.

    A closed strip may begin at another crossing than its ribbon.
    """

    def alike(ribbon: int) -> bool:
        one, other = designed[ribbon], strips.get(ribbon, [])
        starts = range(len(one)) if closed[ribbon] else range(1)
        return any(one[k:] + one[:k] == other for k in starts)

    return sum(not alike(ribbon) for ribbon in designed)


def measure(name: str) -> dict[str, Any]:
    """Weave one model into a folder, and compare the files."""
    start = process_time()
    request = WeaveRequest(ribbons=MODELS[name], size=SIZE, formats=("json", "pattern"))
    with tempfile.TemporaryDirectory() as folder:
        mesh = written(name, Path(folder))
        weave_file(MeshSource(mesh), f"{folder}/woven", request)
        design, pattern, report = (
            json.loads(Path(folder, "woven", f"{file}.json").read_text(encoding="utf-8"))
            for file in ("weave", "pattern", "report")
        )
    closed = [ribbon["closed"] for ribbon in design["ribbons"]]
    designed = met_by_ribbons(design["crossings"], "ribbons", "arclength", "over_index")
    strips = met_by_ribbons(pattern["crossings"], "strips", "at", "over")
    wanted, made = openings_of(pattern_of(design)), surface_of(Pattern.from_document(pattern))
    return {
        "name": name,
        "ribbons": len(closed),
        "crossings": len(pattern["crossings"]),
        "alternation": {
            "design": alternation(designed, closed),
            "report": report["strips"]["alternation"],
            "strips": alternation(strips, closed),
        },
        "reordered": reordered(designed, strips, closed),
        "genus": [design["surface"]["genus"], made.genus],
        "openings": [wanted, made.openings],
        "of": report["strips"]["of"],
        "verdict": report["verdict"],
        "differs": list(report["strips"]["differs"]),
        "cpu": process_time() - start,
        "memory_gb": peak_gigabytes(),
    }


def written(name: str, folder: Path) -> str:
    """The name of a data set, or the path of a file with a surface that we build."""
    from geoweave.meshing import write_mesh

    build = catalogue.MODELS[name].build
    if build is None:
        return name
    path = folder / f"{name}.obj"
    write_mesh(build(), path)
    return str(path)


def broken(row: dict[str, Any]) -> list[str]:
    """What is not as it must be in a row, in words."""
    found = []
    said = row["alternation"]
    if max(said.values()) - min(said.values()) > 1e-9:
        found.append(f"alternation is {said}")
    if row["reordered"]:
        found.append(f"{row['reordered']} strips meet the others in another order than in the design")
    closes = row["genus"][0] == row["genus"][1] and row["openings"][0] == row["openings"][1]
    if not closes and row["verdict"]["word"] != "do not cut this":
        found.append(f"the strips close otherwise than the design, and the verdict is {row['verdict']}")
    return [f"{row['name']}: {sentence}" for sentence in found]


def line(row: dict[str, Any]) -> str:
    """One line of the table."""
    said = row["alternation"]
    cells = [row["name"], str(row["ribbons"]), f"{row['crossings']:,}"]
    cells += [f"{said[of]:.1%}" for of in ("design", "report", "strips")]
    cells += [str(row["reordered"])]
    cells += [f"{one} / {other}" for one, other in (row["genus"], row["openings"])]
    verdict = "; ".join([row["verdict"]["word"], *row["verdict"]["reasons"]])
    cells += [row["of"], verdict, f"{row['cpu']:.0f}", f"{row['memory_gb']:.1f}"]
    return "| " + " | ".join(cells) + " |"


def table(names: list[str] | None = None) -> list[str]:
    """Weave the models, print the table and keep it; return what breaks a rule."""
    print(f"\nObjects {SIZE:.0f} mm long, as designed / as their strips make them.\n")
    lines = [HEAD, "|---|" + "---:|" * 8 + "---|---|---:|---:|"]
    print("\n".join(lines), flush=True)
    faults = []
    for name in names or MODELS:
        command = [sys.executable, "-m", "benchmarks.makers", "--one", name]
        row = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)
        lines.append(line(row))
        print(lines[-1], flush=True)
        faults += broken(row)
    lines += ["", *faults]
    print("\n".join(faults))
    TABLE.parent.mkdir(parents=True, exist_ok=True)
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return faults


def main() -> int:
    """Weave the models named, or all of them."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.makers")
    parser.add_argument("--one", metavar="NAME", choices=[*MODELS], help="weave this one, print JSON")
    parser.add_argument("names", metavar="NAME", nargs="*", help="only these")
    options = parser.parse_args()
    unknown = set(options.names) - set(MODELS)
    if unknown:
        parser.error(f"no such model: {', '.join(sorted(unknown))}")
    if options.one:
        print(json.dumps(measure(options.one)))
        return 0
    return int(bool(table(options.names or None)))


if __name__ == "__main__":
    raise SystemExit(main())
