"""A triangle mesh that is being edited, as flat arrays, and the tests that every edit must pass.

Half-edge ``3 f + k`` lies opposite corner ``k`` of face ``f`` and runs from corner ``k + 1`` to corner
``k + 2``, as in `TriMesh`; the corner has the same number. Marked edges (the boundary and creases) form
curves: they are never flipped, and their vertices move along them only. Every function here is compiled.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geoweave.arrays import Flags, Indices, Scalars, Vectors
from geoweave.compiled import compiled
from geoweave.surface import BoxTree, nearest

FREE, ON_CURVE, LOCKED = 0, 1, 2
"""Kinds of vertices: one that moves on the surface, one that moves along its curve, one that stays."""

ROOM = 16_384
"""A vertex with more faces than this is not edited until flips and splits have given it fewer."""

SLIVER = 0.05
"""The normal of a face below this quality says nothing (1 equilateral, 0 flat)."""

TURN = 0.3
"""Cosine of the largest angle by which an edit may turn the normal of a face."""

FLOOR = 0.3
"""An edit must not take a face from above this quality to below it."""

DESPERATE = 0.05
"""Share of its quality that a face must keep where no better way takes a vertex back onto the surface."""


class Patch(NamedTuple):
    """A mesh under edit. A removed face has vertex -1 at its corners; a removed vertex has corner -1."""

    points: Vectors
    """(V, 3) positions."""
    kind: Indices
    """(V,) FREE, ON_CURVE or LOCKED."""
    corner: Indices
    """(V,) one corner of each vertex."""
    at: Indices
    """(3F,) vertex at each corner."""
    over: Indices
    """(3F,) half-edge on the other side of each half-edge, -1 on the boundary."""
    marked: Flags
    """(3F,) whether the half-edge lies on a boundary or crease."""


class Guide(NamedTuple):
    """What vertices must lie on: the surface, its boundary (found by direction), its creases."""

    surface: BoxTree
    rims: BoxTree
    creases: BoxTree


@compiled
def following(h: int) -> int:
    """The next half-edge, or corner, of the same face."""
    return h - 2 if h % 3 == 2 else h + 1


@compiled
def preceding(h: int) -> int:
    """The half-edge, or corner, before this one in the same face."""
    return h + 2 if h % 3 == 0 else h - 1


@compiled
def corners_around(patch: Patch, vertex: int, ring: Indices) -> tuple[int, bool]:
    """Fill in the corners around a vertex, counter-clockwise; return how many, and whether they close up.

    The count is 0 where the ring has no room for them.
    """
    start = patch.corner[vertex]
    first = start
    while True:
        h = patch.over[preceding(first)]
        if h < 0:
            break
        first = preceding(h)
        if first == start:
            break
    count, corner = 0, first
    while count < ROOM:
        ring[count] = corner
        count += 1
        h = patch.over[following(corner)]
        if h < 0:
            return count, False
        corner = following(h)
        if corner == first:
            return count, True
    return 0, False


@compiled
def area_vector(a: Scalars, b: Scalars, c: Scalars) -> tuple[float, float, float, float]:
    """Twice the area vector n of a triangle, and its quality ``2 sqrt(3) |n| / (sum of squared sides)``."""
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    wx, wy, wz = vx - ux, vy - uy, vz - uz
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    sides = ux * ux + uy * uy + uz * uz + vx * vx + vy * vy + vz * vz + wx * wx + wy * wy + wz * wz
    quality = 2.0 * np.sqrt(3.0) * np.sqrt(x * x + y * y + z * z) / sides if sides > 0.0 else 0.0
    return x, y, z, quality


@compiled
def distance(a: Scalars, b: Scalars) -> float:
    """Distance of two points."""
    return float(np.sqrt((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2))


@compiled
def agree(ax: float, ay: float, az: float, bx: float, by: float, bz: float, cosine: float) -> bool:
    """Whether the angle between two vectors is smaller than the one with the given cosine."""
    size = float(np.sqrt((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz)))
    return ax * bx + ay * by + az * bz > cosine * size


@compiled
def may_move(
    patch: Patch, ring: Indices, count: int, vertex: int, place: Scalars, dying: int, worse: float
) -> bool:
    """Whether a vertex may move to a place without turning a face over or making a sliver.

    A face whose quality is below `FLOOR` must keep the share `worse` of it. Faces with the vertex `dying`
    do not count, because they are about to be removed.
    """
    sx = sy = sz = 0.0
    for i in range(count):
        b, c = patch.at[following(ring[i])], patch.at[preceding(ring[i])]
        x, y, z, _ = area_vector(patch.points[vertex], patch.points[b], patch.points[c])
        sx, sy, sz = sx + x, sy + y, sz + z
    for i in range(count):
        b, c = patch.at[following(ring[i])], patch.at[preceding(ring[i])]
        if dying in (b, c):
            continue
        x, y, z, old = area_vector(patch.points[vertex], patch.points[b], patch.points[c])
        nx, ny, nz, new = area_vector(place, patch.points[b], patch.points[c])
        if new < min(FLOOR, worse * old) or new <= 0.0:
            return False
        if old > SLIVER:
            if not agree(x, y, z, nx, ny, nz, TURN):
                return False
        elif not agree(sx, sy, sz, nx, ny, nz, 0.0):
            return False
    return True


@compiled
def _aim_within(patch: Patch, vertex: int, ring: Indices, count: int) -> tuple[Scalars, Scalars]:
    """The area-weighted mean of the faces around a vertex, moved into the tangent plane, and the normal."""
    goal, normal = np.zeros(3), np.zeros(3)
    p = patch.points[vertex]
    total = 0.0
    for i in range(count):
        b, c = patch.points[patch.at[following(ring[i])]], patch.points[patch.at[preceding(ring[i])]]
        x, y, z, _ = area_vector(p, b, c)
        area = np.sqrt(x * x + y * y + z * z)
        total += area
        normal[0], normal[1], normal[2] = normal[0] + x, normal[1] + y, normal[2] + z
        for k in range(3):
            goal[k] += area * (p[k] + b[k] + c[k]) / 3.0
    size = np.sqrt(normal[0] ** 2 + normal[1] ** 2 + normal[2] ** 2)
    if total <= 0.0 or size <= 0.0:
        return p.copy(), normal
    lift = 0.0
    for k in range(3):
        goal[k] /= total
        normal[k] /= size
        lift += normal[k] * (goal[k] - p[k])
    for k in range(3):
        goal[k] -= lift * normal[k]
    return goal, normal


@compiled
def _aim_along(patch: Patch, ring: Indices, count: int, closed: bool) -> tuple[Scalars, Scalars]:
    """The middle between the two neighbours on a vertex's curve, and the direction of the boundary there.

    A crease has no direction: there the second vector is zero.
    """
    goal, tangent = np.zeros(3), np.zeros(3)
    for i in range(count):
        if patch.marked[preceding(ring[i])]:
            goal += 0.5 * patch.points[patch.at[following(ring[i])]]
    if not closed:
        goal += 0.5 * patch.points[patch.at[preceding(ring[count - 1])]]
        tangent += (
            patch.points[patch.at[following(ring[0])]] - patch.points[patch.at[preceding(ring[count - 1])]]
        )
    return goal, tangent


@compiled
def aim(patch: Patch, vertex: int, ring: Indices, count: int, closed: bool) -> tuple[Scalars, Scalars]:
    """The place of a vertex evenly among its neighbours, and its normal, or the direction of its curve."""
    if patch.kind[vertex] == FREE:
        return _aim_within(patch, vertex, ring, count)
    return _aim_along(patch, ring, count, closed)


@compiled
def settle(patch: Patch, guide: Guide, vertex: int, closed: bool, facing: Scalars, place: Scalars) -> bool:
    """Move a place to the closest point of what the vertex must lie on, and return whether there is one.

    Only parts of the surface or boundary count that face the same way as `facing`.
    """
    spot = place.copy()
    if patch.kind[vertex] == FREE:
        return nearest(guide.surface, spot, facing, place) >= 0
    return nearest(guide.creases if closed else guide.rims, spot, facing, place) >= 0


@compiled
def slide(patch: Patch, guide: Guide, vertex: int, ring: Indices) -> bool:
    """Move a vertex towards its aim and back onto the surface; return whether a step was allowed.

    The whole way is tried first, then half of it, a quarter, and at last none (back onto the surface only).
    """
    count, closed = corners_around(patch, vertex, ring)
    if count == 0 or patch.kind[vertex] == LOCKED:
        return False
    goal, facing = aim(patch, vertex, ring, count, closed)
    for step, worse in ((1.0, 1.0), (0.5, 1.0), (0.25, 1.0), (0.0, 1.0), (0.0, DESPERATE)):
        place = patch.points[vertex] + step * (goal - patch.points[vertex])
        if settle(patch, guide, vertex, closed, facing, place) and may_move(
            patch, ring, count, vertex, place, -1, worse
        ):
            patch.points[vertex] = place
            return True
    return False
