"""N-RoSys whose singularities are given: trivial connections (Crane et al. 2010; footnote of Section 4.1).

A connection is trivial if what it carries round any loop comes back as it was. One that turns by given
multiples of a turn round the vertices is found with sums over a tree and Poisson problems on the dual graph.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Indices, Scalars, frozen
from geoweave.errors import FieldError
from geoweave.fields.face_field import unit
from geoweave.fields.operators import dual_weights, face_laplacian
from geoweave.fields.rosy import RoSyField
from geoweave.fields.singularities import windings
from geoweave.sparse import factorized, nested_dissection, one_blas_thread
from geoweave.surface import TriMesh

TURN = 2.0 * np.pi

FITS = 1e-6
"""How far the number of a face may be from the neighbour's, turned as is said, radians."""

SWEEPS = 20
"""Passes over the loops in which the whole turns round them are chosen; two or three are usual."""


@dataclass(frozen=True, eq=False)
class ConnectedRoSy(RoSyField):
    """An N-RoSy that also says by how much it turns from face to face.

    A RoSy alone is matched by the smallest turn, which is at most pi / N. Round a vertex of k triangles it
    can have no index above k / 2N in this way. Here the turns are given, so any index can be.

    Attributes
    ----------
    turns : (E_int,) turn of the number of the RoSy, its N-th power, over each interior edge from face i to
        face j, radians; N times the turn of the vectors

    Raises
    ------
    FieldError
        If a turn does not lead from the number of one face to that of the next.

    Examples
    --------
    >>> disk = gw.shapes.disk(faces=200)
    >>> index = np.zeros(disk.n_vertices, dtype=int)
    >>> index[np.linalg.norm(disk.vertices, axis=1).argmin()] = 5
    >>> rosy = gw.prescribed_rosy(disk, 6, index)
    >>> bool((rosy.index_numerators == index).all()), bool(abs(rosy.turns).max() > np.pi / 2)
    (True, True)
    """

    turns: Scalars

    def __post_init__(self) -> None:
        super().__post_init__()
        turns = np.array(self.turns, dtype=np.float64)
        count = len(self.mesh.interior_edges)
        if turns.shape != (count,):
            raise FieldError(
                f"a connected N-RoSy needs one turn per interior edge, ({count},), not {turns.shape}"
            )
        wrong = ~(np.abs(np.angle(np.exp(1j * (smallest_turns(self) - turns)))) < FITS)
        if wrong.any():
            edge = int(np.flatnonzero(wrong)[0])
            raise FieldError(f"the turn over interior edge {edge} does not lead from one face to the other")
        object.__setattr__(self, "turns", frozen(turns))

    @cached_property
    def matching(self) -> Indices:
        """(E_int,) shift sigma: vector k of face i is turned to vector ``(k + sigma) mod N`` of face j."""
        i, j = self.mesh.edge_faces[self.mesh.interior_edges].T
        first = self.vectors[:, 0]
        arrives = self.mesh.transport * first[i] * np.exp(1j * self.turns / self.degree)
        ahead = np.angle(arrives * first[j].conj())
        return frozen(np.rint(ahead * self.degree / TURN).astype(np.int64) % self.degree)


def smallest_turns(rosy: RoSyField) -> Scalars:
    """(E_int,) smallest turn of the number of an N-RoSy over each interior edge, in (-pi, pi]."""
    mesh = rosy.mesh
    i, j = mesh.edge_faces[mesh.interior_edges].T
    return np.angle(rosy.values[j] * (mesh.transport**rosy.degree * rosy.values[i]).conj())


def turns_of(rosy: RoSyField) -> Scalars:
    """(E_int,) the turns of an N-RoSy: those that it says, or the smallest."""
    return rosy.turns if isinstance(rosy, ConnectedRoSy) else smallest_turns(rosy)


