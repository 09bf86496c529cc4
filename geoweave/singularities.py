"""Singularities of a face field: where it winds, and by how much (Sections 4.1 and 4.2.2)."""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Indices, Scalars, frozen
from geoweave.fields import FaceField


def rotation_across(field: FaceField) -> Scalars:
    """Smallest turn of the field across each interior edge, ``arg(w_j / T_{j<-i} w_i)``, in (-pi, pi].

    Returns
    -------
    (E_int,) radians, counter-clockwise positive; positive from face i to face j.
    """
    mesh = field.mesh
    i, j = mesh.edge_faces[mesh.interior_edges].T
    return np.angle(field.values[j] * (mesh.transport * field.values[i]).conj())


def _turning(field: FaceField) -> Scalars:
    """(V,) turns of the field round each vertex: the angle defect and the turns across its edges, / 2 pi."""
    mesh = field.mesh
    turn = rotation_across(field)
    # Face i lies to the left of its edge, so crossing from i to j goes counter-clockwise round the head.
    tail, head = mesh.edges[mesh.interior_edges].T
    across = np.bincount(head, turn, mesh.n_vertices) - np.bincount(tail, turn, mesh.n_vertices)
    return (mesh.angle_defects + across) / (2.0 * np.pi)


def vertex_indices(field: FaceField) -> Indices:
    """Index of the field at each interior vertex: its full turns round the vertex, zero where it is regular.

    ``(angle defect + sum of the turns across the edges) / 2 pi``, an integer: +1 for a source, a sink or
    a vortex, -1 for a saddle. Together with `boundary_indices` it sums to the Euler characteristic.

    Returns
    -------
    (V,) int64, zero on boundary vertices
    """
    indices = np.rint(_turning(field)).astype(np.int64)
    indices[field.mesh.boundary_vertices] = 0
    return frozen(indices)


def boundary_indices(field: FaceField) -> Indices:
    """Index that each boundary loop would have if a disk without a singularity of its own closed it.

    The turns of the field along the loop, relative to the loop's tangent, in the order of
    `TriMesh.boundary_loops`. A disk with a constant field has +1 on its only loop; an annulus with a
    radial field has 0 on both.

    Returns
    -------
    (loops,) int64
    """
    turning = _turning(field)
    return frozen(np.array([np.rint(turning[loop].sum()) for loop in field.mesh.boundary_loops], np.int64))


def index_sum(field: FaceField) -> int:
    """Sum of all indices, boundary loops included: the Euler characteristic (Poincaré and Hopf)."""
    return int(vertex_indices(field).sum() + boundary_indices(field).sum())


def singular_vertices(field: FaceField) -> Indices:
    """Vertices of index other than zero."""
    return frozen(np.flatnonzero(vertex_indices(field)))


def circulation(field: FaceField, vertices: Indices) -> Scalars:
    """Circulation of the field round each of the given interior vertices, over the perimeter of its star.

    ``sum over the outer edges of w . e / sum of |e|``: 1 for a perfect vortex, 0 for a source, a sink
    or a field that is curl-free around the vertex. "No vorticity" of Section 4.1.2 means a value near 0.

    Returns
    -------
    (len(vertices),) between -1 and 1 for a unit field
    """
    mesh = field.mesh
    along = (field.values[:, None].conj() * mesh.halfedge_vectors).real
    flow = np.bincount(mesh.faces.ravel(), along.ravel(), mesh.n_vertices)
    perimeter = np.bincount(mesh.faces.ravel(), np.abs(mesh.halfedge_vectors).ravel(), mesh.n_vertices)
    return (flow / perimeter)[vertices]
