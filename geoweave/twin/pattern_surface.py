"""The surface that the strips of a pattern close into, known from the pattern alone (Section 5.4).

At each crossing the signed angle says in which cyclic order the two strips leave it, seen from outside. Such
orders at the vertices of a graph make it the net of a closed surface: going along a stretch of strip and
always turning off to the left leads round a face. The number of faces gives the Euler characteristic, and
with it the genus, before anything has a place in space.

Conventions
-----------
Dart ``4 x + 2 s + b`` leaves crossing x along its strip s, towards the end of the strip (b = 0) or towards
its start (b = 1). A stretch between two neighbouring crossings has two darts; what is left of a strip beyond
its last crossing is a tail, and bounds no face.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Flags, Indices, Scalars, frozen
from geoweave.errors import FieldError
from geoweave.fabrication import Pattern

__all__ = ["Chords", "PatternSurface", "Slip", "surface_of"]

LAID_FLAT = 12
"""Faces of up to so many corners are laid flat to find how far apart their corners are."""

OPENING = 10
"""From so many corners on, a face into which half as many strips end is called an opening."""

CLOSE = 1.0
"""Crossings nearer than this many widths lie on each other; their order does not show on the object."""

HEAPED = 0.25
"""Crossings nearer than this many widths are one heap, in which strips turn as they like."""

SHALLOW = 15.0
"""Below this angle, degrees, the ribbons of a crossing lie along each other, and its sign does not show."""


class Chords(NamedTuple):
    """Distances within faces, between corners that no stretch of strip joins."""

    ends: Indices
    """(K, 2) crossings."""
    lengths: Scalars
    """(K,) mm, on the face laid flat."""


class Slip(NamedTuple):
    """A place where the pattern contradicts itself."""

    kind: str
    """What is wrong: "angle", its sign; "order", of two neighbours on a strip; "place", of a crossing."""
    crossings: tuple[int, ...]
    """The crossing, or the two."""
    strip: int
    """The strip on which the order is wrong, or the first strip of the crossing."""
    apart: float
    """How far apart the two crossings are on the strip, mm; the angle, degrees, at most 90; or 0."""
    plain: bool
    """Whether it would show on the object, so that ribbons could not be put together so."""


@dataclass(frozen=True, eq=False)
class PatternSurface:
    """The closed surface in which a pattern's strips are a net, each face a disk.

    Attributes
    ----------
    pattern : the pattern
    partner : (4 C,) dart at the other end of the same stretch, -1 where the strip ends
    stretch : (4 C,) length of the stretch, mm; 0 for a tail
    """

    pattern: Pattern
    partner: Indices
    stretch: Scalars

    @cached_property
    def directions(self) -> Scalars:
        """(4 C,) direction of each dart in the plane of its crossing, radians from that of dart ``4 x``."""
        turn = np.radians(self.pattern.angle)
        none = np.zeros_like(turn)
        return frozen(np.column_stack([none, none + np.pi, turn, turn + np.pi]).ravel())

    @cached_property
    def clockwise(self) -> Indices:
        """(4 C,) next dart of the same crossing with a stretch, turning to the right."""
        ring = _rings(self.pattern.angle)
        return frozen(_next_present(ring, self.partner))

    @cached_property
    def faces(self) -> tuple[Indices, ...]:
        """Darts round each face, which lies to their left."""
        after = self.clockwise[self.partner].tolist()
        seen = (self.partner < 0).tolist()
        found = []
        for first in range(len(seen)):
            if seen[first]:
                continue
            walk, dart = [], first
            while not seen[dart]:
                seen[dart] = True
                walk.append(dart)
                dart = after[dart]
            found.append(frozen(np.array(walk, dtype=np.int64)))
        return tuple(found)

    @cached_property
    def edges(self) -> Indices:
        """(E, 2) darts of each stretch, the one along the strip first."""
        forward = np.flatnonzero((self.partner >= 0) & (np.arange(len(self.partner)) % 2 == 0))
        return frozen(np.column_stack([forward, self.partner[forward]]))

    @cached_property
    def tails(self) -> tuple[int, ...]:
        """Number of strips that end in each face."""
        own = np.bincount(np.flatnonzero(self.partner < 0) // 4, minlength=len(self.pattern.ribbons))
        ring = _rings(self.pattern.angle)
        rank = np.empty(ring.size, dtype=np.int64)
        rank[ring.ravel()] = np.arange(ring.size) % 4
        counts = []
        for walk in self.faces:
            arriving = self.partner[walk]
            leaving = self.clockwise[arriving]
            between = (rank[arriving] - rank[leaving] - 1) % 4
            counts.append(int(between[own[arriving // 4] > 0].sum()))
        return tuple(counts)

    @cached_property
    def meshes(self) -> tuple[Indices, ...]:
        """Faces without the openings: rims, so large that they are no meshes, into which many strips end."""
        return tuple(
            walk
            for walk, ends in zip(self.faces, self.tails, strict=True)
            if len(walk) < OPENING or 2 * ends < len(walk)
        )

    @property
    def openings(self) -> int:
        """Number of faces that are rims."""
        return len(self.faces) - len(self.meshes)

    @cached_property
    def pieces(self) -> tuple[tuple[int, ...], ...]:
        """Strips of each part of the pattern that no crossing joins to another, the largest first."""
        count, pair = len(self.pattern.strips), self.pattern.ribbons
        links = sparse.csr_array((np.ones(len(pair)), (pair[:, 0], pair[:, 1])), shape=(count, count))
        parts, label = csgraph.connected_components(links, directed=False)
        found = [tuple(np.flatnonzero(label == part).tolist()) for part in range(parts)]
        return tuple(sorted(found, key=lambda strips: (-len(strips), strips)))

    @property
    def euler_characteristic(self) -> int:
        """Crossings less stretches plus faces: ``2 - 2 genus`` for each piece of the closed surface."""
        return len(self.pattern.ribbons) - len(self.edges) + len(self.faces)

    @property
    def genus(self) -> int:
        """Handles of the closed surface, over all pieces."""
        return len(self.pieces) - self.euler_characteristic // 2

    @cached_property
    def tangled(self) -> tuple[Indices, ...]:
        """Faces that come to a crossing twice.

        A sound pattern has none, unless a single crossing is all that joins two parts. A wrong sign, or a
        crossing at a wrong place between others, joins the faces about it into long ones that do.
        """
        return tuple(walk for walk in self.faces if len(np.unique(walk // 4)) < len(walk))

    @cached_property
    def slips(self) -> tuple[Slip, ...]:
        """What to correct so that no face is tangled; nothing for a sound pattern.

        Changes that do it at once come alone: the sign of a crossing, the order of two neighbours on a strip,
        or else the place of a crossing of two strips, where leaving out either of these does it. If more than
        one place is wrong, every change of a sign or of an order that takes a handle away is listed.
        """
        if not self.tangled:
            return ()
        single = [*self._wrong_angles(), *self._wrong_orders()]
        healing = [slip for slip in single if not surface_of(self._corrected(slip)).tangled]
        found = healing or self._wrong_places() or single
        return tuple(sorted(found, key=lambda slip: (not slip.plain, slip.kind, slip.crossings)))

    def said(self, slip: Slip) -> str:
        """Say what is wrong at a place, with the names that are written on the strips."""
        pattern, names = self.pattern, [strip.label for strip in self.pattern.strips]
        first = slip.crossings[0]
        one, other = (names[r] for r in pattern.ribbons[first])
        if slip.kind == "angle":
            return (
                f"crossing {first} of {one} and {other} turns {pattern.angle[first]:.0f} degrees, "
                "and everything about it fits the other sign"
            )
        if slip.kind == "place":
            along, across = pattern.at[first]
            return (
                f"crossing {first} is {along:.1f} mm along {one} and {across:.1f} mm along {other}, and "
                "everything else fits together without it"
            )
        second = slip.crossings[1]
        mine = names[slip.strip]
        partners = [
            next((names[r] for r in pattern.ribbons[x] if r != slip.strip), mine) for x in (first, second)
        ]
        return (
            f"{mine} meets {partners[0]} (crossing {first}) before {partners[1]} (crossing {second}, "
            f"{slip.apart:.1f} mm on), and everything about it fits the other order"
        )

    def chords(self) -> Chords:
        """Distances across faces, which are laid flat with their lengths and angles.

        Angles are spread evenly so that they close, then places; a face that is too curved for that, an
        opening, or one that meets itself is left out.
        """
        ends, lengths = [], []
        for walk in self.faces:
            corners, n = walk // 4, len(walk)
            if not 4 <= n <= LAID_FLAT or len(np.unique(corners)) < n:
                continue
            arriving, leaving = self.partner[walk], np.roll(walk, -1)
            turn = self.directions[leaving] - self.directions[arriving] - np.pi
            turn = np.remainder(turn + np.pi, 2 * np.pi) - np.pi
            curvature = 2 * np.pi - turn.sum()
            if abs(curvature) > np.pi:
                continue
            heading = np.concatenate([[0.0], np.cumsum(turn[:-1] + curvature / n)])
            place = np.concatenate([[0.0], np.cumsum(self.stretch[walk] * np.exp(1j * heading))])
            place = (place - np.linspace(0.0, 1.0, n + 1) * place[-1])[:-1]
            i, j = np.triu_indices(n, 2)
            across = ~((i == 0) & (j == n - 1))
            i, j = i[across], j[across]
            ends.append(np.column_stack([corners[i], corners[j]]))
            lengths.append(np.abs(place[i] - place[j]))
        if not ends:
            return Chords(np.zeros((0, 2), dtype=np.int64), np.zeros(0))
        return Chords(np.concatenate(ends), np.concatenate(lengths))

    # -- slips ------------------------------------------------------------------------------------------

    def _wrong_angles(self) -> list[Slip]:
        pattern, found = self.pattern, []
        turned = _next_present(_rings(-pattern.angle), self.partner)
        for x in range(len(pattern.ribbons)):
            own = [dart for dart in range(4 * x, 4 * x + 4) if self.partner[dart] >= 0]
            if len(own) < 3:  # two darts have one cyclic order
                continue
            clockwise = {dart: int(turned[dart]) for dart in own}
            if self._faces_through(own, {}, clockwise) - self._faces_through(own, {}, {}) >= 2:
                angle = abs(float(pattern.angle[x]))
                angle = min(angle, 180.0 - angle)
                clear = angle > SHALLOW and self.stretch[own].min() > HEAPED * pattern.width
                found.append(Slip("angle", (x,), int(pattern.ribbons[x, 0]), angle, bool(clear)))
        return found

    def _wrong_orders(self) -> list[Slip]:
        pattern, found = self.pattern, []
        for here, there in self.edges.tolist():
            first, second = here, there ^ 1  # forward darts of the two crossings on the strip
            if first // 2 == second // 2:
                continue
            before, after = int(self.partner[first ^ 1]), int(self.partner[second])
            if before in (second, second ^ 1) or after in (first, first ^ 1):
                continue
            # before -> first -> second -> after becomes before -> second -> first -> after
            changed = {second: first ^ 1, first ^ 1: second, second ^ 1: before, first: after}
            if before >= 0:
                changed[before] = second ^ 1
            if after >= 0:
                changed[after] = first
            darts = [d for x in {first // 4, second // 4} for d in range(4 * x, 4 * x + 4)]
            darts += [d for d in (before, after) if d >= 0]
            if self._faces_through(darts, changed, None) - self._faces_through(darts, {}, {}) >= 2:
                apart = float(self.stretch[here])
                x, side = divmod(first // 2, 2)
                found.append(
                    Slip(
                        "order",
                        (x, second // 4),
                        int(pattern.ribbons[x, side]),
                        apart,
                        apart > CLOSE * pattern.width,
                    )
                )
        return found

    def _wrong_places(self) -> list[Slip]:
        pattern, count = self.pattern, len(self.pattern.strips)
        meeting = {int(d) // 4 for walk in self.tangled for d in walk}
        among = np.unique(pattern.ribbons[sorted(meeting)])
        healing = np.zeros(count, dtype=bool)
        for r in among.tolist():
            kept = (pattern.ribbons != r).all(axis=1)
            if kept.any():
                healing[r] = not surface_of(_only(pattern, kept)).tangled
        both = healing[pattern.ribbons].all(axis=1)
        return [
            Slip("place", (x,), int(pattern.ribbons[x, 0]), 0.0, True) for x in np.flatnonzero(both).tolist()
        ]

    def _corrected(self, slip: Slip) -> Pattern:
        """The pattern with a sign or an order changed."""
        pattern = self.pattern
        if slip.kind == "angle":
            angle = pattern.angle.copy()
            angle[slip.crossings[0]] *= -1
            return replace(pattern, angle=angle)
        at = pattern.at.copy()
        (x, s), (y, t) = min(
            (((x, s), (y, t)) for s in (0, 1) for t in (0, 1) for x, y in [slip.crossings]
             if pattern.ribbons[x, s] == pattern.ribbons[y, t] == slip.strip),
            key=lambda pair: abs(abs(at[pair[0]] - at[pair[1]]) - slip.apart),
        )  # fmt: skip
        at[x, s], at[y, t] = pattern.at[y, t], pattern.at[x, s]
        return replace(pattern, at=at)

    def _faces_through(
        self, darts: list[int], partner: dict[int, int], clockwise: dict[int, int] | None
    ) -> int:
        """Number of faces on which darts lie, with other partners and other neighbours than there are.

        None for the neighbours finds them anew from the partners, at the crossings where these change.
        """
        if clockwise is None:
            clockwise = {}
            ring = _rings(self.pattern.angle)
            for x in {dart // 4 for dart in partner}:
                present = [d for d in ring[x].tolist() if partner.get(d, int(self.partner[d])) >= 0]
                clockwise |= {d: present[k - 1] for k, d in enumerate(present)}
        old_partner, old_clockwise = self._lists
        seen: set[int] = set()
        count = 0
        for first in darts:
            if first in seen or partner.get(first, old_partner[first]) < 0:
                continue
            count += 1
            dart = first
            while dart not in seen:
                seen.add(dart)
                arriving = partner.get(dart, old_partner[dart])
                dart = clockwise.get(arriving, old_clockwise[arriving])
        return count

    @cached_property
    def _lists(self) -> tuple[list[int], list[int]]:
        return self.partner.tolist(), self.clockwise.tolist()


def surface_of(pattern: Pattern) -> PatternSurface:
    """Join the crossings of a pattern by the stretches of its strips.

    Raises
    ------
    FieldError
        If there is no crossing.
    """
    count = len(pattern.ribbons)
    if not count:
        raise FieldError("no strip of the pattern crosses another; there is nothing to weave")
    partner = np.full(4 * count, -1, dtype=np.int64)
    stretch = np.zeros(4 * count)
    for strip, met in zip(pattern.strips, pattern.passages, strict=True):
        ahead = [*met[1:], met[0]] if strip.closed and met else met[1:]
        for number, (here, there) in enumerate(zip(met, ahead, strict=False)):
            out, into = 4 * here.crossing + 2 * here.side, 4 * there.crossing + 2 * there.side + 1
            partner[out], partner[into] = into, out
            round_trip = strip.length if number + 1 == len(met) else 0.0
            stretch[[out, into]] = there.at - here.at + round_trip
    return PatternSurface(pattern, frozen(partner), frozen(stretch))


def _only(pattern: Pattern, kept: Flags) -> Pattern:
    """The pattern with some of its crossings."""
    return replace(
        pattern,
        ribbons=pattern.ribbons[kept],
        at=pattern.at[kept],
        angle=pattern.angle[kept],
        over=pattern.over[kept],
        mark=pattern.mark[kept],
        round=pattern.round[kept],
    )


def _rings(angle: Scalars) -> Indices:
    """(C, 4) darts of each crossing, counter-clockwise seen from outside."""
    first = 4 * np.arange(len(angle))[:, None]
    return first + np.where((angle >= 0)[:, None], [0, 2, 1, 3], [0, 3, 1, 2])


def _next_present(ring: Indices, partner: Indices) -> Indices:
    """(4 C,) dart before each one in its ring, of those that have a partner; -1 for a dart without."""
    present = partner[ring] >= 0
    found = np.full(ring.size, -1, dtype=np.int64)
    for back in (4, 3, 2, 1):  # the nearest is entered last
        other = np.roll(ring, back, axis=1)
        good = present & np.roll(present, back, axis=1)
        found[ring[good]] = other[good]
    return found
