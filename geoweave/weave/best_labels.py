"""Two-valued labels with wanted agreements and disagreements: as few broken as possible, with a proof.

Each edge of a graph asks that its ends agree (parity 0) or differ (parity 1). All can have what they ask
for exactly when no cycle has odd parity. Otherwise at least one edge of every odd cycle is broken, and the
broken edges of a best labelling are a smallest set that meets every odd cycle. This is Max-Cut, NP-hard in
general (Poljak and Tuza 1994). On planar graphs the linear program over odd cycles has integer corners
(Barahona and Mahjoub 1986; Guenin 2001), so that cutting planes alone find and prove the optimum.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Flags, Indices, Scalars, frozen
from geoweave.errors import GeoweaveError
from geoweave.weave.odd_cycles import EQUAL, DoubledGraph, Graph, adjacency
from geoweave.weave.weave_types import EFFORT

__all__ = ["Labelling", "best_labels"]

_WORK = 1_200_000
"""Elementary steps that may be spent for each unit of effort: for `EFFORT` about a minute on a slow machine.

Searches and programs take longer on larger graphs, so that their number alone does not bound the time.
"""
_PROGRAM_STEPS = 300
"""Elementary steps for each entry of a program's matrix and each iteration of its solver, as measured."""
_NODE_STEPS = 3_000
"""The same for each entry and each node of the tree of an integer program."""
_ITERATIONS = 10_000
"""Iterations of the solver of one program with fractions; usual are 20 to 60."""

_ROUNDING = 1e-4
"""What a bound from a program may owe to its tolerances; taken off before it is rounded up."""
_SHORT = 1e-5
"""Added to the weight of each edge: of two odd cycles of one weight the one of fewer edges is taken."""
_SEARCHES = 100
"""Sources searched from before the weights are looked at again."""
_LOOKS = 20
"""Of very many sources each twentieth part is searched from before the weights are looked at again."""
_NODES = 2_000
"""Nodes of the tree of one integer program."""
_STEPS = (8, 16, 32)
"""Odd cycles that z leaves out altogether are looked for first, up to these numbers of edges in turn."""


@dataclass(frozen=True, eq=False)
class Labelling:
    """Labels of the nodes, what they break, and what no labels can avoid."""

    labels: Flags
    """(N,) one label per node; the first node of each connected component is False."""
    broken: Flags
    """(M,) the edges whose ends are not as asked."""
    bound: int
    """No labels break fewer edges."""
    best_cost: bool
    """Whether the ``tie`` costs of the broken edges are the smallest among labels that break as few."""
    effort: int
    """Searches and rows of programs that it took."""

    @property
    def proven(self) -> bool:
        """Whether no labels break fewer edges than these."""
        return int(self.broken.sum()) == self.bound


def best_labels(
    nodes: int,
    first: ArrayLike,
    second: ArrayLike,
    parity: ArrayLike,
    tie: ArrayLike | None = None,
    effort: int = EFFORT,
) -> Labelling:
    """Labels x of the nodes that break the fewest of the wishes ``x_first ^ x_second == parity``.

    ``minimize sum_e z_e`` over z in {0, 1} with ``sum of z over C >= 1`` for every odd cycle C. A connected
    component without odd cycles is labelled outright. On the others cutting planes add the odd cycles that
    the current z misses, each the shortest walk between the two copies of a node in the doubled graph, where
    an edge joins equal copies (parity 0) or different ones (parity 1); every linear program on the way is a
    bound, and labels are read off a spanning tree of smallest z. If fractions remain, the integer program
    over the cycles found goes on in the same way.

    The result depends on nothing but the input: the search is ended by counted effort, never by a clock.

    Parameters
    ----------
    nodes : number of nodes N
    first, second, parity : (M,) ends and wish of each edge. An edge from a node to itself is met or broken
        whatever the labels
    tie : (M,) whole numbers from 0 on. Of the labellings that break the fewest edges, one in which the sum
        over the broken edges is smallest
    effort : searches for odd cycles and rows of programs solved after which the best labels so far are
        returned with their bound. On large graphs elementary steps are counted too, and may end it earlier

    Raises
    ------
    GeoweaveError
        If the arrays do not fit each other, an edge names no node, or the effort is not positive.
    """
    start, end, wish = (np.asarray(each, dtype=np.int64) for each in (first, second, parity))
    price = np.zeros(len(start), dtype=np.int64) if tie is None else np.asarray(tie, dtype=np.int64)
    if not start.shape == end.shape == wish.shape == price.shape == (len(start),):
        raise GeoweaveError(f"ends, parities and ties are rows of one length, not {start.shape}, {end.shape}")
    if len(start) and (min(start.min(), end.min()) < 0 or max(start.max(), end.max()) >= nodes):
        raise GeoweaveError(f"an edge names a node outside 0..{nodes - 1}")
    if not np.isin(wish, (0, 1)).all() or (price < 0).any() or effort < 1:
        raise GeoweaveError("parities are 0 or 1, ties are not negative, and the effort is positive")
    budget = _Budget(effort)

    proper = start != end
    labels = _labels(nodes, start[proper], end[proper], wish[proper])
    component = csgraph.connected_components(adjacency(nodes, start, end), directed=False)[1]
    odd_components = np.unique(
        component[start[proper & ((labels[start] ^ labels[end]) != wish.astype(bool))]]
    )
    sizes = np.bincount(component, minlength=1)
    bound = int(np.count_nonzero(~proper & (wish == 1)))
    finished = True
    for one in odd_components[np.argsort(sizes[odd_components], kind="stable")]:
        inside = np.flatnonzero(component == one)
        edges = np.flatnonzero((component[start] == one) & proper)
        place = np.empty(nodes, dtype=np.int64)
        place[inside] = np.arange(len(inside))
        graph = _merged(len(inside), place[start[edges]], place[end[edges]], wish[edges], price[edges])
        labels[inside], least, best = _Program(graph, budget).solve()
        bound, finished = bound + least, finished and best
    broken = (labels[start] ^ labels[end]) != wish.astype(bool)
    best = finished and int(broken.sum()) == bound
    return Labelling(frozen(labels), frozen(broken), bound, best, budget.used)


