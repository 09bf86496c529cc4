"""Lightest odd cycles of a graph whose edges ask their ends to agree or to differ.

In the doubled graph each node has two copies. An edge that asks for agreement (parity 0) joins equal copies,
one that asks for difference (parity 1) joins different ones. A closed walk has odd parity exactly when it
leads from one copy of a node to the other.
"""

from __future__ import annotations

import heapq
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Indices, Scalars
from geoweave.compiled import compiled

__all__ = ["EQUAL", "DoubledGraph", "Graph", "adjacency"]

BLOCK = 5_000_000
"""Distances that are held in memory at once: 40 MB."""

EQUAL = 1e-6
"""Sums that differ by no more are as good as equal."""

_RAISED = 0.12
"""Added to the weight of the edges of an odd cycle found, so that other cycles are found beside it."""


class Graph(NamedTuple):
    """A connected graph with an odd cycle; an edge stands for ``times`` equal ones and costs ``cost``."""

    nodes: int
    first: Indices
    second: Indices
    parity: Indices
    times: Indices
    cost: Scalars


def adjacency(nodes: int, start: Indices, end: Indices) -> sparse.csr_array:
    """(nodes, nodes) matrix with a one for each edge."""
    return sparse.csr_array((np.ones(len(start)), (start, end)), shape=(nodes, nodes))


class DoubledGraph:
    """Two copies of each node, joined by the edges according to their parity; neighbours by node."""

    def __init__(self, graph: Graph) -> None:
        nodes, start, end, wish = graph.nodes, graph.first, graph.second, graph.parity
        self.nodes = nodes
        self.steps = 0
        """Elementary steps that `near_their_copies` took so far, at most."""
        tail = np.concatenate([start, start + nodes])
        head = np.concatenate([end + nodes * wish, end + nodes * (1 - wish)])
        edge = np.tile(np.arange(len(start)), 2)
        tail, head, edge = np.concatenate([tail, head]), np.concatenate([head, tail]), np.tile(edge, 2)
        order = np.lexsort((head, tail))
        self.heads, self.edge = head[order], edge[order]
        self.starts = np.concatenate([[0], np.cumsum(np.bincount(tail, minlength=2 * nodes))])

    def odd_cycles(self, weight: Scalars, sources: Indices, limit: float) -> list[Indices]:
        """Edges of the lightest odd cycles through the sources, none heavier than the limit.

        The weights are raised on the edges found.
        """
        edges, ends = _odd_walks(
            self.starts, self.heads, self.edge, weight, sources, self.nodes, limit, _RAISED
        )
        return [np.unique(cycle) for cycle in np.split(edges, ends)[:-1]]

    def near_their_copies(self, z: Scalars, sources: Indices) -> Indices:
        """Sources nearer than one to their other copies, nearest first; edges of no length are contracted."""
        nodes, length = self.nodes, z[self.edge]
        tails = np.repeat(np.arange(2 * nodes), np.diff(self.starts))
        inner = length < EQUAL
        joined = adjacency(2 * nodes, tails[inner], self.heads[inner])
        count, part = csgraph.connected_components(joined, directed=False)
        part = part.astype(np.int64)  # the product of two of these numbers is taken below
        tail, head, outer = part[tails[~inner]], part[self.heads[~inner]], length[~inner]
        # Of parallel edges between two parts the lightest one.
        order = np.lexsort((outer, tail * count + head))
        key, chosen = np.unique((tail * count + head)[order], return_index=True)
        shrunk = sparse.csr_array((outer[order][chosen], (key // count, key % count)), shape=(count, count))
        unique, row = np.unique(part[sources], return_inverse=True)
        target, distance = part[sources + nodes], np.empty(len(sources))
        # A row of distances to all nodes for each source: in blocks, so that memory stays bounded.
        block = max(1, BLOCK // count)
        for first in range(0, len(unique), block):
            here = np.flatnonzero((row >= first) & (row < first + block))
            found = csgraph.dijkstra(shrunk, indices=unique[first : first + block], limit=1.0)
            distance[here] = found[row[here] - first, target[here]]
        self.steps += len(self.heads) + len(unique) * (count + len(key))
        near = np.flatnonzero(distance < 1.0 - EQUAL)
        result: Indices = sources[near[np.argsort(distance[near], kind="stable")]]
        return result


@compiled
def _odd_walks(
    starts: Indices, heads: Indices, edge: Indices, weight: Scalars, sources: Indices, nodes: int,
    limit: float, raised: float,
) -> tuple[Indices, Indices]:  # fmt: skip
    """Lightest odd closed walks through the sources in turn, none heavier than ``limit``.

    Dijkstra's method runs from each source. The path from the other copy of the source to a node mirrors the
    path from the source to the other copy of the node. So a closed walk consists of the two paths to both
    copies of one node, and a search only goes half as far. The weight of the edges found is ``raised`` before
    the next search, so that walks differ.

    Parameters
    ----------
    starts, heads, edge : neighbours of each node of the doubled graph, and the edges that lead to them
    weight : (E,) positive; changed
    """
    far = np.inf
    distance = np.full(2 * nodes, far)
    done = np.zeros(2 * nodes, dtype=np.bool_)
    before = np.full(2 * nodes, -1)
    through = np.full(2 * nodes, -1)
    touched = np.empty(2 * nodes, dtype=np.int64)
    edges = [0 for _ in range(0)]
    ends = [0 for _ in range(0)]
    for source in sources:
        distance[source] = 0.0
        touched[0], count = source, 1
        best, meeting = far, -1
        heap = [(0.0, source)]
        while heap:
            so_far, node = heapq.heappop(heap)
            if 2.0 * so_far >= min(best, limit):
                break
            if done[node]:
                continue
            done[node] = True
            for k in range(starts[node], starts[node + 1]):
                head = heads[k]
                total = so_far + weight[edge[k]]
                if total <= limit and total < distance[head]:
                    if distance[head] == far:
                        touched[count] = head
                        count += 1
                    distance[head], before[head], through[head] = total, node, edge[k]
                    heapq.heappush(heap, (total, head))
                    walk = total + distance[(head + nodes) % (2 * nodes)]
                    if walk <= limit and walk < best:
                        best, meeting = walk, head
        if meeting >= 0:
            for node in (meeting, (meeting + nodes) % (2 * nodes)):
                while node != source:
                    weight[through[node]] += raised
                    edges.append(through[node])
                    node = before[node]
            ends.append(len(edges))
        for k in range(count):
            node = touched[k]
            distance[node], done[node], before[node], through[node] = far, False, -1, -1
    return np.array(edges, dtype=np.int64), np.array(ends, dtype=np.int64)
