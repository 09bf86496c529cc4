"""Straightest geodesics (the naive tracing of Section 3, Fig. 3).

A straightest geodesic (Polthier and Schmies 1998) goes straight on inside a face, across an edge once the two
faces are unfolded, and through a vertex with the same angle to its left and right.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from geoweave.arrays import Complexes, Indices, Scalars, Vectors
from geoweave.compiled import compiled
from geoweave.curves.curves import Curves
from geoweave.curves.face_walk import (
    EDGE_MARGIN,
    Ground,
    corner,
    ground,
    in_space,
    leave,
    on_edge_in_space,
    planar,
    straight_through,
    unfold,
)
from geoweave.errors import FieldError
from geoweave.surface import TriMesh

__all__ = ["straightest"]

OUTSIDE = 1e-6
"""A start may lie outside its face by this share of the face's size."""

STEEP = 1e-9
"""A direction whose part in the plane of its face is a smaller share of it is normal to the face."""

STANDSTILL = 1e-12
"""Steps shorter than this share of the mean edge make no point of their own."""


def straightest(
    mesh: TriMesh,
    faces: ArrayLike,
    directions: ArrayLike,
    length: ArrayLike,
    *,
    points: ArrayLike | None = None,
    behind: ArrayLike = 0.0,
) -> Curves:
    """Trace straightest geodesics from points in faces, in given directions and for given lengths.

    Parameters
    ----------
    mesh : the surface
    faces : (n,) face of each start
    directions : (n, 3) vectors in space; what is normal to the face is dropped
    length : how far to go, one number or (n,); a geodesic ends early at the boundary
    points : (n, 3) starts; the centres of the faces if not given
    behind : how far to go the other way as well; the curve then starts there

    Returns
    -------
    Curves
        One for each start, in their order, of turning zero everywhere.

    Raises
    ------
    FieldError
        If the shapes do not fit, a start is not in its face, a direction is normal to its face, or a length
        is not positive.

    Examples
    --------
    >>> import geoweave as gw
    >>> ring = gw.shapes.torus(faces=400)
    >>> line = gw.straightest(ring, [0], ring.frames[[0], 0], 2.0)
    >>> line.lengths.round(6), line.turning.any()
    (array([2.]), np.False_)
    """
    face = np.asarray(faces, dtype=np.int64).ravel()
    n = len(face)
    if n and not (face.min() >= 0 and face.max() < mesh.n_faces):
        raise FieldError(f"a geodesic starts in a face outside 0..{mesh.n_faces - 1}")
    start = mesh.barycenters[face] if points is None else np.asarray(points, dtype=np.float64)
    heading = np.asarray(directions, dtype=np.float64)
    for array, name in ((start, "starts"), (heading, "directions")):
        if array.shape != (n, 3):
            raise FieldError(f"the {name} of {n} geodesics need shape ({n}, 3), not {array.shape}")
    ahead = np.broadcast_to(np.asarray(length, dtype=np.float64), (n,))
    back = np.broadcast_to(np.asarray(behind, dtype=np.float64), (n,))
    if not (np.isfinite(ahead).all() and (ahead > 0).all() and np.isfinite(back).all() and (back >= 0).all()):
        raise FieldError("the lengths of geodesics must be positive and finite, and not negative behind")
    place = planar(mesh, face, start - mesh.vertices[mesh.faces[face, 0]])
    _check_inside(mesh, face, place)
    way = planar(mesh, face, heading)
    size = np.abs(way)
    steep = ~(size > STEEP * np.linalg.norm(heading, axis=1))
    if steep.any():
        raise FieldError(
            f"the direction of geodesic {int(np.flatnonzero(steep)[0])} has no part in the plane of its face"
        )
    surface = ground(mesh, np.zeros(mesh.n_faces, dtype=np.complex128), np.zeros(mesh.n_vertices))
    least = STANDSTILL * mesh.mean_edge
    way = way / size
    found = _walk_all(surface, face, place, way, np.ascontiguousarray(ahead), least)
    if not back.any():
        return _curves(mesh, *found)
    other = _walk_all(surface, face, place, -way, np.ascontiguousarray(back), least)
    return _curves(mesh, *_back_to_back(other, found))


