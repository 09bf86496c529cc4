"""In which order to put the ribbons together (Section 5.4: a backbone first, everything else off it)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from geoweave.arrays import Indices
from geoweave.fabrication.pattern import Pattern

__all__ = ["BACKBONE", "MEDIUM", "Step", "assembly"]

MEDIUM = (0.25, 0.75)
"""Between these shares of all ribbons, sorted by length, a ribbon is of medium length."""

BACKBONE = 0.15
"""Share of the ribbons that the backbone has, three at least."""


class Step(NamedTuple):
    """One ribbon that is laid in."""

    strip: int
    backbone: bool
    crossings: tuple[int, ...]
    """Those with ribbons that are there already, or with itself, in the order in which they come on it."""


def assembly(pattern: Pattern) -> tuple[Step, ...]:
    """Order the ribbons: a backbone of medium length, then always the one that crosses most of what is there.

    The first is the ribbon of medium length that crosses most others. While the backbone is built, only
    ribbons of medium length are taken, as long as one of them crosses what is there. Afterwards all are. Ties
    are broken by the share of a ribbon's crossings that this fixes, then by its number. A component of the
    weave that touches no other begins like the first. Hoops close the openings, so they come last.
    """
    count = len(pattern.strips)
    crossed = np.zeros((count, count), dtype=np.int64)
    np.add.at(crossed, (pattern.ribbons[:, 0], pattern.ribbons[:, 1]), 1)
    np.add.at(crossed, (pattern.ribbons[:, 1], pattern.ribbons[:, 0]), 1)
    np.fill_diagonal(crossed, 0)
    total = crossed.sum(axis=1)
    hoop = np.array([strip.hoop for strip in pattern.strips], dtype=bool)
    medium = _medium(np.array([strip.length for strip in pattern.strips])) & ~hoop
    wanted = min(max(3, math.ceil(BACKBONE * count)), count)
    placed = np.zeros(count, dtype=bool)
    held = np.zeros(count, dtype=np.int64)
    steps: list[Step] = []
    for number in range(count):
        free = np.flatnonzero(~placed & ~hoop)
        if not len(free):
            free = np.flatnonzero(~placed)
        touching = free[held[free] > 0]
        backbone = number < wanted
        among = touching if len(touching) else free
        if (backbone or not len(touching)) and medium[among].any():
            among = among[medium[among]]
        elif backbone:
            backbone = False
        score = held if len(touching) else total
        share = held / np.maximum(total, 1)
        chosen = int(min(among, key=lambda r: (-score[r], -share[r], r)))
        placed[chosen] = True
        held += crossed[chosen]
        fixed = dict.fromkeys(each.crossing for each in pattern.passages[chosen] if placed[each.partner])
        steps.append(Step(chosen, backbone, tuple(fixed)))
    return tuple(steps)


def _medium(
    lengths: np.ndarray[tuple[int], np.dtype[np.float64]],
) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Which ribbons are neither among the shortest nor among the longest."""
    order: Indices = np.argsort(lengths, kind="stable")
    low, high = (round(share * len(lengths)) for share in MEDIUM)
    found = np.zeros(len(lengths), dtype=bool)
    found[order[low : max(high, low + 1)]] = True
    return found
