"""The weave that the strips make, measured on the strips as they are cut (Section 5.4).

A weave that comes to rest is another one than its design: ribbons are longer or shorter, crossings are at
other places. What a maker is told of has to be true of the strips on the table.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geoweave.arrays import Scalars
from geoweave.fabrication.pattern import Pattern
from geoweave.weave import AsCut, Passages

__all__ = ["MeasuredStrips", "beside", "measured"]

NEAR_PARALLEL = 20.0
"""Strips that cross at less, degrees, lie along each other; the limit of the report of the design."""

ROUNDING = 1e-3
"""Two numbers of a design and its strips are the same if they differ by no more than this share."""

WORST = 20
"""Places of each kind that are listed."""


@dataclass(frozen=True, eq=False)
class MeasuredStrips:
    """A pattern and what is measured on its strips; lengths in mm, angles in degrees.

    See Also
    --------
    measured : makes one of a pattern.
    geoweave.weave.inspected : the same questions to the design, on its surface.
    """

    pattern: Pattern

    @cached_property
    def as_cut(self) -> AsCut:
        """The strips without their names and marks, with all that can be measured on them."""
        pattern = self.pattern
        closed = np.array([strip.closed for strip in pattern.strips], dtype=bool)
        lengths = np.array([strip.length for strip in pattern.strips])
        passages = Passages(pattern.ribbons, pattern.at, closed)
        return AsCut(passages, pattern.over, np.radians(pattern.angle), lengths, pattern.width)

    @property
    def alternation(self) -> float:
        """Share of the crossings next to each other on a strip between which the strip changes sides."""
        return self.as_cut.alternation

    @property
    def free_ends(self) -> Scalars:
        """Length of every end of an open strip beyond its outermost crossing, the longest first.

        A strip that nothing crosses is free all along.
        """
        beyond = self.as_cut.overhang[~self.as_cut.passages.closed].ravel()
        return np.sort(beyond)[::-1]

    def document(self) -> dict[str, Any]:
        """What ``report.json`` says of the strips; lengths in mm."""
        pattern, cut, beyond = self.pattern, self.as_cut, self.free_ends
        angles, apart = cut.crossing_angles, cut.neighbours.distance
        return {
            "ribbons": len(pattern.strips),
            "crossings": len(pattern.at),
            "total_length": float(sum(strip.length for strip in pattern.strips)),
            "alternation": self.alternation,
            "crossing_angle_deg": {
                "median": _quantile(angles, 0.5),
                "p05": _quantile(angles, 0.05),
                "smallest": _quantile(angles, 0.0),
            },
            "apart": {
                "median": _quantile(apart, 0.5),
                "p05": _quantile(apart, 0.05),
                "smallest": _quantile(apart, 0.0),
            },
            "width": pattern.width,
            "share_that_fits": cut.share_that_fits,
            "near_parallel": int((angles < NEAR_PARALLEL).sum()),
            "crowded": int((cut.neighbours.widths < pattern.width).sum()),
            "free_ends": {
                "count": len(beyond),
                "longest": float(beyond.max(initial=0.0)),
                "median": _quantile(beyond, 0.5),
                "trimmed": sum(cut > 0 for strip in pattern.strips for cut in strip.trimmed),
                "trimmed_length": float(sum(sum(strip.trimmed) for strip in pattern.strips)),
            },
            "places": self.places(),
        }

    def places(self, most: int = WORST) -> list[dict[str, Any]]:
        """Where the strips will not weave, the worst of each kind first, with the place on the strip.

        Kinds are ``near_parallel`` (value: the angle, degrees), ``crowded`` (value: the width that would fit
        between the two crossings, mm) and ``free_end`` of a strip that nothing crosses (value: its length).
        """
        pattern, near, angles = self.pattern, self.as_cut.neighbours, self.as_cut.crossing_angles
        found = []
        flat = np.flatnonzero(angles < NEAR_PARALLEL)
        for x in flat[np.argsort(angles[flat], kind="stable")][:most].tolist():
            pair = pattern.ribbons[x].tolist()
            found.append(self._place("near_parallel", pair, pattern.at[x, 0], angles[x]))
        tight = np.flatnonzero(near.widths < pattern.width)
        for k in tight[np.argsort(near.widths[tight], kind="stable")][:most].tolist():
            strip, x = int(near.ribbon[k]), int(near.first[k])
            at = pattern.at[x, pattern.ribbons[x].tolist().index(strip)]
            found.append(self._place("crowded", [strip, *near.others[k].tolist()], at, near.widths[k]))
        bare = [r for r, passages in enumerate(pattern.passages) if not passages]
        found += [self._place("free_end", [r], 0.0, pattern.strips[r].length) for r in bare[:most]]
        return found

    def _place(self, kind: str, strips: list[int], at: float, value: float) -> dict[str, Any]:
        labels = [self.pattern.strips[r].label for r in strips]
        return {"kind": kind, "strips": labels, "at": round(float(at), 4), "value": float(value)}


def measured(pattern: Pattern) -> MeasuredStrips:
    """Measure the weave that flat strips make.

    Parameters
    ----------
    pattern : the strips as they are cut

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=100.0)
    >>> found = gw.fabrication.measured(gw.fabrication.pattern_of(weave))
    >>> bool(abs(found.alternation - weave.interlacing.alternation) < 1e-12)  # cut as designed
    True
    >>> bool(np.allclose(found.as_cut.crossing_angles, weave.crossing_angles, atol=1e-3))  # degrees
    True
    """
    return MeasuredStrips(pattern)


def beside(designed: MeasuredStrips, cut: MeasuredStrips) -> dict[str, tuple[float, float]]:
    """The numbers in which a design and the strips that are cut of it differ, side by side.

    Parameters
    ----------
    designed : measured on the strips that the design itself would give
    cut : measured on the strips that are cut

    Returns
    -------
    dict
        By the name of each number that differs by more than a rounding, such as ``"alternation"`` or
        ``"crossing_angle_deg.median"``: what it is in the design, and on the strips.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=100.0)
    >>> designed, rest = gw.fabrication.pattern_of(weave), gw.fabrication.pattern_of(gw.relaxed_weave(weave))
    >>> differs = gw.fabrication.beside(gw.fabrication.measured(designed), gw.fabrication.measured(rest))
    >>> "crossing_angle_deg.median" in differs, "ribbons" in differs
    (True, False)
    """
    one, other = _flat(designed.document()), _flat(cut.document())
    return {
        name: (value, other[name])
        for name, value in one.items()
        if abs(value - other[name]) > ROUNDING * max(abs(value), abs(other[name]))
    }


def _flat(document: dict[str, Any], before: str = "") -> dict[str, float]:
    """The numbers of a document by their names, those of a part as ``part.name``."""
    found: dict[str, float] = {}
    for name, value in document.items():
        if isinstance(value, dict):
            found |= _flat(value, f"{before}{name}.")
        elif isinstance(value, int | float):
            found[before + name] = value
    return found


def _quantile(values: Scalars, share: float) -> float:
    """A quantile of some values, 0 if there are none."""
    return float(np.quantile(values, share)) if len(values) else 0.0
