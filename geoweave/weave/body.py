"""Ribbons in space: with width and thickness, one over the other where they cross (Section 5.1, Fig. 18).

This is the one place that says how a ribbon looks. The GLB, the guide and the pictures all draw what
`bodies` returns.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geoweave.arrays import Indices, Scalars, Vectors
from geoweave.errors import FieldError
from geoweave.weave.lying_over import CLEAR, Frames, Passings, passings, share_beside
from geoweave.weave.passages import Passages

__all__ = ["CLEAR", "SECTIONS", "Body", "Centreline", "bodies"]

SECTIONS = 0.25
"""Distance between cross sections, in widths."""

ROUNDS = 2
"""How often bodies are made, measured where they cross, and parted by what is still missing."""

NEAREST = 1.05
"""Least distance of the middles of two ribbons anywhere in their crossing, in thicknesses."""

NECK = 0.8
"""A ribbon that is drawn narrower at a crossing has its full width again so many widths farther on."""

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
    share: Scalars
    """(P,) of the width that the ribbon is drawn with, at most 1"""
    width: float
    thickness: float

    @property
    def corners(self) -> NDArray[np.float64]:
        """(P, 4, 3) corners of the cross sections: lower right, lower left, upper left, upper right."""
        wide = 0.5 * self.width * self.share[:, None] * self.side
        thick = 0.5 * self.thickness * self.up
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

    At a crossing the two ribbons are moved apart along the normal, until their middles are `CLEAR`
    thicknesses apart over the whole of what they share. Ribbons on a surface go through each other, so each
    of them moves by half of that. Ribbons at rest lie over each other already, so they move by what is
    missing. Over a crossing the height stays the same; between two crossings it goes smoothly from one
    height to the next. Where ribbons hold each other so closely that there is no room for that, they are
    drawn narrower (`geoweave.weave.lying_over.passings`).

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
    >>> round(float(first.centre[:, 2].max() - second.centre[:, 2].min()), 3)  # 1.2 thicknesses
    0.6
    """
    for name, value in (("width", width), ("thickness", thickness), ("step", step)):
        if not (np.isfinite(value) and value > 0):
            raise FieldError(f"the {name} of a ribbon in space must be a positive number, not {value}")
    measured = [_Line(line) for line in lines]
    frames = _frames(measured, width, step * width)
    passages = Passages(crossings, arclength, frames.closed)
    met = passings(frames, passages, over, width, thickness)
    ribbon = passages.ribbons.ravel()[passages.order]
    own = np.split(passages.order, np.searchsorted(ribbon, np.arange(1, len(lines))))

    def drawn(met: Passings) -> list[Body]:
        pairs = zip(measured, own, strict=True)
        return [_body(line, met, mine, width, thickness, step * width) for line, mine in pairs]

    made = drawn(met)
    for _ in range(ROUNDS):
        met = met.parted(_joined(made), 0.5 * width, NEAREST * thickness)
        made = drawn(met)
    frames = _joined(made)
    share = share_beside(frames, met, width, thickness)
    return tuple(
        _narrowed(body, share[first:end])
        for body, (first, end) in zip(made, itertools.pairwise(frames.offsets), strict=True)
    )


def _narrowed(body: Body, share: Scalars) -> Body:
    """The body no wider than that anywhere, with slow changes of its width."""
    narrow = np.flatnonzero(share < 1.0)
    reach = np.full(len(narrow), 0.25 * body.width)
    return body._replace(
        share=np.minimum(
            body.share, _shares(body.at, body.at[narrow], reach, share[narrow], body.width, body.closed)
        )
    )


class _Line:
    """A centreline with the lengths along it; a closed one ends where it begins."""

    def __init__(self, line: Centreline) -> None:
        self.closed = line.closed
        self.at = line.arclength
        self.points = np.concatenate([line.points, line.points[:1]]) if line.closed else line.points
        self.normals = line.normals[: len(self.at) - 1]
        """(P - 1, 3) of each segment."""

    def sections(self, where: Scalars, reach: float) -> tuple[Vectors, Vectors, Vectors]:
        """Middle, normal and direction of cross sections at these lengths; normals are means over reach."""
        centre = np.stack([np.interp(where, self.at, self.points[:, axis]) for axis in range(3)], axis=1)
        up = _mean_normals(where, self, reach)
        # As the pages find it again from the middles: the way from the section before to the one after.
        ahead = np.gradient(centre, axis=0)
        if self.closed:
            ahead[0] = ahead[-1] = centre[1] - centre[-2]
        ahead /= np.maximum(np.linalg.norm(ahead, axis=1, keepdims=True), 1e-12)
        up -= (up * ahead).sum(axis=1, keepdims=True) * ahead
        up /= np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-12)
        return centre, up, ahead


