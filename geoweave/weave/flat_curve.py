"""The centreline of a strip that is cut curved, in the plane of its sheet."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geoweave.arrays import Scalars

__all__ = ["FlatCurve", "check_curvature"]

TURN = 0.2
"""Largest angle over which a centreline is integrated in one go, radians: exact to 1e-9 of its length."""

GAUSS = np.polynomial.legendre.leggauss(4)
"""Places and weights of the integration."""


@dataclass(frozen=True, eq=False)
class FlatCurve:
    """A curve in the plane whose curvature is linear between knots.

    Attributes
    ----------
    knots : (K, 2) place along the curve and curvature there, left is positive; at least one, places
        increasing. Beyond the first and the last the curvature is constant, unless the strip is closed
    length : once round for a closed strip, in the unit of the places
    closed : whether the strip is closed

    Examples
    --------
    >>> arc = gw.weave.FlatCurve(((0.0, 0.1),), 30.0)
    >>> np.round(arc.points([0.0, 10 * np.pi / 2]), 6).tolist()  # a quarter of a circle of radius 10
    [[0.0, 0.0], [10.0, 10.0]]
    """

    knots: Sequence[tuple[float, float]]
    length: float
    closed: bool = False

    @cached_property
    def _laid(self) -> tuple[Scalars, Scalars, Scalars]:
        """Places, curvatures and headings at the knots, those of a closed strip twice round both ways."""
        at, bend = np.array(self.knots, dtype=np.float64).reshape(-1, 2).T
        if self.closed:
            turns = range(-2, 4)
            at = np.concatenate([at + k * self.length for k in turns])
            bend = np.tile(bend, len(turns))
        turned = np.concatenate([[0.0], np.cumsum(0.5 * (bend[1:] + bend[:-1]) * np.diff(at))])
        return at, bend, turned

    @property
    def sharpest(self) -> float:
        """Largest curvature, whichever way."""
        return float(np.abs(self._laid[1]).max())

    @property
    def mirrored(self) -> FlatCurve:
        """The same curve seen from the other side."""
        return FlatCurve(tuple((at, -bend) for at, bend in self.knots), self.length, self.closed)

    def curvature(self, s: ArrayLike) -> Scalars:
        """Curvature at places along the curve."""
        at, bend, _ = self._laid
        return np.asarray(np.interp(np.asarray(s, dtype=np.float64), at, bend))

    def heading(self, s: ArrayLike) -> Scalars:
        """Angle of the curve at places along it, radians from its direction at 0, left is positive."""
        return self._heading(np.asarray(s, dtype=np.float64)) - self._heading(np.zeros(()))

    def _heading(self, s: Scalars) -> Scalars:
        at, bend, turned = self._laid
        low = np.clip(np.searchsorted(at, s, side="right") - 1, 0, len(at) - 1)
        along = s - at[low]
        # Before the first knot `low` is the first one and `along` is negative, at constant curvature.
        return np.asarray(turned[low] + 0.5 * along * (bend[low] + self.curvature(s)))

    def points(self, s: ArrayLike) -> NDArray[np.float64]:
        """(N, 2) points at places along the curve; it begins at the origin, along x."""
        places = np.asarray(s, dtype=np.float64)
        if not len(places):
            return np.zeros((0, 2))
        low, high = min(float(places.min()), 0.0), max(float(places.max()), 0.0)
        cells = math.ceil((high - low) * self.sharpest / TURN) + 1
        grid = np.unique(np.concatenate([places, [0.0], np.linspace(low, high, cells + 1), self._laid[0]]))
        grid = grid[(grid >= low) & (grid <= high)]
        nodes, weights = GAUSS
        half = 0.5 * np.diff(grid)
        inside = 0.5 * (grid[1:] + grid[:-1])[:, None] + half[:, None] * nodes
        steps = half * (np.exp(1j * self.heading(inside)) @ weights)
        way = np.concatenate([[0.0], np.cumsum(steps)])
        found = way[np.searchsorted(grid, places)] - way[np.searchsorted(grid, 0.0)]
        return np.column_stack([found.real, found.imag])

    def part(self, before: float, length: float) -> FlatCurve:
        """An open piece of it, from a place on."""
        at = self._laid[0]
        inner = at[(at > before) & (at < before + length)]
        places = np.concatenate([[before], inner, [before + length]])
        bends = self.curvature(places)
        return FlatCurve(tuple(zip((places - before).tolist(), bends.tolist(), strict=True)), length)


def check_curvature(knots: Sequence[Sequence[float]], width: float, place: str) -> None:
    """Refuse curvatures of a strip whose places do not increase, or at which its edges would cross.

    Raises
    ------
    ValueError
        With half a sentence that begins with the place in the document.
    """
    at = [float(each[0]) for each in knots]
    if any(b <= a for a, b in pairwise(at)):
        raise ValueError(f"{place} has places that do not increase")
    sharpest = max((abs(float(each[1])) for each in knots), default=0.0)
    if sharpest * width >= 2:
        raise ValueError(
            f"{place} is {sharpest:.4g} at its sharpest, where the edges of a strip {width:.4g} wide cross"
        )
