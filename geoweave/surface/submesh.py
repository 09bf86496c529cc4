"""Parts of a surface: what is left when faces are taken out, as a surface of its own (Section 4.2.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geoweave.arrays import Flags, Indices
from geoweave.errors import MeshError
from geoweave.surface.components import connected_components
from geoweave.surface.mesh import TriMesh


@dataclass(frozen=True, eq=False)
class Part:
    """Some faces of a surface as a surface of its own.

    Faces keep their order and their corners, hence their frames (and signs): the values of a face field carry
    over as they are, ``values[part.faces]``.

    Attributes
    ----------
    mesh : the part
    whole : the surface it was taken from
    faces : (F',) face of the whole that each face of the part is
    vertices : (V',) vertex of the whole that each vertex of the part is; a vertex at which two fans of
        the part touch appears once for each
    """

    mesh: TriMesh
    whole: TriMesh
    faces: Indices
    vertices: Indices

    @property
    def kept(self) -> Flags:
        """(F,) faces of the whole that belong to the part."""
        kept = np.zeros(self.whole.n_faces, dtype=bool)
        kept[self.faces] = True
        return kept


def part_of(mesh: TriMesh, keep: Flags) -> Part:
    """Take the flagged faces of a mesh as a mesh of their own.

    Where two fans of kept faces touch in a vertex only, the vertex is doubled: the part is a manifold.

    Parameters
    ----------
    mesh : the surface
    keep : (F,) the faces to keep, at least one

    Raises
    ------
    MeshError
        If the flags do not fit the mesh or keep no face.
    """
    if keep.shape != (mesh.n_faces,):
        raise MeshError(f"flags of faces need shape ({mesh.n_faces},), not {keep.shape}")
    if not keep.any():
        raise MeshError(f"none of the {mesh.n_faces} faces is kept, so there is no part")
    faces = np.flatnonzero(keep)
    # Corners are joined where two kept faces share an edge; each group of joined corners is one vertex.
    inner = mesh.interior_edges[keep[mesh.edge_faces[mesh.interior_edges]].all(axis=1)]
    here, there = mesh.corners_across(inner)
    pairs = np.stack([here.ravel(), there.ravel()], axis=1)
    fan = connected_components(pairs, 3 * mesh.n_faces).reshape(-1, 3)[faces]
    # Vertices stay in the order of the whole.
    old = mesh.faces[faces]
    key = old.ravel() * (int(fan.max()) + 1) + fan.ravel()
    _, first, corners = np.unique(key, return_index=True, return_inverse=True)
    vertices = old.ravel()[first]
    part = mesh.restricted(faces, mesh.vertices[vertices], corners.reshape(-1, 3))
    return Part(part, mesh, faces, vertices)
