"""Split, collapse and flip the edges of a mesh, and slide its vertices, without changing its topology.

Each pass goes through a list of edges in the order given, and changes the arrays of a `Patch` in place.
"""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Indices, Scalars
from geoweave.compiled import compiled
from geoweave.meshing.halfedge_patch import (
    FLOOR,
    FREE,
    LOCKED,
    ON_CURVE,
    ROOM,
    Guide,
    Patch,
    agree,
    aim,
    area_vector,
    corners_around,
    distance,
    following,
    may_move,
    preceding,
    settle,
    slide,
)

LONGER = 1.1
"""A collapse may stretch a side that is too long already by this factor, and no further."""

NEEDLES = 0.5
"""Share of its quality that a collapse must leave to a face that is bad already.

Below 1, because the faces of a fan of needles get worse before they get better.
"""

SAME_CIRCLE = 1e-6
"""An edge is flipped towards Delaunay where its two cotangents add up to less than minus this."""

SAME_SIDE = 0.5
"""Cosine of the farthest that the normal of a flipped face may turn from the mean normal of the two."""

NO_ANGLE = 1e30
"""Stands for the cotangent of an angle of zero."""


@compiled
def _joined(patch: Patch, a: int, b: int, ring: Indices) -> bool:
    """Whether an edge joins two vertices; also True where `a` has more faces than the ring has room for."""
    count, _ = corners_around(patch, a, ring)
    for i in range(count):
        if b in (patch.at[following(ring[i])], patch.at[preceding(ring[i])]):
            return True
    return count == 0


@compiled
def _split(patch: Patch, h: int, vertex: int, face: int) -> int:
    """Halve an edge by the vertex `vertex`, using faces from `face` on; return the next unused face."""
    points, kind, corner, at, over, marked = patch
    g = over[h]
    sides = np.array([h, g])
    ends = np.array([at[following(h)], at[preceding(h)]])
    points[vertex] = 0.5 * (points[ends[0]] + points[ends[1]])
    kind[vertex] = ON_CURVE if marked[h] else FREE
    for s in range(2 if g >= 0 else 1):
        e, new = sides[s], 3 * (face + s)
        far, apex = ends[1 - s], at[e]
        beyond = over[following(e)]
        at[preceding(e)] = vertex
        at[new], at[new + 1], at[new + 2] = vertex, far, apex
        over[new], marked[new] = beyond, marked[following(e)]
        if beyond >= 0:
            over[beyond] = new
        over[following(e)], over[new + 1] = new + 1, following(e)
        marked[following(e)] = marked[new + 1] = False
        marked[new + 2] = marked[e]
        over[new + 2] = -1
        corner[far] = new + 1
    corner[vertex] = 3 * face
    if g < 0:
        return face + 1
    over[h], over[3 * (face + 1) + 2] = 3 * (face + 1) + 2, h
    over[g], over[3 * face + 2] = 3 * face + 2, g
    return face + 2


@compiled
def split_edges(
    patch: Patch, guide: Guide, edges: Indices, longest: float, budget: int, vertex: int, face: int
) -> tuple[int, int]:
    """Split the listed half-edges that are longer than `longest`, until `budget` faces have been added.

    `vertex` and `face` are the first unused ones; the next unused ones are returned.
    """
    ring = np.empty(ROOM, dtype=np.int64)
    limit = face + budget
    for i in range(len(edges)):
        h = edges[i]
        if face >= limit:
            break
        if distance(patch.points[patch.at[following(h)]], patch.points[patch.at[preceding(h)]]) > longest:
            face = _split(patch, h, vertex, face)
            slide(patch, guide, vertex, ring)
            vertex += 1
    return vertex, face


@compiled
def _may_close(patch: Patch, h: int, ring: Indices) -> bool:
    """Whether the face of half-edge h may be removed: its apex keeps enough faces, and no two curves meet."""
    n, b = following(h), preceding(h)
    if (patch.over[n] < 0 and patch.over[b] < 0) or (patch.marked[n] and patch.marked[b]):
        return False
    count, closed = corners_around(patch, patch.at[h], ring)
    return count > (3 if closed else 1)


