"""The order in which ribbons meet each other, which no step of physics may change.

The topology of a weave is the order of the contacts along every ribbon, which ribbon lies above at each, and
to which side the other one leaves. While a weave relaxes, a contact holds one place of each ribbon, so the
order cannot change. While ribbons slide, contacts move along them (E.1), and nothing in the paper keeps one
from passing the next.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from geoweave.arrays import Indices, Scalars, cross, frozen
from geoweave.errors import RodError
from geoweave.rods.rods import Contacts, Rods

__all__ = ["Changes", "Gaps", "crossing_sines", "gaps_of", "order_changes", "positions"]

SHALLOW = 15.0
"""Below this angle, degrees, ribbons lie along each other, and the sign of their angle does not show."""


def positions(rods: Rods, contacts: Contacts | None = None) -> Scalars:
    """(C, 2) arclength of contacts along their rods at rest, from the start of each rod.

    >>> rods = gw.elastic_rods(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)).rods
    >>> bool((gw.rods.positions(rods) >= 0).all())
    True
    """
    layout, met = rods.layout, rods.contacts if contacts is None else contacts
    before = np.cumsum(rods.rest) - rods.rest
    before = before - before[layout.segment_offsets[:-1]][layout.rod_of_segment]
    return np.asarray(before[met.segments] + met.places * rods.rest[met.segments])


@dataclass(frozen=True, eq=False)
class Gaps:
    """Contacts that follow each other along rods, and how far apart they are.

    Attributes
    ----------
    before, after : (P,) passages; passage ``2 c + k`` is contact c as seen by its rod k
    lengths : (P,) arclength from the one to the other, at rest
    where : (C, 2) arclength of the contacts they were made with
    whole : (C, 2) length of the rod of each passage if it is closed, infinite if not
    """

    before: Indices
    after: Indices
    lengths: Scalars
    where: Scalars
    whole: Scalars

    def moved(self, where: Scalars) -> Scalars:
        """(P,) lengths after contacts moved to other arclengths (C, 2); negative where one passed the next.

        On a closed rod a contact moved the shorter way round.
        """
        shift = where - self.where
        round_trip = np.where(np.isfinite(self.whole), self.whole, 1.0)
        turns = np.where(np.isfinite(self.whole), np.round(shift / round_trip), 0.0)
        shift = (shift - turns * round_trip).ravel()
        return np.asarray(self.lengths + shift[self.after] - shift[self.before])


def gaps_of(rods: Rods) -> Gaps:
    """Find the neighbours of each contact along its two rods."""
    layout = rods.layout
    where = positions(rods)
    rod = layout.rod_of_segment[rods.contacts.segments].ravel()
    total = np.add.reduceat(rods.rest, layout.segment_offsets[:-1])
    order = np.lexsort((where.ravel(), rod))
    ranked, place = rod[order], where.ravel()[order]
    first = np.searchsorted(ranked, ranked, side="left")
    past = np.searchsorted(ranked, ranked, side="right")
    here = np.arange(len(order))
    last = here + 1 == past
    ahead = np.where(last, first, np.minimum(here + 1, len(order) - 1))
    lengths = place[ahead] - place + np.where(last, total[ranked], 0.0)
    kept = ~last | layout.closed[ranked]
    whole = np.where(layout.closed, total, np.inf)[rod].reshape(-1, 2)
    return Gaps(order[kept], order[ahead][kept], lengths[kept], where, whole)


def crossing_sines(rods: Rods) -> Scalars:
    """(C,) sine of the signed angle from the first rod of each contact to the second, seen from outside."""
    one, two = rods.contacts.segments.T
    agree = np.where((rods.directors[one] * rods.directors[two]).sum(axis=1) < 0, -1.0, 1.0)
    up = rods.directors[one] + agree[:, None] * rods.directors[two]
    up /= np.linalg.norm(up, axis=1)[:, None]
    return np.asarray((cross(rods.tangents[one], rods.tangents[two]) * up).sum(axis=1))


class Changes(NamedTuple):
    """What makes rods another weave than their design; all are empty if it is the same."""

    passed: Indices
    """(P, 2) contacts that follow each other along a rod of the design, and no longer do."""
    turned: Indices
    """Contacts whose angle has another sign, where it was more than `SHALLOW`."""
    swapped: Indices
    """Contacts at which the other rod lies above now."""

    def __bool__(self) -> bool:
        return any(len(each) > 0 for each in self)


def order_changes(design: Rods, rods: Rods) -> Changes:
    """Compare the topology of rods with that of their design: order, over and under, signs of angles.

    Parameters
    ----------
    design : with the contacts of the weave
    rods : the same rods with the same contacts, after sliding or relaxing

    Raises
    ------
    RodError
        If the two have other contacts.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)
    >>> rest = gw.relaxed_weave(weave)
    >>> bool(gw.rods.order_changes(rest.designed, rest.left.rods))
    False
    """
    own, other = design.contacts, rods.contacts
    owner = design.layout.rod_of_segment
    if len(own) != len(other) or not np.array_equal(owner[own.segments], owner[other.segments]):
        raise RodError("the rods have other contacts than their design; compare rods made of one another")
    order = gaps_of(design)
    # Arclengths are compared at the lengths of the design: relaxing gives rods new rest lengths.
    passed = order.moved(positions(design, other)) <= 0
    before, after = crossing_sines(design), crossing_sines(rods)
    steep = np.abs(before) > np.sin(np.radians(SHALLOW))
    return Changes(
        frozen(np.column_stack([order.before[passed], order.after[passed]]) // 2),
        frozen(np.flatnonzero(steep & (before * after <= 0))),
        frozen(np.flatnonzero(own.over != other.over)),
    )
