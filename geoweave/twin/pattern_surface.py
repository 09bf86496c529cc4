"""The surface that the strips of a pattern close into, known from the pattern alone (Section 5.4).

At each crossing the signed angle gives the cyclic order in which the two strips leave it, seen from outside.
A graph with a cyclic order at every vertex is embedded in one closed surface: whoever walks along a stretch
of strip and turns left at every crossing walks round a face. Counting faces gives the Euler characteristic
and the genus, without any place in space.

Conventions
-----------
Dart ``4 x + 2 s + b`` leaves crossing x along its strip s, towards the end of the strip (b = 0) or towards
its start (b = 1). A stretch between two neighbouring crossings has two darts. A tail is what is left of a
strip beyond its last crossing; it bounds no face.

A face is an opening if the end of a strip lies in it that the pattern says to lie at an opening. On a surface
whose boundary no ribbon closes off, all ends at one opening lie in one face, and no other opening's do.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from geoweave.arrays import Indices, Scalars, frozen
from geoweave.errors import FieldError
from geoweave.fabrication import Pattern

__all__ = ["Chords", "PatternSurface", "next_present", "openings_of", "rings", "surface_of"]

LAID_FLAT = 12
"""Faces of up to so many corners are laid flat to find how far apart their corners are."""


class Chords(NamedTuple):
    """Distances within faces, between corners that no stretch of strip joins."""

    ends: Indices
    """(K, 2) crossings."""
    lengths: Scalars
    """(K,) mm, on the face laid flat."""


@dataclass(frozen=True, eq=False)
class PatternSurface:
    """The closed surface in which a pattern's strips are embedded, each face a disk.

    Attributes
    ----------
    pattern : the pattern
    partner : (4 C,) dart at the other end of the same stretch, -1 where the strip ends
    stretch : (4 C,) length of the stretch, mm; 0 for a tail

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.torus(faces=800), ribbons=8).sized(200.0)
    >>> gw.twin.surface_of(gw.fabrication.pattern_of(weave)).genus
    1
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
        ring = rings(self.pattern.angle)
        return frozen(next_present(ring, self.partner))

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
    def left(self) -> Indices:
        """(4 C,) face to the left of each dart, and that in which a tail ends; -1 at a crossing of tails."""
        face = np.full(len(self.partner), -1, dtype=np.int64)
        for number, walk in enumerate(self.faces):
            face[walk] = number
        ring = rings(self.pattern.angle)
        found = face[ring]
        # The face of a tail is that to the left of the next stretch to its right.
        for _ in range(3):
            found = np.where(found >= 0, found, np.roll(found, 1, axis=1))
        face[ring] = found
        return frozen(face)

    @cached_property
    def tails(self) -> tuple[int, ...]:
        """Number of strips that end in each face."""
        face = self.left[self.partner < 0]
        return tuple(np.bincount(face[face >= 0], minlength=len(self.faces)).tolist())

    @cached_property
    def opening_faces(self) -> frozenset[int]:
        """Faces in which a strip ends that the pattern says to end at an opening."""
        found = set()
        for strip, met in zip(self.pattern.strips, self.pattern.passages, strict=True):
            if not met or strip.closed or strip.openings is None:
                continue
            tails = (4 * met[0].crossing + 2 * met[0].side + 1, 4 * met[-1].crossing + 2 * met[-1].side)
            for dart, opening in zip(tails, strip.openings, strict=True):
                if opening >= 0 and self.left[dart] >= 0:
                    found.add(int(self.left[dart]))
        return frozenset(found)

    @property
    def meshes(self) -> tuple[Indices, ...]:
        """Faces that are no openings."""
        return tuple(walk for number, walk in enumerate(self.faces) if number not in self.opening_faces)

    @property
    def openings(self) -> int | None:
        """Number of faces that are openings; None if the pattern does not say which strips end at one."""
        return None if openings_of(self.pattern) is None else len(self.opening_faces)

    @cached_property
    def pieces(self) -> tuple[tuple[int, ...], ...]:
        """Strips of each part of the pattern that no crossing joins to another, the largest first."""
        from scipy import sparse
        from scipy.sparse import csgraph

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
        """Faces that pass a crossing twice.

        A sound pattern has none, unless two parts are joined by a single crossing only. A wrong sign or a
        crossing at a wrong place joins the faces about it into a long one that passes it twice.
        """
        return tuple(walk for walk in self.faces if len(np.unique(walk // 4)) < len(walk))

    def chords(self) -> Chords:
        """Distances across faces, which are laid flat with their lengths and angles.

        A flat face closes only nearly. The error of its angles is spread evenly over its corners, then the
        error of its places. Faces that are too curved for this, openings, and tangled faces are left out.
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


def surface_of(pattern: Pattern) -> PatternSurface:
    """Join the crossings of a pattern by the stretches of its strips.

    Raises
    ------
    FieldError
        If there is no crossing.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.sphere(600), ribbons=8).sized(200.0)
    >>> surface = gw.twin.surface_of(gw.fabrication.pattern_of(weave))
    >>> surface.genus, surface.openings
    (0, 0)
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


def openings_of(pattern: Pattern) -> int | None:
    """How many openings with ends of strips an object has, by what its strips say; None if they do not say.

    The surface that the strips close into has as many (`PatternSurface.openings`) unless a crossing is
    wrong, or no strip passes between two openings.

    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=800), ribbons=10).sized(200.0)
    >>> gw.twin.openings_of(gw.fabrication.pattern_of(weave))
    1
    """
    said = [strip.openings for strip in pattern.strips if not strip.closed]
    if any(each is None for each in said):
        return None
    return len({opening for each in said if each is not None for opening in each if opening >= 0})


def rings(angle: Scalars) -> Indices:
    """(C, 4) darts of each crossing, counter-clockwise seen from outside."""
    first = 4 * np.arange(len(angle))[:, None]
    return first + np.where((angle >= 0)[:, None], [0, 2, 1, 3], [0, 3, 1, 2])


def next_present(ring: Indices, partner: Indices) -> Indices:
    """(4 C,) dart before each one in its ring, of those that have a partner; -1 for a dart without."""
    present = partner[ring] >= 0
    found = np.full(ring.size, -1, dtype=np.int64)
    for back in (4, 3, 2, 1):  # the nearest is entered last
        other = np.roll(ring, back, axis=1)
        good = present & np.roll(present, back, axis=1)
        found[ring[good]] = other[good]
    return found
