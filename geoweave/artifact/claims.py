"""What the paper claims, what checks it, and the table of claims in docs/results.md.

``tests/claims/claims.toml`` holds one ``[[claim]]`` for each measurable sentence of the paper::

    [[claim]]
    id = "sphere-great-circles"
    section = "4.1.2"
    says = "on the sphere ours follows great circles"
    test = ["tests/claims/test_x.py::test_name", "notebooks/fig07_sphere.ipynb"]
    paper = "expected great circles"       # a number or a few words, optional
    figure = "paper/fig07_sphere"          # a table under figures/, with the next two, optional
    where = { method = "ours" }            # the rows that count, all if left out
    ours = "{angle:.1f}° off"              # filled from each of those rows

Our numbers are never written in this file. They are read from the tables that the notebooks publish, so the
page cannot keep an old number.
"""

from __future__ import annotations

import csv
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geoweave.errors import GeoweaveError

__all__ = ["Claim", "ClaimError", "ours", "read", "table"]

LIST = Path("tests") / "claims" / "claims.toml"
"""Where the claims stand, from the root of a checkout."""

PLACE = re.compile(r"\{([^{}:]+)(?::([^{}]*))?\}")
"""A place in the words for our number: the column, and how its value is formatted."""


class ClaimError(GeoweaveError):
    """An entry of the list of claims cannot be read, or names something that does not exist."""


@dataclass(frozen=True)
class Claim:
    """One measurable sentence of the paper.

    Attributes
    ----------
    id : a short name
    section : section of the paper, with the figure or equation if the claim is made there
    says : the claim, in our words
    tests : what checks the claim, ``file::function`` or the path of a notebook, from the root of the checkout
    paper : the paper's number or wording, "" if there is none to compare
    ours : words for our numbers, with fields such as ``{angle:.1f}``, "" if there are none
    figure : the table under ``figures/`` that fills the fields, without file extension
    where : columns and values that choose rows of the table
    """

    id: str
    section: str
    says: str
    tests: tuple[str, ...]
    paper: str = ""
    ours: str = ""
    figure: str = ""
    where: tuple[tuple[str, str], ...] = ()


def read(root: Path) -> tuple[Claim, ...]:
    """Read the claims of a checkout, in their order.

    Raises
    ------
    ClaimError
        If the list cannot be read, or an entry lacks a key, has an unknown key or repeats an id.
    """
    path = root / LIST
    try:
        entries = tomllib.loads(path.read_text(encoding="utf-8"))["claim"]
    except (OSError, KeyError, tomllib.TOMLDecodeError) as error:
        raise ClaimError(f"{LIST.as_posix()} holds no list of claims ({error})") from error
    claims = tuple(_claim(entry, number) for number, entry in enumerate(entries))
    ids = [claim.id for claim in claims]
    for name in ids:
        if ids.count(name) > 1:
            raise ClaimError(f"two claims are called '{name}'")
    return claims


def _claim(entry: Mapping[str, Any], number: int) -> Claim:
    known = {"id", "section", "says", "test", "paper", "ours", "figure", "where"}
    name = entry.get("id", f"number {number}")
    for key in ("id", "section", "says", "test"):
        if not entry.get(key):
            raise ClaimError(f"claim '{name}' has no '{key}'")
    if set(entry) - known:
        raise ClaimError(f"claim '{name}' has a '{min(set(entry) - known)}', which means nothing")
    if bool(entry.get("ours")) != bool(entry.get("figure")):
        raise ClaimError(f"claim '{name}' needs both 'ours' and 'figure', or neither")
    tests = entry["test"]
    return Claim(
        id=entry["id"],
        section=entry["section"],
        says=entry["says"],
        tests=(tests,) if isinstance(tests, str) else tuple(tests),
        paper=entry.get("paper", ""),
        ours=entry.get("ours", ""),
        figure=entry.get("figure", ""),
        where=tuple((key, str(value)) for key, value in entry.get("where", {}).items()),
    )


def ours(root: Path, claim: Claim) -> str:
    """Fill in our numbers from the figure's table. Several rows are joined by commas.

    Raises
    ------
    ClaimError
        If the table, a column or a row does not exist, or a value is not a number where one is needed.
    """
    if not claim.figure:
        return ""
    path = root / "figures" / f"{claim.figure}.csv"
    if not path.is_file():
        raise ClaimError(f"claim '{claim.id}' reads figures/{claim.figure}.csv, which is not there")
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    wanted = {column for column, _ in claim.where} | {place[0] for place in PLACE.findall(claim.ours)}
    missing = wanted - set(rows[0] if rows else ())
    if missing:
        raise ClaimError(f"claim '{claim.id}' reads a column '{min(missing)}', which {path.name} has not")
    chosen = [row for row in rows if all(row[column] == value for column, value in claim.where)]
    if not chosen:
        raise ClaimError(f"claim '{claim.id}' reads a row {dict(claim.where)}, which {path.name} has not")
    return ", ".join(_filled(claim, row) for row in chosen)


def _filled(claim: Claim, row: Mapping[str, str]) -> str:
    return PLACE.sub(lambda place: _value(claim, row, place), claim.ours)


def _value(claim: Claim, row: Mapping[str, str], place: re.Match[str]) -> str:
    column, form = place[1], place[2]
    if not form:
        return row[column]
    try:
        return format(float(row[column]), form)
    except ValueError as error:
        raise ClaimError(f"claim '{claim.id}': '{row[column]}' in '{column}' is no number") from error


def table(root: Path) -> list[str]:
    """Lines of Markdown for docs/results.md: every claim, with the paper's number and ours if it has one.

    Raises
    ------
    ClaimError
        As for `read` and `ours`.
    """
    claims = read(root)
    lines = [
        f"All {len(claims)} claims, as they stand with their tests in [{LIST.name}](../{LIST.as_posix()}).",
        "",
        "| section | claim | paper | here | checked by |",
        "|---|---|---|---|---|",
    ]
    for claim in claims:
        files = dict.fromkeys(test.partition("::")[0] for test in claim.tests)
        links = ", ".join(f"[{Path(file).stem}](../{file})" for file in files)
        cells = (claim.section, claim.says, claim.paper, ours(root, claim), links)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return lines
