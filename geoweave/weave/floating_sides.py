"""Over and under of a twill or a basket that break as few rules as can be found, and a bound on the fewest.

A rule of a row relates two crossings, one of a cell four (`geoweave.weave.weave_types`). Labels of two
crossings each are solved with a proof by `best_labels`. Here two such problems, each of which leaves out a
part of what sides have to meet, give bounds and starts. A search that turns crossings over counts all rules.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Flags, Indices, Scalars
from geoweave.weave.best_labels import Labelling, best_labels
from geoweave.weave.odd_cycles import adjacency
from geoweave.weave.rule_cycles import fewest_of_cycles
from geoweave.weave.weave_types import Rules

__all__ = ["floating_sides"]

_PROOFS, _STARTS = 20, 100
"""Share of the effort, one in so many, for each problem that gives a bound, and for each that gives a start.

Rules of rows are no planar graph: ten times the effort raised no bound of a torus of 500 crossings.
"""

_TRIES = 6
"""Parts of the links, the largest first, of which the opposite labels are tried too."""

_DEPTH = 200
"""Crossings that are turned over before the best of these steps is gone back to."""

_STEPS = 100_000
"""Crossings that one search turns over at most."""


def floating_sides(rules: Rules, effort: int) -> tuple[Indices, int]:
    """Sides that break few rules of a twill or a basket, and a number of rules that none breaks fewer than.

    Rules of rows alone are wishes ``x ^ x' == p`` for crossings two apart, and their proven fewest is a
    bound. Labels of links that need not come from sides are another: each rule of a row is given twice and
    one of a cell as its two pairs, so that half of the fewest broken is a bound on all sides. If neither is
    reached, the odd cycles of both together give a better one (`geoweave.weave.rule_cycles`).

    Parameters
    ----------
    rules : of `rules_of`
    effort : as for `best_labels`; where it is used up, the bound still holds

    Returns
    -------
    (C,) which ribbon lies over at each crossing, and the bound
    """
    passages, links = rules.passages, rules.passages.relations
    search = _Search(rules)
    sides = rules.of_sides
    rows = best_labels(
        len(passages), sides.first, sides.second, sides.parity, None, max(1, effort // _PROOFS)
    )
    stays = _staying(rules, max(1, effort // _PROOFS))
    bound = max(rows.bound, -(-stays.bound // 2))
    best, broken = search.improved(rows.labels.astype(np.int64))
    for labels in _both_ways(rules, stays.labels):
        if broken == bound:
            break
        wanted = links.parity ^ labels
        found = best_labels(len(passages), links.first, links.second, wanted, None, max(1, effort // _STARTS))
        over, number = search.improved(found.labels.astype(np.int64))
        if number < broken:
            best, broken = over, number
    if broken > bound:
        bound = max(bound, fewest_of_cycles(rules, best, effort))
    return best, min(bound, broken)


def _staying(rules: Rules, effort: int) -> Labelling:
    """Labels of the links that break the fewest rules, whether or not there are sides that have them."""
    stays = rules.of_links
    twice = np.concatenate([np.arange(len(rules.row)), np.arange(len(stays.rule))])
    first, second, parity = stays.first[twice], stays.second[twice], stays.parity[twice]
    links = len(rules.passages.relations.first)
    return best_labels(links, first, second, parity, None, effort)


def _both_ways(rules: Rules, labels: Flags) -> list[Flags]:
    """These labels of the links, and those that are opposite on one part of them: as good by themselves."""
    wishes = rules.of_links
    graph = adjacency(len(labels), wishes.first, wishes.second)
    count, part = csgraph.connected_components(graph, directed=False)
    largest = np.argsort(-np.bincount(part, minlength=count), kind="stable")[:_TRIES]
    return [labels, *(labels ^ (part == each) for each in largest)]


class _Search:
    """Turns crossings over, one at a time, to break fewer rules."""

    def __init__(self, rules: Rules) -> None:
        self.rules = rules
        links, crossings = rules.passages.relations, len(rules.passages)
        number = np.tile(np.arange(len(links.first)), 2)
        ends = sparse.csr_array(
            (np.ones(len(number)), (number, np.concatenate([links.first, links.second]))),
            shape=(len(links.first), crossings),
        )
        one, other = np.concatenate([rules.row, rules.cell[:, [0, 2]]]).T
        enters = ends[one] + ends[other]
        enters.data %= 2.0  # a crossing that both links share does not enter
        enters.eliminate_zeros()
        self.enters = sparse.csr_array(enters.T)
        self.rows = sparse.csr_array(enters)

    def improved(self, over: Indices) -> tuple[Indices, int]:
        """Better sides, and how many rules they break.

        Of all crossings not yet turned over, the one that mends most is turned over, also where that is less
        than none; after some such steps the best of them is gone back to. The first round that mends nothing
        is the last (Kernighan and Lin 1970).
        """
        over, left = over.copy(), _STEPS
        broken = int(self.rules.broken(over).sum())
        while left > 0 and broken:
            wrong = np.where(self.rules.broken(over), 1.0, -1.0)
            gain: Scalars = np.asarray(self.enters @ wrong)
            order, total, best, kept = [], 0.0, 0.0, 0
            for _ in range(min(_DEPTH, len(over), left)):
                node = int(np.argmax(gain))
                order.append(node)
                total += gain[node]
                self._turn(node, wrong, gain)
                gain[node] = -np.inf
                if total > best:
                    best, kept = total, len(order)
            left -= len(order)
            if not kept:
                break
            over[order[:kept]] ^= 1
            broken -= int(best)
        return over, broken

    def _turn(self, node: int, wrong: Scalars, gain: Scalars) -> None:
        """Turn one crossing over: its rules change, and what their other crossings mend."""
        enters, rows = self.enters, self.rows
        for rule in enters.indices[enters.indptr[node] : enters.indptr[node + 1]]:
            members = rows.indices[rows.indptr[rule] : rows.indptr[rule + 1]]
            gain[members] -= 2.0 * wrong[rule]
            wrong[rule] = -wrong[rule]
