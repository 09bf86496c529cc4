"""Local curl correction of Ray et al. 2006: a scale that keeps the curl on each face small (Section 4.2.3).

The paper compares its integrating factor with this one (Figs. 13 and 15).
"""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np
from scipy import sparse

from geoweave.arrays import Complexes, Scalars, Vectors, frozen
from geoweave.errors import FieldError
from geoweave.fields import FaceField, as_real, face_mass, field_mass, gradient
from geoweave.sparse import factorized, nested_dissection, one_blas_thread

Measure: TypeAlias = Literal["absolute", "relative"]
"""Which curl is made small: see `curl_corrected_scale`."""

SMOOTHNESS: dict[Measure, float] = {"absolute": 1e-4, "relative": 1e-2}
"""Weight of the gradient of the scale: the paper's mu of Eq. 7, and what is best on the sphere of Fig. 13."""

DEFINITE = 1e-8
"""Weight of the values of the scale, over the area: it holds constants and is too small to move the rest."""

LEAST = 0.01
"""Least value of a scale that is not positive by construction, as a share of its mean."""


@one_blas_thread()
def curl_corrected_scale(
    field: FaceField, *, measure: Measure = "absolute", smoothness: float | None = None
) -> Scalars:
    """Find the scale s for which ``s w-perp`` has the least local curl (Ray et al. 2006; Section 4.2.3).

    The scale and the field w-perp = -1j w are interpolated to the vertices. ``s w-perp`` is linear on each
    triangle, so its curl is constant there. These are the linear finite elements that the paper describes for
    this method. The scale minimises

    - ``"absolute"``: ``sum_i A_i curl_i(s w-perp)^2`` among scales of prescribed mean,
    - ``"relative"``: ``sum_i A_i (curl_i(s w-perp) / s)^2``, linear in ``log s``, so that s is positive,

    plus ``smoothness * |grad s|^2`` (or ``|grad log s|^2``). The first is the problem of the paper without
    the condition ``|s| = 1``: under that condition the minimiser changes sign on the sphere of Fig. 13. The
    second is the strongest form of the method that we found (DEVIATIONS.md, curl-correction).

    Parameters
    ----------
    field : unit field w on the surface, without singularities
    measure : which curl to minimise; with "absolute", a scale below 1 % of its mean is raised to that
        value
    smoothness : weight of the gradient of the scale, a number; `SMOOTHNESS` if not given

    Returns
    -------
    (F,) positive, area mean 1 on each component

    Raises
    ------
    FieldError
        If the measure is unknown or the weight is not a positive number.
    """
    if measure not in SMOOTHNESS:
        raise FieldError(f"there is no measure '{measure}': use 'absolute' or 'relative'")
    weight = SMOOTHNESS[measure] if smoothness is None else smoothness
    if not 0 < weight < np.inf:
        raise FieldError(f"the weight of the gradient of a scale must be positive and finite, not {weight}")
    mesh = field.mesh
    of_scale = local_curl(field)
    corners, areas = mesh.faces.ravel(), np.repeat(mesh.face_areas / 3.0, 3)
    lumped = np.bincount(corners, areas, mesh.n_vertices)
    stiffness = weight * (gradient(mesh).T @ field_mass(mesh) @ gradient(mesh))
    # For a constant field on a flat surface the scale is determined only up to a constant.
    stiffness = stiffness + sparse.diags_array(DEFINITE * lumped / mesh.face_areas.sum())
    if measure == "absolute":
        matrix = of_scale.T @ face_mass(mesh) @ of_scale + stiffness
        # By Lagrange multipliers, the minimiser among scales of a given mean is a multiple of this.
        at_vertices = _solved(matrix, np.asarray(lumped, dtype=np.float64))
    else:
        along = _derivative_along(field)
        matrix = along.T @ face_mass(mesh) @ along + stiffness
        constant = of_scale @ np.ones(mesh.n_vertices)
        at_vertices = np.exp(-_solved(matrix, along.T @ (mesh.face_areas * constant)))
    scale = at_vertices[mesh.faces].mean(axis=1)
    if measure == "absolute":
        scale = np.maximum(scale, LEAST * mesh.component_means(scale)[mesh.face_components])
    return frozen(scale / mesh.component_means(scale)[mesh.face_components])


def local_curl(field: FaceField) -> sparse.csr_array:
    """Curl of ``s w-perp`` on each triangle for a scale at the vertices, (F, V); unit: field / length.

    ``curl_i = (1 / A_i) sum over the sides e_ab of (s_a w-perp_a + s_b w-perp_b) . e_ab / 2``, with
    w-perp interpolated to the vertices by parallel transport and transported back to the plane of each face.
    Counter-clockwise is positive.
    """
    mesh = field.mesh
    # Corner k contributes to its two sides. Their sum is minus the opposite side.
    along = (_corner_directions(field).conj() * mesh.halfedge_vectors).real
    entries = -0.5 * along / mesh.face_areas[:, None]
    rows = np.repeat(np.arange(mesh.n_faces), 3)
    return sparse.csr_array(
        (entries.ravel(), (rows, mesh.faces.ravel())), shape=(mesh.n_faces, mesh.n_vertices)
    )


def _derivative_along(field: FaceField) -> sparse.csr_array:
    """The part of curl(s w-perp) due to grad s, ``grad s x w-perp = -w . grad s`` on a face, (F, V)."""
    mesh = field.mesh
    rows, columns = np.repeat(np.arange(mesh.n_faces), 2), np.arange(2 * mesh.n_faces)
    dot = sparse.csr_array((-as_real(field.values), (rows, columns)), shape=(mesh.n_faces, 2 * mesh.n_faces))
    return sparse.csr_array(dot @ gradient(mesh))


def _corner_directions(field: FaceField) -> Complexes:
    """(F, 3) w-perp at the vertex of each corner, in the frame of the face."""
    mesh = field.mesh
    vertex, face = mesh.faces.ravel(), np.repeat(np.arange(mesh.n_faces), 3)
    across, up = mesh.face_normals[face], mesh.vertex_normals[vertex]
    arriving = _tilted(mesh.ambient(-1j * field.values)[face], across, up)
    arriving *= mesh.corner_angles.ravel()[:, None]
    total = np.stack([np.bincount(vertex, arriving[:, k], mesh.n_vertices) for k in range(3)], axis=1)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    # Where the field around a vertex sums to zero there is no direction; the vertex then gets zero.
    at_vertex = total / np.where(length > 0, length, 1.0)
    planar = np.einsum("cx,cax->ca", _tilted(at_vertex[vertex], up, across), mesh.frames[face])
    return (planar[:, 0] + 1j * planar[:, 1]).reshape(-1, 3)


def _tilted(vectors: Vectors, start: Vectors, end: Vectors) -> Vectors:
    """Rotate vectors by the smallest rotation that takes one unit normal to another, all (n, 3).

    This is parallel transport along the great circle that joins the normals.
    """
    axis = np.cross(start, end)
    cosine = np.einsum("nx,nx->n", start, end)[:, None]
    lift = np.einsum("nx,nx->n", axis, vectors)[:, None] / np.maximum(1.0 + cosine, 1e-12)
    return np.asarray(cosine * vectors + np.cross(axis, vectors) + lift * axis)


def _solved(matrix: sparse.csr_array, right: Scalars) -> Scalars:
    held = sparse.csr_array(matrix)
    return factorized(held, nested_dissection(held)).solve(right)