def _frames(lines: Sequence[_Line], width: float, step: float) -> Frames:
    """Sections of the centrelines, evenly along each."""
    parts = []
    for line in lines:
        where = _even(float(line.at[-1]), step)
        centre, up, ahead = line.sections(where, 0.5 * width)
        parts.append((where, centre, ahead, up))
    return Frames.joined([line.closed for line in lines], parts)


def _joined(made: Sequence[Body]) -> Frames:
    """The cross sections of all bodies, one after the other."""
    parts = [(body.at, body.centre, body.ahead, body.up) for body in made]
    return Frames.joined([body.closed for body in made], parts)


def _body(line: _Line, met: Passings, own: Indices, width: float, thickness: float, step: float) -> Body:
    """The body of one ribbon; own are its passings, in the order in which it comes to them."""
    length = float(line.at[-1])
    levels = _levels(met, own, length, line.closed)
    where = _sections(length, levels, step)
    centre, up, ahead = line.sections(where, 0.5 * width)
    lifted = centre + _heights(where, levels)[:, None] * up
    slim = own[met.share[own] < 1.0]
    share = _shares(where, met.at[slim], met.reach[slim], met.share[slim], width, line.closed)
    return Body(line.closed, where, lifted, np.cross(up, ahead), up, ahead, share, width, thickness)


class _Levels(NamedTuple):
    """Stretches of a ribbon that keep one height; what lies between two of them is a ramp."""

    starts: Scalars
    ends: Scalars
    heights: Scalars


def _levels(met: Passings, own: Indices, length: float, closed: bool) -> _Levels:
    at, reach, height = met.at[own], met.reach[own], met.height[own]
    if closed and len(own):
        at = np.concatenate([at - length, at, at + length])
        reach, height = np.tile(reach, 3), np.tile(height, 3)
    starts, ends = at - reach, at + reach
    for k in range(len(at) - 1):
        if ends[k] <= starts[k + 1]:
            continue
        # Two share some of it: the one that is farther from the surface keeps its height there.
        first = abs(height[k]) >= abs(height[k + 1])
        if height[k] * height[k + 1] < 0:
            ends[k] = starts[k + 1] = 0.5 * (max(starts[k + 1], at[k]) + min(ends[k], at[k + 1]))
        elif first:
            starts[k + 1] = ends[k]
            ends[k + 1] = max(ends[k + 1], ends[k])
        else:
            ends[k] = max(starts[k + 1], starts[k])
            starts[k + 1] = ends[k]
    return _Levels(starts, ends, height)


def _even(length: float, step: float) -> Scalars:
    """Lengths about a step apart, the ends among them."""
    return np.linspace(0.0, length, max(round(length / step), 2) + 1)


def _sections(length: float, levels: _Levels, step: float) -> Scalars:
    """Where cross sections are: evenly along the line, where each ramp begins and ends, and within it."""
    even = _even(length, step)
    begin, end = levels.ends[:-1], levels.starts[1:]
    ramps = levels.heights[:-1] != levels.heights[1:]
    begin, end = begin[ramps], end[ramps]
    end = np.maximum(end, begin)
    within = [begin + part * (end - begin) for part in (0.0, 1 / 3, 2 / 3, 1.0)]
    met = np.unique(np.concatenate(within)) if len(begin) else np.zeros(0)
    met = met[(met > 0.1 * step) & (met < length - 0.1 * step)]
    if len(met):
        # What is nearly the same place is one place.
        met = met[np.concatenate([[True], np.diff(met) > 1e-3 * step])]
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


def _heights(where: Scalars, levels: _Levels) -> Scalars:
    """Height above the centreline: level over each crossing, with slope 0 at both ends of every ramp."""
    if not len(levels.heights):
        return np.zeros(len(where))
    knots = np.maximum.accumulate(np.stack([levels.starts, levels.ends], axis=1).ravel())
    values = np.repeat(levels.heights, 2)
    after = np.clip(np.searchsorted(knots, where, side="right"), 1, len(knots) - 1)
    low, high = knots[after - 1], knots[after]
    share = np.clip((where - low) / np.maximum(high - low, 1e-300), 0.0, 1.0)
    blend = share**2 * (3.0 - 2.0 * share)
    return np.asarray((1.0 - blend) * values[after - 1] + blend * values[after])


def _shares(
    where: Scalars, at: Scalars, reach: Scalars, least: Scalars, width: float, closed: bool
) -> Scalars:
    """Share of the full width: no more than the least within reach of each place, then slowly full."""
    apart = np.abs(where[:, None] - at)
    if closed:
        apart = np.minimum(apart, where[-1] - apart)
    part = np.clip((apart - reach) / (NECK * width), 0.0, 1.0)
    found = least + (1.0 - least) * part**2 * (3.0 - 2.0 * part)
    return np.asarray(found.min(axis=1, initial=1.0))
