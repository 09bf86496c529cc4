"""The cut list: every strip, its length, and which stock length it is cut from."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

from geoweave.errors import FieldError
from geoweave.fabrication.assembly_order import Step
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.pieces import Making, Piece, pieces_of

__all__ = ["COLUMNS", "CutList", "cut_list"]

COLUMNS = (
    "strip",
    "piece",
    "family",
    "closed",
    "length_mm",
    "cut_mm",
    "stock",
    "crossings",
    "order",
    "bow_mm",
    "turning_deg",
)
"""Of ``cutlist.csv``."""


class CutList(NamedTuple):
    """Which pieces are cut from which stock length."""

    pieces: tuple[Piece, ...]
    stock: tuple[int, ...]
    """Number of the stock length of each piece, from 1."""
    stock_length: float
    total: float
    """Of the centrelines, mm."""
    cut: float
    """With what is added, mm."""

    @property
    def used(self) -> int:
        """How many stock lengths are needed."""
        return max(self.stock, default=0)

    @property
    def per_stock(self) -> tuple[int, ...]:
        """How many pieces come from each stock length."""
        return tuple(self.stock.count(number) for number in range(1, self.used + 1))

    def text(
        self,
        pattern: Pattern,
        order: Sequence[Step],
        places: Mapping[str, Mapping[Piece, tuple[int, int]]] | None = None,
        keys: Mapping[Piece, str] | None = None,
    ) -> str:
        """The contents of ``cutlist.csv``: a row for each piece, then the totals in metres.

        ``order`` is the number of the step at which a strip is laid in; ``bow_mm`` and ``turning_deg`` are
        the bending of a ribbon that a straight strip neglects. ``places`` are page and row of each piece, by
        what it lies on, a pair of columns each; ``keys`` what stands in the key for it.
        """
        where, lines = places or {}, keys or {}
        more = [f"{medium}_{what}" for medium in where for what in ("page", "row")]
        step = {each.strip: number for number, each in enumerate(order, 1)}
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow([*COLUMNS, *more, *(["key"] if keys else [])])
        for piece, stock in zip(self.pieces, self.stock, strict=True):
            strip = pattern.strips[piece.strip]
            writer.writerow(
                [
                    strip.label,
                    f"{piece.number}/{piece.total}",
                    strip.family,
                    "yes" if strip.closed else "no",
                    f"{strip.length:.2f}",
                    f"{piece.length:.2f}",
                    stock,
                    len(pattern.passages[piece.strip]),
                    step[piece.strip],
                    f"{strip.bow:.2f}",
                    f"{strip.turning:.2f}",
                    *(number for each in where.values() for number in each[piece]),
                    *([lines.get(piece, "")] if keys else []),
                ]
            )
        writer.writerow([])
        counts = self.per_stock
        for name, value in (
            ("total_m", f"{self.total / 1000:.3f}"),
            ("cut_m", f"{self.cut / 1000:.3f}"),
            ("stock_length_m", f"{self.stock_length / 1000:.3f}"),
            ("stock_lengths", str(self.used)),
            ("pieces_per_stock_length", " ".join(str(count) for count in counts)),
        ):
            writer.writerow([name, value])
        return out.getvalue()


def cut_list(
    pattern: Pattern,
    making: Making,
    stock_length: float = 1000.0,
    pieces: Sequence[Piece] | None = None,
) -> CutList:
    """Which strips come from which stock length: the longest first, each from the first with room for it.

    A strip longer than a stock length is cut in pieces, unless the pieces are given.

    Parameters
    ----------
    pattern : the strips
    making : what is added to them
    stock_length : in mm; the kerf is lost at each cut
    pieces : what is cut, no piece longer than a stock length

    Raises
    ------
    FieldError
        If the stock length is no positive number or too short for pieces that overlap.
    """
    if not (math.isfinite(stock_length) and stock_length > 0):
        raise FieldError(f"the stock length must be a positive number of mm, not {stock_length}")
    pieces = pieces_of(pattern, making, stock_length) if pieces is None else tuple(pieces)
    left: list[float] = []
    stock = [0] * len(pieces)
    for k in sorted(range(len(pieces)), key=lambda k: (-pieces[k].length, k)):
        need = pieces[k].length + making.kerf
        number = next((n for n, room in enumerate(left) if room >= need - 1e-9), len(left))
        if number == len(left):
            left.append(stock_length)
        left[number] -= need
        stock[k] = number + 1
    total = math.fsum(strip.length for strip in pattern.strips)
    return CutList(pieces, tuple(stock), stock_length, total, math.fsum(piece.length for piece in pieces))
