"""Singularities of an N-RoSy that are moved along the edges, and pairs that are made to meet (Section 6).

A path with one whole turn on its edges takes an index of 1 / N from its start and gives it to its end. All
other indices stay, whatever the field.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Indices, Scalars
from geoweave.errors import FieldError
from geoweave.fields.connected_rosy import rewound
from geoweave.fields.rosy import RoSyField
from geoweave.surface import TriMesh


@dataclass(frozen=True)
class Pair:
    """Two singularities of opposite sign, and how far they are apart along edges."""

    positive: int
    """Vertex of the positive index."""
    negative: int
    """Vertex of the negative one."""
    distance: float
    """Length of the shortest path of interior edges between them."""


@dataclass(frozen=True, eq=False)
class Merged:
    """An N-RoSy without the pairs of singularities that were merged.

    Attributes
    ----------
    rosy : what is left; the same object if there was no such pair
    pairs : the pairs, nearest first; one that lost more than 1 / N on both sides stands here as often
    """

    rosy: RoSyField
    pairs: tuple[Pair, ...]


class EdgePaths:
    """Shortest paths along the interior edges of a mesh."""

    def __init__(self, mesh: TriMesh) -> None:
        self.mesh = mesh
        tails, heads = mesh.edges[mesh.interior_edges].T
        lengths = mesh.edge_lengths[mesh.interior_edges]
        shape = (mesh.n_vertices,) * 2
        self._graph = sparse.coo_array((lengths, (tails, heads)), shape=shape).tocsr()
        names = sparse.coo_array((1.0 + np.arange(len(tails)), (tails, heads)), shape=shape).tocsr()
        self._names = sparse.csr_array(names + names.T)

    def within(self, sources: Indices, distance: float) -> tuple[Scalars, Indices]:
        """Distances (sources, V) up to a limit, infinite beyond, and the vertex before each on its path."""
        far, before = csgraph.dijkstra(
            self._graph, directed=False, indices=sources, limit=distance, return_predecessors=True
        )
        return far, np.asarray(before, dtype=np.int64)

    def add_turn(self, jumps: Indices, before: Indices, start: int, end: int) -> None:
        """Add to whole turns (E_int,) one that takes an index of 1 / N from the start of a path to its end.

        Parameters
        ----------
        before : (V,) row of `within` that belongs to the start
        """
        here = end
        while here != start:
            last = int(before[here])
            edge = int(self._names[last, here]) - 1
            # A turn over an edge counts for its head and against its tail.
            jumps[edge] += 1 if self.mesh.edges[self.mesh.interior_edges[edge], 1] == here else -1
            here = last


def merged_pairs(rosy: RoSyField, distance: float) -> Merged:
    """Merge singularities of opposite sign that are no farther apart than a distance.

    The nearest two first: each loses 1 / N, until one of them is regular. A whole turn is put on the edges of
    the shortest path between them and spread by one Poisson problem on the dual graph (`rewound`).

    Parameters
    ----------
    rosy : the N-RoSy
    distance : along edges, unit length

    Returns
    -------
    Merged
        The indices of its RoSy are those of the given one, but for the pairs.

    Raises
    ------
    FieldError
        If the distance is negative or not a number.

    Examples
    --------
    >>> mesh = gw.shapes.torus(faces=2_000)
    >>> rosy = gw.smoothest_rosy(mesh)
    >>> merged = gw.merged_pairs(rosy, 1.5)
    >>> before, after = len(rosy.branch_points), len(merged.rosy.branch_points)
    >>> len(merged.pairs) > 3, before - after == 2 * len(merged.pairs)
    (True, True)
    """
    if not distance >= 0:
        raise FieldError(f"singularities are merged within a distance of zero or more, not {distance}")
    left = rosy.index_numerators.copy()
    positive, negative = np.flatnonzero(left > 0), np.flatnonzero(left < 0)
    if not len(positive) or not len(negative):
        return Merged(rosy, ())
    paths = EdgePaths(rosy.mesh)
    far, before = paths.within(positive, distance)
    near = far[:, negative]
    rows, columns = np.nonzero(near <= distance)
    jumps = np.zeros(len(rosy.mesh.interior_edges), dtype=np.int64)
    pairs: list[Pair] = []
    for each in np.argsort(near[rows, columns], kind="stable"):
        a, b = int(positive[rows[each]]), int(negative[columns[each]])
        units = int(min(left[a], -left[b]))
        for _ in range(units):
            paths.add_turn(jumps, before[rows[each]], a, b)
        pairs += [Pair(a, b, float(near[rows[each], columns[each]]))] * units
        left[a] -= units
        left[b] += units
    return Merged(rewound(rosy, jumps), tuple(pairs)) if pairs else Merged(rosy, ())


def moved(rosy: RoSyField, moves: Sequence[tuple[int, int]]) -> RoSyField:
    """Move 1 / N of index from one vertex to another, once for each pair of vertices.

    Parameters
    ----------
    rosy : the N-RoSy
    moves : (from, to): the index of the first falls by 1 / N, that of the second rises by it

    Raises
    ------
    FieldError
        If no path of interior edges joins two of the vertices, or one lies on the boundary.

    Examples
    --------
    >>> rosy = gw.smoothest_rosy(gw.shapes.sphere(faces=320))
    >>> there, away = rosy.branch_points[0], np.flatnonzero(rosy.index_numerators == 0)[0]
    >>> after = gw.fields.moved(rosy, [(there, away)]).index_numerators - rosy.index_numerators
    >>> int(after[there]), int(after[away]), int(abs(after).sum())
    (-1, 1, 2)
    """
    mesh = rosy.mesh
    if not len(moves):
        return rosy
    paths = EdgePaths(mesh)
    jumps = np.zeros(len(mesh.interior_edges), dtype=np.int64)
    for start, end in moves:
        if mesh.boundary_vertices[[start, end]].any():
            raise FieldError(f"one of the vertices {start} and {end} lies on the boundary, where no index is")
        far, before = paths.within(np.array([start]), np.inf)
        if not np.isfinite(far[0, end]):
            raise FieldError(f"no path of interior edges leads from vertex {start} to vertex {end}")
        paths.add_turn(jumps, before[0], int(start), int(end))
    return rewound(rosy, jumps)
