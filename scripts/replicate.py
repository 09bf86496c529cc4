"""Reproduce the sphere of Fig. 7 and say whether the numbers are the committed ones (scripts/replicate.sh).

    python scripts/replicate.py

Executes notebooks/fig07_sphere.ipynb, which asserts the claims of the paper, into build/replicate/, and
compares its table with figures/fig07_sphere.csv. Nothing else in the checkout is changed.
"""

from __future__ import annotations

import csv
import os
import shutil
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from geoweave.artifact import doctor, notebooks
from geoweave.artifact.execution import Children, execute, interrupt_once
from geoweave.artifact.progress import Progress
from geoweave.errors import GeoweaveError

ROOT = Path(__file__).resolve().parent.parent
NAME = "fig07_sphere"
CLOSE, SMALL = 0.03, 0.01
"""Numbers agree to within this share of them, or this much."""

ANY_OF_MANY = {"Pottmann et al.": 0.6}
"""Rows that start from one of several equally smooth fields, which one depends on the last bit, and the share
to within which they agree."""

WORDS = {
    "angle": "degrees from great circles",
    "curvature": "geodesic curvature",
    "vorticity": "vorticity",
    "singularities": "singularities",
    "total curl": "total curl",
}
"""What the columns of the table are."""

Table = Sequence[Mapping[str, str]]


def table(path: Path) -> Table:
    """The rows of a table that a notebook published."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def differences(committed: Table, here: Table) -> list[str]:
    """Sentences on what differs, [] if the tables agree: the same rows, and numbers to within `CLOSE`."""
    names = [[row["method"] for row in rows] for rows in (committed, here)]
    if names[0] != names[1] or [list(row) for row in committed] != [list(row) for row in here]:
        return [f"the table has other rows or columns: {', '.join(names[1])}"]
    found = []
    for one, other in zip(committed, here, strict=True):
        share = ANY_OF_MANY.get(one["method"], CLOSE)
        for column in WORDS:
            a, b = float(one[column]), float(other[column])
            # not <=, so that nan differs from everything
            if not abs(a - b) <= max(share * abs(a), SMALL):
                found.append(f"{one['method']}: {WORDS[column]} {b:g}, committed {a:g}")
    return found


def side_by_side(committed: Table, here: Table) -> list[str]:
    """Lines of a table, one number a line, committed and here; no two cells touch, however long they are."""
    rows = [("field", "what", "committed", "here")]
    for one, other in zip(committed, here, strict=False):
        for column, words in WORDS.items():
            numbers = (f"{float(table_row[column]):.4g}" for table_row in (one, other))
            rows.append((other["method"], words, *numbers))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            cell.ljust(width) if place < 2 else cell.rjust(width)
            for place, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in rows
    ]


def main() -> int:
    """Execute, compare, and say PASS (status 0) or FAIL (status 1)."""
    interrupt_once()
    target = ROOT / "build" / "replicate"
    target.parent.mkdir(exist_ok=True)
    print("Fig. 7 of 'Weaving Geodesic Foliations': four vector fields on the sphere.", flush=True)
    print("Only the fields of the paper follow great circles and have no vortices.", flush=True)
    work = Path(tempfile.mkdtemp(prefix="running-", dir=target.parent))
    try:
        doctor.require_rendering()
        cells = len(notebooks.code_cells(notebooks.read(notebooks.path_of(ROOT, NAME))))
        with Progress(1) as progress:
            progress.start(NAME, cells)
            outcome = execute(
                ROOT, NAME, "default", work, Children(), lambda done: progress.advance(NAME, done)
            )
        shutil.rmtree(target, ignore_errors=True)
        os.replace(work, target)
    except GeoweaveError as error:
        print(f"FAIL: {error}")
        return 1
    except KeyboardInterrupt:
        print("FAIL: interrupted")
        return 1
    finally:
        shutil.rmtree(work, ignore_errors=True)
    if outcome.problem:
        print(f"FAIL: the notebook stopped: {outcome.problem} (see {target / 'executed.ipynb'})")
        return 1
    committed, here = (table(folder / f"{NAME}.csv") for folder in (ROOT / "figures", target / "figures"))
    print("\n".join(side_by_side(committed, here)))
    print(f"The picture:  {target / 'figures' / f'{NAME}.png'}")
    print(f"The notebook: {target / 'executed.ipynb'}")
    wrong = differences(committed, here)
    for sentence in wrong:
        print(f"differs: {sentence}")
    print(f"{'FAIL' if wrong else 'PASS'}: {len(wrong) or 'no'} number(s) differ; {outcome.seconds:.0f} s")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