class DualPotential:
    """Functions on faces whose differences are nearest to given numbers on interior edges.

    ``argmin sum over ij of weight_ij (c_ij - (phi_j - phi_i))^2``, the Poisson problem on the dual graph with
    the weights of the Dirichlet energy; one face of each component is held at zero.

    Parameters
    ----------
    mesh : the surface
    """

    def __init__(self, mesh: TriMesh) -> None:
        i, j = mesh.edge_faces[mesh.interior_edges].T
        count = len(i)
        self._free = np.delete(np.arange(mesh.n_faces), np.unique(mesh.face_components, return_index=True)[1])
        self._steps = sparse.csr_array(
            (np.tile([-1.0, 1.0], count), (np.repeat(np.arange(count), 2), np.stack([i, j], axis=1).ravel())),
            shape=(count, mesh.n_faces),
        )
        self.weights = dual_weights(mesh)
        laplacian = face_laplacian(mesh)[self._free][:, self._free]
        self._factors = factorized(sparse.csr_array(laplacian), nested_dissection(laplacian))

    def of(self, jumps: Scalars) -> Scalars:
        """(F,) the function of (E_int,) numbers, or one in each column."""
        weighted = (self.weights * jumps.T).T
        phi = np.zeros((self._steps.shape[1], *jumps.shape[1:]))
        phi[self._free] = self._factors.solve((self._steps.T @ weighted)[self._free])
        return phi

    def rest(self, jumps: Scalars) -> Scalars:
        """What no function explains of (E_int,) numbers, or of those in each column."""
        return np.asarray(jumps - self._steps @ self.of(jumps))


def rewound(rosy: RoSyField, jumps: Indices) -> ConnectedRoSy:
    """Add whole turns to the edges of an N-RoSy, and spread them as evenly as can be.

    ``phi = argmin sum of weight_ij (2 pi k_ij - (phi_j - phi_i))^2``, then ``u <- u exp(-i phi)``. The index
    changes at each vertex by exactly what the whole turns round it sum to, and nowhere else.

    Parameters
    ----------
    rosy : the N-RoSy
    jumps : (E_int,) whole turns k of its number from face i to face j

    Returns
    -------
    ConnectedRoSy
    """
    mesh = rosy.mesh
    added = TURN * np.asarray(jumps, dtype=np.float64)
    phi = DualPotential(mesh).of(added)
    i, j = mesh.edge_faces[mesh.interior_edges].T
    turns = turns_of(rosy) + added - (phi[j] - phi[i])
    return ConnectedRoSy(mesh, rosy.degree, rosy.values * np.exp(-1j * phi), turns)


class _Trees(NamedTuple):
    """A spanning forest of the faces, one of the vertices that avoids it, and the edges in neither."""

    faces: Indices
    """(F,) parent of each face, -1 at a root."""
    face_edges: Indices
    """(F,) interior edge to the parent, -1 at a root."""
    face_depth: Indices
    nodes: Indices
    """(V,) node of each vertex: itself, and for all boundary vertices of a component the first of them."""
    parents: Indices
    """(V,) parent of each node, -1 at a root and at vertices that are no nodes."""
    parent_edges: Indices
    depth: Indices
    """(V,) steps to the root, -1 at vertices that are no nodes."""
    generators: Indices
    """Interior edges in neither: one for each class of loops."""


def _forest(count: int, ends: Indices, roots: Indices) -> tuple[Indices, Indices, Indices]:
    """Breadth-first forest of a graph from its roots: parent, edge to it, and depth of each node."""
    low, high = ends.min(axis=1), ends.max(axis=1)
    _, first = np.unique(low * count + high, return_index=True)
    first = first[low[first] != high[first]]
    graph = sparse.coo_array((1.0 + first, (low[first], high[first])), shape=(count, count)).tocsr()
    graph = sparse.csr_array(graph + graph.T)
    depth, parent, _ = csgraph.dijkstra(
        graph, indices=roots, unweighted=True, return_predecessors=True, min_only=True
    )
    reached = np.isfinite(depth)
    child = np.flatnonzero(reached & (parent >= 0))
    edge = np.full(count, -1, dtype=np.int64)
    edge[child] = np.asarray(graph[child, parent[child]]).ravel().astype(np.int64) - 1
    return (
        np.where(parent >= 0, parent, -1).astype(np.int64),
        edge,
        np.where(reached, depth, -1).astype(np.int64),
    )


def _trees(mesh: TriMesh) -> _Trees:
    faces = mesh.edge_faces[mesh.interior_edges]
    _, face_roots = np.unique(mesh.face_components, return_index=True)
    parent, face_edge, face_depth = _forest(mesh.n_faces, faces, face_roots)
    left = np.ones(len(faces), dtype=bool)
    left[face_edge[face_edge >= 0]] = False
    # All boundary vertices of a component are one node, which takes what is left over.
    nodes, roots = np.arange(mesh.n_vertices), np.unique(mesh.vertex_components, return_index=True)[1]
    rim = np.flatnonzero(mesh.boundary_vertices)
    components, first = np.unique(mesh.vertex_components[rim], return_index=True)
    roots[components] = rim[first]
    nodes[rim] = roots[mesh.vertex_components[rim]]
    ends = nodes[mesh.edges[mesh.interior_edges]]
    crossed = np.flatnonzero(left)
    parents, within, depth = _forest(mesh.n_vertices, ends[crossed], roots)
    parent_edges = np.where(within >= 0, crossed[within], -1)
    left[parent_edges[parent_edges >= 0]] = False
    return _Trees(parent, face_edge, face_depth, nodes, parents, parent_edges, depth, np.flatnonzero(left))


