"""What cannot be made, refused with the number that would work."""

from __future__ import annotations

import math

from geoweave.errors import FieldError
from geoweave.fabrication.nesting import Stock
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.pieces import Making, cut_length

__all__ = ["WALL", "check_made"]

WALL = 0.5
"""A hole leaves so much of the strip on either side, mm, or the thickness of the strip if that is more."""


NARROWEST = 0.5
"""Narrower strips are not cut, mm."""


def check_made(pattern: Pattern, making: Making, stock: Stock) -> None:
    """Refuse strips too narrow, holes that cut a strip in two, sheets too narrow, and rolls too short.

    Raises
    ------
    FieldError
        With the number that would work.
    """
    if pattern.width < NARROWEST:
        times = math.ceil(NARROWEST / pattern.width)
        raise FieldError(
            f"strips {pattern.width:.2g} mm wide cannot be cut; make the object {times} times as large, or "
            f"its ribbons {NARROWEST:g} mm wide or more"
        )
    _check_holes(pattern, making)
    tall = pattern.width + making.kerf
    if tall > stock.height - 2 * stock.margin:
        needed = math.ceil(tall + 2 * stock.margin)
        widest = stock.height - 2 * stock.margin - making.kerf
        also = f", or strips of {math.floor(10 * widest) / 10:g} mm" if widest > 0.1 else ""
        raise FieldError(
            f"strips {pattern.width:.4g} mm wide do not fit on a sheet of {stock.height:g} mm with "
            f"margins of {stock.margin:g} mm; take a sheet of {needed} mm or more{also}"
        )
    if stock.roll:
        lengths = [cut_length(pattern, making, r) + making.kerf for r in range(len(pattern.strips))]
        longest = max(range(len(lengths)), key=lambda r: lengths[r])
        needed = math.ceil(lengths[longest] + 2 * stock.margin)
        if lengths[longest] > stock.room:
            raise FieldError(
                f"strip {pattern.strips[longest].label} is {lengths[longest]:.6g} mm long and the roll "
                f"leaves {stock.room:.6g} mm; take a roll of {needed} mm or "
                "more, or a sheet, on which long strips are made of pieces"
            )


def _check_holes(pattern: Pattern, making: Making) -> None:
    if not making.holes:
        return
    if making.holes <= making.kerf:
        raise FieldError(
            f"a hole of {making.holes:g} mm is not wider than the kerf of {making.kerf:g} mm; take one of "
            f"{making.kerf + 0.1:g} mm or more"
        )
    wall = max(WALL, pattern.thickness)
    widest = math.floor(100 * (pattern.width - 2 * wall) + 1e-6) / 100
    if making.holes > widest:
        if widest <= making.kerf:
            needed = making.holes + 2 * wall
            raise FieldError(
                f"strips {pattern.width:.4g} mm wide have no room for holes of {making.holes:g} mm; make "
                f"them {needed:.4g} mm wide or more"
            )
        raise FieldError(
            f"holes of {making.holes:g} mm leave less than {wall:g} mm on either side of strips "
            f"{pattern.width:.4g} mm wide; take holes of {widest:g} mm or less, or strips of "
            f"{making.holes + 2 * wall:.4g} mm or more"
        )
