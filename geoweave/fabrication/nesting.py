"""Pieces laid out on sheets, in rows, as a person sorts them.

A row holds strips of one family. The pieces of a strip that is longer than a row lie in rows that follow each
other, and short strips fill what the last of them leaves. Rows come in the order of the numbers of their
first strips, so that a strip is found where it is looked for. Where this wastes more than a tenth, rows are
filled with whatever fits best, and only rows and the pieces in them are sorted; the index says where each is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from geoweave.errors import FieldError
from geoweave.fabrication.strip_figures import Drawn, Figure

__all__ = ["Laid", "Sheet", "Stock", "nested", "used_share"]


@dataclass(frozen=True)
class Stock:
    """The sheets that strips are cut from, mm.

    Attributes
    ----------
    width, height : of a sheet. Without a height there is one sheet, as high as needed. If the width is
        missing too, it is as wide as the longest strip
    margin : left free along the edges
    gap : between neighbouring strips
    roll : whether it is a roll: ``height`` is its width, and strips lie along it, in one piece each

    Raises
    ------
    FieldError
        If a number is out of range.
    """

    width: float = math.inf
    height: float = math.inf
    margin: float = 5.0
    gap: float = 2.0
    roll: bool = False

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

    @property
    def across(self) -> float:
        """Height that a curved piece may have."""
        return self.height - 2 * self.margin


class Laid(NamedTuple):
    """A piece on a sheet."""

    drawn: Drawn
    x: float
    """Where its start is, mm from the left edge of the sheet."""
    y: float
    """Where its middle is, mm from the lower edge."""
    row: int = 1
    """Which row of the sheet it lies in, from 1 at the top."""

    @property
    def figures(self) -> tuple[Figure, ...]:
        """What is drawn, where it lies on the sheet."""
        return tuple(figure.moved(self.x, self.y) for figure in self.drawn.figures)


class Sheet(NamedTuple):
    """A sheet and what is cut from it."""

    width: float
    height: float
    laid: tuple[Laid, ...]

    @property
    def lowest(self) -> float:
        """Lower edge of the lowest piece, mm from the lower edge of the sheet."""
        return min(each.y + each.drawn.extent.bottom for each in self.laid)


def nested(drawings: Sequence[Drawn], stock: Stock) -> tuple[Sheet, ...]:
    """Lay pieces in rows, and rows on sheets.

    Raises
    ------
    FieldError
        If a piece does not fit on a sheet.
    """
    if not drawings:
        raise FieldError("there is no strip to lay out")
    for each in drawings:
        tall = each.extent.top - each.extent.bottom
        if tall > stock.height - 2 * stock.margin:
            raise FieldError(
                f"strips {tall:.4g} mm high do not fit on a sheet {stock.height:g} mm high with margins of "
                f"{stock.margin:g} mm; take one of {math.ceil(tall + 2 * stock.margin)} mm or more"
            )
        if _length(each) > stock.room + 1e-9:
            raise FieldError(
                f"a strip of {_length(each):.6g} mm does not fit on a sheet that leaves {stock.room:.6g} mm; "
                f"take one of {math.ceil(_length(each) + 2 * stock.margin)} mm or more"
            )
    longest = max(_length(each) for each in drawings)
    if math.isfinite(stock.room) and not stock.roll:
        return _sheets(drawings, stock, stock.room)
    if not math.isfinite(stock.height):
        return _sheets(drawings, stock, longest)
    # Along a roll rows are as long as they must be to lie side by side, but no longer than the roll.
    tall = max(each.extent.top - each.extent.bottom for each in drawings) + stock.gap
    across = max(int((stock.height - 2 * stock.margin + stock.gap) / tall), 1)
    room = max(longest, sum(_length(each) + stock.gap for each in drawings) / across)
    while room < stock.room and len(_sheets(drawings, stock, room)) > 1:
        room *= ROLL_STEP
    return _sheets(drawings, stock, min(room, stock.room))


def used_share(sheets: Sequence[Sheet], around: tuple[float, float] = (0.0, 0.0)) -> float:
    """Which share of the sheets the strips take; of the last one counts what lies above its lowest strip.

    Parameters
    ----------
    sheets : with what is cut from them
    around : what the paper has more than a sheet in width and in height, mm
    """
    taken = sum(each.drawn.area for sheet in sheets for each in sheet.laid)
    last = sheets[-1]
    whole = sum((sheet.width + around[0]) * (sheet.height + around[1]) for sheet in sheets[:-1])
    share = (last.height - last.lowest) / last.height
    return float(taken / (whole + share * (last.width + around[0]) * (last.height + around[1])))


WORTH = 0.9
"""Rows of mixed families are laid where they need no more than this share of the height of sorted ones."""

ROLL_STEP = 1.02
"""By this factor the rows along a roll are lengthened until they fit."""


def _sheets(drawings: Sequence[Drawn], stock: Stock, room: float) -> tuple[Sheet, ...]:
    """Lay rows of a length on sheets, in their order."""
    sheets: list[list[Laid]] = [[]]
    down, number = 0.0, 0
    for row in _rows(drawings, room, stock.gap):
        top = max(drawings[k].extent.top for k in row)
        bottom = min(drawings[k].extent.bottom for k in row)
        if number and down + stock.gap + top - bottom > stock.height - 2 * stock.margin + 1e-9:
            sheets.append([])
            down, number = 0.0, 0
        down += stock.gap if number else 0.0
        number += 1
        x = stock.margin
        for k in row:
            left = drawings[k].extent.left
            sheets[-1].append(Laid(drawings[k], x - left, -(stock.margin + down + top), number))
            x += _length(drawings[k]) + stock.gap
        down += top - bottom
    height = stock.height if math.isfinite(stock.height) else down + 2 * stock.margin
    width = room + 2 * stock.margin
    return tuple(
        Sheet(width, height, tuple(each._replace(y=each.y + height) for each in laid)) for laid in sheets
    )


def _rows(drawings: Sequence[Drawn], room: float, gap: float) -> list[list[int]]:
    """Which pieces lie in a row: sorted, unless that wastes too much."""
    tidy, full = _sorted_rows(drawings, room, gap), _full_rows(drawings, room, gap)
    tall = [sum(_height(drawings, row) + gap for row in rows) for rows in (tidy, full)]
    return full if tall[1] <= WORTH * tall[0] else tidy


def _height(drawings: Sequence[Drawn], row: list[int]) -> float:
    return max(drawings[k].extent.top for k in row) - min(drawings[k].extent.bottom for k in row)


def _full_rows(drawings: Sequence[Drawn], room: float, gap: float) -> list[list[int]]:
    """Rows filled as well as can be, whatever the family: the longest first, each where it fills best.

    Pieces are sorted within their rows, and rows by their first pieces.
    """
    order = sorted(range(len(drawings)), key=lambda k: (-_length(drawings[k]), _by(drawings)(k)))
    rows = [sorted(row, key=_by(drawings)) for row in _best_fit(order, drawings, room, gap)]
    return sorted(rows, key=lambda row: _by(drawings)(row[0]))


def _sorted_rows(drawings: Sequence[Drawn], room: float, gap: float) -> list[list[int]]:
    """Rows of one family each, sorted by family and number, short ones behind each other."""
    rows: list[list[int]] = []
    for family in sorted({each.family for each in drawings}):
        own = sorted((k for k in range(len(drawings)) if drawings[k].family == family), key=_by(drawings))
        spliced = [k for k in own if drawings[k].piece.total > 1]
        whole = [k for k in own if drawings[k].piece.total == 1]
        # The last piece of a strip may lie behind that of another one; its other pieces fill their rows.
        rest = sorted(whole, key=lambda k: -_length(drawings[k]))
        found = _best_fit([*spliced, *rest], drawings, room, gap)
        rows += sorted(found, key=lambda row: _by(drawings)(row[0]))
    return _merged(rows, drawings, room, gap)


def _best_fit(order: Sequence[int], drawings: Sequence[Drawn], room: float, gap: float) -> list[list[int]]:
    """Lay pieces in rows in this order, each into the row that it fills best."""
    found: list[list[int]] = []
    left: list[float] = []
    for k in order:
        need = _length(drawings[k]) + gap
        fitting = [(left[r], r) for r in range(len(found)) if left[r] >= need - 1e-9]
        if fitting:
            r = min(fitting)[1]
            found[r].append(k)
            left[r] -= need
        else:
            found.append([k])
            left.append(room + gap - need)
    return found


def _merged(rows: list[list[int]], drawings: Sequence[Drawn], room: float, gap: float) -> list[list[int]]:
    """Move a row as a whole to the end of an earlier one that has room for it."""
    kept: list[list[int]] = []
    left: list[float] = []
    for row in rows:
        need = sum(_length(drawings[k]) + gap for k in row)
        first = next((r for r in range(len(kept)) if left[r] >= need - 1e-9), None)
        if first is None or drawings[row[0]].piece.total > 1:
            kept.append(row)
            left.append(room + gap - need)
        else:
            kept[first] += row
            left[first] -= need
    return kept


def _by(drawings: Sequence[Drawn]) -> Callable[[int], tuple[int, int, int]]:
    """The order in which a person looks for pieces: family, number, piece."""
    return lambda k: (drawings[k].family, drawings[k].number, drawings[k].piece.number)


def _length(drawing: Drawn) -> float:
    return drawing.extent.right - drawing.extent.left
