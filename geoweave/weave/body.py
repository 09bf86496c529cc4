"""Ribbons in space: with width and thickness, one over the other where they cross (Section 5.1, Fig. 18).

This is the one place that says how a ribbon looks. The GLB, the guide and the pictures all draw what
`bodies` returns.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geoweave.arrays import Indices, Scalars, Vectors
from geoweave.errors import FieldError

__all__ = ["CLEAR", "SECTIONS", "Body", "Centreline", "bodies"]

CLEAR = 1.4
"""Distance of the middles of two ribbons where they cross, in thicknesses.

It is more than 1 because a surface that bends under a flat ribbon brings the edges of the ribbons closer.
"""

SECTIONS = 0.25
"""Distance between cross sections, in widths."""

FLAT = 0.5
"""A ribbon keeps its height up to so many widths to either side of a crossing ..."""

FLAT_SHARE = 0.4
"""... but at most for this share of the way to the next crossing, so that it has room to rise or fall."""

_CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))
"""Corners of a cross section, in half widths to the left and half thicknesses up."""


class Centreline(NamedTuple):
    """The line that a ribbon follows."""

    points: Vectors
    """(P, 3); a closed line does not repeat its first point."""
    normals: Vectors
    """(P, 3) unit normal of the segment that starts at each point; an open line does not use its last."""
    closed: bool

    @property
    def arclength(self) -> Scalars:
        """Length along the line at each point; for a closed line also once round."""
        ends = np.concatenate([self.points, self.points[:1]]) if self.closed else self.points
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ends, axis=0), axis=1))])


class Body(NamedTuple):
    """One ribbon as a rectangle that is swept along its centreline.

    A closed ribbon ends with the cross section that it begins with.
    """

    closed: bool
    at: Scalars
    """(P,) length along the centreline at which each cross section is."""
    centre: Vectors
    """(P, 3) middle of each cross section."""
    side: Vectors
    """(P, 3) unit, to the left."""
    up: Vectors
    """(P, 3) unit, outwards."""
    ahead: Vectors
    """(P, 3) unit, along the centreline."""
    width: float
    thickness: float

    @property
    def corners(self) -> NDArray[np.float64]:
        """(P, 4, 3) corners of the cross sections: lower right, lower left, upper left, upper right."""
        wide, thick = 0.5 * self.width * self.side, 0.5 * self.thickness * self.up
        return np.stack([self.centre + a * wide + b * thick for a, b in _CORNERS], axis=1)

    def solid(self) -> tuple[Vectors, NDArray[np.int64]]:
        """The closed surface of the ribbon: (V, 3) vertices and (Q, 4) quadrilaterals seen from outside.

        Vertices 4 k to 4 k + 3 are the corners of cross section k; a closed ribbon has one section less.
        """
        corners = self.corners[:-1] if self.closed else self.corners
        count = 4 * len(corners)
        here = 4 * np.arange(len(corners) if self.closed else len(corners) - 1)
        there = (here + 4) % count
        quads = [
            np.stack([here + a, here + b, there + b, there + a], axis=1)
            for a, b in ((0, 1), (1, 2), (2, 3), (3, 0))
        ]
        if not self.closed:
            last = count - 4
            quads.append(np.array([[3, 2, 1, 0], [last, last + 1, last + 2, last + 3]]))
        return corners.reshape(-1, 3), np.concatenate(quads)


def bodies(
    lines: Sequence[Centreline],
    crossings: Indices,
    arclength: NDArray[np.float64],
    over: Indices,
    *,
    width: float,
    thickness: float,
    step: float = SECTIONS,
) -> tuple[Body, ...]:
    """Give ribbons their width and thickness, and raise or lower them where they cross.

    At a crossing the two ribbons are moved apart along the normal, by the same amount each, until their
    middles are `CLEAR` thicknesses apart. Ribbons on a surface go through each other, so each of them moves
    by half of that. Ribbons at rest lie over each other already, so they move by what is missing. Across the
    width of a crossing the height stays the same; between two crossings it goes smoothly from one height to
    the next.

    Parameters
    ----------
    lines : the n centrelines
    crossings : (C, 2) the two ribbons of each crossing
    arclength : (C, 2) how far along each of the two centrelines it is
    over : (C,) which of the two lies above, 0 or 1
    width, thickness : of a ribbon, in the unit of the points
    step : distance between cross sections, in widths

    Raises
    ------
    FieldError
        If the width, the thickness or the step is not positive.

    Examples
    --------
    >>> up = np.array([[0.0, 0.0, 1.0]] * 2)
    >>> east = gw.weave.Centreline(np.array([[-10.0, 0, 0], [10, 0, 0]]), up, closed=False)
    >>> north = gw.weave.Centreline(np.array([[0, -10.0, 0], [0, 10, 0]]), up, closed=False)
    >>> met = np.array([[0, 1]]), np.array([[10.0, 10.0]]), np.array([0])
    >>> first, second = gw.weave.bodies([east, north], *met, width=2.0, thickness=0.5)
    >>> round(float(first.centre[:, 2].max() - second.centre[:, 2].min()), 3)  # 1.4 thicknesses
    0.7
    """
    for name, value in (("width", width), ("thickness", thickness), ("step", step)):
        if not (np.isfinite(value) and value > 0):
            raise FieldError(f"the {name} of a ribbon in space must be a positive number, not {value}")
    measured = [_Line(line) for line in lines]
    heights: list[list[tuple[float, float]]] = [[] for _ in lines]
    for (r, q), (s, t), above in zip(crossings.tolist(), arclength.tolist(), over.tolist(), strict=True):
        normal = measured[r].normal(s) + measured[q].normal(t)
        apart = measured[r].point(s) - measured[q].point(t)
        sign = 1 if above == 0 else -1
        there = sign * float(apart @ normal) / max(float(np.linalg.norm(normal)), 1e-12)
        height = 0.5 * sign * max(CLEAR * thickness - there, 0.0)
        heights[r].append((s, height))
        heights[q].append((t, -height))
    return tuple(
        _body(line, sorted(height), width, thickness, step * width)
        for line, height in zip(measured, heights, strict=True)
    )


class _Line:
    """A centreline with the lengths along it; a closed one ends where it begins."""

    def __init__(self, line: Centreline) -> None:
        self.closed = line.closed
        self.at = line.arclength
        self.points = np.concatenate([line.points, line.points[:1]]) if line.closed else line.points
        self.normals = line.normals[: len(self.at) - 1]
        """(P - 1, 3) of each segment."""

    def point(self, s: float) -> Vectors:
        """(3,) the point at a length along the line."""
        return np.array([np.interp(s, self.at, self.points[:, axis]) for axis in range(3)])

    def normal(self, s: float) -> Vectors:
        """(3,) the normal of the segment there."""
        segment = int(np.searchsorted(self.at, s, side="right")) - 1
        return np.asarray(self.normals[min(max(segment, 0), len(self.normals) - 1)])


def _body(
    line: _Line, heights: list[tuple[float, float]], width: float, thickness: float, step: float
) -> Body:
    where = _sections(line.at[-1], [s for s, _ in heights], step)
    centre = np.stack([np.interp(where, line.at, line.points[:, axis]) for axis in range(3)], axis=1)
    up = _mean_normals(where, line, 0.5 * width)
    ahead = np.gradient(centre, axis=0)
    if line.closed:
        ahead[0] = ahead[-1] = centre[1] - centre[-2]
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    up -= (up * ahead).sum(axis=1, keepdims=True) * ahead
    up /= np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-12)
    lifted = centre + _heights(where, heights, line.at[-1], width, line.closed)[:, None] * up
    return Body(line.closed, where, lifted, np.cross(up, ahead), up, ahead, width, thickness)


def _sections(length: float, crossings: Sequence[float], step: float) -> Scalars:
    """Where cross sections are: evenly along the line, and one at each crossing, where the height peaks."""
    even = np.linspace(0.0, length, max(round(length / step), 2) + 1)
    met = np.array([s for s in crossings if 0.1 * step < s < length - 0.1 * step])
    if len(met):
        nearest = np.abs(even[:, None] - met).min(axis=1)
        nearest[[0, -1]] = np.inf
        even = even[nearest > 0.25 * step]
    return np.unique(np.concatenate([even, met]))


def _mean_normals(where: Scalars, line: _Line, reach: float) -> Vectors:
    """Mean of the normals within reach to either side, so that a ribbon turns evenly from face to face."""
    normals, steps = line.normals, np.diff(line.at)
    if line.closed:
        normals, steps = np.tile(normals, (3, 1)), np.tile(steps, 3)
        where = where + line.at[-1]
    along = np.concatenate([[0.0], np.cumsum(steps)])
    summed = np.concatenate([np.zeros((1, 3)), np.cumsum(steps[:, None] * normals, axis=0)])
    low, high = (np.clip(where + way * reach, 0.0, along[-1]) for way in (-1, 1))
    return np.stack(
        [np.interp(high, along, summed[:, k]) - np.interp(low, along, summed[:, k]) for k in range(3)], axis=1
    )


def _heights(
    where: Scalars, heights: list[tuple[float, float]], length: float, width: float, closed: bool
) -> Scalars:
    """Height above the centreline: level at each crossing, with slope 0 at both ends of every rise."""
    if not heights:
        return np.zeros(len(where))
    place, first = np.unique([s for s, _ in heights], return_index=True)
    value = np.array([h for _, h in heights])[first]
    if closed:
        place = np.concatenate([place - length, place, place + length])
        value = np.tile(value, 3)
    gaps = np.diff(place, prepend=-np.inf, append=np.inf)
    reach = np.minimum(FLAT * width, FLAT_SHARE * np.minimum(gaps[:-1], gaps[1:]))
    knots = np.stack([place - reach, place + reach], axis=1).ravel()
    levels = np.repeat(value, 2)
    share = np.interp(where, knots, np.arange(len(knots)))
    before = np.minimum(share.astype(np.int64), len(knots) - 2)
    share -= before
    blend = share**2 * (3.0 - 2.0 * share)
    return np.asarray((1.0 - blend) * levels[before] + blend * levels[before + 1])
