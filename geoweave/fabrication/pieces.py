"""Strips as they are cut: with additions to their length, and in pieces where a sheet is too short."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geoweave.errors import FieldError
from geoweave.fabrication.pattern import Passage, Pattern
from geoweave.fabrication.presets import LABELS, Labels
from geoweave.weave import FlatCurve

__all__ = ["Join", "Making", "Piece", "cut_length", "holes_of", "lowest", "pieces_of", "rim", "shown"]

NEAR = 2.5
"""Places of a curved strip so many widths apart along it must not touch on the sheet. At a curvature x
width of 1 they are nearly two widths from each other."""


@dataclass(frozen=True)
class Making:
    """How strips are cut, in mm.

    Attributes
    ----------
    overlap : length by which two pieces of one strip lie on each other, and of the tab of a closed ribbon
    extra : added beyond each end of an open ribbon
    kerf : width of the cut; outlines are drawn half of it outside, so that the strip comes out as it should
    holes : diameter of a hole at every crossing, for rivets, eyelets or brads; 0 for none. Drawn smaller by
        the kerf, so that the hole comes out as it should
    score : whether both edges have a nick at every crossing
    labels : names "engraved" as lines, "printed" as letters of a font, or "none"
    mirror : whether strips are drawn as seen from the inside of the object, to be printed there
    hoops : what strips keep beyond the middle of the hoop of an opening; 0 for no hoops

    Raises
    ------
    FieldError
        If a number is out of range.
    """

    overlap: float = 15.0
    extra: float = 0.0
    kerf: float = 0.0
    holes: float = 0.0
    score: bool = False
    labels: Labels = "engraved"
    mirror: bool = False
    hoops: float = 0.0

    def __post_init__(self) -> None:
        if self.labels not in LABELS:
            raise FieldError(f"names on strips are {', '.join(LABELS)}; not '{self.labels}'")
        for name in ("overlap", "extra", "kerf", "holes", "hoops"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value >= 0):
                raise FieldError(f"the {name} of strips must be 0 mm or more, not {value}")
        if self.overlap < 1:
            raise FieldError(
                f"strips that overlap by {self.overlap} mm cannot be joined; 1 mm or more is needed"
            )


class Join(NamedTuple):
    """Where two pieces of a strip, or the two ends of a closed one, lie on each other."""

    low: float
    """Where the overlap begins, mm along the strip."""
    high: float
    """Where it ends."""
    name: str
    """The same on both sides."""
    ahead: bool
    """Whether it is at the end of the piece, not at its start."""


class Piece(NamedTuple):
    """A strip, or a part of one, that is cut in one go."""

    strip: int
    number: int
    """From 1."""
    total: int
    """Of pieces of this strip."""
    start: float
    """Where it begins, mm along the strip; negative with something added."""
    end: float
    """Where it ends."""
    joins: tuple[Join, ...]
    """At most one at each end."""

    @property
    def length(self) -> float:
        """In mm, without the kerf."""
        return self.end - self.start


def _spans(low: float, high: float, count: int, room: float, overlap: float) -> list[tuple[float, float]]:
    """Where the pieces of a strip begin and end."""
    if count == 1:
        return [(low, high)]
    step = room - overlap
    starts = [low + k * step for k in range(count)]
    # A join needs an overlap at both ends and something between them.
    starts[-1] = max(min(starts[-1], high - 3 * overlap), starts[-2] + overlap)
    ends = [start + overlap for start in starts[1:]] + [high]
    return list(zip(starts, ends, strict=True))


def cut_length(pattern: Pattern, making: Making, strip: int) -> float:
    """Length of a strip with what is added at its ends, mm."""
    low, high = _ends(pattern, making, strip)
    return high - low


def pieces_of(
    pattern: Pattern,
    making: Making,
    longest: float = math.inf,
    highest: float = math.inf,
    *,
    whole: bool = False,
) -> tuple[Piece, ...]:
    """Cut every strip into as few pieces as a sheet allows: all as long as it is, but for the last.

    The last is no shorter than three overlaps; what it needs for that comes from the one before. A strip that
    is cut curved comes in equal pieces, so many that each fits and does not lie over itself.

    Parameters
    ----------
    pattern : the strips
    making : what is added to them
    longest : a piece with its kerf, mm
    highest : the room across a sheet for a piece with its kerf, mm
    whole : do not cut strips because they are curved, as for the guide, which shows them straight

    Raises
    ------
    FieldError
        If pieces so short cannot overlap, or the tab of a closed ribbon is longer than half the ribbon.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=300.0)
    >>> pattern, making = gw.fabrication.pattern_of(weave), gw.fabrication.Making(overlap=15.0)
    >>> pieces = gw.fabrication.pieces_of(pattern, making, longest=200.0)
    >>> len(pieces) > len(pattern.strips) and max(piece.length for piece in pieces) <= 200.0
    True
    """
    room, overlap = longest - making.kerf, making.overlap
    if room < 3 * overlap:
        raise FieldError(
            f"a sheet that holds {longest:.6g} mm of a strip is too short for pieces that overlap by "
            f"{overlap:g} mm; take a longer sheet or a smaller overlap"
        )
    found = []
    for r, strip in enumerate(pattern.strips):
        low, high = _ends(pattern, making, r)
        if strip.closed and overlap > 0.5 * strip.length:
            raise FieldError(
                f"strip {strip.label} is {strip.length:.6g} mm round, too short for a tab of {overlap:g} mm"
            )
        count = max(math.ceil((high - low - overlap) / (room - overlap) - 1e-9), 1)
        if high - low <= room:
            count = 1
        most = room
        if strip.curve is not None and not whole:
            count = _flat_pieces(strip.curve, (low, high), count, pattern.width, making, (room, highest))
            most = (high - low + (count - 1) * overlap) / count
        for k, (start, end) in enumerate(_spans(low, high, count, most, overlap)):
            joins = []
            if k or strip.closed:
                name = f"{strip.label}={k or count}"
                joins.append(Join(start, start + overlap, name, False))
            if k < count - 1 or strip.closed:
                joins.append(Join(end - overlap, end, f"{strip.label}={k + 1}", True))
            found.append(Piece(r, k + 1, count, start, end, tuple(joins)))
    return tuple(found)


def shown(pattern: Pattern, piece: Piece, border: float) -> tuple[Passage, ...]:
    """Crossings that are marked on a piece, those on the tab of a closed ribbon once more.

    In an overlap a crossing is marked on both pieces, unless it is nearer than a border to where one of them
    is cut; so an overlap must be wider than two borders.
    """
    strip = pattern.strips[piece.strip]
    behind = piece.start + (border if any(not each.ahead for each in piece.joins) else -math.inf)
    ahead = piece.end - (border if any(each.ahead for each in piece.joins) else -math.inf)
    found = []
    for turn in (0.0, strip.length) if strip.closed else (0.0,):
        for each in pattern.passages[piece.strip]:
            at = each.at + turn
            # The start of a closed ribbon needs no border, because its tab lies under it.
            first = piece.number == 1 and strip.closed and turn == 0.0
            if (first or at >= behind) and piece.start <= at + 1e-9 and at <= ahead:
                found.append(each._replace(at=at))
    return tuple(found)


def holes_of(pattern: Pattern, piece: Piece, making: Making) -> tuple[float, ...]:
    """Where a piece has holes, mm along the strip: wherever a part of the hole of a crossing lies on it.

    In an overlap both pieces have the hole, so that it goes through both.
    """
    if not making.holes:
        return ()
    strip, reach = pattern.strips[piece.strip], 0.5 * making.holes
    turns = (-strip.length, 0.0, strip.length) if strip.closed else (0.0,)
    found = (each.at + turn for each in pattern.passages[piece.strip] for turn in turns)
    return tuple(sorted(at for at in found if piece.start - reach < at < piece.end + reach))


def _ends(pattern: Pattern, making: Making, strip: int) -> tuple[float, float]:
    """Where a strip with what is added begins and ends, mm along it."""
    length = pattern.strips[strip].length
    if pattern.strips[strip].closed:
        return 0.0, length + making.overlap
    return -making.extra, length + making.extra


def rim(curve: FlatCurve, piece: Piece, width: float) -> NDArray[np.float64]:
    """(N, 2) points of both edges of a piece of a curved strip, laid flat."""
    count = max(math.ceil(piece.length * max(curve.sharpest / 0.1, 1.0 / width)), 1)
    places = np.linspace(piece.start, piece.end, count + 1)
    angle = curve.heading(places)
    left = 0.5 * width * np.column_stack([-np.sin(angle), np.cos(angle)])
    middle = curve.points(places)
    return np.concatenate([middle + left, middle - left])


def lowest(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2, 2) matrix that turns points, as ``points @ matrix``, so that they are as low as can be.

    The lowest box has a side along one of the convex hull, which is tried for each of them.
    """
    from scipy.spatial import ConvexHull

    hull = points[ConvexHull(points).vertices]
    along = np.roll(hull, -1, axis=0) - hull
    along /= np.linalg.norm(along, axis=1)[:, None]
    across = np.column_stack([-along[:, 1], along[:, 0]])
    height = np.ptp(hull @ across.T, axis=0)
    best = int(np.argmin(np.round(height, 9)))
    # Of the two ways round, the one in which the strip reads from left to right.
    sign = 1.0 if (points[len(points) // 2 - 1] - points[0]) @ along[best] >= 0 else -1.0
    return np.asarray(sign * np.column_stack([along[best], across[best]]))


def _flat_pieces(
    curve: FlatCurve,
    ends: tuple[float, float],
    count: int,
    width: float,
    making: Making,
    room: tuple[float, float],
) -> int:
    """In how many pieces a curved strip fits on a sheet without lying over itself, at least ``count``."""
    low, high = ends
    overlap = making.overlap
    while True:
        size = (high - low + (count - 1) * overlap) / count
        starts = [low + k * (size - overlap) for k in range(count)]
        pieces = [Piece(0, 1, 1, start, start + size, ()) for start in starts]
        if all(_lies_flat(curve, piece, width, making.kerf, room) for piece in pieces):
            return count
        if size < 3 * overlap:
            raise FieldError(
                f"a strip is so curved that pieces of {size:.4g} mm do not fit on a sheet that leaves "
                f"{room[0]:.6g} x {room[1]:.6g} mm; take a larger sheet or a smaller overlap"
            )
        count += 1


def _lies_flat(curve: FlatCurve, piece: Piece, width: float, kerf: float, room: tuple[float, float]) -> bool:
    """Whether a piece fits on a sheet and does not lie over itself."""
    edges = rim(curve, piece, width)
    extent = np.ptp(edges @ lowest(edges), axis=0) + kerf
    if extent[0] > room[0] + kerf + 1e-9 or extent[1] > room[1] + 1e-9:
        return False
    turned = curve.heading(np.linspace(piece.start, piece.end, 1 + len(edges) // 2))
    if np.ptp(turned) < np.pi:
        return True
    middle = 0.5 * (edges[: len(edges) // 2] + edges[len(edges) // 2 :])
    apart = np.linalg.norm(middle[:, None] - middle[None], axis=2)
    along = piece.length / (len(middle) - 1) * np.abs(np.subtract.outer(*2 * [np.arange(len(middle))]))
    return bool((apart[along > NEAR * width] > 1.05 * width + kerf).all())
