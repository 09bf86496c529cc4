"""Level sets of a circle-valued function: the leaves of the foliation it stands for (Sections 3 and 4.2).

Whether a level crosses an edge, and how often, is decided in integers, the same for every face that meets
there: a vertex exactly at the level counts as just above it. So no segment is lost or found twice, wherever
the level falls; only then are the places of the crossings computed.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np

from geoweave.arrays import Flags, Indices, Scalars
from geoweave.compiled import compiled
from geoweave.curves import Curves, lifted
from geoweave.errors import FieldError
from geoweave.foliation.circle_function import TURN, CircleFunction, wrapped
from geoweave.foliation.foliation import Foliation
from geoweave.surface import TriMesh

__all__ = ["isolines"]

SNAP = 1e-9
"""A crossing within this share of an edge from its end lies in the vertex there."""

AT_LEVEL = 1e-12
"""A vertex within so many turns of the level is at the level: far above rounding, far below any edge."""


def isolines(function: CircleFunction | Foliation, levels: Sequence[float] = (0.5 * np.pi,)) -> Curves:
    """Extract the level sets ``theta = level`` (modulo full turns) of a circle-valued function.

    In each face they are the straight level lines of the linear function with the given changes along its
    edges; an edge is crossed several times if theta turns more than once along it. Lines are joined over
    shared edges, closed where they close, and end at the boundary. In a face with an edge dislocation of n
    turns all but n crossings of its edges are joined, next to the corners first so that no two lines cross,
    and n lines end at an edge of it (Section 4.2.1).

    Lines run with theta growing to their right: the field ``w`` with ``grad theta = -i w`` (the paper's
    clockwise ``w-perp``) points along them.

    Parameters
    ----------
    function : theta, or a foliation, whose level sets are then drawn on the whole surface
    levels : the levels, radians; lines of the first level come first

    Returns
    -------
    Curves
        Possibly none. Where a line passes a vertex it has one point there, and its turning angle is half the
        difference of the angles to its right and its left, as on a straightest geodesic. A ridge exactly at
        its level is surrounded, a peak left out.

    Raises
    ------
    FieldError
        If a level is not finite.

    Examples
    --------
    >>> import geoweave as gw
    >>> field = gw.geodesic_field(gw.smoothest_field(gw.shapes.torus(faces=400))).field
    >>> leaves = gw.isolines(gw.foliate(field), [0.0, 3.14])
    >>> bool(leaves.closed.all()), len(leaves) >= 2
    (True, True)
    """
    if isinstance(function, Foliation):
        return lifted(isolines(function.circle, levels), function.part)
    circle = function
    asked = np.asarray(levels, dtype=np.float64).ravel()
    if not np.isfinite(asked).all():
        raise FieldError(f"the levels of isolines must be finite, not {asked.tolist()}")
    found = [_level_set(circle, float(level)) for level in asked]
    return found[0] if len(found) == 1 else Curves.concatenate(circle.mesh, chain.from_iterable(found))


class _Crossings(NamedTuple):
    """Where one level crosses the edges, edge after edge, and along each edge in its direction."""

    edge: Indices
    """(n,) edge that is crossed."""
    share: Scalars
    """(n,) share of the edge, 0 at its start, at which it is."""
    rising: Flags
    """(n,) whether theta grows along the edge."""
    first: Indices
    """(E,) the first crossing of each edge."""
    turns: Indices
    """(E,) number of crossings of each edge, negative where theta falls along it."""
    above: Scalars
    """(V,) height of each vertex above the level, in turns, in [0, 1)."""


def _level_set(circle: CircleFunction, level: float) -> Curves:
    mesh = circle.mesh
    crossings = _cross(circle, level)
    following, face = _match(mesh, crossings)
    tail, head = mesh.edges[crossings.edge].T
    vertex = np.where(crossings.share < SNAP, tail, np.where(crossings.share > 1.0 - SNAP, head, -1))
    order, sizes, closed = _chains(following, vertex)
    # What passes through a vertex from edge to edge is one point there: a run of crossings.
    owner = np.repeat(np.arange(len(sizes)), sizes)
    place, at = order, vertex[order]
    starts = np.ones(len(order), dtype=bool)
    starts[1:] = (at[1:] < 0) | (at[1:] != at[:-1]) | (owner[1:] != owner[:-1])
    kept = np.bincount(owner[starts], minlength=len(sizes)) > 1
    starts, inside = starts[kept[owner]], kept[owner]
    place, owner, at = place[inside], owner[inside], at[inside]
    run = np.flatnonzero(starts)
    counts = np.bincount(owner[starts], minlength=len(sizes))[kept]
    offsets = np.concatenate([[0], np.cumsum(counts)])
    closed = closed[kept]
    last = np.append(run, len(place))[1:] - 1

    share, vertex_of_run = crossings.share[place[run]], at[run]
    ends = mesh.vertices[mesh.edges[crossings.edge[place[run]]]]
    points = (1.0 - share)[:, None] * ends[:, 0] + share[:, None] * ends[:, 1]
    points = np.where(vertex_of_run[:, None] >= 0, mesh.vertices[vertex_of_run], points)
    faces = face[place[last]]
    tips = offsets[1:][~closed] - 1
    faces[tips] = faces[tips - 1]
    # Unfolding turns the frames; the sum over a run is the turn from the face before to the face after.
    turn = np.add.reduceat(_unfolding(mesh, crossings)[place], run) if len(run) else np.empty(0)
    on_vertex = np.flatnonzero(vertex_of_run >= 0)
    passed = vertex_of_run[on_vertex]
    # The vertex lies to the right if it is above the level; half of its defect belongs to either side.
    right = crossings.above[passed] < 0.5
    half = 0.5 * np.where(mesh.boundary_vertices[passed], 0.0, mesh.angle_defects[passed])
    extra = np.zeros(len(run))
    extra[on_vertex] = np.where(right, -half, half)
    turning = _turning(mesh, points, faces, turn, offsets, closed) + extra
    turning[np.concatenate([offsets[:-1][~closed], tips])] = 0.0
    return Curves(mesh, points, faces, turning, np.zeros(len(points), dtype=bool), offsets, closed)


def _cross(circle: CircleFunction, level: float) -> _Crossings:
    """Find where a level crosses the edges."""
    mesh = circle.mesh
    above = (circle.theta - level) / TURN
    above -= np.floor(above)
    above[np.minimum(above, 1.0 - above) < AT_LEVEL] = 0.0
    tail, head = mesh.edges.T
    start, change = above[tail], above[head] - above[tail]
    # In turns above the level both ends are in [0, 1) up to an integer, and that is the number of crossings.
    turns = np.rint(circle.jumps / TURN - change).astype(np.int64)
    count = np.abs(turns)
    first = np.cumsum(count) - count
    edge = np.repeat(np.arange(mesh.n_edges), count)
    step = np.arange(len(edge)) - first[edge]
    rising = turns[edge] > 0
    height = np.where(rising, 1 + step, -step)
    share = (height - start[edge]) / (change + turns)[edge]
    return _Crossings(edge, np.clip(share, 0.0, 1.0), rising, first, turns, above)


def _match(mesh: TriMesh, crossings: _Crossings) -> tuple[Indices, Indices]:
    """Join crossings within each face: the crossing after each one, and the face between (-1 if none).

    Lines enter a face where theta grows along its boundary and leave where it falls. Those nearest to a
    corner are joined round it first.
    """
    signed = (crossings.turns[mesh.face_edges] * mesh.face_edge_signs).astype(np.int64)
    count = np.abs(signed)
    following = np.full(len(crossings.edge), -1, dtype=np.int64)
    face_of = np.full(len(crossings.edge), -1, dtype=np.int64)
    # At most one side differs in sign from both others, and all that is joined is joined to it.
    joined = np.zeros_like(count)
    for k in range(3):
        p, q = (k + 1) % 3, (k + 2) % 3
        lone = (signed[:, k] != 0) & (signed[:, k] * signed[:, p] <= 0) & (signed[:, k] * signed[:, q] <= 0)
        own, one, two = count[:, k], count[:, p], count[:, q]
        # Of the lines left over in a dislocated face, about half are left on each of the two sides.
        low, high = np.maximum(0, own - two), np.minimum(one, own)
        with_one = np.where(one + two <= own, one, (low + high) // 2)
        with_two = np.where(one + two <= own, two, own - with_one)
        # Sides k and k + 1 meet in corner k + 2, sides k and k + 2 in corner k + 1.
        joined[lone, q] = with_one[lone]
        joined[lone, p] = with_two[lone]
    corner = np.repeat(np.arange(joined.size), joined.ravel())
    nth = np.arange(len(corner)) - np.repeat(np.cumsum(joined.ravel()) - joined.ravel(), joined.ravel())
    f, c = corner // 3, corner % 3
    # Counted from the corner: side c + 1 ends there, side c + 2 starts there.
    before, after = (c + 1) % 3, (c + 2) % 3
    one = _nth_crossing(mesh, crossings, f, before, count[f, before] - 1 - nth)
    two = _nth_crossing(mesh, crossings, f, after, nth)
    enters = signed[f, before] > 0
    start, end = np.where(enters, one, two), np.where(enters, two, one)
    following[start], face_of[start] = end, f
    return following, face_of


def _nth_crossing(mesh: TriMesh, crossings: _Crossings, face: Indices, side: Indices, n: Indices) -> Indices:
    """Find the n-th crossing along a side of a face, in the direction of the face's boundary."""
    edge = mesh.face_edges[face, side]
    along = mesh.face_edge_signs[face, side] > 0
    return crossings.first[edge] + np.where(along, n, np.abs(crossings.turns[edge]) - 1 - n)


