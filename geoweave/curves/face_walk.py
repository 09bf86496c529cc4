"""Walking over a surface from face to face, exactly: straight inside a face, unfolded across an edge.

The walks are compiled and work on the flat arrays of `Ground`. A place on the surface is a face and a complex
number in the frame of that face, whose origin is the face's corner 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geoweave.arrays import Complexes, Indices, Scalars, Vectors
from geoweave.compiled import compiled
from geoweave.surface import TriMesh

EDGE_MARGIN = 1e-9
"""Crossings keep this share of an edge away from its ends, so that a line passes a vertex on one side."""

WALL = 0.5
"""Cosine of 60 degrees: vectors that meet at an edge at a wider angle form a wall, where lines end."""

WALL_ANGLE = np.pi / 3
"""The same as an angle, radians."""

MOST_FACES = 100_000
"""Faces that one walk may pass, so that it ends whatever the mesh."""


class Ground(NamedTuple):
    """The arrays of a mesh, and of a field on it, that the compiled walks read."""

    across: Indices
    """(F, 3) half-edge ``3 g + k`` on the other side of each half-edge, -1 on the boundary."""
    sides: Complexes
    """(F, 3) the half-edges in the frames of their faces."""
    field: Complexes
    """(F,) unit vectors, or zero where the field vanishes."""
    faces: Indices
    """(F, 3) vertices of the faces."""
    vertices: Vectors
    """(V, 3) positions."""
    frames: Vectors
    """(F, 2, 3) frames of the faces."""
    normals: Vectors
    """(F, 3) unit normals."""
    around: Scalars
    """(V,) sum of the angles at each vertex; 0 on the boundary."""
    guard: Scalars
    """(V,) radius around each vertex in which a line ends; 0 at regular vertices."""


def ground(mesh: TriMesh, values: Complexes, guard: Scalars) -> Ground:
    """Collect the arrays for walks along a field, with a radius around each vertex in which lines end."""
    halfedges = mesh.edge_halfedges
    along, against = halfedges[:, 0], halfedges[:, 1]
    across = np.full(3 * mesh.n_faces, -1, dtype=np.int64)
    across[along] = against
    inner = against >= 0
    across[against[inner]] = along[inner]
    size = np.abs(values)
    field = np.where(size > 0, values / np.where(size > 0, size, 1.0), 0.0)
    around = np.where(mesh.boundary_vertices, 0.0, 2.0 * np.pi - mesh.angle_defects)
    return Ground(
        across.reshape(-1, 3), mesh.halfedge_vectors, field, mesh.faces, mesh.vertices, mesh.frames,
        mesh.face_normals, around, guard,
    )  # fmt: skip


def planar(mesh: TriMesh, faces: Indices, vectors: Vectors) -> Complexes:
    """(n,) coordinates of vectors in the frames of faces; the part normal to the face is dropped."""
    frames = mesh.frames[faces]
    return np.asarray(
        np.einsum("px,px->p", vectors, frames[:, 0]) + 1j * np.einsum("px,px->p", vectors, frames[:, 1])
    )


@compiled
def cross(a: complex, b: complex) -> float:
    """Area spanned by two plane vectors, positive when b is to the left of a."""
    return a.real * b.imag - a.imag * b.real


@compiled
def dot(a: complex, b: complex) -> float:
    """Scalar product of two plane vectors."""
    return a.real * b.real + a.imag * b.imag


@compiled
def corner(g: Ground, face: int, k: int) -> complex:
    """Place of a corner in the frame of its face."""
    if k == 0:
        return 0j
    place: complex = g.sides[face, 2] if k == 1 else -g.sides[face, 1]
    return place


@compiled
def in_space(g: Ground, face: int, place: complex, out: Vectors) -> None:
    """Write the point of space of a place on a face."""
    origin = g.faces[face, 0]
    for x in range(3):
        out[x] = g.vertices[origin, x] + place.real * g.frames[face, 0, x] + place.imag * g.frames[face, 1, x]


@compiled
def on_edge_in_space(g: Ground, face: int, k: int, t: float, out: Vectors) -> None:
    """Write the point of space at share t of a half-edge, the same to the last bit from either face."""
    a, b = g.faces[face, (k + 1) % 3], g.faces[face, (k + 2) % 3]
    if a > b:
        a, b, t = b, a, 1.0 - t
    for x in range(3):
        out[x] = (1.0 - t) * g.vertices[a, x] + t * g.vertices[b, x]


@compiled
def leave(g: Ground, face: int, place: complex, way: complex, entry: int) -> tuple[int, float]:
    """Find where a straight line leaves a face: the half-edge and the share of it.

    ``entry`` names the half-edge the line came in by (0-2), 3 + k a corner k it starts from, -1 neither.
    """
    best, exit_side = np.inf, -1
    for k in range(3):
        if k == entry or (entry >= 3 and k != entry - 3):
            continue
        side = g.sides[face, k]
        outward = cross(way, side)
        if outward > 0.0:
            distance = max(0.0, cross(side, place - corner(g, face, (k + 1) % 3))) / outward
            if distance < best:
                best, exit_side = distance, k
    if exit_side < 0:
        # Rounding only: a line parallel to the edge it came in by, or grazing the corner it starts from.
        exit_side = entry - 3 if entry >= 3 else (entry + 1) % 3
        best = 0.0
    side = g.sides[face, exit_side]
    share = dot(side, place + best * way - corner(g, face, (exit_side + 1) % 3)) / dot(side, side)
    return exit_side, min(max(share, EDGE_MARGIN), 1.0 - EDGE_MARGIN)


@compiled
def unfold(g: Ground, face: int, k: int) -> complex:
    """Rotation that takes a vector of a face into the frame of the face across half-edge k (Eq. 2)."""
    other = g.across[face, k]
    turn: complex = -g.sides[other // 3, other % 3] * g.sides[face, k].conjugate()
    turn /= abs(turn)
    return turn


@compiled
def around_vertex(g: Ground, face: int, k: int, sign: float) -> tuple[int, int, int, float]:
    """Choose where a line goes on after it has come along half-edge k of a face to its head.

    The faces around the vertex are unfolded about it, starting from the edge the line came along. Straight on
    is half the angle around the vertex. The line may go into a face whose own vector leads from the vertex
    into it, or along an edge to which the vectors on both sides point. Of these the one nearest to straight
    on is taken.

    Returns
    -------
    kind (0 into a face, 1 along an edge, -1 nowhere), face, corner of that face at the vertex (the edge is
    the one from that corner to the next), turning angle
    """
    half = 0.5 * g.around[g.faces[face, (k + 2) % 3]]
    # The fan starts with the face whose edge from corner c to c + 1 is the one the line came along.
    other = g.across[face, k]
    start, first = other // 3, (other % 3 + 1) % 3
    kind, best_face, best_corner, best, turning = -1, -1, -1, 0.5 * np.pi, 0.0
    f, c, swept, before = start, first, 0.0, 0.0
    while True:
        out = g.sides[f, (c + 2) % 3]
        back = -g.sides[f, (c + 1) % 3]
        sector = abs(np.angle(back * out.conjugate()))
        way = sign * g.field[f]
        ahead = np.angle(way * out.conjugate()) if way != 0j else np.nan
        if 0.0 <= ahead <= sector:
            turn = swept + ahead - half
            if abs(turn) < best:
                kind, best_face, best_corner, best = 0, f, c, abs(turn)
                turning = turn
        elif swept > 0.0 and ahead < 0.0 < before and before - ahead < WALL_ANGLE:
            turn = swept - half
            if abs(turn) < best:
                kind, best_face, best_corner, best = 1, f, c, abs(turn)
                turning = turn
        before = ahead - sector
        swept += sector
        other = g.across[f, (c + 1) % 3]
        f, c = other // 3, (other % 3 + 1) % 3
        if f == start:
            break
    return kind, best_face, best_corner, turning


@compiled
def straight_through(g: Ground, face: int, c: int, way: complex) -> tuple[int, int, complex]:
    """Go straight on through an interior vertex: half of the angle around it lies on either side.

    The line arrives at corner c of a face in direction ``way``.

    Returns
    -------
    face it enters, corner of that face at the vertex, direction there
    """
    out = g.sides[face, (c + 2) % 3]
    # Angles run counter-clockwise from the side that leaves the corner: first back along the line, then
    # half the total angle on.
    ahead = np.angle(-way * out.conjugate()) + 0.5 * g.around[g.faces[face, c]]
    while True:
        out = g.sides[face, (c + 2) % 3]
        sector = np.angle(-g.sides[face, (c + 1) % 3] * out.conjugate())
        if ahead <= sector:
            break
        ahead -= sector
        other = g.across[face, (c + 1) % 3]
        face, c = other // 3, (other % 3 + 1) % 3
    onward: complex = out / abs(out) * complex(np.cos(ahead), np.sin(ahead))
    return face, c, onward


@compiled
def straight_walk(
    g: Ground, face: int, place: complex, way: complex, length: float
) -> tuple[int, complex, bool]:
    """Follow the straightest geodesic from a place for a given length.

    Returns
    -------
    face and place at its end, and whether it got there before the boundary
    """
    entry = -1
    for _ in range(MOST_FACES):
        k, share = leave(g, face, place, way, entry)
        target = corner(g, face, (k + 1) % 3) + share * g.sides[face, k]
        step = abs(target - place)
        if step >= length:
            return face, place + way * length, True
        length -= step
        other = g.across[face, k]
        if other < 0:
            return face, target, False
        way = way * unfold(g, face, k)
        face, entry = other // 3, other % 3
        place = corner(g, face, (entry + 1) % 3) + (1.0 - share) * g.sides[face, entry]
    return face, place, False