def _check_inside(mesh: TriMesh, faces: Indices, places: Complexes) -> None:
    sides = mesh.halfedge_vectors[faces]
    tails = np.stack([sides[:, 2], -sides[:, 1], np.zeros(len(faces))], axis=1)
    share = (sides.conj() * (places[:, None] - tails)).imag / (2.0 * mesh.face_areas[faces])[:, None]
    outside = (share < -OUTSIDE).any(axis=1)
    if outside.any():
        bad = int(np.flatnonzero(outside)[0])
        raise FieldError(f"the start of geodesic {bad} is not in its face {int(faces[bad])}")


@compiled
def _walk_all(
    g: Ground, faces: Indices, places: Complexes, ways: Complexes, lengths: Scalars, least: float
) -> tuple[Vectors, Indices, Indices]:
    """Points, their faces and the number of points of each geodesic."""
    room = 64 * max(1, len(faces))
    points, own = np.empty((room, 3)), np.empty(room, dtype=np.int64)
    sizes = np.empty(len(faces), dtype=np.int64)
    total = 0
    for number in range(len(faces)):
        face, place, way, left = faces[number], places[number], ways[number], lengths[number]
        entry, first = -1, total
        in_space(g, face, place, points[total])
        own[total] = face
        total += 1
        while left > 0.0:
            if total + 1 > room - 1:
                room *= 2
                more, more_own = np.empty((room, 3)), np.empty(room, dtype=np.int64)
                more[:total], more_own[:total] = points[:total], own[:total]
                points, own = more, more_own
            k, share = leave(g, face, place, way, entry)
            a, b = (k + 1) % 3, (k + 2) % 3
            hit = a if share <= EDGE_MARGIN else (b if share >= 1.0 - EDGE_MARGIN else -1)
            target = corner(g, face, hit) if hit >= 0 else corner(g, face, a) + share * g.sides[face, k]
            step = abs(target - place)
            if step >= left:
                in_space(g, face, place + left * way, points[total])
                own[total] = face
                total += 1
                break
            own[total - 1] = face
            if step > least:
                if hit >= 0:
                    points[total] = g.vertices[g.faces[face, hit]]
                else:
                    on_edge_in_space(g, face, k, share, points[total])
                own[total] = face
                total += 1
            left -= step
            if hit >= 0:
                if g.around[g.faces[face, hit]] == 0.0:
                    break
                face, c, way = straight_through(g, face, hit, way)
                place, entry = corner(g, face, c), 3 + c
            else:
                other = g.across[face, k]
                if other < 0:
                    break
                way = way * unfold(g, face, k)
                face, entry = other // 3, other % 3
                place = corner(g, face, (entry + 1) % 3) + (1.0 - share) * g.sides[face, entry]
            own[total - 1] = face
        # The last point belongs to the face of the segment before it.
        if total - first > 1:
            own[total - 1] = own[total - 2]
        sizes[number] = total - first
    return points[:total], own[:total], sizes


def _back_to_back(
    back: tuple[Vectors, Indices, Indices], ahead: tuple[Vectors, Indices, Indices]
) -> tuple[Vectors, Indices, Indices]:
    """Reverse the first lines and append the second ones, which have the same starts."""
    lengths = back[2] - 1
    ends = np.cumsum(back[2])
    # Points of a line backwards without its start; their segments lie in the faces one point nearer to it.
    turned = np.concatenate([[0], np.cumsum(lengths)])
    within = np.arange(turned[-1]) - np.repeat(turned[:-1], lengths)
    source = np.repeat(ends - 1, lengths) - within
    at = np.repeat(np.concatenate([[0], np.cumsum(ahead[2])[:-1]]), lengths)
    points = np.insert(ahead[0], at, back[0][source], axis=0)
    faces = np.insert(ahead[1], at, back[1][source - 1])
    return points, faces, lengths + ahead[2]


def _curves(mesh: TriMesh, points: Vectors, faces: Indices, sizes: Indices) -> Curves:
    if (sizes < 2).any():
        bad = int(np.flatnonzero(sizes < 2)[0])
        raise FieldError(f"geodesic {bad} starts at the boundary and heads outwards")
    total = len(points)
    return Curves(
        mesh,
        points,
        faces,
        np.zeros(total),
        np.zeros(total, dtype=bool),
        np.concatenate([[0], np.cumsum(sizes)]),
        np.zeros(len(sizes), dtype=bool),
    )
