"""In which order to put the ribbons together (Section 5.4: a backbone first, everything else off it).

The next ribbon is one that is held by what is there, and as near as possible to where the hands are: the
object grows zone by zone, and is not turned over for every ribbon.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geoweave.arrays import Indices, Scalars, Vectors
from geoweave.fabrication.pattern import Pattern

__all__ = ["BACKBONE", "HELD", "LATEST", "MEDIUM", "Step", "assembly"]

MEDIUM = (0.25, 0.75)
"""Between these shares of all ribbons, sorted by length, a ribbon is of medium length."""

BACKBONE = 0.15
"""Share of the ribbons that the backbone has, three at least."""

HELD = 2
"""A ribbon is laid in when it crosses what is there at so many places, if any ribbon does."""

LATEST = 0.5
"""A closed ribbon is next when this share of its crossings is with ribbons that are there: it has to be
threaded through them, and its ends still have to meet."""


class Step(NamedTuple):
    """One ribbon that is laid in."""

    strip: int
    backbone: bool
    crossings: tuple[int, ...]
    """Those with ribbons that are there already, or with itself, in the order in which they come on it."""
    zone: int = 0
    """Which part of the object it is worked at, from 0 (`geoweave.fabrication.assembly_zones`)."""


def assembly(pattern: Pattern, places: Vectors | None = None) -> tuple[Step, ...]:
    """Order the ribbons: a backbone of medium length, then always the nearest one that holds.

    A step is worked at the mean of the crossings that it fastens. Of the ribbons that cross what is there at
    `HELD` places or more, the one is next whose place of work is nearest to that of the step before. While
    the backbone is built, only ribbons of medium length are taken, as long as one of them crosses what is
    there. A closed ribbon is next as soon as `LATEST` of its crossings are with what is there. A component of
    the weave that touches no other begins with the ribbon of medium length that crosses most others. Ties
    are broken by the number. Hoops close the openings, so they come last.

    Parameters
    ----------
    pattern : the strips
    places : (C, 3) where the crossings are in space; without them, of the ribbons that hold always the one is
        next that crosses most of what is there
    """
    count = len(pattern.strips)
    state = _State.of(pattern, places)
    hoop = np.array([strip.hoop for strip in pattern.strips], dtype=bool)
    closed = np.array([strip.closed for strip in pattern.strips], dtype=bool) & ~hoop
    medium = _medium(np.array([strip.length for strip in pattern.strips])) & ~hoop
    wanted = min(max(3, math.ceil(BACKBONE * count)), count)
    steps: list[Step] = []
    for number in range(count):
        free = np.flatnonzero(~state.placed & ~hoop)
        if not len(free):
            free = np.flatnonzero(~state.placed)
        touching = free[state.held[free] > 0]
        backbone = number < wanted
        among = touching if len(touching) else free
        late = among[closed[among] & (state.held[among] >= LATEST * state.total[among])]
        if len(touching) and len(late) and not backbone:
            among = late
        elif (backbone or not len(touching)) and medium[among].any():
            among = among[medium[among]]
        elif backbone:
            backbone = False
        chosen = state.nearest(among) if len(touching) else state.first(among)
        state.lay(chosen)
        met = pattern.passages[chosen]
        fixed = dict.fromkeys(each.crossing for each in met if state.placed[each.partner])
        state.hands(list(fixed))
        steps.append(Step(chosen, backbone, tuple(fixed)))
    return tuple(steps)


class _State:
    """What is there, and what each ribbon that is not would be fastened at."""

    def __init__(self, crossed: Indices, places: Vectors | None, sums: NDArray[np.float64]) -> None:
        self.crossed, self.places, self.sums = crossed, places, sums
        self.total = crossed.sum(axis=1)
        self.placed = np.zeros(len(crossed), dtype=bool)
        self.held = np.zeros(len(crossed), dtype=np.int64)
        self.there = np.zeros((len(crossed), 3))
        self.last: Scalars | None = None

    @classmethod
    def of(cls, pattern: Pattern, places: Vectors | None) -> _State:
        """Nothing is there yet; crossings of a ribbon with itself hold it to nothing."""
        count = len(pattern.strips)
        crossed = np.zeros((count, count), dtype=np.int64)
        sums = np.zeros((count, count, 3)) if places is not None else np.zeros((0, 0, 3))
        for one, other in ((0, 1), (1, 0)):
            pair = pattern.ribbons[:, one], pattern.ribbons[:, other]
            np.add.at(crossed, pair, 1)
            if places is not None:
                np.add.at(sums, pair, places)
        np.fill_diagonal(crossed, 0)
        sums[np.arange(len(sums)), np.arange(len(sums))] = 0.0
        return cls(crossed, places, sums)

    def lay(self, strip: int) -> None:
        """A ribbon is there."""
        self.placed[strip] = True
        self.held += self.crossed[strip]
        if self.places is not None:
            self.there += self.sums[strip]

    def hands(self, crossings: list[int]) -> None:
        """The hands are at the crossings that were fastened."""
        if self.places is not None and crossings:
            self.last = self.places[crossings].mean(axis=0)

    def first(self, among: Indices) -> int:
        """The one that crosses most others."""
        return int(min(among, key=lambda r: (-self.total[r], r)))

    def nearest(self, among: Indices) -> int:
        """The one that is worked nearest to the hands, of those that hold."""
        held = among[self.held[among] >= np.minimum(HELD, self.total[among])]
        among = held if len(held) else among
        if self.places is None or self.last is None:
            share = self.held / np.maximum(self.total, 1)
            return int(min(among, key=lambda r: (-self.held[r], -share[r], r)))
        work = self.there[among] / np.maximum(self.held[among], 1)[:, None]
        return int(among[np.argmin(np.linalg.norm(work - self.last, axis=1))])


def _medium(
    lengths: np.ndarray[tuple[int], np.dtype[np.float64]],
) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which ribbons are neither among the shortest nor among the longest."""
    order: Indices = np.argsort(lengths, kind="stable")
    low, high = (round(share * len(lengths)) for share in MEDIUM)
    found = np.zeros(len(lengths), dtype=bool)
    found[order[low : max(high, low + 1)]] = True
    return found
