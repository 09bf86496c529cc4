"""Numbers for vertices and faces that the shape gives, so that remeshing does not hang on the file."""

from __future__ import annotations

import numpy as np

from geoweave.surface import TriMesh

__all__ = ["ordered_by_place"]


def ordered_by_place(mesh: TriMesh) -> TriMesh:
    """Number vertices by their distance from the centre of the area, and faces and corners by their vertices.

    A remesher takes edges one after the other, and where it starts decides which triangles it makes. After
    this, a surface that was turned or whose file lists it in another order is remeshed to the same triangles.
    Vertices at the same distance, as on a sphere, keep the order they have.

    Parameters
    ----------
    mesh : any surface

    Returns
    -------
    TriMesh
        The same triangles, as they were oriented; the vertex nearest to the centre is number 0.

    Examples
    --------
    >>> lump = gw.shapes.torus(faces=400)
    >>> lump = gw.TriMesh(lump.vertices * [1.0, 1.3, 0.7] + 0.1 * lump.vertices**2, lump.faces)
    >>> again = gw.TriMesh(lump.vertices[::-1], lump.n_vertices - 1 - lump.faces[::-1])
    >>> one, two = (gw.meshing.ordered_by_place(each) for each in (lump, again))
    >>> bool((one.faces == two.faces).all()), bool((one.vertices == two.vertices).all())
    (True, True)
    """
    center = np.average(mesh.barycenters, axis=0, weights=mesh.face_areas)
    order = np.argsort(((mesh.vertices - center) ** 2).sum(axis=1), kind="stable")
    rank = np.empty(mesh.n_vertices, dtype=np.int64)
    rank[order] = np.arange(mesh.n_vertices)
    faces = rank[mesh.faces]
    first = faces.argmin(axis=1)
    faces = faces[np.arange(mesh.n_faces)[:, None], (first[:, None] + np.arange(3)) % 3]
    return TriMesh(mesh.vertices[order], faces[np.lexsort(faces.T[::-1])])
