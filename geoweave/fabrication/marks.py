"""A small set of marks that tell crossings apart, and which crossing gets which (Section 5.4, Fig. 20).

A crossing is found again on the other ribbon by the name of that ribbon and a mark. Two ribbons may cross
often, so crossings of one pair never share a mark; where there are more of them than marks, a second round
begins, which the label says.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geoweave.arrays import Flags, Indices, Scalars, frozen
from geoweave.errors import FieldError

__all__ = ["DISC", "MARKS", "assigned", "circle", "outline"]

MARKS = ("disc", "triangle", "square", "star", "hourglass", "plus", "needle", "half")
"""Names of the marks, the plainest first."""

DISC = 0.86
"""Radius of the disc in radii of a mark."""

NEAR = 3
"""Crossings up to so many places apart on a ribbon get different marks where possible."""


def outline(mark: int) -> NDArray[np.float64]:
    """(P, 2) closed outline of a mark in the square of side 2 about the origin; no point comes twice.

    Raises
    ------
    FieldError
        If there is no such mark.
    """
    if not 0 <= mark < len(MARKS):
        raise FieldError(f"there are {len(MARKS)} marks, numbered from 0; not {mark}")
    return frozen(_OUTLINES[MARKS[mark]]())


def assigned(ribbons: Indices, arclengths: Scalars, closed: Flags) -> tuple[Indices, Indices]:
    """Choose the mark of each crossing, and its round: 0 unless the pair of ribbons has used up all marks.

    Greedy in the order of the crossings: never a mark that the pair has in this round; then the one that the
    neighbours on both ribbons use least; then the one used least so far.

    Parameters
    ----------
    ribbons : (C, 2) the two ribbons of each crossing
    arclengths : (C, 2) how far along each of them
    closed : (n,) whether a ribbon ends where it begins

    Returns
    -------
    tuple
        (C,) marks and (C,) rounds.
    """
    count = len(ribbons)
    marks, rounds = np.full(count, -1, dtype=np.int64), np.zeros(count, dtype=np.int64)
    around = _neighbours(ribbons, arclengths, closed)
    of_pair: dict[tuple[int, int], list[int]] = {}
    used = np.zeros(len(MARKS), dtype=np.int64)
    for x in range(count):
        one, other = sorted(ribbons[x].tolist())
        before = of_pair.setdefault((one, other), [])
        rounds[x] = len(before) // len(MARKS)
        taken = before[rounds[x] * len(MARKS) :]
        near = np.bincount(marks[[y for y in around[x] if marks[y] >= 0]], minlength=len(MARKS))
        free = [mark for mark in range(len(MARKS)) if mark not in taken]
        marks[x] = min(free, key=lambda mark: (near[mark], used[mark], mark))
        before.append(int(marks[x]))
        used[marks[x]] += 1
    return frozen(marks), frozen(rounds)


def _neighbours(ribbons: Indices, arclengths: Scalars, closed: Flags) -> list[list[int]]:
    """Crossings within `NEAR` places of each one on either of its ribbons."""
    around: list[list[int]] = [[] for _ in range(len(ribbons))]
    order = np.lexsort((arclengths.ravel(), ribbons.ravel()))
    owner = ribbons.ravel()[order]
    bounds = np.searchsorted(owner, np.arange(len(closed) + 1))
    for r in range(len(closed)):
        own = order[bounds[r] : bounds[r + 1]] // 2
        for k, x in enumerate(own):
            for step in range(-NEAR, NEAR + 1):
                if step and (closed[r] or 0 <= k + step < len(own)):
                    around[x].append(int(own[(k + step) % len(own)]))
    return around


def circle(count: int) -> NDArray[np.float64]:
    """(count, 2) points of the circle of radius 1, counter-clockwise."""
    return _round(0, 360, count + 1)[:-1]


def _round(first: float, last: float, count: int) -> NDArray[np.float64]:
    """Points on the circle of radius 1 from one angle to another, degrees."""
    angle = np.radians(np.linspace(first, last, count))
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _disc() -> NDArray[np.float64]:
    return DISC * circle(32)


def _triangle() -> NDArray[np.float64]:
    return _round(90, 450, 4)[:-1] - [0.0, 0.1]


def _square() -> NDArray[np.float64]:
    return 1.05 * np.array([[-0.7, -0.7], [0.7, -0.7], [0.7, 0.7], [-0.7, 0.7]])


def _star() -> NDArray[np.float64]:
    points = _round(90, 450, 11)[:-1]
    points[1::2] *= 0.4
    return points


def _hourglass() -> NDArray[np.float64]:
    return np.array([[-0.75, -0.9], [0.75, -0.9], [0.12, 0.0], [0.75, 0.9], [-0.75, 0.9], [-0.12, 0.0]])


def _plus() -> NDArray[np.float64]:
    a, b = 0.95, 0.3
    corners = [(a, b), (b, b), (b, a), (-b, a), (-b, b), (-a, b)]
    return np.array([*corners, *((-x, -y) for x, y in corners)])


def _needle() -> NDArray[np.float64]:
    return np.array([[0.0, -1.0], [0.42, 0.0], [0.0, 1.0], [-0.42, 0.0]])


def _half() -> NDArray[np.float64]:
    return 0.95 * _round(0, 180, 17) - [0.0, 0.42]


_OUTLINES = {
    "disc": _disc,
    "triangle": _triangle,
    "square": _square,
    "star": _star,
    "hourglass": _hourglass,
    "plus": _plus,
    "needle": _needle,
    "half": _half,
}
