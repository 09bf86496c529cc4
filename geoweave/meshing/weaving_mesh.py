"""The mesh that a weave is found on: even, and fine enough for the spacing that was asked for (Section 5.2).

The paper remeshes every input: "there is no reason not to remesh all inputs" (Section 6). A mesh that is as
even as the remesher would make it, with about as many triangles as the weave needs, is left as it is
(DEVIATIONS.md, remeshed-first).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geoweave.arrays import Scalars
from geoweave.errors import MeshError
from geoweave.meshing.place_order import ordered_by_place
from geoweave.meshing.prepare import Prepared, remeshed
from geoweave.surface import TriMesh

__all__ = ["evened", "faces_to_weave_on"]

FACES_PER_PAIR = 1.0
"""Faces F for n ribbons, as ``F = n^2``: about three edges between neighbouring ribbons.

n ribbons of three families on a surface of area A are about ``d = 4.4 sqrt(A) / n`` apart, as measured on the
embedded models. An edge h of F equilateral triangles has ``h^2 = 2.3 A / F``, so that ``d / h`` is about 3.
With twice as many faces a scan of 100 ribbons alternates as often (97.1 % both times) and takes much longer.
"""

COARSEST, FINEST = 4_000, 60_000
"""Least number of triangles on the largest component, and the most in all, whatever is asked for."""

USUAL = 10_000
"""The most triangles if no number of ribbons is asked for: then the mesh itself sets the spacing."""

TOO_FEW, TOO_MANY = 0.5, 2.5
"""A mesh is kept if the number of its triangles lies between these shares of what a weave needs."""

UNEVEN = 2.0
"""Longest edge of a mesh that is kept, in sides of as many equilateral triangles with the same area."""

SLENDER = 48.0
"""Least mean over the faces of the smallest angle, degrees, of a mesh that is kept.

Remeshed surfaces have 53, equilateral triangles 60, a grid of squares with diagonals 45.
"""


def faces_to_weave_on(mesh: TriMesh, ribbons: int | None = None) -> int:
    """Return the number of triangles that a weave of so many ribbons needs.

    Parameters
    ----------
    mesh : the surface
    ribbons : how many there are to be; None where a scale is given, which counts from the mesh

    Examples
    --------
    >>> surface = gw.shapes.torus(faces=600)
    >>> [gw.meshing.faces_to_weave_on(surface, ribbons) for ribbons in (20, 100, 1000)]
    [4000, 10000, 60000]
    """
    areas = np.bincount(mesh.face_components, mesh.face_areas)
    least = round(COARSEST * float(areas.sum() / areas.max()))
    if ribbons is None:
        return min(max(mesh.n_faces, least), max(USUAL, COARSEST))
    return min(max(round(FACES_PER_PAIR * ribbons**2), least), FINEST)


def evened(prepared: Prepared, *, ribbons: int | None = None, name: str = "mesh") -> Prepared:
    """Remesh a surface for a weave; leave one that is even and of about the right number of faces as it is.

    One long edge makes a whole weave coarse, because the steepest edge sets its density (footnote 4). Regular
    grids lead the field along their diagonals. More triangles than `faces_to_weave_on` says cost time and
    memory and do not change the weave. The new triangles do not hang on how the file lists the old ones.

    Parameters
    ----------
    prepared : the surface, of any scale
    ribbons : how many ribbons there are to be, if that was asked for
    name : of the file, for the message

    Returns
    -------
    Prepared
        Its report says from how many faces it was remeshed. It has more faces where its topology needs more.

    Raises
    ------
    MeshError
        If no such number of triangles keeps the topology.

    Examples
    --------
    >>> ball = gw.shapes.icosahedron()
    >>> gw.meshing.evened(gw.meshing.prepare_arrays(ball.vertices, ball.faces)).mesh.n_faces > 3_900
    True
    """
    mesh = prepared.mesh
    faces = faces_to_weave_on(mesh, ribbons)
    if TOO_FEW * faces <= mesh.n_faces <= TOO_MANY * faces and _is_even(mesh):
        return prepared
    most = 4 * max(mesh.n_faces, faces)
    ordered = replace(prepared, mesh=ordered_by_place(mesh))
    while True:
        try:
            return remeshed(ordered, faces, name=name)
        except MeshError:
            faces *= 2
            if faces > most:
                raise


def _is_even(mesh: TriMesh) -> bool:
    """Whether a mesh is about as even as the remesher makes one."""
    side = np.sqrt(4.0 * mesh.face_areas.sum() / (np.sqrt(3.0) * mesh.n_faces))
    return bool(mesh.edge_lengths.max() <= UNEVEN * side and smallest_angles(mesh).mean() >= SLENDER)


def smallest_angles(mesh: TriMesh) -> Scalars:
    """(F,) smallest angle of each face, degrees."""
    lengths = np.sort(mesh.edge_lengths[mesh.face_edges], axis=1)
    # The smallest angle lies between the two longer sides.
    sine = 2.0 * mesh.face_areas / (lengths[:, 1] * lengths[:, 2])
    return np.asarray(np.degrees(np.arcsin(np.clip(sine, 0.0, 1.0))))
