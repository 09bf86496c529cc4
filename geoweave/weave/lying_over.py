"""How high ribbons lie where they cross, and how wide they are drawn there, so that none cuts another."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from geoweave.arrays import Flags, Indices, Scalars, Vectors
from geoweave.surface import connected_components
from geoweave.weave.passages import Passages

__all__ = ["CLEAR", "Frames", "Passings", "passings", "share_beside"]

CLEAR = 1.2
"""Distance of the middles of two ribbons over the whole of their crossing, in thicknesses."""

RAMP = 0.1
"""Least length over which a ribbon goes from over to under, in widths."""

STACKED = 0.5
"""Where a ribbon would have to be narrower than this share of its width to find room for a ramp, it keeps its
height instead, and three ribbons lie in three layers, if their order allows it."""

NARROWEST = 0.5
"""Least share of its width that a ribbon is drawn with."""

HIGHEST = 4.0
"""Ribbons that cross over a fold of the surface are parted by at most so many times the least distance.

They may still cut each other then; else they would stand off the surface.
"""

SHALLOWEST = np.sin(np.deg2rad(15.0))
"""Crossings at a smaller angle are taken to be at this one: what they share would have no end."""

SIDE = 0.3
"""Sections of two ribbons are side by side if so many widths at most lie between them along a ribbon."""

NEIGHBOURS = 5
"""So many of the next crossings along a ribbon may share its room with one."""


@dataclass(frozen=True, eq=False)
class Frames:
    """Centrelines with their frames at given lengths, all ribbons one after the other."""

    offsets: Indices
    """(n + 1,) of the ribbons; a closed ribbon ends with what it begins with"""
    closed: Flags
    """(n,)"""
    at: Scalars
    """(P,) length along the centreline"""
    centre: Vectors
    """(P, 3)"""
    ahead: Vectors
    """(P, 3) unit"""
    up: Vectors
    """(P, 3) unit"""

    @classmethod
    def joined(
        cls, closed: Sequence[bool], parts: Sequence[tuple[Scalars, Vectors, Vectors, Vectors]]
    ) -> Frames:
        """Put the sections of ribbons one after the other.

        Parameters
        ----------
        closed : for each ribbon
        parts : for each ribbon ``at``, ``centre``, ``ahead`` and ``up`` of its sections
        """
        nothing = (np.zeros(0), *(np.zeros((0, 3)) for _ in range(3)))
        at, centre, ahead, up = (np.concatenate(each) for each in zip(nothing, *parts, strict=True))
        offsets = np.concatenate([[0], np.cumsum([len(part[0]) for part in parts])]).astype(np.int64)
        return cls(offsets, np.array(closed, dtype=bool), at, centre, ahead, up)

    @property
    def lengths(self) -> Scalars:
        """(n,) of the centrelines."""
        return self.at[self.offsets[1:] - 1]

    @property
    def ribbon(self) -> Indices:
        """(P,) the ribbon of each section."""
        return np.repeat(np.arange(len(self.closed)), np.diff(self.offsets))

    def there(self, ribbons: Indices, at: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        """Centre, direction, left and normal of ribbons at lengths along them, each (..., 3)."""
        length = self.lengths[ribbons]
        s = np.where(self.closed[ribbons], at % length, np.clip(at, 0.0, length))
        # One axis for all ribbons: each has its own stretch of it.
        start = np.concatenate([[0.0], np.cumsum(self.lengths + 1.0)])
        after = np.searchsorted(start[self.ribbon] + self.at, start[ribbons] + s, side="right")
        k = np.clip(after - 1, self.offsets[ribbons], self.offsets[ribbons + 1] - 2)
        share = ((s - self.at[k]) / np.maximum(self.at[k + 1] - self.at[k], 1e-300))[..., None]
        centre, ahead, up = (
            (1.0 - share) * each[k] + share * each[k + 1] for each in (self.centre, self.ahead, self.up)
        )
        ahead /= np.maximum(np.linalg.norm(ahead, axis=-1, keepdims=True), 1e-12)
        up -= (up * ahead).sum(axis=-1, keepdims=True) * ahead
        up /= np.maximum(np.linalg.norm(up, axis=-1, keepdims=True), 1e-12)
        return centre, ahead, np.cross(up, ahead), up


@dataclass(frozen=True, eq=False)
class Passings:
    """What a ribbon does at each of its crossings; 2 x and 2 x + 1 are the two ribbons of crossing x.

    Attributes
    ----------
    ribbons : (2 C,) the ribbon
    at : (2 C,) length along it
    reach : (2 C,) the ribbon keeps its height so far to either side
    share : (2 C,) of the full width that the ribbon is drawn with there
    height : (2 C,) above the centreline
    above : (2 C,) whether it is the upper one
    group : (2 C,) number of the layer; passings of one layer have one height
    lift : (C,) by how much the two ribbons of each crossing are parted
    deepest : height below which no ribbon goes; where that is not low enough, the upper one is raised
    """

    ribbons: Indices
    at: Scalars
    reach: Scalars
    share: Scalars
    height: Scalars
    above: Flags
    group: Indices
    lift: Scalars
    deepest: float

    def parted(self, frames: Frames, half: float, clear: float) -> Passings:
        """The same with the ribbons of every crossing farther apart by what is missing.

        Parameters
        ----------
        frames : of the ribbons with the heights of this
        half : half the full width
        clear : least distance of the middles of two ribbons all over their crossing
        """
        more = _missing(frames, self.ribbons, self.at, self.above, self.reach, half * self.share, clear)
        lift = np.minimum(self.lift + more, np.maximum(self.lift, HIGHEST * clear))
        return replace(self, lift=lift, height=_heights(self.group, self.above, lift, self.deepest))


def passings(frames: Frames, passages: Passages, over: Indices, width: float, thickness: float) -> Passings:
    """Find heights and widths at crossings with which no two ribbons cut each other.

    Two ribbons of width w that cross at an angle a share ``w / 2 (1 / sin a + |cot a|)`` of each of them to
    either side. Over this length the height stays. Where the next crossing leaves no room to go from over to
    under, both ribbons and the two that they cross are drawn narrower there, which makes room. Three ribbons
    that meet nearly in a point are stacked in three layers instead, if one can lie over both others.

    Parameters
    ----------
    frames : of the ribbons
    passages : which ribbons cross, and where
    over : (C,) which of the two lies above, 0 or 1
    width, thickness : of a ribbon
    """
    ribbons, at = passages.ribbons.ravel(), passages.arclengths.ravel()
    above = (np.stack([over == 0, over == 1], axis=1)).ravel()
    straight, slant = _angles(frames.there(ribbons, at)[1].reshape(-1, 2, 3))
    unit = 0.5 * width * np.repeat(np.stack([slant, 1.0 / straight], axis=1), 2, axis=0)
    reach = unit.sum(axis=1)
    pairs, apart = _neighbours(passages, frames.lengths, reach, width)
    needed = (apart - RAMP * width) / (reach[pairs[:, 0]] + reach[pairs[:, 1]])
    group, share = _layers(pairs, needed, above)
    partner = np.arange(len(at)) ^ 1
    reach = unit[:, 0] * share + unit[:, 1] * share[partner]
    lift = _missing(frames, ribbons, at, above, reach, 0.5 * width * share, CLEAR * thickness)
    deepest = -0.5 * CLEAR * thickness
    height = _heights(group, above, lift, deepest)
    return Passings(ribbons, at, reach, share, height, above, group, lift, deepest)


def share_beside(frames: Frames, met: Passings, width: float, thickness: float) -> Scalars:
    """(P,) share of the width at each section with which ribbons that run side by side do not overlap.

    Only sections count that no crossing of the two ribbons is near, and that do not lie clear of each other
    one over the other. At a distance d, with an angle a between them, each is at most
    ``d / (1 + |cos a|)`` wide to the side of the other.

    Parameters
    ----------
    frames : of the ribbons with their heights
    met : what they do at their crossings
    width, thickness : full width and thickness of a ribbon
    """
    owner, share = frames.ribbon, np.ones(len(frames.at))
    tree = cKDTree(frames.centre)
    one, two = tree.query_pairs(width, output_type="ndarray").T
    one, two = np.concatenate([one, two]), np.concatenate([two, one])
    length = frames.lengths[owner[one]]
    round_trip = np.abs(frames.at[one] - frames.at[two])
    round_trip = np.where(frames.closed[owner[one]], np.minimum(round_trip, length - round_trip), round_trip)
    apart = frames.centre[two] - frames.centre[one]
    normal, ahead = frames.up[one], frames.ahead[one]
    close = (owner[one] != owner[two]) | (round_trip > 2.0 * width)
    close &= np.abs((apart * ahead).sum(axis=1)) < 0.5 * SIDE * width
    close &= np.abs((apart * normal).sum(axis=1)) < thickness
    close &= (normal * frames.up[two]).sum(axis=1) > 0.5
    one, two, apart = one[close], two[close], apart[close]
    free = ~_at_a_crossing(frames, met, one, two, SIDE * width)
    one, two, apart = one[free], two[free], apart[free]
    side = np.cross(frames.up[one], frames.ahead[one])
    lean = np.abs((frames.ahead[one] * frames.ahead[two]).sum(axis=1))
    room = np.abs((apart * side).sum(axis=1)) / (0.5 * width * (1.0 + lean))
    room = np.maximum(0.97 * room, NARROWEST)
    np.minimum.at(share, one, room)
    np.minimum.at(share, two, room)
    return share


def _at_a_crossing(frames: Frames, met: Passings, one: Indices, two: Indices, more: float) -> Flags:
    """Whether a pair of sections lies within a crossing of their two ribbons."""
    count = len(frames.closed)
    key = frames.ribbon[one] * count + frames.ribbon[two]
    own = met.ribbons * count + met.ribbons[np.arange(len(met.at)) ^ 1]
    order = np.argsort(own, kind="stable")
    low, high = (np.searchsorted(own[order], key, side=side) for side in ("left", "right"))
    found = np.zeros(len(key), dtype=bool)
    for step in range(int((high - low).max(initial=0))):
        k = np.flatnonzero(low + step < high)
        i = order[low[k] + step]
        inside = np.ones(len(k), dtype=bool)
        for section, passing in ((one[k], i), (two[k], i ^ 1)):
            apart = np.abs(frames.at[section] - met.at[passing])
            length = frames.lengths[met.ribbons[passing]]
            closed = frames.closed[met.ribbons[passing]]
            apart = np.where(closed, np.minimum(apart, length - apart), apart)
            inside &= apart <= met.reach[passing] + more
        found[k] |= inside
    return found


def _angles(ahead: NDArray[np.float64]) -> tuple[Scalars, Scalars]:
    """Sine and absolute cotangent of the angle of each crossing."""
    cosine = np.abs((ahead[:, 0] * ahead[:, 1]).sum(axis=1))
    sine = np.maximum(np.sqrt(np.maximum(1.0 - cosine**2, 0.0)), SHALLOWEST)
    return sine, np.minimum(cosine, np.sqrt(1.0 - sine**2)) / sine


def _neighbours(
    passages: Passages, lengths: Scalars, reach: Scalars, width: float
) -> tuple[Indices, Scalars]:
    """(P, 2) passages of one ribbon that come near each other, the second behind the first, and how near."""
    at, ribbon, place = passages.arclengths.ravel(), passages.ribbons.ravel(), np.argsort(passages.order)
    first = after = passages.order
    pairs, ways = [], []
    for _ in range(NEIGHBOURS):
        after = passages.following[after]
        kept = (after >= 0) & (after != first)
        first, after = first[kept], after[kept]
        apart = at[after] - at[first] + np.where(place[after] < place[first], lengths[ribbon[first]], 0.0)
        near = apart < reach[first] + reach[after] + RAMP * width
        pairs.append(np.stack([first, after], axis=1)[near])
        ways.append(apart[near])
    return np.concatenate(pairs), np.concatenate(ways)


def _layers(pairs: Indices, needed: Scalars, above: Flags) -> tuple[Indices, Scalars]:
    """Number of the layer of each passing, and the share of its width that it is drawn with."""
    count = len(above)
    group = np.arange(count)
    members = {i: [i] for i in range(count)}
    share = np.ones(count)
    turns = above[pairs[:, 0]] != above[pairs[:, 1]]
    # First those that go from over to under; those that stay over, or under, only keep their height.
    for k in np.lexsort([needed, ~turns]):
        if needed[k] >= 1.0:
            continue
        i, j = (int(each) for each in pairs[k])
        layered = not turns[k] or needed[k] < STACKED
        if layered and _can_be_one(group[i], group[j], members, group, above):
            if group[i] != group[j]:
                first, second = sorted((int(group[i]), int(group[j])))
                members[first] += members.pop(second)
                group[members[first]] = first
        elif turns[k]:
            for each in (i, j, i ^ 1, j ^ 1):
                share[each] = min(share[each], max(float(needed[k]), NARROWEST))
    return np.unique(group, return_inverse=True)[1], share


def _can_be_one(first: int, second: int, members: dict[int, list[int]], group: Indices, above: Flags) -> bool:
    """Whether two groups may lie at one height: no way leads down from one to the other."""
    if first == second:
        return True
    for start, end in ((first, second), (second, first)):
        seen, todo = {int(start)}, [int(start)]
        while todo:
            for i in members[todo.pop()]:
                if above[i]:
                    lower = int(group[i ^ 1])
                    if lower == end:
                        return False
                    if lower not in seen:
                        seen.add(lower)
                        todo.append(lower)
    return True


def _missing(
    frames: Frames, ribbons: Indices, at: Scalars, above: Flags, reach: Scalars, half: Scalars, clear: float
) -> Scalars:
    """(C,) by how much the two ribbons of each crossing have to part, measured all over what they share."""
    upper = np.flatnonzero(above)
    lower = upper ^ 1
    middle = [frames.there(ribbons[each], at[each]) for each in (upper, lower)]
    normal = middle[0][3] + middle[1][3]
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    apart = ((middle[0][0] - middle[1][0]) * normal).sum(axis=1)
    for u, v in itertools.product(np.linspace(-1.0, 1.0, 9), np.linspace(-1.0, 1.0, 5)):
        centre, _, left, _ = frames.there(ribbons[upper], at[upper] + u * reach[upper])
        point = centre + (v * half[upper])[:, None] * left
        below = at[lower] + ((point - middle[1][0]) * middle[1][1]).sum(axis=1)
        centre, _, left, _ = frames.there(ribbons[lower], below)
        across = ((point - centre) * left).sum(axis=1)
        gap = ((point - centre - across[:, None] * left) * normal).sum(axis=1)
        shared = np.abs(across) <= 1.05 * half[lower]
        apart = np.where(shared, np.minimum(apart, gap), apart)
    return np.maximum(clear - apart, 0.0)


def _heights(group: Indices, above: Flags, lift: Scalars, deepest: float) -> Scalars:
    """(2 C,) heights that part the ribbons of each crossing by so much, as even about 0 as layers allow."""
    upper = np.flatnonzero(above)
    top, bottom = group[upper], group[upper ^ 1]
    level = np.zeros(int(group.max(initial=-1)) + 1)
    while True:  # no way down leads back (`_can_be_one`), so this ends
        raised = level.copy()
        np.maximum.at(raised, top, level[bottom] + lift)
        if (raised == level).all():
            break
        level = raised
    # What lies over or under each other, directly or through others, is set about 0 together.
    part = connected_components(np.stack([top, bottom], axis=1), len(level))
    highest = np.zeros(len(level))
    np.maximum.at(highest, part, level)
    return np.asarray((level + np.maximum(-0.5 * highest[part], deepest))[group])