def _flow(mesh: TriMesh, trees: _Trees, wanted: Indices) -> Indices:
    """Whole turns on the tree of the vertices whose sums round the nodes are the wanted numbers.

    Parameters
    ----------
    wanted : (V, columns) sums, taken round each node but the roots

    Returns
    -------
    (E_int, columns)
    """
    sums = np.zeros_like(wanted)
    np.add.at(sums, trees.nodes, wanted)
    jumps = np.zeros((len(mesh.interior_edges), wanted.shape[1]), dtype=np.int64)
    heads = trees.nodes[mesh.edges[mesh.interior_edges, 1]]
    for level in range(int(trees.depth.max()), 0, -1):
        node = np.flatnonzero(trees.depth == level)
        edge = trees.parent_edges[node]
        jumps[edge] = np.where(heads[edge] == node, 1, -1)[:, None] * sums[node]
        np.add.at(sums, trees.parents[node], sums[node])
    return jumps


def _loops(mesh: TriMesh, trees: _Trees) -> Indices:
    """(E_int, loops) one turn over the edges of each loop of the surface, or path from rim to rim."""
    tails, heads = mesh.edges[mesh.interior_edges[trees.generators]].T
    column = np.arange(len(trees.generators))
    wanted = np.zeros((mesh.n_vertices, len(column)), dtype=np.int64)
    np.add.at(wanted, (heads, column), -1)
    np.add.at(wanted, (tails, column), 1)
    loops = _flow(mesh, trees, wanted)
    loops[trees.generators, column] = 1
    return loops


def _whole_turns(potential: DualPotential, rest: Scalars, loops: Indices) -> Indices:
    """Whole turns round each loop that make the energy of the turns small.

    The energy is a quadratic function of the numbers: the minimum over the reals is rounded one number after
    the other (Babai), then single numbers are changed while that lowers it.
    """
    count = loops.shape[1]
    turns = np.zeros(count, dtype=np.int64)
    if not count:
        return turns
    harmonic = TURN * potential.rest(loops.astype(np.float64))
    root = np.sqrt(potential.weights)
    q, r = np.linalg.qr(root[:, None] * harmonic)
    aim = -q.T @ (root * rest)
    for k in range(count - 1, -1, -1):
        turns[k] = np.rint((aim[k] - r[k, k + 1 :] @ turns[k + 1 :]) / r[k, k])
    form = r.T @ r
    for _ in range(SWEEPS):
        before = turns.copy()
        for k in range(count):
            slope = form[k] @ turns - r[:, k] @ aim
            # A rise of one costs form[k, k] / 2 + slope; half a step too much is rounding, not a gain.
            best = -slope / form[k, k]
            if abs(best) > 0.5 + FITS:
                turns[k] += int(np.rint(best))
        if (turns == before).all():
            break
    return turns


def check_sums(mesh: TriMesh, degree: int, numerators: Indices) -> None:
    """Refuse indices that do not sum to the Euler characteristic of a closed component.

    Raises
    ------
    FieldError
        The text says the missing sum.
    """
    for component in range(mesh.n_components):
        own = mesh.vertex_components == component
        if own[mesh.boundary_vertices].any():
            continue
        faces = int((mesh.face_components == component).sum())
        # Every edge of a closed surface has two faces.
        characteristic = int(own.sum()) - faces // 2
        given, due = int(numerators[own].sum()), degree * characteristic
        if given != due:
            where = "the surface" if mesh.n_components == 1 else f"component {component} of the surface"
            raise FieldError(
                f"the indices of the singularities sum to {given}/{degree}, but those of a field on {where} "
                f"sum to {due}/{degree}, {degree} times its Euler characteristic {characteristic}: "
                f"{due - given:+d}/{degree} is missing"
            )


