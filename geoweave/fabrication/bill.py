"""What an object takes to make: metres, fasteners, weight, hours, and how difficult it is."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from geoweave.fabrication.measured_strips import measured
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.pieces import Making, Piece
from geoweave.wording import counted

__all__ = ["Bill", "bill_of"]

MINUTES = {"crossing": 1.5, "strip": 2.0, "join": 1.0}
"""Work for each crossing, strip and join.

The paper's bunny of 1,823 crossings and 108 ribbons took about fifty hours (Section 5.4); these give 49.
"""

STEPS = ((100, "an afternoon's work"), (400, "easy"), (1000, "demanding"), (2000, "hard"))
"""Up to so many crossings an object is called so; beyond the last, very hard."""

CROWDED, TURNS, NARROW = 0.25, 0.9, 4.0
"""Reasons to call it harder: this share of neighbours too near for the width, fewer than this share of
neighbours between which a strip changes sides, strips narrower than this, mm."""


@dataclass(frozen=True)
class Bill:
    """What an object takes; lengths in metres, weight in grams."""

    strips: int
    pieces: int
    crossings: int
    metres: float
    """Of strip, with everything that is added."""
    grams: float
    """Of the strips that are woven; waste does not count."""
    joins: int
    """Where pieces of a strip, or the ends of a closed one, are glued."""
    fasten: int
    """Crossings at which something is fastened: with holes every one, else the outermost of open strips."""
    hours: float
    """By the model of `MINUTES`."""
    difficulty: str
    """In words."""
    reasons: tuple[str, ...]
    """Why it is so difficult."""

    def document(self) -> dict[str, Any]:
        """What ``report.json`` says."""
        return {
            **asdict(self),
            "reasons": list(self.reasons),
            "hours_model": "minutes: " + ", ".join(f"{value:g} a {name}" for name, value in MINUTES.items()),
        }


def bill_of(pattern: Pattern, pieces: tuple[Piece, ...], making: Making, density: float = 0.8) -> Bill:
    """Count what an object takes.

    Parameters
    ----------
    pattern : the strips
    pieces : that they are cut in
    making : how they are cut
    density : of the material, g/cm3

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=100.0)
    >>> pattern, making = gw.fabrication.pattern_of(weave), gw.fabrication.Making()
    >>> bill = gw.fabrication.bill_of(pattern, gw.fabrication.pieces_of(pattern, making), making)
    >>> bill.strips == len(weave.ribbons), bill.difficulty
    (True, "an afternoon's work")
    """
    length = sum(piece.length for piece in pieces)
    joins = sum(join.ahead for piece in pieces for join in piece.joins)
    crossings, strips = len(pattern.at), len(pattern.strips)
    outer = {
        passages[k].crossing
        for strip, passages in zip(pattern.strips, pattern.passages, strict=True)
        if passages and not strip.closed
        for k in (0, -1)
    }
    work = {"crossing": crossings, "strip": strips, "join": joins}
    word, reasons = _difficulty(pattern)
    return Bill(
        strips,
        len(pieces),
        crossings,
        length / 1000,
        length * pattern.width * pattern.thickness * density / 1000,
        joins,
        crossings if making.holes else len(outer),
        sum(MINUTES[name] * count for name, count in work.items()) / 60,
        word,
        tuple(reasons),
    )


def _difficulty(pattern: Pattern) -> tuple[str, list[str]]:
    """How difficult an object is, in words, and why."""
    crossings, cut = len(pattern.at), measured(pattern)
    words = [word for _, word in STEPS] + ["very hard"]
    level = next((k for k, (most, _) in enumerate(STEPS) if crossings <= most), len(STEPS))
    reasons = [f"{counted(crossings, 'crossing')} on {counted(len(pattern.strips), 'strip')}"]
    neighbours = len(cut.as_cut.neighbours.widths)
    crowded = float((cut.as_cut.neighbours.widths < pattern.width).sum()) / max(neighbours, 1)
    harder = []
    if crowded > CROWDED:
        harder.append(f"{crowded:.0%} of neighbouring crossings are nearer than the strips are wide")
    if crossings and not pattern.floating and cut.alternation < TURNS:
        harder.append(f"a strip changes sides at only {cut.alternation:.0%} of its crossings")
    if pattern.width < NARROW:
        harder.append(f"strips only {pattern.width:.3g} mm wide")
    return words[min(level + bool(harder), len(STEPS))], reasons + harder
