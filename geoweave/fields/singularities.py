"""Singularities of a face field: where it winds, and by how much (Sections 4.1 and 4.2.2)."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from geoweave.arrays import Indices, Scalars, frozen
from geoweave.fields.face_field import FaceField
from geoweave.surface import TriMesh


def rotation_across(field: FaceField) -> Scalars:
    """Smallest turn of the field across each interior edge, ``arg(w_j / T_{j<-i} w_i)``, in (-pi, pi].

    Returns
    -------
    (E_int,) radians, counter-clockwise positive; positive from face i to face j.
    """
    mesh = field.mesh
    i, j = mesh.edge_faces[mesh.interior_edges].T
    return np.angle(field.values[j] * (mesh.transport * field.values[i]).conj())


def windings(mesh: TriMesh, turn: Scalars, degree: int = 1) -> Scalars:
    """Full turns of a section round each vertex, ``(N angle defect + sum of its turns) / 2 pi``.

    Parameters
    ----------
    mesh : the surface
    turn : (E_int,) turn across each interior edge, from face i to face j, beyond parallel transport
    degree : N, when what turns is the N-th power of a vector; its turns are N times those of the vector

    Returns
    -------
    (V,) an integer, but for rounding, at interior vertices. Over a boundary loop the values sum to one.
    """
    # Face i lies to the left of its edge, so crossing from i to j goes counter-clockwise round the head.
    tail, head = mesh.edges[mesh.interior_edges].T
    across = np.bincount(head, turn, mesh.n_vertices) - np.bincount(tail, turn, mesh.n_vertices)
    return (degree * mesh.angle_defects + across) / (2.0 * np.pi)


def vertex_indices(field: FaceField) -> Indices:
    """Index of the field at each interior vertex: its full turns round the vertex, zero where it is regular.

    ``(angle defect + sum of the turns across the edges) / 2 pi``, an integer: +1 for a source, a sink or
    a vortex, -1 for a saddle. Together with `boundary_indices` it sums to the Euler characteristic.

    Returns
    -------
    (V,) int64, zero on boundary vertices

    See Also
    --------
    singular_vertices : where the index is not zero
    index_sum : the sum, with the boundary's part

    Examples
    --------
    >>> sphere = gw.shapes.sphere(faces=320)
    >>> vortex = gw.FaceField.from_ambient(sphere, np.cross([0.0, 0.3, 1.0], sphere.barycenters))
    >>> int(gw.vertex_indices(vortex).sum())
    2
    """
    indices = np.rint(windings(field.mesh, rotation_across(field))).astype(np.int64)
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
    turning = windings(field.mesh, rotation_across(field))
    return frozen(np.array([np.rint(turning[loop].sum()) for loop in field.mesh.boundary_loops], np.int64))


def index_sum(field: FaceField) -> int:
    """Sum of all indices, boundary loops included: the Euler characteristic (Poincaré and Hopf).

    Examples
    --------
    >>> surface = gw.shapes.genus_g(2, faces=600)
    >>> gw.index_sum(gw.random_field(surface)), surface.euler_characteristic
    (-2, -2)
    """
    return int(vertex_indices(field).sum() + boundary_indices(field).sum())


def singular_vertices(field: FaceField) -> Indices:
    """Vertices of index other than zero.

    See Also
    --------
    vertex_indices : the index at every vertex

    Examples
    --------
    >>> len(gw.singular_vertices(gw.smoothest_field(gw.shapes.torus(faces=400))))
    0
    """
    return frozen(np.flatnonzero(vertex_indices(field)))


def circulation(field: FaceField, vertices: Indices, *, rings: int = 2) -> Scalars:
    """Circulation of the field round each of the given vertices, over the length of the path.

    ``sum over the path of w . e / sum of |e|`` along the outer edges of the faces within so many rings of the
    vertex: 1 for a perfect vortex, 0 for a source, a sink or a curl-free field. "No vorticity" of
    Section 4.1.2 means a value near 0. A singularity rarely sits right on its vertex; the second ring sees
    less of that than the first.

    Returns
    -------
    (len(vertices),) between -1 and 1 for a unit field

    Examples
    --------
    >>> disk = gw.shapes.disk(faces=2000)
    >>> whirl = gw.FaceField.from_ambient(disk, np.cross([0.0, 0.0, 1.0], disk.barycenters)).normalized()
    >>> centre = np.linalg.norm(disk.vertices, axis=1).argmin()
    >>> gw.circulation(whirl, np.array([centre])).round(1)
    array([1.])
    """
    mesh = field.mesh
    corners = sparse.csr_array(
        (np.ones(3 * mesh.n_faces), (mesh.faces.ravel(), np.repeat(np.arange(mesh.n_faces), 3))),
        shape=(mesh.n_vertices, mesh.n_faces),
    )
    inside = corners[np.asarray(vertices, dtype=np.int64)]
    for _ in range(rings - 1):
        inside = inside @ corners.T @ corners
    inside = sparse.csr_array(
        (inside.data > 0, inside.indices, inside.indptr), shape=inside.shape, dtype=float
    )
    # One column more, never inside, stands for what lies across the boundary.
    padded = sparse.hstack([inside, sparse.csr_array((inside.shape[0], 1))], format="csc")
    along = (field.values[:, None].conj() * mesh.halfedge_vectors).real
    length = np.abs(mesh.halfedge_vectors)
    flow, path = np.zeros(inside.shape[0]), np.zeros(inside.shape[0])
    for k in range(3):
        outer = inside - inside.multiply(padded[:, mesh.face_neighbors[:, k]])
        flow += np.asarray(outer @ along[:, k])
        path += np.asarray(outer @ length[:, k])
    return flow / path
