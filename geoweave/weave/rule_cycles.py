"""A number of rules of a twill or a basket that no choice of sides breaks fewer than: odd cycles of rules.

Two wishes of each rule of a row are met together or broken together: ``x_a ^ x_c = p`` of the sides at
crossings two apart, and ``y_e ^ y_f = 1`` of the labels of links. So are the two pairs of links of a cell.
Each rule r has a number ``z_r``, 1 if it is broken, and every cycle of wishes of odd parity holds a broken
one: ``sum z_r >= 1`` over the rules that it holds an odd number of times. The least sum of all z that meets
the cycles found is a bound (`geoweave.weave.best_labels` does the same where a rule is one wish).
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from geoweave.arrays import Indices, Scalars
from geoweave.weave.odd_cycles import DoubledGraph, Graph
from geoweave.weave.weave_types import Rules

__all__ = ["fewest_of_cycles"]

_SHORT = 1e-5
"""Added to the weight of each wish: of two odd cycles of one weight the one of fewer wishes is taken."""
_LENGTHS = (8, 16, 32)
"""Odd cycles that z leaves out altogether are looked for up to so many wishes in turn, then others."""
_SEARCHES, _ENOUGH = 100, 60
"""Sources searched from in one round at most, and cycles after which a round is over."""
_ROUNDS, _EACH = 12, 200
"""Rounds at most, and the effort that one counts for."""
_NODES = 500
"""Nodes of the tree of one integer program."""
_ROUNDING = 1e-4
"""What a bound from a program may owe to its tolerances; taken off before it is rounded up."""


def fewest_of_cycles(rules: Rules, over: Indices, effort: int) -> int:
    """A bound on the number of rules that any sides break.

    Parameters
    ----------
    rules : of `geoweave.weave.weave_types.rules_of`
    over : (C,) good sides: every odd cycle holds a rule that they break, so that others are not searched from
    effort : rounds of cutting planes are an effort of 200 each, and twelve at most
    """
    search = _Cycles(rules, over)
    for _ in range(min(_ROUNDS, max(1, effort // _EACH))):
        if search.least >= search.most or not search.step():
            break
    return min(search.least, search.most)


class _Cycles:
    """The wishes of all rules as one graph, the odd cycles found, and the bound that they give."""

    def __init__(self, rules: Rules, over: Indices) -> None:
        crossings = len(rules.passages)
        sides, stays = rules.of_sides, rules.of_links
        start = np.concatenate([sides.first, crossings + stays.first])
        end = np.concatenate([sides.second, crossings + stays.second])
        parity = np.concatenate([sides.parity, stays.parity])
        rule = np.concatenate([sides.rule, stays.rule])
        loop = start == end
        # A wish of a crossing with itself is met or broken whatever the sides.
        self.cycles = [np.array([each]) for each in np.unique(rule[loop & (parity == 1)])]
        self.start, self.end, self.parity, self.rule = (each[~loop] for each in (start, end, parity, rule))
        ones = np.ones(len(self.start), dtype=np.int64)
        nodes = crossings + len(rules.passages.relations.first)
        self.doubled = DoubledGraph(
            Graph(nodes, self.start, self.end, self.parity, ones, ones.astype(np.float64))
        )
        broken = rules.broken(over)
        self.most, self.bound = int(broken.sum()), float(len(self.cycles))
        self.sources = np.unique(self.start[broken[self.rule]])
        self.z = np.zeros(len(rules))
        self.whole = False

    @property
    def least(self) -> int:
        """No sides break fewer rules."""
        return int(np.ceil(self.bound - _ROUNDING))

    def step(self) -> bool:
        """Add the odd cycles that z misses, and find the cheapest z again; whether that can go on."""
        if not self.cut():
            if self.whole:
                return False
            self.whole = True
        if self.cycles:
            self.z = self.program()
        return bool(self.cycles)

    def cut(self) -> bool:
        """Gather odd cycles on which z sums to less than one; whether there was any."""
        weight, before = self.z[self.rule] + _SHORT, len(self.cycles)
        near = self.doubled.near_their_copies(self.z[self.rule], self.sources)[:_SEARCHES]
        for limit in (*(steps * _SHORT for steps in _LENGTHS), 1.0 - _ROUNDING):
            if len(near) and len(self.cycles) - before < _ENOUGH:
                self.cycles += [self.held(each) for each in self.doubled.odd_cycles(weight, near, limit)]
        return len(self.cycles) > before

    def held(self, wishes: Indices) -> Indices:
        """The rules that an odd cycle holds an odd number of times; of a walk that is none, all of them."""
        ends = np.concatenate([self.start[wishes], self.end[wishes]])
        rules, times = np.unique(self.rule[wishes], return_counts=True)
        cycle = not (np.bincount(ends) % 2).any() and self.parity[wishes].sum() % 2
        result: Indices = rules[times % 2 == 1] if cycle else rules
        return result

    def program(self) -> Scalars:
        """Cheapest z that meets the cycles found, in whole numbers once there is no other way on."""
        from scipy.optimize import Bounds, LinearConstraint, milp

        members = np.concatenate(self.cycles)
        starts = np.cumsum([0, *(len(each) for each in self.cycles)])
        matrix = sparse.csr_array(
            (np.ones(len(members)), members, starts), shape=(len(self.cycles), len(self.z))
        )
        found = milp(
            np.ones(len(self.z)),
            integrality=np.full(len(self.z), int(self.whole)),
            bounds=Bounds(0.0, 1.0),
            constraints=LinearConstraint(matrix, lb=1.0),
            options={"node_limit": _NODES, "mip_rel_gap": 0.0},
        )
        bound = found.mip_dual_bound if self.whole else found.fun
        if bound is not None and np.isfinite(bound):
            self.bound = max(self.bound, float(bound))
        if found.x is None:
            return self.z
        return np.rint(found.x) if self.whole else np.clip(found.x, 0.0, 1.0)
