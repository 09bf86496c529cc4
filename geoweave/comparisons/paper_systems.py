"""The paper's own linear systems, kept small and plain to check the reduced ones against (Appendix B)."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph
from scipy.sparse.linalg import splu

from geoweave.arrays import Complexes, Flags, Indices, Scalars
from geoweave.fields import (
    FaceField,
    Handles,
    as_complex,
    as_real,
    curl,
    dual_weights,
    face_laplacian,
    field_mass,
    transport_differences,
)
from geoweave.surface import TriMesh


def kkt_system(
    field: FaceField, smoothness: float, handles: Handles | None = None
) -> tuple[sparse.csc_array, Scalars, Indices]:
    """Assemble the KKT system of the delta step (Appendix B).

    ``[M + lambda L, C'; C, 0] [delta; mu] = [-lambda L u; -C u]``

    The right-hand side is that of Appendix B without the unknown delta in it, L is positive semi-definite,
    and handles are deleted columns (DEVIATIONS.md, kkt-signs). Rows of C that repeat others are dropped, so
    that a direct solver needs no rank-revealing factorisation.

    Returns
    -------
    matrix (n + m, n + m), right-hand side (n + m,), and the (n,) positions of the unknowns in (2F,)
    """
    mesh = field.mesh
    marks = np.zeros(mesh.n_faces, dtype=bool) if handles is None else handles.marks(mesh)
    free = np.flatnonzero(np.repeat(~marks, 2))
    jumps = transport_differences(mesh)
    weights = sparse.diags_array(np.repeat(dual_weights(mesh), 2))
    laplacian = jumps.T @ weights @ jumps
    upper = sparse.csr_array(field_mass(mesh) + smoothness * laplacian)[free][:, free]
    u = as_real(field.values)
    rows = _independent_rows(mesh, marks)
    constraint = curl(mesh)[rows]
    matrix = sparse.block_array([[upper, constraint[:, free].T], [constraint[:, free], None]], format="csc")
    right = np.concatenate([-smoothness * (laplacian @ u)[free], -(constraint @ u)])
    return matrix, right, free


def kkt_closed_field(field: FaceField, smoothness: float, handles: Handles | None = None) -> Complexes:
    """Take the delta step of Algorithm 1 as the paper states it: (F,) values of ``w + delta`` (Appendix B).

    Parameters
    ----------
    field : unit field w, equal to the handles' values on the handles
    smoothness : lambda > 0, unit length^2
    """
    matrix, right, free = kkt_system(field, smoothness, handles)
    factors = splu(matrix)
    solution = factors.solve(right)
    solution += factors.solve(right - matrix @ solution)
    delta = np.zeros(2 * field.mesh.n_faces)
    delta[free] = solution[: len(free)]
    return field.values + as_complex(delta)


def _independent_rows(mesh: TriMesh, handle: Flags) -> Indices:
    """Interior edges whose curl constraints are independent on the faces that are no handles.

    Around every face the constraints' multipliers can only cancel if all three are equal, and a boundary
    edge has none: so each region of free faces that reaches no boundary has one constraint too many.
    """
    i, j = mesh.edge_faces[mesh.interior_edges].T
    both = ~handle[i] & ~handle[j]
    graph = sparse.coo_array((np.ones(int(both.sum())), (i[both], j[both])), shape=(mesh.n_faces,) * 2)
    count, region = csgraph.connected_components(graph, directed=False)
    surplus = np.ones(count, dtype=bool)
    surplus[region[mesh.edge_faces[mesh.boundary_edges, 0]]] = False
    surplus[region[handle]] = False
    used = ~(handle[i] & handle[j])
    rows = np.flatnonzero(used)
    owner = np.where(handle[i], region[j], region[i])[rows]
    _, first = np.unique(owner, return_index=True)
    return np.delete(rows, first[surplus[owner[first]]])


def constrained_power_step(
    field: FaceField, delta: Complexes, s: Scalars, smoothness: float
) -> tuple[Complexes, Scalars]:
    """One step of inverse iteration for Eq. 7 within its constraint, by a KKT system (Appendix C).

    ``min 1/2 x' (A1 + A2) x - x' A2 y`` subject to ``C (s w-perp + delta) = 0``, with y = (delta, s) given
    and x = (delta, s) sought.

    Parameters
    ----------
    field : unit field w
    delta, s : (F,) complex and (F,) real, the iterate
    smoothness : mu, length^2
    """
    total, second, constraint = _appendix_c(field, smoothness)
    size, count = total.shape[0], constraint.shape[0]
    matrix = sparse.block_array([[total, constraint.T], [constraint, None]], format="csc")
    right = np.concatenate([second @ np.concatenate([as_real(delta), s]), np.zeros(count)])
    solution = splu(matrix).solve(right)[:size]
    return as_complex(solution[: 2 * field.mesh.n_faces]), solution[2 * field.mesh.n_faces :]


def algorithm_2_step(
    field: FaceField, delta: Complexes, s: Scalars, smoothness: float
) -> tuple[Complexes, Scalars]:
    """One step of Algorithm 2 as printed: solve without the constraint, then project onto it (Appendix C).

    The projection is orthogonal in the plain coordinates, so the result is not the constrained minimiser
    (DEVIATIONS.md, rescaling).

    Parameters
    ----------
    field, delta, s, smoothness : as in `constrained_power_step`
    """
    total, second, constraint = _appendix_c(field, smoothness)
    x = splu(sparse.csc_array(total)).solve(second @ np.concatenate([as_real(delta), s]))
    gram = sparse.csc_array(constraint @ constraint.T)
    x = x - constraint.T @ splu(gram).solve(constraint @ x)
    return as_complex(x[: 2 * field.mesh.n_faces]), x[2 * field.mesh.n_faces :]


def _appendix_c(
    field: FaceField, smoothness: float
) -> tuple[sparse.csr_array, sparse.csr_array, sparse.csr_array]:
    """``A1 + A2``, ``A2`` and the constraint B of Appendix C, on x = (delta, s)."""
    mesh = field.mesh
    count = mesh.n_faces
    areas = sparse.diags_array(mesh.face_areas)
    first = sparse.block_diag([field_mass(mesh), smoothness * face_laplacian(mesh)], format="csr")
    second = sparse.block_diag([field_mass(mesh), areas], format="csr")
    rows = np.arange(2 * count)
    turned = sparse.csr_array((as_real(-1j * field.values), (rows, rows // 2)), shape=(2 * count, count))
    jumps = curl(mesh)[_independent_rows(mesh, np.zeros(count, dtype=bool))]
    constraint = sparse.csr_array(sparse.hstack([jumps, jumps @ turned]))
    return sparse.csr_array(first + second), sparse.csr_array(second), constraint
