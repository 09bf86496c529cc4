"""Which points of a surface are too near to curves already placed on it: samples in a hashed grid."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geoweave.arrays import Complexes, Indices, Scalars, Vectors
from geoweave.compiled import compiled
from geoweave.curves.face_walk import Ground, in_space

SAME_SHEET = 0.3
"""Points are near each other only if the scalar product of their normals exceeds this."""


class Samples(NamedTuple):
    """Points along the lines so far, found through a hash of the grid cell they lie in."""

    points: Vectors
    normals: Vectors
    line: Indices
    arclength: Scalars
    slot: Indices
    older: Indices
    newest: Indices
    origin: Scalars
    cell: float


@compiled
def _slot(q: Samples, x: int, y: int, z: int) -> int:
    return ((x * 73856093) ^ (y * 19349663) ^ (z * 83492791)) & (len(q.newest) - 1)


@compiled
def _cell(q: Samples, value: float, axis: int) -> int:
    return int(np.floor((value - q.origin[axis]) / q.cell))


@compiled
def remember(q: Samples, n: int, point: Vectors, normal: Vectors, line: int, s: float) -> None:
    """Enter sample n, the newest."""
    for x in range(3):
        q.points[n, x], q.normals[n, x] = point[x], normal[x]
    slot = _slot(q, _cell(q, point[0], 0), _cell(q, point[1], 1), _cell(q, point[2], 2))
    q.line[n], q.arclength[n], q.slot[n], q.older[n] = line, s, slot, q.newest[slot]
    q.newest[slot] = n


@compiled
def forget(q: Samples, first: int, end: int) -> None:
    """Take out the samples from ``first`` on, of the ``end`` there are."""
    for n in range(end - 1, first - 1, -1):
        q.newest[q.slot[n]] = q.older[n]


@compiled
def blocked(
    q: Samples, point: Vectors, normal: Vectors, near: float, line: int, s: float, free: float,
    start: Vectors, close: float, zone: float,
) -> bool:  # fmt: skip
    """Whether a point is nearer than ``near`` to another line, or to its own more than ``free`` along it.

    A line that comes back to its own start from behind, in line with it, is let through to close.
    ``start`` holds the first point, the heading there and the direction to its left.
    """
    x, y, z = _cell(q, point[0], 0), _cell(q, point[1], 1), _cell(q, point[2], 2)
    for i in range(x - 1, x + 2):
        for j in range(y - 1, y + 2):
            for k in range(z - 1, z + 2):
                n = q.newest[_slot(q, i, j, k)]
                while n >= 0:
                    square = 0.0
                    agree = 0.0
                    for a in range(3):
                        square += (q.points[n, a] - point[a]) ** 2
                        agree += q.normals[n, a] * normal[a]
                    if square < near * near and agree > SAME_SHEET:
                        if q.line[n] != line:
                            return True
                        if abs(q.arclength[n] - s) > free:
                            beyond, aside = 0.0, 0.0
                            for a in range(3):
                                beyond += (point[a] - start[0, a]) * start[1, a]
                                aside += (point[a] - start[0, a]) * start[2, a]
                            returning = abs(q.arclength[n]) < zone and beyond <= 0.0 and abs(aside) <= close
                            if not returning:
                                return True
                    n = q.older[n]
    return False


@compiled
def first_free(g: Ground, q: Samples, faces: Indices, places: Complexes, first: int, near: float) -> int:
    """Index of the first place, from ``first`` on, with no line nearer than ``near``; else their number."""
    point = np.empty(3)
    start = np.zeros((3, 3))
    for c in range(first, len(faces)):
        in_space(g, faces[c], places[c], point)
        if not blocked(q, point, g.normals[faces[c]], near, -1, 0.0, 0.0, start, 0.0, 0.0):
            return c
    return len(faces)


def room_for(count: int, cell: float, origin: Scalars) -> Samples:
    """Make an empty store for ``count`` samples that are looked for within one ``cell`` length."""
    slots = 1 << int(np.ceil(np.log2(max(count, 2))))
    return Samples(
        np.empty((count, 3)), np.empty((count, 3)), np.empty(count, dtype=np.int64), np.empty(count),
        np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64), np.full(slots, -1), origin, cell,
    )  # fmt: skip


def enlarged(q: Samples) -> Samples:
    """Double the room, keeping the samples."""
    points, normals, line, arclength, slot, older = (
        np.concatenate([each, np.empty_like(each)])
        for each in (q.points, q.normals, q.line, q.arclength, q.slot, q.older)
    )
    return Samples(points, normals, line, arclength, slot, older, q.newest, q.origin, q.cell)
