"""Which ribbon passes over at each crossing (Section 5.2; interleaved triples: Section 6).

A ribbon should go over and under in turn. This relates the labels of consecutive crossings. Let ``x_c`` be 0
or 1: which of the two ribbons of crossing c lies over. A ribbon that is number s of crossing c and then
number t of crossing d alternates between them exactly when ``x_c ^ x_d == 1 ^ s ^ t``. The paper labels the
crossings greedily. `optimal` finds the best labels with a proof (geoweave.weave.best_labels). In a twill and
in a basket a ribbon goes over two and under two (geoweave.weave.weave_types).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geoweave.arrays import Flags, Indices, frozen
from geoweave.errors import GeoweaveError
from geoweave.weave.passages import Passages
from geoweave.weave.weave_types import EFFORT, FLOATING, WeaveType, rules_of
from geoweave.wording import counted

__all__ = ["EFFORT", "Interlacing", "greedy", "judged", "optimal"]


@dataclass(frozen=True, eq=False)
class Interlacing:
    """The upper ribbon of each crossing, and how far ribbons alternate."""

    over: Indices
    """(C,) 0 or 1: which of the two ribbons of the crossing lies above."""
    broken: Flags
    """(M,) relations between consecutive crossings at which the ribbon stays on the same side."""
    bound: int
    """No choice breaks fewer of what the weave is to meet, relations or rules. 0 where nothing is known."""
    triples: int
    """Triangles of consecutive passages."""
    interleaved: int
    """Triangles in which each ribbon lies over one of the others and under the other one."""
    triples_proven: bool = False
    """Whether no choice that breaks as few relations interleaves more triangles."""
    pattern: WeaveType = "plain"
    """The weave that is meant; "plain" and "kagome" ask for nothing but that ribbons alternate."""
    unmet: Flags | None = None
    """(K,) rules of a twill or a basket that are broken; None where ribbons are to alternate."""

    @property
    def alternation(self) -> float:
        """Fraction of the consecutive crossings at which the ribbon changes sides; 1 without any."""
        return 1.0 - int(self.broken.sum()) / max(len(self.broken), 1)

    @property
    def alternation_bound(self) -> float:
        """The fraction that no choice exceeds; 1 for a twill and a basket, which are not to alternate."""
        return 1.0 if self.unmet is not None else self.met_bound

    @property
    def asked(self) -> int:
        """How many relations or rules the weave is to meet."""
        return len(self.broken if self.unmet is None else self.unmet)

    @property
    def defects(self) -> int:
        """How many of these are broken."""
        return int((self.broken if self.unmet is None else self.unmet).sum())

    @property
    def met(self) -> float:
        """The share of these that is met; 1 without any."""
        return 1.0 - self.defects / max(self.asked, 1)

    @property
    def met_bound(self) -> float:
        """The share that no choice exceeds."""
        return 1.0 - self.bound / max(self.asked, 1)

    @property
    def proven(self) -> bool:
        """Whether no choice breaks fewer of what the weave is to meet."""
        return self.defects == self.bound

    def document(self) -> dict[str, Any]:
        """What reports say of the pattern."""
        return {
            "name": self.pattern,
            "relations": self.asked,
            "broken": self.defects,
            "fraction": self.met,
            "fewest": self.bound,
            "optimal_fraction_bound": self.met_bound,
            "proven": self.proven,
        }


def judged(passages: Passages, over: ArrayLike, pattern: WeaveType = "plain") -> Interlacing:
    """Count the relations, and for a twill or a basket the rules, that sides break. The result has no bound.

    Parameters
    ----------
    over : (C,) which ribbon lies over at each crossing, 0 or 1
    pattern : the weave that is meant

    Raises
    ------
    GeoweaveError
        If there is not one 0 or 1 for each crossing.
    """
    sides = np.array(over, dtype=np.int64)
    if sides.shape != (len(passages),) or not np.isin(sides, (0, 1)).all():
        raise GeoweaveError(
            f"sides of {counted(len(passages), 'crossing')} are as many zeros and ones, not an array of "
            f"shape {sides.shape}"
        )
    relations, triples = passages.relations, passages.triples
    broken = sides[relations.first] ^ sides[relations.second] != relations.parity
    interleaved = int((~broken[triples].any(axis=1)).sum())
    unmet = frozen(rules_of(passages, pattern).broken(sides)) if pattern in FLOATING else None
    return Interlacing(frozen(sides), frozen(broken), 0, len(triples), interleaved, False, pattern, unmet)


def greedy(passages: Passages, seed: int = 0) -> Interlacing:
    """The paper's rule: one ribbon after the other in random order, over and under in turn (Section 5.2).

    A crossing that an earlier ribbon has labelled keeps its label, even where it breaks the alternation. The
    ribbon then alternates from there. A ribbon begins over unless its first crossing has a label.

    Parameters
    ----------
    seed : of the order of the ribbons
    """
    ribbons = passages.ribbons.ravel()[passages.order]
    over = np.full(len(passages), -1, dtype=np.int64)
    bounds = np.searchsorted(ribbons, np.arange(len(passages.closed) + 1))
    for ribbon in np.random.default_rng(seed).permutation(len(passages.closed)):
        above = True
        for passage in passages.order[bounds[ribbon] : bounds[ribbon + 1]].tolist():
            crossing, side = divmod(passage, 2)
            if over[crossing] < 0:
                over[crossing] = side if above else 1 - side
            above = over[crossing] != side
    return judged(passages, over)


def optimal(passages: Passages, effort: int = EFFORT, pattern: WeaveType = "plain") -> Interlacing:
    """Find the sides that break the fewest relations; among these, the ones that interleave most triangles.

    Of a twill or a basket these are the rules, triangles do not count, and `floating_sides` searches; the
    bound holds, and need not be reached.

    `best_labels` solves this exactly. When the counted effort is used up, it returns the best sides found
    with a valid bound.
    The same passages give the same sides on every machine. Crossings of the same two ribbons within a
    ribbon's width should be `merged` first. The paper leaves the choice among assignments, and interleaving,
    to future work (Section 6).
    """
    from geoweave.weave.best_labels import best_labels
    from geoweave.weave.floating_sides import floating_sides

    if pattern in FLOATING:
        over, bound = floating_sides(rules_of(passages, pattern), effort)
        return replace(judged(passages, over, pattern), bound=bound)
    relations, triples = passages.relations, passages.triples
    # A triangle that does not interleave breaks two of its three relations.
    weight = np.bincount(triples.ravel(), minlength=len(relations.first))
    best = best_labels(len(passages), relations.first, relations.second, relations.parity, weight, effort)
    found = judged(passages, best.labels, pattern)
    return replace(found, bound=best.bound, triples_proven=best.best_cost)
