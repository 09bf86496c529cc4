"""How a pattern is made: what is added to strips, what they are cut from, and how they are drawn."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from geoweave.errors import FieldError
from geoweave.fabrication.colours import Colours
from geoweave.fabrication.nesting import Stock
from geoweave.fabrication.pieces import Making
from geoweave.fabrication.sheet_sizes import paper_of
from geoweave.fabrication.up_axes import check_axis

__all__ = ["Bench", "media_of"]


@dataclass(frozen=True)
class Bench:
    """How a pattern is made.

    Attributes
    ----------
    making : overlap, extra and kerf
    stock : sheets of the SVG and of the DXF; by default one long sheet
    stock_length : of the strips that the cut list counts, mm
    colours : of SVG and DXF
    paper_colours : of the pages, the GLB and the guide
    title : what the drawings are called
    papers : of the pages, names of `PAPERS`
    density : of the material, g/cm3
    up : the axis of the weave that is up in the GLB and the guide; found if not given (`up_axis`)

    Examples
    --------
    >>> Making, Stock = gw.fabrication.Making, gw.fabrication.Stock
    >>> bench = gw.fabrication.Bench(Making(overlap=10.0), Stock(width=600.0, height=300.0))
    >>> bench.stock.room  # mm that a strip may be long
    590.0
    """

    making: Making = field(default_factory=Making)
    stock: Stock = field(default_factory=Stock)
    stock_length: float = 1000.0
    colours: Colours = field(default_factory=Colours)
    paper_colours: Colours = field(default_factory=lambda: Colours("paper"))
    title: str = "weave"
    papers: tuple[str, ...] = ("a4", "letter")
    density: float = 0.8
    up: str | None = None

    def __post_init__(self) -> None:
        for name in self.papers:
            paper_of(name)
        if self.up is not None:
            check_axis(self.up)
        if not (math.isfinite(self.stock_length) and self.stock_length > 0):
            raise FieldError(f"the stock length must be a positive number of mm, not {self.stock_length}")
        if not (math.isfinite(self.density) and self.density > 0):
            raise FieldError(f"the density must be a positive number of g/cm3, not {self.density}")


def media_of(formats: Iterable[str], papers: Sequence[str]) -> tuple[str, ...]:
    """What files of some formats are cut from: pieces of strips must fit on all of it."""
    found: list[str] = []
    for name in formats:
        if name in ("svg", "dxf"):
            found.append("sheet")
        elif name == "pdf":
            found += papers
        elif name == "csv":
            found.append("stock")
    return tuple(dict.fromkeys(found)) or ("whole",)
