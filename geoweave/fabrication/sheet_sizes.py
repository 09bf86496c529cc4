"""Sheets, rolls and papers by the names that makers give them."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

from geoweave.errors import FieldError
from geoweave.fabrication.nesting import Stock

__all__ = ["PAPERS", "Paper", "paper_of", "stock_of"]

INCH = 25.4


class Paper(NamedTuple):
    """A page, laid on its long side, mm."""

    name: str
    width: float
    height: float


PAPERS = {
    "a4": Paper("A4", 297.0, 210.0),
    "letter": Paper("US Letter", 279.4, 215.9),
    "a3": Paper("A3", 420.0, 297.0),
    "tabloid": Paper("Tabloid", 431.8, 279.4),
}
"""The papers there are (ISO 216, ANSI/ASME Y14.1)."""

SIZES = re.compile(r"(?P<width>\d+(\.\d+)?)\s*[x×]\s*(?P<height>\d+(\.\d+)?)\s*(?P<unit>mm|cm|in)?")
ROLL = re.compile(r"roll:(?P<width>\d+(\.\d+)?)(\s*[x×]\s*(?P<length>\d+(\.\d+)?))?\s*(?P<unit>mm|cm|in)?")
UNITS = {None: 1.0, "mm": 1.0, "cm": 10.0, "in": INCH}


def paper_of(name: str) -> Paper:
    """The paper of a name.

    Raises
    ------
    FieldError
        If there is none.
    """
    if name.lower() not in PAPERS:
        raise FieldError(f"there is no paper '{name}'; the papers are {', '.join(PAPERS)}")
    return PAPERS[name.lower()]


def stock_of(sheet: str | None, margin: float = 5.0, gap: float = 2.0) -> Stock:
    """Sheets by their name or size.

    Parameters
    ----------
    sheet : such as ``"600x400"`` (mm), ``"30x60cm"``, ``"12x24in"``, ``"a4"``, ``"a3"``, ``"letter"``,
        ``"tabloid"``; or ``"roll:610"``, a roll of that width with strips along it, ``"roll:22x50000"`` one
        of that length. A sheet is laid on its long side, as strips are long. None is one long sheet
    margin, gap : left free along the edges, and between strips, mm

    Raises
    ------
    FieldError
        If it is no such size.

    Examples
    --------
    >>> round(gw.fabrication.stock_of("12x24in", margin=0.0).room, 6)  # mm that a strip may be long
    609.6
    >>> gw.fabrication.stock_of("roll:610").height
    610.0
    """
    if sheet is None:
        return Stock(margin=margin, gap=gap)
    text = sheet.strip().lower()
    if text in PAPERS:
        return Stock(PAPERS[text].width, PAPERS[text].height, margin, gap)
    if found := ROLL.fullmatch(text):
        unit, length = UNITS[found["unit"]], found["length"]
        long = math.inf if length is None else unit * float(length)
        return Stock(long, unit * float(found["width"]), margin, gap, roll=True)
    if found := SIZES.fullmatch(text):
        unit = UNITS[found["unit"]]
        one, other = unit * float(found["width"]), unit * float(found["height"])
        return Stock(max(one, other), min(one, other), margin, gap)
    raise FieldError(
        f"a sheet is WIDTHxHEIGHT in mm such as 600x400, in cm or inches such as 12x24in, roll:WIDTH, or one "
        f"of {', '.join(PAPERS)}; not '{sheet}'"
    )
