"""What a drawn strip is made of: lines and areas, each with a role, on layers (Section 5.4, Fig. 20)."""

from __future__ import annotations

from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geoweave.fabrication.pieces import Piece
from geoweave.fabrication.stroke_font import Box

__all__ = ["LAYERS", "ROLES", "Drawn", "Figure", "Paths", "Role"]

Role: TypeAlias = Literal[
    "ground",
    "band",
    "outline",
    "fold",
    "under",
    "over",
    "heading",
    "leader",
    "hollow",
    "solid",
    "label",
    "name",
]
Paths: TypeAlias = tuple[NDArray[np.float64], ...]

LAYERS = ("colour", "cut", "score", "guide", "label")
"""From the bottom up."""

ROLES: dict[Role, str] = {
    "ground": "colour",
    "band": "colour",
    "outline": "cut",
    "fold": "score",
    "under": "guide",
    "over": "guide",
    "heading": "guide",
    "leader": "guide",
    "hollow": "guide",
    "solid": "guide",
    "label": "label",
    "name": "label",
}
"""Layer of each kind of figure."""


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

    def moved(self, x: float, y: float) -> Figure:
        """The same figure elsewhere."""
        return self._replace(paths=tuple(path + [x, y] for path in self.paths))


class Drawn(NamedTuple):
    """The drawing of a piece; its start is at x = 0, its middle at y = 0."""

    piece: Piece
    figures: tuple[Figure, ...]
    extent: Box
    """With what stands beside the strip."""
