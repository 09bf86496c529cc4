"""What a sweep says of each mesh, and the table of them all."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from geoweave.files import printable
from geoweave.wording import counted

__all__ = ["COLUMNS", "TABLES", "Row", "table_texts"]

TABLES = ("table.csv", "table.md")
"""Names of the files that the table is written to."""


@dataclass(frozen=True)
class Row:
    """What became of one mesh of a sweep.

    Attributes
    ----------
    mesh : as it was asked for
    folder : name of its folder
    state : "done" (woven now), "kept" (there already) or "failed"
    problem : for a failure, one sentence
    result : what ``geoweave weave --json`` says of it, {} for a failure
    fault : the traceback, where the failure is a fault of ours
    """

    mesh: str
    folder: str
    state: str
    problem: str = ""
    result: Mapping[str, Any] | None = None
    fault: str = ""

    def sentence(self) -> str:
        """What the progress display says of it."""
        if self.result is None:
            return f"failed: {self.problem}"
        done = self.result
        if self.state == "kept":
            return f"{counted(done['ribbons'], 'ribbon')}, kept: mesh, options and version are the same"
        return (
            f"{counted(done['ribbons'], 'ribbon')}, {counted(done['crossings'], 'crossing')}, in "
            f"{done['seconds']['total']:.0f} s"
        )


COLUMNS: dict[str, Callable[[Mapping[str, Any]], Any]] = {
    "faces": lambda r: r["faces"],
    "genus": lambda r: r["genus"],
    "boundary loops": lambda r: r["boundary_loops"],
    "branch points": lambda r: r["branch_points"],
    "ribbons": lambda r: r["ribbons"],
    "crossings": lambda r: r["crossings"],
    "length": lambda r: f"{r['total_length']:.6g}",
    "units": lambda r: r["units"],
    "median angle": lambda r: f"{r['crossing_angle_deg']['median']:.1f}",
    "5 % angle": lambda r: f"{r['crossing_angle_deg']['p05']:.1f}",
    "alternation": lambda r: f"{r['alternation']['fraction']:.4f}",
    "at most": lambda r: f"{r['alternation']['optimal_fraction_bound']:.4f}",
    "piled": lambda r: f"{r['regularity']['piled']:.4f}",
    "bare": lambda r: f"{r['regularity']['bare']:.4f}",
    "loose ends": lambda r: r["loose_ends"],
    "broken rules": lambda r: r["violations"],
    "farthest at rest": lambda r: "" if r["relax"] is None else f"{r['relax']['hausdorff_held']:.4f}",
    "at rest": lambda r: "" if r["relax"] is None else ("yes" if r["relax"]["converged"] else "no"),
}
"""Columns of the table after mesh and folder, and what each says of a result; ``problem`` is the last."""


def table_texts(rows: Sequence[Row]) -> dict[str, str]:
    """The contents of the two tables, without times: the same meshes and options give the same bytes."""
    head = ["mesh", "folder", *COLUMNS, "problem"]
    cells = [
        [
            printable(row.mesh),
            printable(row.folder),
            *(("" if row.result is None else str(say(row.result))) for say in COLUMNS.values()),
            printable(row.problem),
        ]
        for row in rows
    ]
    plain = io.StringIO()
    writer = csv.writer(plain, lineterminator="\n")
    writer.writerows([head, *cells])
    ruled = [head, ["---"] * 2 + ["---:"] * len(COLUMNS) + ["---"], *cells]
    lines = ["| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in ruled]
    return {"table.csv": plain.getvalue(), "table.md": "\n".join(lines) + "\n"}
