"""The discrete operators of Appendix B, and the closed fields they act on (Section 4.1).

Every Laplacian here is positive semi-definite. Fields enter real matrices as `as_real`: the two
coordinates of each face's vector, interleaved.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Complexes, Flags, Indices, Scalars, frozen
from geoweave.surface import TriMesh


def as_real(values: Complexes) -> Scalars:
    """View (F,) complex vectors as (2F,) real coordinates, interleaved."""
    return np.ascontiguousarray(values).view(np.float64)


def as_complex(coordinates: Scalars) -> Complexes:
    """View (2F,) interleaved real coordinates as (F,) complex vectors."""
    return np.ascontiguousarray(coordinates).view(np.complex128)


def curl(mesh: TriMesh) -> sparse.csr_array:
    """Discrete curl C, interior edges x face fields (Eq. 3).

    Row ij is the jump of the field's projection on the shared edge, ``(w_j - w_i) . e_ij``, so
    ``C @ v == 0`` exactly when the field is locally a gradient.

    Returns
    -------
    (E_int, 2F) sparse, acting on ``as_real(field)``; unit: length x field.
    """
    sides = mesh.edge_halfedges[mesh.interior_edges]
    vectors = mesh.halfedge_vectors.ravel()[sides]
    count = len(sides)
    rows = np.repeat(np.arange(count), 4)
    columns = (2 * (sides // 3)[:, :, None] + np.arange(2)).ravel()
    # Along the edge for face i, against it for face j: both half-edges enter with the same sign.
    vectors = vectors * np.stack([np.ones(count), mesh.bundle.over_edges], axis=1)
    entries = -np.stack([vectors.real, vectors.imag], axis=2).ravel()
    return sparse.csr_array((entries, (rows, columns)), shape=(count, 2 * mesh.n_faces))


def sharp(mesh: TriMesh) -> sparse.csr_array:
    """The face field whose circulation along the edges of each face is given, (2F, E).

    On a closed 1-form (one whose values along the sides of every face sum to zero) the result ``v``
    satisfies ``v . e = omega(e)`` on all three sides, and its curl vanishes.
    """
    # With omega summing to zero, v = (1 / 6A) J sum_k (omega_{k+1} - omega_{k+2}) h_k, J a quarter turn.
    h = mesh.halfedge_vectors
    weights = 1j * (h[:, [2, 0, 1]] - h[:, [1, 2, 0]]) / (6.0 * mesh.face_areas[:, None])
    weights = weights * mesh.bundle.forms
    rows = np.broadcast_to(np.arange(2 * mesh.n_faces).reshape(-1, 1, 2), (mesh.n_faces, 3, 2)).ravel()
    columns = np.repeat(mesh.face_edges.ravel(), 2)
    entries = np.stack([weights.real, weights.imag], axis=2).ravel()
    return sparse.csr_array((entries, (rows, columns)), shape=(2 * mesh.n_faces, mesh.n_edges))


def differences(mesh: TriMesh) -> sparse.csr_array:
    """The exterior derivative d of vertex functions, (E, V): end less start of each edge."""
    rows = np.repeat(np.arange(mesh.n_edges), 2)
    entries = (mesh.bundle.ends * [-1.0, 1.0]).ravel()
    return sparse.csr_array((entries, (rows, mesh.edges.ravel())), shape=(mesh.n_edges, mesh.n_vertices))


def gradient(mesh: TriMesh) -> sparse.csr_array:
    """Gradient G of piecewise linear functions, (2F, V): exact on linear functions; unit: 1 / length."""
    # grad f = sum_k f_k J h_k / 2A, with h_k the half-edge opposite corner k, J a quarter turn.
    weights = 1j * mesh.halfedge_vectors * mesh.bundle.corners / (2.0 * mesh.face_areas[:, None])
    rows = np.broadcast_to(np.arange(2 * mesh.n_faces).reshape(-1, 1, 2), (mesh.n_faces, 3, 2)).ravel()
    entries = np.stack([weights.real, weights.imag], axis=2).ravel()
    return sparse.csr_array(
        (entries, (rows, np.repeat(mesh.faces.ravel(), 2))), shape=(2 * mesh.n_faces, mesh.n_vertices)
    )


def face_mass(mesh: TriMesh) -> sparse.dia_array:
    """Inner product of functions on faces, M_F: (F, F) diagonal of face areas."""
    return sparse.diags_array(mesh.face_areas)


def field_mass(mesh: TriMesh) -> sparse.dia_array:
    """Inner product of face fields, M^v_F: (2F, 2F) diagonal of face areas, each twice."""
    return sparse.diags_array(np.repeat(mesh.face_areas, 2))


DEFINITE = 1e-3
"""Shift of the eigenvalues of an energy, over the area of the surface; a number."""


def spectral_shift(areas: Scalars) -> float:
    """Shift that makes an energy of fields positive definite, 1 / length^2.

    Some surfaces have fields without energy: parallel ones on a flat surface, harmonic ones on a torus. The
    shift is small beside the first eigenvalue that is not zero, which is of the order of 1 / area.

    Parameters
    ----------
    areas : (F,) areas of the faces

    Examples
    --------
    >>> from geoweave.fields import spectral_shift
    >>> spectral_shift(np.array([0.5, 0.5]))
    0.001
    """
    return float(DEFINITE / areas.sum())


def dual_weights(mesh: TriMesh) -> Scalars:
    """Weight ``|e| / |e*| = 1.5 |e|^2 / (A_i + A_j)`` of each interior edge, (E_int,), always positive.

    The paper's reciprocal cotan weight (Appendix B) is infinite on right-angled pairs and negative on
    obtuse ones; this barycentric dual equals it on equilateral triangles (DEVIATIONS.md, dual-weights).
    """
    i, j = mesh.edge_faces[mesh.interior_edges].T
    lengths = mesh.edge_lengths[mesh.interior_edges]
    return 1.5 * lengths**2 / (mesh.face_areas[i] + mesh.face_areas[j])


def _at_faces(mesh: TriMesh, values: Scalars) -> Scalars:
    """(F,) sum of the values of the interior edges of each face; zeros where there is no such edge."""
    i, j = mesh.edge_faces[mesh.interior_edges].T
    total = np.bincount(i, values, mesh.n_faces) + np.bincount(j, values, mesh.n_faces)
    return np.asarray(total, dtype=np.float64)


def face_laplacian(mesh: TriMesh) -> sparse.csr_array:
    """Laplacian of functions on faces, L_F, (F, F), positive semi-definite (Appendix B)."""
    i, j = mesh.edge_faces[mesh.interior_edges].T
    weights = dual_weights(mesh)
    off = sparse.coo_array((weights, (i, j)), shape=(mesh.n_faces,) * 2)
    diagonal = _at_faces(mesh, weights)
    return sparse.csr_array(sparse.diags_array(diagonal) - (off + off.T))


def connection_laplacian(mesh: TriMesh, degree: int = 1) -> sparse.csr_array:
    """Laplacian of face fields (degree 1) or of N-RoSy fields, (F, F) Hermitian positive semi-definite.

    ``conj(u) @ L @ u = sum over ij of weight_ij |T_{j<-i} u_i - u_j|^2``, the Dirichlet energy of
    Appendix B, with the transport raised to the power ``degree``.
    """
    i, j = mesh.edge_faces[mesh.interior_edges].T
    weights = dual_weights(mesh)
    off = sparse.coo_array((weights * mesh.transport**degree, (j, i)), shape=(mesh.n_faces,) * 2)
    diagonal = _at_faces(mesh, weights)
    return sparse.csr_array(sparse.diags_array(diagonal) - (off + off.conj().T))


def dirichlet_energy(mesh: TriMesh, values: Complexes) -> float:
    """Dirichlet energy ``sum over ij of weight_ij |T_{j<-i} u_i - u_j|^2`` of a face field (Appendix B)."""
    i, j = mesh.edge_faces[mesh.interior_edges].T
    return float(dual_weights(mesh) @ np.abs(mesh.transport * values[i] - values[j]) ** 2)


def transport_differences(mesh: TriMesh) -> sparse.csr_array:
    """``T_{j<-i} u_i - u_j`` over each interior edge as a real matrix, (2 E_int, 2F).

    With the dual weights W repeated twice, ``D.T @ W @ D`` is the real form of `connection_laplacian`.
    """
    i, j = mesh.edge_faces[mesh.interior_edges].T
    count = len(i)
    turn = mesh.transport
    rows = (2 * np.arange(count)[:, None] + [0, 0, 0, 1, 1, 1]).ravel()
    columns = np.stack([2 * i, 2 * i + 1, 2 * j, 2 * i, 2 * i + 1, 2 * j + 1], axis=1).ravel()
    minus = np.full(count, -1.0)
    entries = np.stack([turn.real, -turn.imag, minus, turn.imag, turn.real, minus], axis=1).ravel()
    return sparse.csr_array((entries, (rows, columns)), shape=(2 * count, 2 * mesh.n_faces))


def harmonic_generators(mesh: TriMesh) -> sparse.csc_array:
    """One closed 1-form per class of the first cohomology, (E, beta_1), by tree and cotree.

    A spanning tree of the vertices and, disjoint from it, a breadth-first spanning tree of the faces,
    rooted outside the surface where it has a boundary (one root joins all loops) and at any face where
    it is closed. Each edge in neither carries a form: 1 on the edge, and the imbalance of its two faces
    pushed up the dual tree. The forms are closed (they sum to zero around every face), and no
    combination of them is exact. Their number is 2 g for a closed component and 1 - chi for one with a
    boundary; -chi where the component is twisted by its signs.

    Entries are +1 and -1, along the edge's direction; +2 and -2 too in a closed twisted component.
    """
    n_faces, n_edges = mesh.n_faces, mesh.n_edges
    in_tree = _spanning_tree(mesh)
    outer = n_faces + mesh.face_components
    i, j = mesh.edge_faces.T
    across = np.where(j < 0, outer[i], j)
    free = np.flatnonzero(~in_tree)
    parent_edge, parent = _dual_tree(mesh, free, i[free], across[free])
    in_cotree = np.zeros(n_edges, dtype=bool)
    in_cotree[parent_edge[parent_edge >= 0]] = True
    generators = np.flatnonzero(~in_tree & ~in_cotree)
    count = len(generators)

    over = np.ones(n_edges)
    over[mesh.interior_edges] = mesh.bundle.over_edges

    rows, columns, entries = [generators], [np.arange(count)], [np.ones(count)]
    for start, imbalance in ((i[generators], np.ones(count)), (across[generators], -over[generators])):
        # The form adds its imbalance to the sum around the start face; walking up, each parent edge cancels
        # it there and hands it on to the next face, until the root swallows it.
        walker, label = start, np.arange(count)
        while len(walker):
            climbing = parent_edge[walker] >= 0
            walker, label, imbalance = walker[climbing], label[climbing], imbalance[climbing]
            edge = parent_edge[walker]
            along = np.where(i[edge] == walker, 1.0, -over[edge])
            rows.append(edge)
            columns.append(label)
            entries.append(-imbalance * along)
            walker, imbalance = parent[walker], imbalance * over[edge]
    forms = sparse.coo_array(
        (np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns))), shape=(n_edges, count)
    ).tocsc()
    forms.sum_duplicates()
    forms.eliminate_zeros()
    return _independent(mesh, forms, generators, in_tree) if mesh.bundle.twisted_components.any() else forms


def _independent(
    mesh: TriMesh, forms: sparse.csc_array, generators: Indices, in_tree: Flags
) -> sparse.csc_array:
    """Of the forms of each twisted component leave out a dependent one, and close the others at the root.

    Odd functions have no constants, so one combination of the forms is exact: that on an edge which returns
    along the tree with the opposite sign. On a closed component the root of the dual tree may be left with an
    imbalance, since going round the cotree changes signs too: another form takes it away.
    """
    component = mesh.face_components[mesh.edge_faces[generators, 0]]
    unbalanced = (
        mesh.bundle.ends.prod(axis=1) * mesh.bundle.gauge(np.flatnonzero(in_tree))[mesh.edges].prod(axis=1)
        < 0
    )
    dropped = np.zeros(len(generators), dtype=bool)
    wrong = np.flatnonzero(unbalanced[generators])
    dropped[wrong[np.unique(component[wrong], return_index=True)[1]]] = True
    around = sparse.csr_array(
        (
            mesh.bundle.forms.ravel(),
            (np.repeat(np.arange(mesh.n_faces), 3), mesh.face_edges.ravel()),
        ),
        shape=(mesh.n_faces, mesh.n_edges),
    )
    left = np.asarray((around @ forms).sum(axis=0))
    size = np.diff(forms.indptr)
    mixing = sparse.eye_array(len(generators), format="lil")
    for each in np.unique(component[(left != 0) & ~dropped]):
        open_forms = np.flatnonzero((component == each) & (left != 0) & ~dropped)
        closing = open_forms[np.argmin(size[open_forms])]
        mixing[closing, open_forms] = -left[open_forms] / left[closing]
        dropped[closing] = True
    kept = sparse.csc_array(forms @ mixing.tocsc()[:, np.flatnonzero(~dropped)])
    kept.eliminate_zeros()
    return kept


def _spanning_tree(mesh: TriMesh) -> Flags:
    """(E,) whether the edge belongs to a spanning forest of the vertices."""
    # Minimal spanning forest of distinct weights: scipy keeps the weight, which names the edge.
    names = np.arange(1.0, mesh.n_edges + 1.0)
    graph = sparse.csr_array((names, tuple(mesh.edges.T)), shape=(mesh.n_vertices,) * 2)
    tree = csgraph.minimum_spanning_tree(graph)
    chosen = np.zeros(mesh.n_edges, dtype=bool)
    chosen[tree.data.astype(np.int64) - 1] = True
    return chosen


def _dual_tree(mesh: TriMesh, edges: Indices, i: Indices, j: Indices) -> tuple[Indices, Indices]:
    """Breadth-first forest over faces and outer nodes across the given edges: parent edge and parent."""
    n_nodes = mesh.n_faces + mesh.n_components
    graph = sparse.coo_array((np.ones(len(edges), dtype=np.int8), (i, j)), shape=(n_nodes,) * 2)
    bounded = np.unique(mesh.face_components[mesh.edge_faces[mesh.boundary_edges, 0]])
    roots = np.unique(mesh.face_components, return_index=True)[1]
    roots[bounded] = mesh.n_faces + bounded
    # One more node joined to every root makes a single breadth-first search serve all components.
    hub = np.full(len(roots), n_nodes)
    joined = sparse.csr_array(
        (
            np.ones(len(edges) + len(roots), dtype=np.int8),
            (np.concatenate([graph.coords[0], hub]), np.concatenate([graph.coords[1], roots])),
        ),
        shape=(n_nodes + 1,) * 2,
    )
    _, found = csgraph.breadth_first_order(joined, n_nodes, directed=False)
    parent: Indices = np.where(found[:n_nodes] == n_nodes, -1, found[:n_nodes]).astype(np.int64)
    # Of several edges between the same two nodes (many lead outside) one is the tree's.
    low, high = np.minimum(i, j), np.maximum(i, j)
    key = low * (n_nodes + 1) + high
    distinct, first = np.unique(key, return_index=True)
    child = np.flatnonzero(parent >= 0)
    wanted = np.minimum(child, parent[child]) * (n_nodes + 1) + np.maximum(child, parent[child])
    parent_edge = np.full(n_nodes, -1, dtype=np.int64)
    parent_edge[child] = edges[first[np.searchsorted(distinct, wanted)]]
    return parent_edge, parent


@dataclass(frozen=True, eq=False)
class ClosedFields:
    """All curl-free fields of a mesh, without a constraint: ``v = B x`` with ``B = [G | H]``.

    The columns of B span the kernel of the curl C exactly: gradients of vertex functions, one vertex of
    each component pinned to zero, and one field for each class of the first cohomology. The paper
    imposes ``C v = 0`` with a multiplier per edge (Appendix B); here it holds by construction
    (DEVIATIONS.md, reduced-system).

    Attributes
    ----------
    mesh : the surface
    """

    mesh: TriMesh

    @cached_property
    def free_vertices(self) -> Indices:
        """Vertices that are not pinned; one vertex of each component is, if constants are functions there."""
        pinned = np.unique(self.mesh.vertex_components, return_index=True)[1]
        pinned = pinned[~self.mesh.bundle.twisted_components]
        return frozen(np.delete(np.arange(self.mesh.n_vertices), pinned))

    @cached_property
    def generators(self) -> sparse.csc_array:
        """(E, beta_1) the closed 1-forms of `harmonic_generators`."""
        return harmonic_generators(self.mesh)

    @cached_property
    def basis(self) -> sparse.csr_array:
        """B, (2F, V - c + beta_1): the free vertices' gradients, then the generators' fields."""
        gradients = gradient(self.mesh)[:, self.free_vertices]
        if not self.generators.shape[1]:
            return sparse.csr_array(gradients)
        fields = sharp(self.mesh) @ self.generators
        return sparse.hstack([gradients, fields], format="csr")

    @cached_property
    def basis_transposed(self) -> sparse.csr_array:
        """B', in row order, for right-hand sides."""
        return self.basis.T.tocsr()

    @cached_property
    def mass(self) -> sparse.csr_array:
        """``B' M B``: on the gradients this is the cotan Laplacian."""
        return sparse.csr_array(self.basis_transposed @ field_mass(self.mesh) @ self.basis)

    @cached_property
    def smoothness(self) -> sparse.csr_array:
        """``B' L B``: the Dirichlet energy of v = B x."""
        jumps = transport_differences(self.mesh) @ self.basis
        weights = sparse.diags_array(np.repeat(dual_weights(self.mesh), 2))
        return sparse.csr_array(jumps.T @ weights @ jumps)


@dataclass(frozen=True, eq=False)
class AllFields:
    """Every face field, in the form of `ClosedFields`: ``v = x``, with no constraint on its curl.

    What Eq. 5 becomes when the curl constraint is removed (Table 1, Fig. 10).

    Attributes
    ----------
    mesh : the surface
    """

    mesh: TriMesh

    @cached_property
    def basis(self) -> sparse.csr_array:
        """The identity, (2F, 2F)."""
        return sparse.csr_array(sparse.eye_array(2 * self.mesh.n_faces))

    @property
    def basis_transposed(self) -> sparse.csr_array:
        """The identity."""
        return self.basis

    @cached_property
    def mass(self) -> sparse.csr_array:
        """M, the areas."""
        return sparse.csr_array(field_mass(self.mesh))

    @cached_property
    def smoothness(self) -> sparse.csr_array:
        """L, the Dirichlet energy, as a real matrix (2F, 2F)."""
        jumps = transport_differences(self.mesh)
        weights = sparse.diags_array(np.repeat(dual_weights(self.mesh), 2))
        return sparse.csr_array(jumps.T @ weights @ jumps)
