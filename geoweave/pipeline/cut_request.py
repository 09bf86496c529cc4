"""How the strips of a weave are to be cut: a preset, and what differs from it."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

from geoweave.errors import FieldError

if TYPE_CHECKING:
    from geoweave.fabrication import Bench

__all__ = ["CutRequest"]

PLAIN: dict[str, Any] = {
    "sheet": None,
    "papers": ("a4", "letter"),
    "margin": 5.0,
    "gap": 1.0,
    "kerf": 0.0,
    "overlap": 15.0,
    "stock_length": 1000.0,
    "labels": "engraved",
    "density": 0.8,
}
"""What holds without a preset."""

BOUND = 1e6
"""The largest length that can be asked for, mm."""


@dataclass(frozen=True)
class CutRequest:
    """How the strips of a weave are to be cut; what is None is as in the preset, or as it was designed.

    Raises
    ------
    FieldError
        If a number is out of range, or there is no such preset, sheet, paper or style.

    Examples
    --------
    >>> bench = gw.CutRequest(preset="veneer-laser", kerf=0.2).bench("bunny")
    >>> bench.making.kerf, bench.stock.width, bench.stock.gap  # mm
    (0.2, 600.0, 1.0)
    """

    preset: str | None = None
    """One of `geoweave.fabrication.PRESETS`."""
    sheet: str | None = None
    """Of SVG and DXF, as `geoweave.fabrication.stock_of` reads it."""
    papers: tuple[str, ...] | None = None
    """Of the pages, names of `geoweave.fabrication.PAPERS`."""
    margin: float | None = None
    """Left free along the edges of a sheet, mm."""
    gap: float | None = None
    """Left free between strips on a sheet, mm."""
    kerf: float | None = None
    """Width of the cut, mm."""
    overlap: float | None = None
    """By which the pieces of a strip lie on each other, mm."""
    end: float | None = None
    """What an open strip keeps beyond its outermost crossings, mm; four widths if not given."""
    extra: float = 0.0
    """Added beyond each end of an open strip, mm."""
    stock_length: float | None = None
    """Of the strips that the cut list counts, mm."""
    width: float | None = None
    """Of a strip, mm."""
    thickness: float | None = None
    """Of a strip, mm."""
    mirror: bool = False
    """Whether strips are drawn as seen from the inside."""
    holes: float = 0.0
    """Diameter of a hole at every crossing, mm; 0 for none."""
    score: bool = False
    """Whether both edges have a nick at every crossing."""
    hoops: float = 0.0
    """What strips keep beyond the middle of the hoop of an opening, mm; 0 for no hoops."""
    colours: str | None = None
    """Of SVG and DXF, "laser" or "paper"; or colours of the families as ``#rrggbb``, separated by commas."""
    labels: str | None = None
    """"engraved", "printed" or "none"."""
    title: str | None = None
    """What the drawings are called."""
    up: str | None = None
    """The axis that is up: x, y, z, -x, -y or -z; as the report of the weave says if not given."""
    formats: tuple[str, ...] | None = None
    """Names from `geoweave.fabrication.FORMATS`; those that the folder holds if not given."""

    def __post_init__(self) -> None:
        """Refuse what cannot be made."""
        for name in ("kerf", "overlap", "margin", "gap", "end", "extra", "holes", "hoops"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and 0 <= value <= BOUND):
                raise FieldError(f"{name} is {value}; give 0 to {BOUND:g} mm")
        for name in ("width", "thickness", "stock_length"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and 0 < value <= BOUND):
                raise FieldError(f"{name} is {value}; give a positive number of mm, at most {BOUND:g}")
        self.bench("weave")

    def setting(self, name: str) -> Any:
        """A number that was given, or that of the preset, or that which holds without one."""
        from geoweave.fabrication import preset_of

        given = getattr(self, name, None)
        if given is not None:
            return given
        if self.preset is not None:
            return getattr(preset_of(self.preset), name)
        return PLAIN.get(name)

    def bench(self, title: str, up: str | None = None) -> Bench:
        """How the strips are made.

        Parameters
        ----------
        title : of the drawings, unless one was asked for
        up : the axis that is up, unless one was asked for
        """
        from geoweave.fabrication import Bench, Making, stock_of

        making = Making(
            self.setting("overlap"),
            self.extra,
            self.setting("kerf"),
            self.holes,
            self.score,
            self.setting("labels"),
            self.mirror,
            self.hoops,
        )
        laser, paper = self._colours()
        return Bench(
            making,
            stock_of(self.setting("sheet"), self.setting("margin"), self.setting("gap")),
            self.setting("stock_length"),
            laser,
            paper,
            self.title or title,
            self.setting("papers"),
            self.setting("density"),
            self.up or up,
        )

    def _colours(self) -> tuple[Any, Any]:
        """Colours of SVG and DXF, and of the pages."""
        from geoweave.fabrication import Colours

        if self.colours is None or self.colours in ("laser", "paper"):
            return Colours("paper" if self.colours == "paper" else "laser"), Colours("paper")
        families = tuple(each.strip() for each in self.colours.split(","))
        return Colours("paper", families=families), Colours("paper", families=families)

    def document(self) -> dict[str, Any]:
        """What was asked for, as ``report.json`` holds it."""
        given = {each.name: (getattr(self, each.name), each.default) for each in fields(self)}
        return {
            name: list(value) if isinstance(value, tuple) else value
            for name, (value, default) in given.items()
            if value != default
        }