@compiled
def _chains(following: Indices, vertex: Indices) -> tuple[Indices, Indices, Flags]:
    """Order crossings along lines: open lines first, then closed ones, which start where no run goes on.

    Crossings joined to no other are left out.
    """
    total = len(following)
    previous = np.full(total, -1, dtype=np.int64)
    for p in range(total):
        if following[p] >= 0:
            previous[following[p]] = p
    order = np.empty(total, dtype=np.int64)
    sizes = np.empty(total, dtype=np.int64)
    closed = np.empty(total, dtype=np.bool_)
    seen = np.zeros(total, dtype=np.bool_)
    n, lines = 0, 0
    for loop in (False, True):
        for p in range(total):
            if seen[p] or following[p] < 0 or (not loop and previous[p] >= 0):
                continue
            start = p
            if loop:
                while vertex[start] >= 0 and vertex[previous[start]] == vertex[start]:
                    start = previous[start]
                    if start == p:
                        break
            q, first = start, n
            while q >= 0 and not seen[q]:
                seen[q] = True
                order[n] = q
                n += 1
                q = following[q]
            sizes[lines], closed[lines] = n - first, loop
            lines += 1
    return order[:n], sizes[:lines], closed[:lines]


def _unfolding(mesh: TriMesh, crossings: _Crossings) -> Scalars:
    """(n,) angle by which unfolding turns vectors from the face a line leaves into the one it enters."""
    turn = np.zeros(mesh.n_edges)
    turn[mesh.interior_edges] = np.angle(mesh.transport)
    # Where theta grows along an edge the line enters its first face, from face j into face i.
    return np.where(crossings.rising, -1.0, 1.0) * turn[crossings.edge]


def _turning(
    mesh: TriMesh, points: Scalars, faces: Indices, turn: Scalars, offsets: Indices, closed: Flags
) -> Scalars:
    """(P,) angle that lines turn at each point once the faces they pass there are unfolded."""
    after = np.arange(1, len(points) + 1)
    before = np.arange(-1, len(points) - 1)
    first, last = offsets[:-1], offsets[1:] - 1
    after[last], before[first] = first, last
    step = points[after] - points
    frames = mesh.frames[faces]
    heading = np.arctan2(np.einsum("px,px->p", step, frames[:, 1]), np.einsum("px,px->p", step, frames[:, 0]))
    return wrapped(heading - heading[before] - turn)
