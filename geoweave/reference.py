"""The paper's own linear systems, kept small and plain to check the reduced ones against (Appendix B)."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph
from scipy.sparse.linalg import splu

from geoweave.arrays import Complexes, Flags, Indices, Scalars
from geoweave.fields import FaceField, Handles
from geoweave.mesh import TriMesh
from geoweave.operators import (
    as_complex,
    as_real,
    curl,
    dual_weights,
    field_mass,
    transport_differences,
)


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
