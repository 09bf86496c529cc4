"""Open ends grow along geodesics until they run into a ribbon or into each other (Section 5.2)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geoweave.arrays import Flags, Indices, Scalars
from geoweave.curves import Crossings, Curves, crossings, stretches
from geoweave.weave.ribbon_ends import ROUNDING, extended, holding, on_boundary

__all__ = ["Growth", "lengthened"]


class Growth(NamedTuple):
    """Extended curves, and the crossings that their ends may stop at.

    All ends grow at one speed. One that runs into the given part of a curve, or into an extension that is
    there before it, stops; a crossing at too small an angle stops it too, but does not hold it. The other
    extension goes back to where the two meet, unless something holds to what lies beyond. So each end that
    stops is held, ends that meet in a gap close it, and no end goes farther than it has to. An end that
    meets nothing goes back to its last crossing (DEVIATIONS.md, ribbon-ends).
    """

    longer: Curves
    """The extended curves."""
    spans: Scalars
    """(n, 2) arc lengths at which each given curve starts and ends on its longer one."""
    met: Crossings
    """Crossings of the extended curves."""
    firm: Flags
    """(C,) whether the angle of a crossing holds an end."""
    beyond: Scalars
    """(C, 2) how far the crossing lies beyond the given part of its two curves, 0 inside."""
    ends: Indices
    """(C, 2) end of each curve that it lies beyond, the start of curve c is ``2 c``."""

    @classmethod
    def of(cls, longer: Curves, spans: Scalars, met: Crossings, shallowest: float) -> Growth:
        """Prepare extended curves; ``shallowest`` is the least angle of a crossing that holds, degrees."""
        low, high = spans[met.curves, 0], spans[met.curves, 1]
        beyond = np.maximum(low - met.arclength, met.arclength - high)
        # What lies within rounding of the last point of the given part lies in it.
        beyond = np.where(beyond > ROUNDING * longer.mesh.mean_edge, beyond, 0.0)
        ends = 2 * met.curves + (met.arclength > high)
        return cls(longer, spans, met, holding(met, shallowest), beyond, ends)

    def grown(self, kept: Flags, tail: float) -> tuple[Scalars, Scalars]:
        """Arc lengths at which each curve starts and ends if only some curves are kept.

        An end is set a tail beyond the crossing that it stops at, or half way to the next one. One that stops
        at a crossing too shallow to hold it, or that meets nothing, is set beyond its last firm crossing;
        without any the curve has no length left. An end on the boundary stays there.
        """
        given = np.asarray(kept[self.met.curves].all(axis=1))
        reached = self._reached(given)
        there = given & (self.beyond <= reached[self.ends]).all(axis=1) & self.firm
        owner, at = self.met.curves[there].ravel(), self.met.arclength[there].ravel()
        first, last = np.full(len(kept), np.inf), np.full(len(kept), -np.inf)
        np.minimum.at(first, owner, at)
        np.maximum.at(last, owner, at)
        lengths, closed = self.longer.lengths, self.longer.closed
        free = on_boundary(self.longer) & np.isinf(reached.reshape(-1, 2))
        start, end = first - tail, last + tail
        # A tail stops half way to what it would cross besides.
        besides = given & (self.beyond <= reached[self.ends] + tail).all(axis=1) & ~there
        owner, at = self.met.curves[besides].ravel(), self.met.arclength[besides].ravel()
        early, late = at < first[owner], at > last[owner]
        np.maximum.at(start, owner[early], 0.5 * (at + first[owner])[early])
        np.minimum.at(end, owner[late], 0.5 * (at + last[owner])[late])
        start = np.where(free[:, 0] | closed, 0.0, np.clip(start, 0.0, lengths))
        end = np.where(free[:, 1] | closed, lengths, np.clip(end, 0.0, lengths))
        return start, np.maximum(end, start)

    def _reached(self, given: Flags) -> Scalars:
        """(2n,) how far each end grows, inf if nothing stops it."""
        reached = np.full(2 * len(self.longer), np.inf)
        hung = np.zeros(len(reached))
        time = self.beyond.max(axis=1)
        order = np.flatnonzero(given & (time > 0))
        order = order[np.argsort(time[order], kind="stable")]
        ends, beyond, firm = self.ends.tolist(), self.beyond.tolist(), self.firm.tolist()
        for x in order.tolist():
            late = int(beyond[x][1] > beyond[x][0])
            comes, stays = ends[x][late], ends[x][1 - late]
            far, near = beyond[x][late], beyond[x][1 - late]
            if far > reached[comes] or near > reached[stays]:
                continue
            reached[comes] = far
            if firm[x]:
                hung[comes] = max(hung[comes], far)
                if near > 0 and hung[stays] <= near and comes != stays:
                    reached[stays] = near
                hung[stays] = max(hung[stays], near)
        return reached


def lengthened(curves: Curves, one: Flags, reach: float, tail: float, shallowest: float) -> Curves | None:
    """Join two parts of a weave by the end that has the shortest way to a crossing with the other part.

    Parameters
    ----------
    one : (n,) which curves are of the one part; the others are of the other one
    reach, tail : how far an end may go, and how far beyond the crossing, lengths
    shallowest : least angle of that crossing and of those on the way to it, degrees

    Returns
    -------
    the curves, one of them longer; or nothing if no end gets there
    """
    longer, spans = extended(curves, reach)
    growth = Growth.of(longer, spans, crossings(longer), shallowest)
    met, far = growth.met, growth.beyond.max(axis=1)
    coming = growth.beyond.argmax(axis=1)
    end = growth.ends[np.arange(len(met)), coming]
    usable = (far > 0) & (growth.beyond.min(axis=1) == 0)
    blocked = np.full(2 * len(longer), np.inf)
    np.minimum.at(blocked, end[usable & ~growth.firm], far[usable & ~growth.firm])
    joins = usable & growth.firm & (one[met.curves[:, 0]] != one[met.curves[:, 1]]) & (far < blocked[end])
    if not joins.any():
        return None
    best = int(np.flatnonzero(joins)[far[joins].argmin()])
    c, at_end = divmod(int(end[best]), 2)
    length = min(float(far[best]) + tail, 0.5 * (float(far[best]) + float(blocked[end[best]])))
    start, stop = spans[:, 0].copy(), spans[:, 1].copy()
    if at_end:
        stop[c] = min(stop[c] + length, longer.lengths[c])
    else:
        start[c] = max(start[c] - length, 0.0)
    return stretches(longer, np.arange(len(longer)), start, stop)