@compiled
def _close(patch: Patch, h: int, keep: int) -> None:
    """Remove the face of half-edge h and join its two other edges, which both end in `keep`."""
    n, b = following(h), preceding(h)
    x, y = patch.over[n], patch.over[b]
    mark = patch.marked[n] or patch.marked[b]
    apex = patch.at[h]
    if x >= 0:
        patch.over[x], patch.marked[x] = y, mark
        patch.corner[apex], patch.corner[keep] = following(x), preceding(x)
    if y >= 0:
        patch.over[y], patch.marked[y] = x, mark
        patch.corner[apex], patch.corner[keep] = preceding(y), following(y)
    for k in range(3):
        patch.at[3 * (h // 3) + k] = -1


@compiled
def _fits(
    patch: Patch, rings: Indices, here: int, there: int, drop: int, keep: int, place: Scalars, longest: float
) -> bool:
    """Whether the two ends of an edge may both move to a place.

    No side may become longer than `longest`. A side that is longer already may grow by the factor `LONGER`:
    in a fan of needles the long sides stay until the short ones have been collapsed.
    """
    for s in range(2):
        vertex, other, count = (drop, keep, here) if s == 0 else (keep, drop, there)
        if not may_move(patch, rings[s], count, vertex, place, other, NEEDLES):
            return False
        for i in range(count):
            for end in (patch.at[following(rings[s, i])], patch.at[preceding(rings[s, i])]):
                now = distance(patch.points[end], patch.points[vertex])
                if end != other and distance(patch.points[end], place) > max(longest, LONGER * now):
                    return False
    return True


@compiled
def _collapse(
    patch: Patch, guide: Guide, h: int, keep: int, drop: int, longest: float, rings: Indices
) -> int:
    """Move the vertex `drop` to `keep` along half-edge h, if that is allowed; return how many faces went.

    The topology must stay (the link condition holds, and both apexes keep enough faces). No face may turn
    over, become a sliver or get a side longer than `longest`.
    """
    points, kind, corner, at, over, marked = patch
    if kind[drop] == LOCKED or (kind[drop] == ON_CURVE and not marked[h]):
        return 0
    g = over[h]
    here, closed = corners_around(patch, drop, rings[0])
    there, there_closed = corners_around(patch, keep, rings[1])
    if here == 0 or there == 0 or (g >= 0 and not closed and not there_closed):
        return 0
    common = 0
    for i in range(-1 if not closed else 0, here):
        a = at[preceding(rings[0, here - 1])] if i < 0 else at[following(rings[0, i])]
        for j in range(-1 if not there_closed else 0, there):
            b = at[preceding(rings[1, there - 1])] if j < 0 else at[following(rings[1, j])]
            if a == b:
                common += 1
    if common != (1 if g < 0 else 2):
        return 0
    if not _may_close(patch, h, rings[2]) or (g >= 0 and not _may_close(patch, g, rings[2])):
        return 0
    place = points[keep].copy()
    fits = False
    if kind[keep] == kind[drop]:
        _, facing = aim(patch, keep, rings[1], there, there_closed)
        place = 0.5 * (place + points[drop])
        fits = settle(patch, guide, keep, there_closed, facing, place) and _fits(
            patch, rings, here, there, drop, keep, place, longest
        )
    if not fits:
        place = points[keep].copy()
        if not _fits(patch, rings, here, there, drop, keep, place, longest):
            return 0
    points[keep] = place
    _close(patch, h, keep)
    if g >= 0:
        _close(patch, g, keep)
    for i in range(here):
        if at[rings[0, i]] >= 0:
            at[rings[0, i]] = keep
    corner[drop] = -1
    return 1 if g < 0 else 2


@compiled
def collapse_edges(
    patch: Patch, guide: Guide, edges: Indices, shortest: float, longest: float, budget: int
) -> int:
    """Collapse the listed half-edges shorter than `shortest`, up to `budget` faces; return how many went."""
    rings = np.empty((3, ROOM), dtype=np.int64)
    gone = 0
    for i in range(len(edges)):
        h = edges[i]
        if gone >= budget:
            break
        if patch.at[h] < 0:
            continue
        a, b = patch.at[following(h)], patch.at[preceding(h)]
        if distance(patch.points[a], patch.points[b]) >= shortest:
            continue
        if patch.kind[a] > patch.kind[b]:
            a, b = b, a
        went = _collapse(patch, guide, h, b, a, longest, rings)
        if went == 0 and patch.kind[a] == patch.kind[b]:
            went = _collapse(patch, guide, h, a, b, longest, rings)
        gone += went
    return gone


@compiled
def _excess(patch: Patch, vertex: int, change: int, ring: Indices) -> int:
    """Squared difference from 6 faces (boundary: 3) of a vertex after a change; -1 if too few stay."""
    count, closed = corners_around(patch, vertex, ring)
    if count == 0:
        return 0
    after = count + change
    if after < (3 if closed else 1):
        return -1
    wanted = 6 if closed else 3
    return (after - wanted) ** 2


@compiled
def _cotangent(a: Scalars, b: Scalars, c: Scalars) -> float:
    """Cotangent of the angle at a."""
    inner = size = 0.0
    x, y, z, _ = area_vector(a, b, c)
    for k in range(3):
        inner += (b[k] - a[k]) * (c[k] - a[k])
    size = np.sqrt(x * x + y * y + z * z)
    return float(inner / size) if size > 0.0 else NO_ANGLE


@compiled
def flip_edges(patch: Patch, delaunay: bool) -> int:
    """Flip edges towards 6 faces per vertex, or towards Delaunay; return how many were flipped.

    A marked edge stays, and so does one whose other diagonal is an edge already, or whose faces would turn
    over or become slivers.
    """
    points, _, corner, at, over, marked = patch
    ring = np.empty(ROOM, dtype=np.int64)
    flips = 0
    for h in range(len(at)):
        g = over[h]
        if at[h] < 0 or g < h or marked[h]:
            continue
        a, b, c, d = at[following(h)], at[preceding(h)], at[h], at[g]
        if delaunay:
            gain = _cotangent(points[c], points[a], points[b]) + _cotangent(points[d], points[a], points[b])
            if gain >= -SAME_CIRCLE:
                continue
            if _excess(patch, a, -1, ring) < 0 or _excess(patch, b, -1, ring) < 0:
                continue
        else:
            before = after = 0
            possible = True
            for vertex, change in ((a, -1), (b, -1), (c, 1), (d, 1)):
                then = _excess(patch, vertex, change, ring)
                possible = possible and then >= 0
                before += _excess(patch, vertex, 0, ring)
                after += then
            if not possible or after >= before:
                continue
        ax, ay, az, q1 = area_vector(points[c], points[a], points[b])
        bx, by, bz, q2 = area_vector(points[d], points[b], points[a])
        sx, sy, sz = ax + bx, ay + by, az + bz
        ux, uy, uz, q3 = area_vector(points[c], points[a], points[d])
        vx, vy, vz, q4 = area_vector(points[d], points[b], points[c])
        if min(q3, q4) < min(FLOOR, min(q1, q2)) or min(q3, q4) <= 0.0:
            continue
        if not (agree(sx, sy, sz, ux, uy, uz, SAME_SIDE) and agree(sx, sy, sz, vx, vy, vz, SAME_SIDE)):
            continue
        if _joined(patch, c, d, ring):
            continue
        x, y = over[following(h)], over[following(g)]
        over[h], marked[h] = y, marked[following(g)]
        over[g], marked[g] = x, marked[following(h)]
        if y >= 0:
            over[y] = h
        if x >= 0:
            over[x] = g
        over[following(h)], over[following(g)] = following(g), following(h)
        marked[following(h)] = marked[following(g)] = False
        at[preceding(h)], at[preceding(g)] = d, c
        corner[a], corner[b], corner[c], corner[d] = following(h), following(g), h, g
        flips += 1
    return flips


@compiled
def relax_vertices(patch: Patch, guide: Guide) -> int:
    """Slide each vertex towards the middle of its faces and back onto the surface, or along its curve.

    A vertex stays where it is if each step tried would turn a face over. Return how many moved.
    """
    ring = np.empty(ROOM, dtype=np.int64)
    moved = 0
    for vertex in range(len(patch.points)):
        if patch.corner[vertex] >= 0 and slide(patch, guide, vertex, ring):
            moved += 1
    return moved