def _labels(nodes: int, start: Indices, end: Indices, wish: Indices) -> Flags:
    """Labels that meet all wishes of each component where that can be, False in the others."""
    both = adjacency(
        2 * nodes,
        np.concatenate([start, start + nodes]),
        np.concatenate([end + nodes * wish, end + nodes * (1 - wish)]),
    )
    copies = csgraph.connected_components(both, directed=False)[1].reshape(2, nodes)
    # The first node of a component comes first in the numbering, and so with its copy of label False.
    labels: Flags = copies[0] > copies[1]
    return labels


def _merged(nodes: int, start: Indices, end: Indices, wish: Indices, price: Indices) -> Graph:
    """Edges of one wish between the same nodes become one."""
    low, high = np.minimum(start, end), np.maximum(start, end)
    key, group, count = np.unique((low * nodes + high) * 2 + wish, return_inverse=True, return_counts=True)
    total = np.bincount(group, weights=price, minlength=len(key))
    # An optimum breaks at most as many edges as a spanning tree leaves over, so that ties sum to 1/2.
    most = (count.sum() - nodes + 1) * max(float((total / count).max()), 1.0)
    cost = count + total / (2.0 * most)
    return Graph(nodes, key // 2 // nodes, key // 2 % nodes, key % 2, count, cost)


class _Budget:
    """What all components together may still spend."""

    def __init__(self, effort: int) -> None:
        self.effort, self.used = effort, 0
        self.steps = effort * _WORK
        """Elementary steps that are left."""

    def spent(self) -> bool:
        """Whether the effort is used up."""
        return self.used >= self.effort or self.steps <= 0


class _Program:
    """The search for one component: odd cycles so far, the best labels, the best bound."""

    def __init__(self, graph: Graph, budget: _Budget) -> None:
        self.graph, self.budget = graph, budget
        self.doubled = DoubledGraph(graph)
        self.cycles: list[Indices] = []
        self.labels = np.zeros(graph.nodes, dtype=bool)
        self.cost = np.inf
        self.bound = 0.0

    def solve(self) -> tuple[Flags, int, bool]:
        """Labels, the bound on the number of broken edges, and whether the costs are proven best too."""
        edges = len(self.graph.first)
        z = np.zeros(edges)
        self.offer(self.graph.cost)
        exact = False
        while not self.closed():
            self.offer(z + _SHORT * self.graph.cost)
            if self.closed() or self.budget.spent():
                break
            if not self.cut(z):
                if exact:
                    break
                exact = True
            z = self.program(exact)
        least = int(np.ceil(self.bound - self.ties() - _ROUNDING))
        return self.labels ^ self.labels[0], min(least, self.broken_count()), self.closed()

    def closed(self) -> bool:
        """Whether the labels cost what the bound says."""
        return self.cost <= self.bound + EQUAL

    def broken(self, labels: Flags) -> Flags:
        """(E,) which edges the labels break."""
        unequal = labels[self.graph.first] ^ labels[self.graph.second]
        result: Flags = unequal != self.graph.parity.astype(bool)
        return result

    def broken_count(self) -> int:
        """Edges that the best labels break, each as often as it was given."""
        return int(self.graph.times[self.broken(self.labels)].sum())

    def ties(self) -> float:
        """The most that the ties of an optimum add to its cost, below one half."""
        graph = self.graph
        dearest = float(((graph.cost - graph.times) / graph.times).max())
        return min(dearest * self.broken_count(), 0.5)

    def offer(self, weight: Scalars) -> None:
        """Keep the labels along the spanning tree of smallest weight, improved, if they are the best yet."""
        graph = self.graph
        # One edge for each pair of nodes: the first of the lighter ones.
        order = np.argsort(weight, kind="stable")
        _, chosen = np.unique((graph.first * graph.nodes + graph.second)[order], return_index=True)
        chosen = order[chosen]
        rank = np.empty(len(order))
        rank[order] = np.arange(1, len(order) + 1)
        tree = sparse.coo_array(
            csgraph.minimum_spanning_tree(
                sparse.csr_array(
                    (rank[chosen], (graph.first[chosen], graph.second[chosen])),
                    shape=(graph.nodes, graph.nodes),
                )
            )
        )
        used = order[tree.data.astype(np.int64) - 1]
        labels = _labels(graph.nodes, graph.first[used], graph.second[used], graph.parity[used])
        labels = self.improved(labels)
        cost = float(graph.cost[self.broken(labels)].sum())
        if cost < self.cost - EQUAL:
            self.labels, self.cost = labels, cost

    def improved(self, labels: Flags) -> Flags:
        """Turn the label that gains most, until none gains."""
        graph, labels = self.graph, labels.copy()
        while True:
            value = np.where(self.broken(labels), graph.cost, -graph.cost)
            gain = np.bincount(graph.first, value, graph.nodes) + np.bincount(
                graph.second, value, graph.nodes
            )
            node = int(np.argmax(gain))
            if gain[node] <= EQUAL:
                return labels
            labels[node] = not labels[node]

    def cut(self, z: Scalars) -> bool:
        """Gather odd cycles on which z sums to less than one; whether there was any.

        Every odd cycle holds an edge that the best labels break, so that their ends are all that need be
        searched from. Cycles that z leaves out altogether come first, the shortest of them before the others.
        """
        sources = np.unique(self.graph.first[self.broken(self.labels)])
        weight, before = z + _SHORT, len(self.cycles)
        searches = max(_SEARCHES, len(sources) // _LOOKS)
        for steps in (*_STEPS, 1.0 / _SHORT - 1.0):
            while not self.budget.spent():
                before_it = self.doubled.steps
                near = self.doubled.near_their_copies(weight - _SHORT, sources)
                self.budget.steps -= self.doubled.steps - before_it
                if not len(near) or not self.gather(weight, near[:searches], steps * _SHORT):
                    break
        return len(self.cycles) > before

    def gather(self, weight: Scalars, sources: Indices, limit: float) -> int:
        """Add odd cycles through the sources, none heavier than the limit; how many."""
        self.budget.used += len(sources)
        found = self.doubled.odd_cycles(weight, sources, limit)
        self.cycles += found
        return len(found)

    def rows(self) -> tuple[sparse.csr_array, Indices]:
        """One row per cycle over the edges that lie on any of them, and those edges."""
        seen = np.unique(np.concatenate(self.cycles))
        place = np.searchsorted(seen, np.concatenate(self.cycles))
        ends = np.cumsum([0, *(len(cycle) for cycle in self.cycles)])
        matrix = sparse.csr_array((np.ones(len(place)), place, ends), shape=(len(self.cycles), len(seen)))
        return matrix, seen

    def program(self, integer: bool) -> Scalars:
        """Cheapest z that meets each cycle found so far, in integers or not; its cost is a bound."""
        matrix, seen = self.rows()
        z = np.zeros(len(self.graph.first))
        self.budget.used += len(self.cycles)
        found, bound = (self.whole if integer else self.relaxed)(matrix, self.graph.cost[seen])
        if bound is not None and np.isfinite(bound):
            self.bound = max(self.bound, float(bound))
        if found is not None:
            z[seen] = found
        return z

    def relaxed(self, matrix: sparse.csr_array, cost: Scalars) -> tuple[Scalars | None, float | None]:
        """The program with fractions, and its value. Its corners are many and alike: by an interior path."""
        from scipy.optimize import linprog

        result = linprog(  # type: ignore[call-overload]  # its stubs forget sparse matrices
            cost,
            A_ub=-matrix,
            b_ub=-np.ones(matrix.shape[0]),
            bounds=(0.0, 1.0),
            method="highs-ipm",
            options={"maxiter": _ITERATIONS},
        )
        self.budget.steps -= _PROGRAM_STEPS * matrix.nnz * int(result.nit)
        if result.status != 0:
            return None, None
        return np.clip(result.x, 0.0, 1.0), float(result.fun)

    def whole(self, matrix: sparse.csr_array, cost: Scalars) -> tuple[Scalars | None, float | None]:
        """The program in integers, as far as its limits let it come, and a bound on its value."""
        from scipy.optimize import Bounds, LinearConstraint, milp

        node = _NODE_STEPS * matrix.nnz
        most = min(_NODES, max(1, self.budget.steps // node))
        result = milp(
            cost,
            integrality=np.ones(len(cost), dtype=np.int64),
            bounds=Bounds(0.0, 1.0),
            constraints=LinearConstraint(matrix, lb=1.0),
            options={"node_limit": most, "mip_rel_gap": 0.0},
        )
        self.budget.steps -= node * max(1, int(result.mip_node_count or 0))
        return None if result.x is None else np.rint(result.x), result.mip_dual_bound