@one_blas_thread()
def prescribed_rosy(
    mesh: TriMesh, degree: int, numerators: Indices, *, like: RoSyField | None = None
) -> ConnectedRoSy:
    """Compute the smoothest N-RoSy with given singularities: a trivial connection (Crane et al. 2010).

    Its number turns from face to face by ``r``, the least sum of ``weight_ij r_ij^2`` for which every vertex
    has its index and what goes round a loop comes back as it was. Round loops of the surface whole turns are
    free; they are chosen so that the sum is small. That it is least is proven for one loop only.

    Parameters
    ----------
    mesh : any surface; where it has a boundary, the loops take the indices that are left
    degree : N
    numerators : (V,) N times the index wanted at each interior vertex, whole numbers
    like : a RoSy whose vectors it is to be near to; a common rotation of all vectors is free

    Returns
    -------
    ConnectedRoSy
        Its `index_numerators` are the given ones, exactly.

    Raises
    ------
    FieldError
        If the indices do not sum to the Euler characteristic on a closed component, one lies on a boundary,
        or one is too large for the few triangles round its vertex.

    See Also
    --------
    smoothest_rosy : finds its own singularities

    Examples
    --------
    >>> sphere = gw.shapes.sphere(faces=320)
    >>> index = np.zeros(sphere.n_vertices, dtype=int)
    >>> index[[sphere.vertices[:, 2].argmin(), sphere.vertices[:, 2].argmax()]] = 5, 7
    >>> bool((gw.prescribed_rosy(sphere, 6, index).index_numerators == index).all())
    True
    """
    if degree < 1:
        raise FieldError(f"an N-RoSy has N >= 1 vectors on a face, not {degree}")
    numerators = np.asarray(numerators, dtype=np.int64)
    if numerators.shape != (mesh.n_vertices,):
        raise FieldError(f"indices need one number per vertex, ({mesh.n_vertices},), not {numerators.shape}")
    if numerators[mesh.boundary_vertices].any():
        raise FieldError("an index on the boundary cannot be prescribed; give it to a vertex inside")
    check_sums(mesh, degree, numerators)
    trees = _trees(mesh)
    start = _parallel_along(mesh, degree, trees)
    turns = smallest_turns(start)
    found = np.rint(windings(mesh, turns, degree)).astype(np.int64)
    wanted = numerators - found
    # The sums round boundary vertices are free.
    wanted[mesh.boundary_vertices] = 0
    jumps = _flow(mesh, trees, wanted[:, None])[:, 0]
    potential, loops = DualPotential(mesh), _loops(mesh, trees)
    jumps = jumps + loops @ _whole_turns(potential, potential.rest(turns + TURN * jumps), loops)
    turns = turns + TURN * jumps
    phi = potential.of(turns)
    i, j = mesh.edge_faces[mesh.interior_edges].T
    values = start.values * np.exp(-1j * phi)
    if like is not None:
        mean = np.array(
            [
                np.sum((mesh.face_areas * like.values * values.conj())[mesh.face_components == c])
                for c in range(mesh.n_components)
            ]
        )
        values = values * unit(mean)[mesh.face_components]
    return _holding(ConnectedRoSy(mesh, degree, values, turns - (phi[j] - phi[i])), numerators)


def _holding(rosy: ConnectedRoSy, numerators: Indices) -> ConnectedRoSy:
    """Refuse a RoSy that turns by half a turn or more from one face to the next: nobody could follow it."""
    wrong = np.flatnonzero(rosy.index_numerators != numerators)
    if len(wrong):
        worst = int(wrong[np.abs(numerators[wrong]).argmax()])
        raise FieldError(
            f"the triangles round vertex {worst} are too few for an index of "
            f"{numerators[worst]}/{rosy.degree}, or for others near it; refine the mesh there or spread it"
        )
    return rosy


def _parallel_along(mesh: TriMesh, degree: int, trees: _Trees) -> RoSyField:
    """The N-RoSy that is parallel along the tree of the faces."""
    values = np.ones(mesh.n_faces, dtype=np.complex128)
    step = mesh.transport**degree
    first = mesh.edge_faces[mesh.interior_edges, 0]
    for level in range(1, int(trees.face_depth.max()) + 1):
        face = np.flatnonzero(trees.face_depth == level)
        edge, parent = trees.face_edges[face], trees.faces[face]
        values[face] = unit(values[parent] * np.where(first[edge] == parent, step[edge], step[edge].conj()))
    return RoSyField(mesh, degree, values)
