"""The last lines of every notebook: its neighbours, its place in the paper, where we differ, the claims.

They are written, not typed, so that a new notebook or a moved row of DEVIATIONS.md leaves no dead link.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

import nbformat

from geoweave.artifact import notebooks
from geoweave.artifact.notebooks import NotebookError
from geoweave.files import replacing, text_job

__all__ = ["PAPER", "anchor", "deviations", "links", "write_links"]

CELL = "links"
"""Identifier of the cell."""

PAPER = "https://doi.org/10.1145/3306346.3323043"
"""Where the paper is."""


def anchor(heading: str) -> str:
    """The place that GitHub gives to a heading, without the hash sign.

    Examples
    --------
    >>> from geoweave.artifact.notebook_links import anchor
    >>> anchor("What we tried: the schedule")
    'what-we-tried-the-schedule'
    """
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


def deviations(root: Path) -> dict[str, str]:
    """Under which heading each row of DEVIATIONS.md stands, by the row's name."""
    found: dict[str, str] = {}
    heading = ""
    for line in (root / "DEVIATIONS.md").read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            heading = line.lstrip("#").strip()
        elif row := re.match(r"\| ([a-z][\w-]*) \|", line):
            found.setdefault(row[1], heading)
    return found


def links(root: Path, name: str) -> str:
    """Markdown of the last cell of a notebook.

    Raises
    ------
    NotebookError
        If ``notebooks/index.toml`` does not say where in the paper the notebook belongs, or names a row that
        DEVIATIONS.md does not have.
    """
    words: dict[str, Any] = tomllib.loads((root / "notebooks" / "index.toml").read_text(encoding="utf-8"))
    section = words.get("sections", {}).get(name)
    if section is None:
        raise NotebookError(f"notebooks/index.toml: [sections] does not have {name}; add it")
    every = notebooks.names(root)
    at = every.index(name)
    ways = []
    for label, other in (("Before", every[at - 1] if at else ""), ("Next", "".join(every[at + 1 : at + 2]))):
        if other:
            title = notebooks.heading(notebooks.read(notebooks.path_of(root, other))).replace("]", "")
            ways.append(f"{label}: [{title.replace('[', '')}]({other}.ipynb).")
    known = deviations(root)
    rows: dict[str, list[str]] = {}
    for row in words.get("deviations", {}).get(name, []):
        if row not in known:
            raise NotebookError(f"notebooks/index.toml: DEVIATIONS.md has no row {row}, which {name} names")
        rows.setdefault(known[row], []).append(f"`{row}`")
    parts = [
        f"{', '.join(each)} under [{heading}](../DEVIATIONS.md#{anchor(heading)})"
        for heading, each in rows.items()
    ]
    differ = "; ".join(parts) or "no row of [DEVIATIONS.md](../DEVIATIONS.md) is about this"
    return (
        f"**Where next.** {' '.join(ways)} All of them: [reading order](README.md).\n\n"
        f"**In the paper.** [Section {section}]({PAPER}). Where we differ: {differ}. Its claims: "
        "[claim by claim](../docs/results.md#claim-by-claim)."
    )


def write_links(root: Path) -> list[str]:
    """Bring the last cell of every notebook up to date; return the names of those that changed.

    A checkout without ``notebooks/index.toml`` does not say where its notebooks belong: it is left as it is.
    """
    changed: list[str] = []
    if not (root / "notebooks" / "index.toml").is_file():
        return changed
    for name in notebooks.names(root):
        path = notebooks.path_of(root, name)
        notebook = notebooks.read(path)
        text = links(root, name)
        if notebook.cells[-1].id == CELL and notebook.cells[-1].source == text:
            continue
        notebook.cells = [cell for cell in notebook.cells if cell.id != CELL]
        notebook.cells.append(nbformat.v4.new_markdown_cell(text, id=CELL))
        with replacing(path) as temporary:
            text_job(nbformat.writes(notebook) + "\n")(temporary)
        changed.append(name)
    return changed
