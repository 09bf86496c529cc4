"""What a drawn strip is made of: lines and areas, each with a role, on layers (Section 5.4, Fig. 20)."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geoweave.fabrication.pieces import Piece
from geoweave.fabrication.stroke_font import Box

__all__ = ["LAYERS", "ROLES", "Drawn", "Figure", "Paths", "Role", "Spot", "Unwritten"]

Role: TypeAlias = Literal[
    "ground",
    "band",
    "outline",
    "fold",
    "under",
    "over",
    "heading",
    "hollow",
    "solid",
    "label",
    "name",
    "nick",
    "hole",
]
Paths: TypeAlias = tuple[NDArray[np.float64], ...]

LAYERS = ("colour", "guide", "label", "score", "hole", "cut")
"""In the order in which a machine works: what is engraved, what is scored, holes, and outlines last.

A strip that is cut free moves, so nothing can be done to it any more.
"""

ROLES: dict[Role, str] = {
    "ground": "colour",
    "band": "colour",
    "outline": "cut",
    "fold": "score",
    "under": "guide",
    "over": "guide",
    "heading": "guide",
    "hollow": "guide",
    "solid": "guide",
    "label": "label",
    "name": "label",
    "nick": "score",
    "hole": "hole",
}
"""Layer of each kind of figure."""


class Spot(NamedTuple):
    """Where a text or a mark stands."""

    x: float
    y: float
    """Its middle, mm."""
    size: float
    """Height of a capital letter, or radius of a mark, mm."""
    turn: float = 0.0
    """By how much it is turned to the left, degrees."""


class Figure(NamedTuple):
    """Lines or an area that are drawn together."""

    role: Role
    paths: Paths
    """(P, 2) each, mm."""
    closed: bool
    family: int
    """Whose colour it has."""
    text: str = ""
    """What its letters say."""
    crossing: int = -1
    """The crossing it belongs to."""
    pen: float = 0.0
    """Width of the lines of letters, mm."""
    spot: Spot | None = None
    """Where a text or a mark stands; a program with letters or circles of its own draws it by that."""
    mark: int = -1
    """Which mark it is, an index into `MARKS`."""
    printed: bool = False
    """Whether a text is to be letters of a font, not lines."""

    def moved(self, x: float, y: float) -> Figure:
        """The same figure elsewhere."""
        spot, shift = self.spot, np.array([x, y])
        return self._replace(
            paths=tuple(path + shift for path in self.paths),
            spot=None if spot is None else spot._replace(x=spot.x + x, y=spot.y + y),
        )


class Unwritten(NamedTuple):
    """A crossing whose name finds no room on the strip, and stands in the key."""

    crossing: int
    at: float
    """Where on the piece, mm from its start."""
    label: str
    """What would stand beside the mark."""
    mark: int
    """Index into `MARKS`."""
    over: bool
    marked: bool
    """Whether the mark is on the strip."""


class Drawn(NamedTuple):
    """The drawing of a piece; its start is at x = 0, its middle at y = 0."""

    piece: Piece
    figures: tuple[Figure, ...]
    extent: Box
    """Of everything that is drawn; nothing stands beside the outline."""
    family: int
    number: int
    """Of the strip in its family, as in its name."""
    area: float
    """Of the outline, mm2."""
    key: tuple[Unwritten, ...] = ()
    """Crossings whose names do not stand on the strip."""
    named: bool = True
    """Whether its own name stands on the strip."""
    smallest: float = math.inf
    """Height of the smallest capital letter on it, mm."""
    spine: NDArray[np.float64] | None = None
    """(N, 2) middle line of a strip that is cut curved; None for a straight one."""
