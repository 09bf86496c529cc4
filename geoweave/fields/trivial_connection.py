"""N-RoSys whose singularities are given: trivial connections (Crane et al. 2010; footnote of Section 4.1).

A connection is trivial if what it carries round any loop comes back as it was. One that turns by given
multiples of a turn round the vertices is found with sums over a tree and Poisson problems on the dual graph.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Indices, Scalars
from geoweave.errors import FieldError
from geoweave.fields.connected_rosy import FITS, TURN, ConnectedRoSy, DualPotential, smallest_turns
from geoweave.fields.face_field import unit
from geoweave.fields.rosy import RoSyField
from geoweave.fields.singularities import windings
from geoweave.sparse import one_blas_thread
from geoweave.surface import TriMesh

SWEEPS = 20
"""Passes over the loops in which the whole turns round them are chosen; two or three are usual."""


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
