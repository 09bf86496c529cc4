"""Which ribbon passes over at each crossing (Section 5.2; interleaved triples: Section 6).

A ribbon should go over and under in turn. This relates the labels of consecutive crossings. Let ``x_c`` be 0
or 1: which of the two ribbons of crossing c lies over. A ribbon that is number s of crossing c and then
number t of crossing d alternates between them exactly when ``x_c ^ x_d == 1 ^ s ^ t``. The paper labels the
crossings greedily. `optimal` finds the best labels with a proof (geoweave.weave.best_labels).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from geoweave.arrays import Flags, Indices, frozen
from geoweave.errors import GeoweaveError
from geoweave.weave.best_labels import EFFORT, best_labels
from geoweave.weave.passages import Passages

__all__ = ["EFFORT", "Interlacing", "greedy", "judged", "optimal"]


@dataclass(frozen=True, eq=False)
class Interlacing:
    """The upper ribbon of each crossing, and how far ribbons alternate."""

    over: Indices
    """(C,) 0 or 1: which of the two ribbons of the crossing lies above."""
    broken: Flags
    """(M,) relations between consecutive crossings at which the ribbon stays on the same side."""
    bound: int
    """No choice breaks fewer relations. 0 where nothing better is known."""
    triples: int
    """Triangles of consecutive passages."""
    interleaved: int
    """Triangles in which each ribbon lies over one of the others and under the other one."""
    triples_proven: bool = False
    """Whether no choice that breaks as few relations interleaves more triangles."""

    @property
    def alternation(self) -> float:
        """Fraction of the consecutive crossings at which the ribbon changes sides; 1 without any."""
        return 1.0 - int(self.broken.sum()) / max(len(self.broken), 1)

    @property
    def alternation_bound(self) -> float:
        """The fraction that no choice exceeds."""
        return 1.0 - self.bound / max(len(self.broken), 1)

    @property
    def proven(self) -> bool:
        """Whether no choice alternates more often."""
        return int(self.broken.sum()) == self.bound


def judged(passages: Passages, over: ArrayLike) -> Interlacing:
    """Count the relations that given sides (C,) break. The result has no bound.

    Raises
    ------
    GeoweaveError
        If there is not one 0 or 1 for each crossing.
    """
    sides = np.array(over, dtype=np.int64)
    if sides.shape != (len(passages),) or not np.isin(sides, (0, 1)).all():
        raise GeoweaveError(f"sides are {len(passages)} zeros and ones, not an array of shape {sides.shape}")
    relations, triples = passages.relations, passages.triples
    broken = sides[relations.first] ^ sides[relations.second] != relations.parity
    interleaved = int((~broken[triples].any(axis=1)).sum())
    return Interlacing(frozen(sides), frozen(broken), 0, len(triples), interleaved)


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


def optimal(passages: Passages, effort: int = EFFORT) -> Interlacing:
    """Find the sides that break the fewest relations; among these, the ones that interleave most triangles.

    `best_labels` solves this exactly. When the counted effort is used up, it returns the best sides found
    with a valid bound.
    The same passages give the same sides on every machine. Crossings of the same two ribbons within a
    ribbon's width should be `merged` first. The paper leaves the choice among assignments, and interleaving,
    to future work (Section 6).
    """
    relations, triples = passages.relations, passages.triples
    # A triangle that does not interleave breaks two of its three relations.
    weight = np.bincount(triples.ravel(), minlength=len(relations.first))
    best = best_labels(len(passages), relations.first, relations.second, relations.parity, weight, effort)
    found = judged(passages, best.labels)
    return replace(found, bound=best.bound, triples_proven=best.best_cost)
