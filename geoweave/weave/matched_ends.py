"""Ends set where over and under can alternate (beyond the paper: DEVIATIONS.md, matched-ends).

Go round a cell between ribbons that alternate. One leaves a lower ribbon for an upper one at each corner, or
an upper one for a lower one at each corner. The two kinds meet where a ribbon ends at another one. So the
number of ends on the rim of a cell is even, or a ribbon does not alternate along it, and a relation is broken
between two odd cells. An end that is set on by one crossing, through a broken relation, makes both cells even
and the relation is met. So does an end that is drawn back by one crossing, beside a broken relation.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from geoweave.arrays import Flags, Scalars
from geoweave.curves import Crossings, crossings, stretches
from geoweave.surface import connected_components
from geoweave.weave.interlacing import Interlacing, optimal
from geoweave.weave.passages import Passages
from geoweave.weave.ribbon_ends import ROUNDING, extended, holding, on_boundary
from geoweave.weave.ribbons import Ribbons, without_touching
from geoweave.weave.weave_types import FLOATING, WeaveType

__all__ = ["with_matched_ends"]

REACH = 1.5
"""How far an end is set on or drawn back at most, in spacings."""

CLEAR = 0.3
"""A crossing that is added keeps this distance from those before and after it, in spacings."""

HELD = 2
"""A ribbon that loses a crossing keeps so many times the fewest that a ribbon may have.

