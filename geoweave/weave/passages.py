"""In which order ribbons pass each other: all that over and under depend on (Section 5.2)."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geoweave.arrays import Flags, Indices, Scalars, frozen
from geoweave.curves import Crossings, Curves
from geoweave.errors import GeoweaveError
from geoweave.wording import counted

__all__ = ["Merge", "Passages", "Relations", "merged"]


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
class Passages:
    """How each ribbon passes the others: which two ribbons cross, and how far along each of them.

    This is all that over and under need: no surface and no position. The columns of a crossing are its ribbon
    number 0 and its ribbon number 1; they may be one ribbon twice. A passage is one ribbon at one crossing.

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

    @classmethod
    def on(cls, curves: Curves, met: Crossings) -> Passages:
        """The passages of curves at their crossings."""
        return cls(met.curves, met.arclength, curves.closed)

    @cached_property
    def order(self) -> Indices:
        """(2C,) all passages by ribbon, then arclength; ``2 c + s`` is ribbon number s at crossing c."""
        return frozen(np.lexsort((self.arclengths.ravel(), self.ribbons.ravel())))

    @cached_property
    def following(self) -> Indices:
        """(2C,) passage that comes next on the ribbon, -1 at its end; round and round on closed ribbons.

        A closed ribbon that passes once only has no next one.
        """
        order, ribbon = self.order, self.ribbons.ravel()[self.order]
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
        here = self.order[self.following[self.order] >= 0]
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
        ring = np.sort(self.rings(3), axis=1)
        return frozen(np.unique(ring, axis=0).reshape(-1, 3))

    def rings(self, count: int) -> Indices:
        """(n, count) relations of each cell of so many corners, in the order in which one walks round it.

        The ribbon changes at each corner, and no other ribbon is met in between.
        """
        here = self.order[self.following[self.order] >= 0]
        there, passages = self.following[here], 2 * len(self)
        # The two ways out of each passage, forward and back, with the relation walked along.
        way = np.full((passages, 2), -1, dtype=np.int64)
        along = np.full((passages, 2), -1, dtype=np.int64)
        way[here, 0], along[here, 0] = there, np.arange(len(here))
        way[there, 1], along[there, 1] = here, np.arange(len(here))
        walked, at, begin = np.empty((passages, 0), dtype=np.int64), np.arange(passages), np.arange(passages)
        for _ in range(count):
            target, relation = way[at].ravel(), along[at].ravel()
            walked, begin = np.repeat(walked, 2, axis=0), np.repeat(begin, 2)
            kept = target >= 0
            walked = np.column_stack([walked[kept], relation[kept]])
            begin, at = begin[kept], target[kept] ^ 1
        ring = walked[at == begin]
        alike = np.sort(ring, axis=1)
        once = (np.diff(alike, axis=1) > 0).all(axis=1)
        _, first = np.unique(alike[once], axis=0, return_index=True)
        return frozen(ring[once][first].reshape(-1, count))


class Merge(NamedTuple):
    """Crossings without near-duplicates, and where they come from."""

    passages: Passages
    kept: Indices
    """(K,) which of the given crossings stayed, ascending."""
    group: Indices
    """(C,) place in ``kept`` of the crossing that stands for each of the given ones."""


def merged(passages: Passages, near: float, lengths: Scalars | None = None) -> Merge:
    """Replace crossings of the same two ribbons that lie near each other by one of them.

    Two ribbons that run along each other may cross several times on a short way. They cannot change sides
    there, so that one of these crossings stands for all: the middle one along its first ribbon.

    Parameters
    ----------
    near : length; crossings within it of each other on both ribbons are joined, and so are chains of such
    lengths : (R,) length of each ribbon, so that the start of a closed one is near its end; without it
        nothing is joined across a start

    Raises
    ------
    GeoweaveError
        If ``near`` is negative or not finite, or the lengths do not fit.
    """
    from scipy import sparse
    from scipy.sparse import csgraph
    from scipy.spatial import KDTree

    if not 0 <= near < np.inf:
        raise GeoweaveError(f"the distance below which crossings are merged is not negative, not {near}")
    if lengths is not None and np.shape(lengths) != passages.closed.shape:
        raise GeoweaveError(
            f"for {counted(len(passages.closed), 'ribbon')} there are lengths of shape {np.shape(lengths)}"
        )
    count = len(passages)
    if count < 2:
        return Merge(passages, frozen(np.arange(count)), frozen(np.arange(count)))
    # The same two ribbons in the same order, and one ribbon with itself by arclength.
    order = np.lexsort((passages.arclengths, passages.ribbons), axis=1)
    pair = np.take_along_axis(passages.ribbons, order, axis=1)
    place = np.take_along_axis(passages.arclengths, order, axis=1)
    copies, owner = _with_copies(pair, place, near, passages.closed, lengths)
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
    rest = Passages(passages.ribbons[kept], passages.arclengths[kept], passages.closed)
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
