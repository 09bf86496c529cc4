"""A surface that is exactly its own mirror image: one half of it, and the image of that half."""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Flags, Indices, Scalars, Triangles, Vectors
from geoweave.errors import MeshError
from geoweave.surface import MirrorPlane, TriMesh, connected_components

__all__ = ["mirrored_half"]

NEAR = 0.25
"""Vertices nearer to the plane than this share of the shortest edge round them are moved into it."""

ISLE = 0.01
"""A piece on one side of the plane with less than this share of the area belongs to the other side."""


def mirrored_half(mesh: TriMesh, plane: MirrorPlane) -> TriMesh:
    """Cut a surface along its mirror plane and put the image of the larger half in place of the other.

    Vertices near the plane are moved into it, so that no slivers are cut off. Edges that still cross it are
    cut there. Vertex by vertex and face by face the second half is the image of the first: so is everything
    that the shape decides, such as fields and level sets.

    Parameters
    ----------
    mesh : a surface that the plane mirrors, as nearly as `geoweave.surface.mirror_plane` allows
    plane : the plane

    Raises
    ------
    MeshError
        If the two halves do not make a surface of the same topology.

    Examples
    --------
    >>> from geoweave.surface import mirror_plane
    >>> spot = gw.models.datasets.load("spot")
    >>> plane = mirror_plane(spot)
    >>> both = gw.meshing.mirrored_half(spot, plane)
    >>> plane.residual > 1e-4, mirror_plane(both).residual < 1e-9, both.genus == spot.genus
    (True, True, True)
    """
    away = _sides(mesh, plane)
    if mesh.face_areas @ np.sign(away[mesh.faces]).sum(axis=1) < 0:
        away = -away
    points, faces, flat = _half(mesh, away)
    points[flat] -= (points[flat] @ plane.normal - plane.offset)[:, None] * plane.normal
    # The image of a vertex in the plane is the vertex itself.
    other = np.where(flat, np.arange(len(points)), len(points) + np.arange(len(points)))
    corners, faces = np.unique(np.concatenate([faces, other[faces][:, ::-1]]), return_inverse=True)
    both = np.concatenate([points, plane.image(points)])[corners]
    found = TriMesh(both, faces.reshape(-1, 3))
    kinds = [(each.n_components, each.euler_characteristic) for each in (mesh, found)]
    if kinds[0] != kinds[1]:
        raise MeshError(
            "half of the surface and its image make a surface of another topology (components and Euler "
            f"characteristic {kinds[1]} in place of {kinds[0]}); leave out --symmetric"
        )
    return found


def _sides(mesh: TriMesh, plane: MirrorPlane) -> Scalars:
    """(V,) distance from the plane with its sign, 0 for vertices that are to be moved into it.

    Where these would touch the plane from one side only, or where more than one line in the plane would run
    through them, they stay where they are.
    """
    given = mesh.vertices @ plane.normal - plane.offset
    shortest = np.full(mesh.n_vertices, np.inf)
    np.minimum.at(shortest, mesh.edges.ravel(), np.repeat(mesh.edge_lengths, 2))
    flat = np.abs(given) < NEAR * shortest
    # One that must stay and lies in the plane counts as above it.
    given = np.where(given == 0, np.finfo(float).tiny, given)
    # What reaches over the plane by a little belongs to the side that it comes from.
    above = given > 0
    pairs = mesh.edges[above[mesh.edges[:, 0]] == above[mesh.edges[:, 1]]]
    piece = connected_components(pairs, mesh.n_vertices)
    areas = np.bincount(piece[mesh.faces].ravel(), np.repeat(mesh.face_areas, 3) / 3.0)
    given = np.where(areas[piece] < ISLE * mesh.face_areas.sum(), -given, given)
    while True:
        away = np.where(flat, 0.0, given)
        bad = flat & (_lines_through(mesh, away) != np.where(mesh.boundary_vertices, 1, 2))
        if not bad.any():
            return away
        flat &= ~bad


def _lines_through(mesh: TriMesh, away: Scalars) -> Indices:
    """(V,) how many ends of lines in the plane meet in each vertex of it, 9 where a line does not cut."""
    side = np.sign(away)
    inner = mesh.interior_edges
    corners = mesh.faces
    ends = np.zeros(mesh.n_vertices, dtype=np.int64)
    for k in range(3):
        one, two = side[corners[:, (k + 1) % 3]], side[corners[:, (k + 2) % 3]]
        np.add.at(ends, corners[:, k], np.where((one == 0) & (two == 0), 9, one * two < 0))
    opposite = side[corners].sum(axis=1)[
        mesh.edge_faces
    ]  # of an edge in the plane: the side of either corner
    in_plane = (side[mesh.edges] == 0).all(axis=1)
    cuts = np.zeros(mesh.n_edges, dtype=bool)
    cuts[inner] = opposite[inner].prod(axis=1) < 0
    np.add.at(ends, mesh.edges[in_plane].ravel(), np.repeat(np.where(cuts[in_plane], 1, 9), 2))
    return ends


def _half(mesh: TriMesh, away: Scalars) -> tuple[Vectors, Triangles, Flags]:
    """The faces where ``away`` is positive, cut where it is zero.

    Returns
    -------
    all points of the surface and then those where edges are cut; the faces; and which points are in the plane
    """
    ends = away[mesh.edges]
    cut = np.flatnonzero(ends[:, 0] * ends[:, 1] < 0)
    share = ends[cut, 0] / (ends[cut, 0] - ends[cut, 1])
    tail, head = mesh.vertices[mesh.edges[cut]].transpose(1, 0, 2)
    points = np.concatenate([mesh.vertices, tail + share[:, None] * (head - tail)])
    new = np.full(mesh.n_edges, -1, dtype=np.int64)
    new[cut] = mesh.n_vertices + np.arange(len(cut))
    above, below = away[mesh.faces] > 0, away[mesh.faces] < 0
    faces = [mesh.faces[above.any(axis=1) & ~below.any(axis=1)]]
    for k in range(3):
        # The corners from the k-th on, and the cuts of the sides opposite them.
        turn = (k + np.arange(3)) % 3
        one, two, three = mesh.faces[:, turn].T
        beyond, to_three, to_two = new[mesh.face_edges[:, turn]].T
        up, down = above[:, turn].T, below[:, turn].T
        single = up[0] & down[1] & down[2]
        faces.append(np.stack([one, to_two, to_three], axis=1)[single])
        pair = down[0] & up[1] & up[2]
        faces.append(np.stack([to_two, two, three], axis=1)[pair])
        faces.append(np.stack([to_two, three, to_three], axis=1)[pair])
        in_plane = ~up[0] & ~down[0]
        faces.append(np.stack([one, two, beyond], axis=1)[in_plane & up[1] & down[2]])
        faces.append(np.stack([one, beyond, three], axis=1)[in_plane & down[1] & up[2]])
    flat = np.concatenate([away == 0, np.ones(len(cut), dtype=bool)])
    return points, np.concatenate(faces), flat
