"""Where a pattern contradicts itself: wrong signs of angles, wrong orders on a strip, wrong places.

A crossing at a wrong place among its neighbours joins the faces about it into long ones that come to a
crossing twice. So a place is wrong where putting it right takes such faces apart again.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from geoweave.arrays import Flags
from geoweave.errors import FieldError
from geoweave.fabrication import Pattern
from geoweave.twin.pattern_surface import PatternSurface, next_present, rings, surface_of
from geoweave.wording import counted

__all__ = ["Contradiction", "check_sound", "contradiction_sentence", "contradictions_of"]

CLOSE = 1.0
"""Crossings nearer than this many widths lie on each other; their order does not show on the object."""

HEAPED = 0.25
"""Crossings nearer than this many widths are one heap, in which strips turn as they like."""

SHALLOW = 15.0
"""Below this angle, degrees, the ribbons of a crossing lie along each other, and its sign does not show."""


class Contradiction(NamedTuple):
    """A place where a pattern contradicts itself."""

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


def contradictions_of(surface: PatternSurface) -> tuple[Contradiction, ...]:
    """What to correct so that no face is tangled; nothing for a sound pattern.

    A change that does it at once comes alone: the sign of a crossing, or the order of two neighbours on a
    strip. Otherwise it is the place of a crossing of two strips where leaving out either of them does it. If
    more than one place is wrong, every change of a sign or of an order that takes a handle away is listed.

    A net of genus 0 lies in a sphere just as its crossings say. Where a face of it comes to a crossing twice,
    something hangs on that crossing alone (`hanging_parts`), and nothing contradicts.

    >>> weave = gw.weave_pattern(gw.shapes.sphere(600), ribbons=8).sized(200.0)
    >>> gw.twin.contradictions_of(gw.twin.surface_of(gw.fabrication.pattern_of(weave)))
    ()
    """
    if not surface.tangled or surface.genus == 0:
        return ()
    search = _Search(surface)
    single = [*search.wrong_angles(), *search.wrong_orders()]
    healing = [each for each in single if not surface_of(_corrected(surface.pattern, each)).tangled]
    found = healing or _wrong_places(surface) or single
    return tuple(sorted(found, key=lambda each: (not each.plain, each.kind, each.crossings)))


def check_sound(surface: PatternSurface, *, anyway: bool = False) -> None:
    """Refuse strips that nobody can put together, whatever their lengths are.

    Parameters
    ----------
    surface : of the pattern
    anyway : refuse pieces only, and no contradictions

    Raises
    ------
    FieldError
        If the pattern is in pieces, or a crossing contradicts those about it.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.sphere(600), ribbons=8).sized(200.0)
    >>> gw.twin.check_sound(gw.twin.surface_of(gw.fabrication.pattern_of(weave)))
    """
    pattern = surface.pattern
    if len(surface.pieces) > 1:
        first, second = surface.pieces[:2]
        raise FieldError(
            f"the pattern is in {len(surface.pieces)} pieces that no crossing holds together "
            f"(one with {pattern.strips[first[0]].label}, one with {pattern.strips[second[0]].label}); "
            "put each of them together by itself"
        )
    plain = [] if anyway else [each for each in contradictions_of(surface) if each.plain]
    if plain:
        more = f", and {counted(len(plain) - 1, 'more such place')}" if len(plain) > 1 else ""
        raise FieldError(
            f"the pattern contradicts itself: {contradiction_sentence(pattern, plain[0])}{more}; "
            "correct the place, or export the weave as it was designed (--no-relax), before its ribbons slid "
            "past each other; --anyway puts it together all the same"
        )


def contradiction_sentence(pattern: Pattern, found: Contradiction) -> str:
    """Say what is wrong at a place, with the names that are written on the strips."""
    names = [strip.label for strip in pattern.strips]
    first = found.crossings[0]
    one, other = (names[r] for r in pattern.ribbons[first])
    if found.kind == "angle":
        return (
            f"crossing {first} of {one} and {other} turns {pattern.angle[first]:.0f} degrees, "
            "and everything about it fits the other sign"
        )
    if found.kind == "place":
        along, across = pattern.at[first]
        return (
            f"crossing {first} is {along:.1f} mm along {one} and {across:.1f} mm along {other}, and "
            "everything else fits together without it"
        )
    second = found.crossings[1]
    mine = names[found.strip]
    partners = [
        next((names[r] for r in pattern.ribbons[x] if r != found.strip), mine) for x in (first, second)
    ]
    return (
        f"{mine} meets {partners[0]} (crossing {first}) before {partners[1]} (crossing {second}, "
        f"{found.apart:.1f} mm on), and everything about it fits the other order"
    )


class _Search:
    """Changes of one sign or one order that would take a handle away from a pattern's surface."""

    def __init__(self, surface: PatternSurface) -> None:
        self.surface = surface
        self.partner, self.clockwise = surface.partner.tolist(), surface.clockwise.tolist()

    def wrong_angles(self) -> list[Contradiction]:
        pattern, found = self.surface.pattern, []
        turned = next_present(rings(-pattern.angle), self.surface.partner)
        for x in range(len(pattern.ribbons)):
            own = [dart for dart in range(4 * x, 4 * x + 4) if self.surface.partner[dart] >= 0]
            if len(own) < 3:  # two darts have one cyclic order
                continue
            clockwise = {dart: int(turned[dart]) for dart in own}
            if self._faces_through(own, {}, clockwise) - self._faces_through(own, {}, {}) >= 2:
                angle = abs(float(pattern.angle[x]))
                angle = min(angle, 180.0 - angle)
                clear = angle > SHALLOW and self.surface.stretch[own].min() > HEAPED * pattern.width
                found.append(Contradiction("angle", (x,), int(pattern.ribbons[x, 0]), angle, bool(clear)))
        return found

    def wrong_orders(self) -> list[Contradiction]:
        pattern, found = self.surface.pattern, []
        for here, there in self.surface.edges.tolist():
            first, second = here, there ^ 1  # forward darts of the two crossings on the strip
            if first // 2 == second // 2:
                continue
            before, after = int(self.surface.partner[first ^ 1]), int(self.surface.partner[second])
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
                apart = float(self.surface.stretch[here])
                x, side = divmod(first // 2, 2)
                found.append(
                    Contradiction(
                        "order",
                        (x, second // 4),
                        int(pattern.ribbons[x, side]),
                        apart,
                        apart > CLOSE * pattern.width,
                    )
                )
        return found

    def _faces_through(
        self, darts: list[int], partner: dict[int, int], clockwise: dict[int, int] | None
    ) -> int:
        """Number of faces on which darts lie, with other partners and other neighbours than there are.

        None for the neighbours finds them anew from the partners, at the crossings where these change.
        """
        if clockwise is None:
            clockwise = {}
            ring = rings(self.surface.pattern.angle)
            for x in {dart // 4 for dart in partner}:
                present = [d for d in ring[x].tolist() if partner.get(d, self.partner[d]) >= 0]
                clockwise |= {d: present[k - 1] for k, d in enumerate(present)}
        seen: set[int] = set()
        count = 0
        for first in darts:
            if first in seen or partner.get(first, self.partner[first]) < 0:
                continue
            count += 1
            dart = first
            while dart not in seen:
                seen.add(dart)
                arriving = partner.get(dart, self.partner[dart])
                dart = clockwise.get(arriving, self.clockwise[arriving])
        return count


def _wrong_places(surface: PatternSurface) -> list[Contradiction]:
    pattern, count = surface.pattern, len(surface.pattern.strips)
    meeting = {int(d) // 4 for walk in surface.tangled for d in walk}
    among = np.unique(pattern.ribbons[sorted(meeting)])
    healing = np.zeros(count, dtype=bool)
    for r in among.tolist():
        kept = (pattern.ribbons != r).all(axis=1)
        if kept.any():
            healing[r] = not surface_of(_only(pattern, kept)).tangled
    both = healing[pattern.ribbons].all(axis=1)
    return [
        Contradiction("place", (x,), int(pattern.ribbons[x, 0]), 0.0, True)
        for x in np.flatnonzero(both).tolist()
    ]


def _corrected(pattern: Pattern, found: Contradiction) -> Pattern:
    """The pattern with a sign or an order changed."""
    if found.kind == "angle":
        angle = pattern.angle.copy()
        angle[found.crossings[0]] *= -1
        return replace(pattern, angle=angle)
    at = pattern.at.copy()
    (x, s), (y, t) = min(
        (((x, s), (y, t)) for s in (0, 1) for t in (0, 1) for x, y in [found.crossings]
         if pattern.ribbons[x, s] == pattern.ribbons[y, t] == found.strip),
        key=lambda pair: abs(abs(at[pair[0]] - at[pair[1]]) - found.apart),
    )  # fmt: skip
    at[x, s], at[y, t] = pattern.at[y, t], pattern.at[x, s]
    return replace(pattern, at=at)


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