In a weave of few ribbons each crossing holds it in shape, and more so than strict alternation does.
"""

ROUNDS = 3
"""How often ends are set anew, by the best sides of the ends before."""


def with_matched_ends(ribbons: Ribbons, effort: int, pattern: WeaveType) -> tuple[Ribbons, Interlacing]:
    """Find the best sides, set ends where a relation is then met, and find the best sides anew.

    An end that is set on crosses a ribbon at an angle that holds it, away from other crossings. One that is
    drawn back leaves many crossings on both ribbons, and no other end in the air. Ends stay as they are
    where that does not lower the number of broken relations, or where the weave would fall apart.

    Parameters
    ----------
    ribbons : centrelines and crossings
    effort, pattern : as for `optimal`; in a twill and a basket ends stay, as ribbons do not alternate there

    Returns
    -------
    the ribbons with the ends that were found best, and their sides
    """
    turns = optimal(ribbons.passages, effort, pattern)
    for _ in range(0 if pattern in FLOATING else ROUNDS):
        other = _set_anew(ribbons, turns) if turns.broken.any() else None
        if other is None:
            break
        found = optimal(other.passages, effort, pattern)
        if found.broken.sum() >= turns.broken.sum():
            break
        ribbons, turns = other, found
    return ribbons, turns


def _set_anew(ribbons: Ribbons, turns: Interlacing) -> Ribbons | None:
    """Make all moves that meet a relation and do not touch each other; nothing if there is none."""
    longer, spans = extended(ribbons.curves, REACH * ribbons.spacing)
    moves = _Moves(ribbons, turns)
    moves.set_on(crossings(longer), spans)
    moves.draw_back()
    if not moves.shifts:
        return None
    start, end = spans[:, 0].copy(), spans[:, 1].copy()
    for which, shift in moves.shifts.items():
        curve, at_end = divmod(which, 2)
        if at_end:
            end[curve] = min(end[curve] + shift, longer.lengths[curve])
        else:
            start[curve] = max(start[curve] - shift, 0.0)
    curves = stretches(longer, np.arange(len(longer)), start, end)
    met = without_touching(crossings(curves), curves, ribbons.cutting.tail * ribbons.spacing)
    found = replace(ribbons, curves=curves, crossings=met)
    return found if _sound(found, ribbons) else None


def _sound(found: Ribbons, before: Ribbons) -> bool:
    """Whether ribbons have enough crossings, held ends, and as many parts as before."""
    number = np.bincount(found.crossings.curves.ravel(), minlength=len(found))
    parts = [connected_components(each.crossings.curves, len(each)).max() for each in (found, before)]
    loose = [int(each.loose.sum()) for each in (found, before)]
    return bool(number.min() >= before.cutting.fewest and parts[0] <= parts[1] and loose[0] <= loose[1])


class _Met(NamedTuple):
    """A crossing that an end would be set on to."""

    end: int
    """Start of ribbon c is ``2 c``, its end ``2 c + 1``."""
    far: float
    """How far beyond the end it lies."""
    ribbon: int
    """That is crossed there."""
    at: float
    """Arc length on that ribbon."""
    firm: bool
    """Whether its angle holds an end."""


class _Moves:
    """Moves of ends that each meet a relation more, none of which touches another's crossings.

    Parameters
    ----------
    ribbons : centrelines and crossings
    turns : best sides
    """

    def __init__(self, ribbons: Ribbons, turns: Interlacing) -> None:
        self.ribbons, self.broken = ribbons, turns.broken
        self.passages: Passages = ribbons.passages
        following = self.passages.following
        here = self.passages.order[following[self.passages.order] >= 0]
        self.after, self.before = np.full((2, len(following)), -1, dtype=np.int64)
        self.after[here] = self.before[following[here]] = np.arange(len(here))
        self.preceding = np.full(len(following), -1, dtype=np.int64)
        self.preceding[following[here]] = here
        self.lies_over = np.repeat(turns.over, 2) == np.tile([0, 1], len(turns.over))
        self.firm = holding(ribbons.crossings, ribbons.cutting.shallowest)
        self.number = np.bincount(self.passages.ribbons.ravel(), minlength=len(ribbons))
        self.shifts: dict[int, float] = {}
        """How far each end goes on; less than 0 where it is drawn back."""
        self._used: set[int] = set()
        self._needed: set[int] = set()
        self._gone: set[int] = set()
        open_ends = ~on_boundary(ribbons.curves) & ~ribbons.curves.closed[:, None]
        owner = self.passages.ribbons.ravel()
        self.last = np.full(2 * len(ribbons), -1, dtype=np.int64)
        """Outermost passage at each end that is held inside, -1 for other ends."""
        for side, none in enumerate((self.preceding, following)):
            tips = np.flatnonzero((none < 0) & open_ends[owner, side])
            self.last[2 * owner[tips] + side] = tips

    def set_on(self, met: Crossings, spans: Scalars) -> None:
        """Set ends on through broken relations; `met` are crossings of the longer curves."""
        clear, tail = (share * self.ribbons.spacing for share in (CLEAR, self.ribbons.cutting.tail))
        for one, after in _first_met(met, spans, self.ribbons):
            last = int(self.last[one.end])
            found = self._around(one.ribbon, one.at)
            if last < 0 or found is None or not one.firm or one.end in self.shifts:
                continue
            passage, gaps = found
            relation = int(self.after[passage])
            way = one.far + self._beyond(one.end, last)
            wrong = not self.broken[relation] or self.lies_over[last] == self.lies_over[passage]
            if wrong or relation in self._used or min(*gaps, way) < clear or last // 2 in self._gone:
                continue
            self._used.add(relation)
            self._needed |= {last // 2, passage // 2, int(self.passages.following[passage]) // 2}
            self.shifts[one.end] = one.far + min(tail, 0.5 * (after - one.far))

    def draw_back(self) -> None:
        """Draw ends back from ribbons beside broken relations."""
        tail, farthest = (share * self.ribbons.spacing for share in (self.ribbons.cutting.tail, REACH))
        owner, at = self.passages.ribbons.ravel(), self.passages.arclengths.ravel()
        fewest = HELD * self.ribbons.cutting.fewest
        for end in np.flatnonzero(self.last >= 0).tolist():
            last = int(self.last[end])
            other, inner = last ^ 1, int((self.preceding if end % 2 else self.passages.following)[last])
            sides = [int(self.before[other]), int(self.after[other])]
            if end in self.shifts or inner < 0 or min(sides) < 0 or owner[last] == owner[other]:
                continue
            along = int((self.before if end % 2 else self.after)[last])
            way = abs(float(at[last] - at[inner]))
            # Without the crossing the two relations of the other ribbon become one.
            now = self.broken[[*sides, along]].sum() - (self.broken[sides].sum() != 1)
            keeps = self.firm[inner // 2] and min(self.number[owner[[last, other]]]) > fewest
            touched = {*sides, along} & self._used or last // 2 in self._needed or inner // 2 in self._gone
            if now < 1 or not keeps or touched or way > farthest:
                continue
            self._used |= {*sides, along}
            self._gone.add(last // 2)
            self._needed.add(inner // 2)
            self.number[owner[[last, other]]] -= 1
            self.shifts[end] = min(tail, 0.5 * way) - way - self._beyond(end, last)

    def _beyond(self, end: int, last: int) -> float:
        """Length of a ribbon beyond its last crossing."""
        at = float(self.passages.arclengths.ravel()[last])
        return float(self.ribbons.curves.lengths[end // 2]) - at if end % 2 else at

    def _around(self, ribbon: int, at: float) -> tuple[int, tuple[float, float]] | None:
        """The passage before a place on a ribbon, and the ways to it and to the next; nothing at its ends."""
        owner = self.passages.ribbons.ravel()[self.passages.order]
        own = self.passages.order[slice(*np.searchsorted(owner, [ribbon, ribbon + 1]))]
        places = self.passages.arclengths.ravel()[own]
        k = int(np.searchsorted(places, at)) - 1
        if self.ribbons.curves.closed[ribbon]:
            length = float(self.ribbons.curves.lengths[ribbon])
        elif 0 <= k < len(own) - 1:
            length = np.inf
        else:
            return None
        following = (k + 1) % len(own)
        gaps = [at - float(places[k]), float(places[following]) - at]
        return int(own[k]), (gaps[0] % length, gaps[1] % length)


def _first_met(met: Crossings, spans: Scalars, ribbons: Ribbons) -> list[tuple[_Met, float]]:
    """For each end that meets a given part of a ribbon, the first such crossing and the way to the second."""
    low, high = spans[met.curves, 0], spans[met.curves, 1]
    beyond = np.maximum(low - met.arclength, met.arclength - high)
    outside: Flags = beyond > ROUNDING * ribbons.curves.mesh.mean_edge
    firm = holding(met, ribbons.cutting.shallowest)
    reached: dict[int, list[_Met]] = {}
    for x in np.flatnonzero(outside.sum(axis=1) == 1).tolist():
        out = int(outside[x, 1])
        ribbon, other = met.curves[x, out], met.curves[x, 1 - out]
        end = int(2 * ribbon + (met.arclength[x, out] > high[x, out]))
        at = float(met.arclength[x, 1 - out] - low[x, 1 - out])
        one = _Met(end, float(beyond[x, out]), int(other), at, bool(firm[x]))
        reached.setdefault(end, []).append(one)
    found = []
    for end in sorted(reached):
        ways = sorted(reached[end], key=lambda each: each.far)
        found.append((ways[0], ways[1].far if len(ways) > 1 else np.inf))
    return found
