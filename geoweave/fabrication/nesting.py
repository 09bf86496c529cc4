"""Pieces laid out on sheets: rows of strips, the longest first."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from geoweave.errors import FieldError
from geoweave.fabrication.strip_figures import Drawn, Figure

__all__ = ["Laid", "Sheet", "Stock", "nested"]


@dataclass(frozen=True)
class Stock:
    """The sheets that strips are cut from, mm.

    Attributes
    ----------
    width, height : of a sheet. Without a height there is one sheet, as high as needed. If the width is
        missing too, it is as wide as the longest strip
    margin : left free along the edges
    gap : between neighbouring strips

    Raises
    ------
    FieldError
        If a number is out of range.
    """

    width: float = math.inf
    height: float = math.inf
    margin: float = 5.0
    gap: float = 2.0

    def __post_init__(self) -> None:
        for name in ("margin", "gap"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise FieldError(f"the {name} of a sheet must be 0 mm or more, not {value}")
        for name in ("width", "height"):
            value = getattr(self, name)
            if not value > 2 * self.margin:
                raise FieldError(
                    f"a sheet {value} mm in {name} has no room between margins of {self.margin:g} mm"
                )

    @property
    def room(self) -> float:
        """Length that a strip may have."""
        return self.width - 2 * self.margin


class Laid(NamedTuple):
    """A piece on a sheet."""

    drawn: Drawn
    x: float
    """Where its start is, mm from the left edge of the sheet."""
    y: float
    """Where its middle is, mm from the lower edge."""

    @property
    def figures(self) -> tuple[Figure, ...]:
        """What is drawn, where it lies on the sheet."""
        return tuple(figure.moved(self.x, self.y) for figure in self.drawn.figures)


class Sheet(NamedTuple):
    """A sheet and what is cut from it."""

    width: float
    height: float
    laid: tuple[Laid, ...]


def nested(drawings: Sequence[Drawn], stock: Stock) -> tuple[Sheet, ...]:
    """Lay pieces in rows, the longest first, each in the first row with room; then lay rows on sheets.

    Raises
    ------
    FieldError
        If a piece does not fit on a sheet.
    """
    order = sorted(range(len(drawings)), key=lambda k: (-_length(drawings[k]), k))
    if not order:
        raise FieldError("there is no strip to lay out")
    room = stock.room if math.isfinite(stock.room) else _length(drawings[order[0]])
    rows: list[list[int]] = []
    used: list[float] = []
    for k in order:
        length = _length(drawings[k])
        if length > room + 1e-9:
            raise FieldError(f"a strip of {length:.6g} mm does not fit on a sheet that leaves {room:.6g} mm")
        fitting = (r for r, taken in enumerate(used) if taken + stock.gap + length <= room + 1e-9)
        row = next(fitting, None)
        if row is None:
            rows.append([k])
            used.append(length)
        else:
            rows[row].append(k)
            used[row] += stock.gap + length
    sheets: list[list[Laid]] = [[]]
    down = 0.0
    for row_of in rows:
        top = max(drawings[k].extent.top for k in row_of)
        bottom = min(drawings[k].extent.bottom for k in row_of)
        if top - bottom > stock.height - 2 * stock.margin:
            raise FieldError(
                f"strips with their labels are {top - bottom:.4g} mm high, more than a sheet of "
                f"{stock.height:g} mm leaves between its margins"
            )
        if down and down + stock.gap + top - bottom > stock.height - 2 * stock.margin:
            sheets.append([])
            down = 0.0
        down += stock.gap if down else 0.0
        x = stock.margin
        for k in row_of:
            left = drawings[k].extent.left
            sheets[-1].append(Laid(drawings[k], x - left, -(stock.margin + down + top)))
            x += _length(drawings[k]) + stock.gap
        down += top - bottom
    height = stock.height if math.isfinite(stock.height) else down + 2 * stock.margin
    width = room + 2 * stock.margin
    return tuple(
        Sheet(width, height, tuple(each._replace(y=each.y + height) for each in laid)) for laid in sheets
    )


def _length(drawing: Drawn) -> float:
    return drawing.extent.right - drawing.extent.left
