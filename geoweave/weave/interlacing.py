"""Which ribbon passes over at each crossing (Section 5.2; interleaved triples: Section 6).

A ribbon should go over and under in turn. That is a wish about two labels: with ``x_c`` the place, 0 or 1,
of the upper ribbon among the two of crossing c, a ribbon that is number s of crossing c and then number t of
crossing d alternates between them exactly when ``x_c ^ x_d == 1 ^ s ^ t``. The paper colours the crossings
greedily; `optimal` finds the best labels with a proof (geoweave.weave.best_labels).
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import KDTree

from geoweave.arrays import Flags, Indices, Scalars, frozen
from geoweave.errors import GeoweaveError
from geoweave.weave.best_labels import best_labels

TIME_LIMIT = 60.0
"""Seconds after which the proof of an optimum ends; its effort is counted, so this is a guard only."""

__all__ = [
    "TIME_LIMIT",
    "Crossings",
    "Interlacing",
    "Merge",
    "Relations",
    "greedy",
    "judged",
    "merged",
    "optimal",
]


class Relations(NamedTuple):
    """Pairs of crossings that follow each other on a ribbon, (M,) arrays."""

    first: Indices
    """The crossing that comes first along the ribbon."""
    second: Indices
    """The crossing that comes next."""
    ribbon: Indices
    """The ribbon."""
    parity: Indices
    """What ``over[first] ^ over[second]`` must be for the ribbon to change sides between them."""


@dataclass(frozen=True, eq=False)
class Crossings:
    """Where ribbons cross: which two, and how far along each of them.

    The columns of a crossing are its ribbon number 0 and its ribbon number 1; they may be one ribbon twice.

    Raises
    ------
    GeoweaveError
        If the shapes differ, a ribbon has no entry in ``closed``, or an arclength is not finite.
    """

    ribbons: Indices
    """(C, 2) ids of the two ribbons."""
    arclengths: NDArray[np.float64]
    """(C, 2) length from the start of each of them to the crossing."""
    closed: Flags
    """(R,) whether a ribbon ends where it begins."""

    def __post_init__(self) -> None:
        ribbons = np.array(self.ribbons, dtype=np.int64)
        arclengths = np.array(self.arclengths, dtype=np.float64)
        closed = np.array(self.closed, dtype=bool)
        if ribbons.size == 0:
            ribbons, arclengths = ribbons.reshape(0, 2), arclengths.reshape(-1, 2)
        if (
            ribbons.ndim != 2
            or ribbons.shape[1] != 2
            or arclengths.shape != ribbons.shape
            or closed.ndim != 1
        ):
            raise GeoweaveError(
                f"crossings are (C, 2) ribbons and (C, 2) arclengths and (R,) flags, not {ribbons.shape}, "
                f"{arclengths.shape} and {closed.shape}"
            )
        if ribbons.size and not 0 <= ribbons.min() <= ribbons.max() < len(closed):
            raise GeoweaveError(
                f"crossings name ribbons {ribbons.min()} to {ribbons.max()}, but flags are {len(closed)}"
            )
        if not np.isfinite(arclengths).all():
            bad = int(np.flatnonzero(~np.isfinite(arclengths).all(axis=1))[0])
            raise GeoweaveError(f"crossing {bad} has the arclengths {arclengths[bad]}, which are not finite")
        for field, value in zip(fields(self), (ribbons, arclengths, closed), strict=True):
            object.__setattr__(self, field.name, frozen(value))

    def __len__(self) -> int:
        return len(self.ribbons)

    @cached_property
    def passages(self) -> Indices:
        """(2C,) passages by ribbon, then arclength; ``2 c + s`` is that of ribbon number s at crossing c."""
        return frozen(np.lexsort((self.arclengths.ravel(), self.ribbons.ravel())))

    @cached_property
    def following(self) -> Indices:
        """(2C,) passage that comes next on the ribbon, -1 at its end; round and round on closed ribbons.

        A closed ribbon that passes once only has no next one.
        """
        order, ribbon = self.passages, self.ribbons.ravel()[self.passages]
        starts = np.flatnonzero(np.diff(ribbon, prepend=-1))
        ends = np.append(starts[1:], len(order)) - 1 if len(order) else starts
        following = np.full(len(order), -1, dtype=np.int64)
        following[order[:-1]] = order[1:]
        first, last = order[starts], order[ends]
        again = self.closed[ribbon[starts]] & (first != last)
        following[last] = np.where(again, first, -1)
        return frozen(following)

    @cached_property
    def relations(self) -> Relations:
        """Pairs of consecutive crossings, ordered by ribbon and arclength."""
        here = self.passages[self.following[self.passages] >= 0]
        there = self.following[here]
        return Relations(
            frozen(here // 2),
            frozen(there // 2),
            frozen(self.ribbons.ravel()[here]),
            frozen(1 ^ (here % 2) ^ (there % 2)),
        )

    @cached_property
    def triples(self) -> Indices:
        """(T, 3) relations that form a triangle: three ribbons, or three pieces of one, that cross pairwise
        and meet no other ribbon in between.

        The ribbon changes at each corner. In a triangle whose three relations are met, each ribbon lies over
        one of the others and under the other one: the three interleave. In any other triangle two relations
        are broken and one ribbon lies over both others.
        """
        here = self.passages[self.following[self.passages] >= 0]
        there, count = self.following[here], 2 * len(self)
        # The two ways out of each passage, forward and back, with the relation walked along.
        way = np.full((count, 2), -1, dtype=np.int64)
        along = np.full((count, 2), -1, dtype=np.int64)
        way[here, 0], along[here, 0] = there, np.arange(len(here))
        way[there, 1], along[there, 1] = here, np.arange(len(here))
        walked, at, begin = np.empty((count, 0), dtype=np.int64), np.arange(count), np.arange(count)
        for _ in range(3):
            target, relation = way[at].ravel(), along[at].ravel()
            walked, begin = np.repeat(walked, 2, axis=0), np.repeat(begin, 2)
            kept = target >= 0
            walked = np.column_stack([walked[kept], relation[kept]])
            begin, at = begin[kept], target[kept] ^ 1
        ring = np.sort(walked[at == begin], axis=1)
        ring = ring[(ring[:, 0] != ring[:, 1]) & (ring[:, 1] != ring[:, 2])]
        return frozen(np.unique(ring, axis=0).reshape(-1, 3))


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
    """Triangles of consecutive crossings."""
    interleaved: int
    """Triangles in which each ribbon lies over one of the others and under the other one."""
    triples_proven: bool = False
    """Whether no choice that breaks as few relations interleaves more triangles."""
    out_of_time: bool = False
    """Whether the search was ended by the clock: only then may another run find something else."""

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


class Merge(NamedTuple):
    """Crossings without near-duplicates, and where they come from."""

    crossings: Crossings
    kept: Indices
    """(K,) which of the given crossings stayed, ascending."""
    group: Indices
    """(C,) place in ``kept`` of the crossing that stands for each of the given ones."""


def judged(crossings: Crossings, over: ArrayLike) -> Interlacing:
    """Count what given sides (C,) break, without a bound.

    Raises
    ------
    GeoweaveError
        If there is not one 0 or 1 for each crossing.
    """
    sides = np.array(over, dtype=np.int64)
    if sides.shape != (len(crossings),) or not np.isin(sides, (0, 1)).all():
        raise GeoweaveError(f"sides are {len(crossings)} zeros and ones, not an array of shape {sides.shape}")
    relations, triples = crossings.relations, crossings.triples
    broken = sides[relations.first] ^ sides[relations.second] != relations.parity
    interleaved = int((~broken[triples].any(axis=1)).sum())
    return Interlacing(frozen(sides), frozen(broken), 0, len(triples), interleaved)


def greedy(crossings: Crossings, seed: int = 0) -> Interlacing:
    """The paper's rule: one ribbon after the other in random order, over and under in turn (Section 5.2).

    Where an earlier ribbon has settled a crossing the wrong way round, that decision stands and the ribbon
    goes on alternating from it. A ribbon begins over unless its first crossing is settled.

    Parameters
    ----------
    seed : of the order of the ribbons
    """
    ribbons = crossings.ribbons.ravel()[crossings.passages]
    over = np.full(len(crossings), -1, dtype=np.int64)
    bounds = np.searchsorted(ribbons, np.arange(len(crossings.closed) + 1))
    for ribbon in np.random.default_rng(seed).permutation(len(crossings.closed)):
        above = True
        for passage in crossings.passages[bounds[ribbon] : bounds[ribbon + 1]].tolist():
            crossing, side = divmod(passage, 2)
            if over[crossing] < 0:
                over[crossing] = side if above else 1 - side
            above = over[crossing] != side
    return judged(crossings, over)


def optimal(crossings: Crossings, time_limit: float = TIME_LIMIT) -> Interlacing:
    """The sides that break the fewest relations, and of these the ones that interleave the most triangles.

    Solved exactly by `best_labels`; when the time limit (seconds) strikes, the best found
    with a valid bound. Crossings of the same two ribbons within a ribbon's width should be `merged` first.
    The paper leaves the choice among assignments, and interleaving, to future work (Section 6).
    """
    relations, triples = crossings.relations, crossings.triples
    # A triangle that does not interleave breaks two of its three relations.
    weight = np.bincount(triples.ravel(), minlength=len(relations.first))
    best = best_labels(
        len(crossings), relations.first, relations.second, relations.parity, weight, time_limit
    )
    found = judged(crossings, best.labels)
    return replace(found, bound=best.bound, triples_proven=best.best_cost, out_of_time=best.out_of_time)


def merged(crossings: Crossings, near: float, lengths: Scalars | None = None) -> Merge:
    """One crossing in place of several between the same two ribbons, each ``near`` the next on both of them.

    Two ribbons that run along each other may be found to cross again and again within a segment. They cannot
    change sides there, so that one of these crossings stands for all: the middle one along its first ribbon.

    Parameters
    ----------
    near : length; crossings that lie within it on both ribbons are joined, and so on from each to the next
    lengths : (R,) length of each ribbon, so that the start of a closed one is near its end; without it
        nothing is joined across a start

    Raises
    ------
    GeoweaveError
        If ``near`` is negative or not finite, or the lengths do not fit.
    """
    if not 0 <= near < np.inf:
        raise GeoweaveError(f"the distance below which crossings are merged is not negative, not {near}")
    if lengths is not None and np.shape(lengths) != crossings.closed.shape:
        raise GeoweaveError(
            f"there are {len(crossings.closed)} ribbons, but lengths of shape {np.shape(lengths)}"
        )
    count = len(crossings)
    if count < 2:
        return Merge(crossings, frozen(np.arange(count)), frozen(np.arange(count)))
    # The same two ribbons in the same order, and one ribbon with itself by arclength.
    order = np.lexsort((crossings.arclengths, crossings.ribbons), axis=1)
    pair = np.take_along_axis(crossings.ribbons, order, axis=1)
    place = np.take_along_axis(crossings.arclengths, order, axis=1)
    copies, owner = _with_copies(pair, place, near, crossings.closed, lengths)
    # A third axis on which different pairs are out of reach.
    key = np.unique(pair, axis=0, return_inverse=True)[1].ravel()[owner] * (2.0 * near + 1.0)
    joined = KDTree(np.column_stack([copies, key])).query_pairs(near, p=np.inf, output_type="ndarray")
    links = sparse.csr_array(
        (np.ones(len(joined)), (owner[joined[:, 0]], owner[joined[:, 1]])), shape=(count, count)
    )
    groups, label = csgraph.connected_components(links, directed=False)
    ranked = np.lexsort((place[:, 0], label))
    sizes = np.bincount(label, minlength=groups)
    middle = ranked[np.cumsum(sizes) - sizes + (sizes - 1) // 2]
    kept = np.sort(middle)
    group = np.empty(groups, dtype=np.int64)
    group[label[kept]] = np.arange(groups)
    rest = Crossings(crossings.ribbons[kept], crossings.arclengths[kept], crossings.closed)
    return Merge(rest, frozen(kept), frozen(group[label]))


def _with_copies(
    pair: Indices, place: NDArray[np.float64], near: float, closed: Flags, lengths: Scalars | None
) -> tuple[NDArray[np.float64], Indices]:
    """Places on the two ribbons, once more beyond the end of a closed one if near its start; and owners."""
    owner = np.arange(len(place))
    if lengths is None:
        return place, owner
    for side in (0, 1):
        ribbon = pair[owner, side]
        early = np.flatnonzero(closed[ribbon] & (place[:, side] <= near))
        again = place[early]
        again[:, side] += np.asarray(lengths, dtype=np.float64)[ribbon[early]]
        place, owner = np.concatenate([place, again]), np.concatenate([owner, owner[early]])
    return place, owner
