"""What is measured on strips as they are cut: order, alternation, angles, room, ends (Sections 5.2 and 5.4).

The design has its crossings on the surface. Strips are cut from a weave at rest, in which crossings have
moved along their ribbons. What a maker is told has to be measured there, from the places on the strips alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from geoweave.arrays import Flags, Indices, Scalars, frozen
from geoweave.errors import GeoweaveError
from geoweave.weave.interlacing import Interlacing, judged
from geoweave.weave.passages import Passages
from geoweave.weave.widths import Neighbours

if TYPE_CHECKING:
    from geoweave.weave.weave import Weave

__all__ = ["AsCut", "moved_out_of_order", "turned_over"]


@dataclass(frozen=True, eq=False)
class AsCut:
    """Strips of one width with their crossings, and everything that can be measured on them.

    Lengths are all in one unit, that of the strips.

    Parameters
    ----------
    passages : which strips cross, and how far along each of them
    over : (C,) which of the two strips lies above, 0 or 1
    angle : (C,) from the direction of the first strip to that of the second, radians, positive to the left
    lengths : (R,) length of each strip
    width : of the strips

    Raises
    ------
    GeoweaveError
        If the shapes do not fit each other.

    Examples
    --------
    >>> import geoweave as gw
    >>> weave = gw.weave_pattern(gw.shapes.torus(faces=600), scale=0.5)
    >>> strips = gw.weave.AsCut.of(weave)
    >>> strips.alternation == weave.interlacing.alternation
    True
    >>> bool(strips.overhang.max() < weave.ribbons.spacing)
    True
    """

    passages: Passages
    over: Indices
    angle: Scalars
    lengths: Scalars
    width: float

    def __post_init__(self) -> None:
        crossings, strips = len(self.passages), len(self.passages.closed)
        for name, count in (("over", crossings), ("angle", crossings), ("lengths", strips)):
            if np.shape(getattr(self, name)) != (count,):
                raise GeoweaveError(
                    f"'{name}' of the strips needs shape ({count},), not {np.shape(getattr(self, name))}"
                )
            frozen(getattr(self, name))

    @classmethod
    def of(cls, weave: Weave) -> AsCut:
        """The ribbons of a `Weave` as strips of their designed lengths, in the unit of its mesh."""
        ribbons = weave.ribbons
        return cls(
            ribbons.passages,
            weave.interlacing.over,
            ribbons.crossings.angle,
            ribbons.curves.lengths,
            weave.width,
        )

    @cached_property
    def interlacing(self) -> Interlacing:
        """What over and under break along the strips, in the order in which crossings come on them."""
        return judged(self.passages, self.over)

    @property
    def alternation(self) -> float:
        """Share of the pairs of crossings next to each other between which the strip changes sides."""
        return self.interlacing.alternation

    @property
    def crossing_angles(self) -> Scalars:
        """(C,) angle between the two strips at each crossing, degrees, at most 90."""
        angle = np.degrees(np.abs(self.angle))
        return np.minimum(angle, 180.0 - angle)

    @cached_property
    def neighbours(self) -> Neighbours:
        """Pairs of crossings next to each other on a strip, with their distance and the width that fits."""
        return Neighbours(self.passages, self.angle, self.lengths)

    @property
    def share_that_fits(self) -> float:
        """Share of the neighbouring crossings that do not overlap at this width; 1 without any."""
        widths = self.neighbours.widths
        return float((widths >= self.width).mean()) if len(widths) else 1.0

    @cached_property
    def overhang(self) -> Scalars:
        """(R, 2) length from each end of an open strip to its nearest crossing; 0 on closed strips.

        A strip without a crossing hangs all along. An end at an opening of the surface is an end too.
        """
        owner, at = self.passages.ribbons.ravel(), self.passages.arclengths.ravel()
        first, last = self.lengths.copy(), np.zeros(len(self.lengths))
        np.minimum.at(first, owner, at)
        np.maximum.at(last, owner, at)
        away = np.stack([first, self.lengths - last], axis=1)
        return frozen(np.where(self.passages.closed[:, None], 0.0, np.maximum(away, 0.0)))

    def loose(self, allowed: float) -> Flags:
        """(R, 2) ends that hang: open, and farther than a length from the nearest crossing."""
        return np.asarray(self.overhang > allowed)

    def metrics(self, allowed: float) -> dict[str, Any]:
        """All of it in one dictionary; ends count as loose beyond the length allowed."""
        angle, gap = self.crossing_angles, self.neighbours.distance
        return {
            "crossings": len(self.passages),
            "alternation": {
                "fraction": self.alternation,
                "pairs": len(self.interlacing.broken),
                "on_one_side": int(self.interlacing.broken.sum()),
            },
            "crossing_angle_deg": _spread(angle),
            "gap": _spread(gap),
            "share_that_fits": self.share_that_fits,
            "interleaved_triples": {"count": self.interlacing.interleaved, "of": self.interlacing.triples},
            "loose_ends": int(self.loose(allowed).sum()),
            "longest_end": float(self.overhang.max(initial=0.0)),
        }


def _spread(values: Scalars) -> dict[str, float | None]:
    """Median, fifth percentile and smallest; nothing where there are no values."""
    if not len(values):
        return {"median": None, "p05": None, "smallest": None}
    return {
        "median": float(np.median(values)),
        "p05": float(np.percentile(values, 5)),
        "smallest": float(values.min()),
    }


def moved_out_of_order(design: Passages, cut: Passages) -> Indices:
    """Crossings whose next crossing on one of their two strips is another one than in the design.

    Closed strips may start anywhere. The crossings are numbered alike in both.

    Raises
    ------
    GeoweaveError
        If the two are not crossings of the same ribbons.

    Examples
    --------
    >>> from geoweave.weave import Passages, moved_out_of_order
    >>> def strip(*places):
    ...     return Passages([[0, 1], [0, 2], [0, 3]], [[at, 1.0] for at in places], [False] * 4)
    >>> moved_out_of_order(strip(1.0, 2.0, 3.0), strip(1.0, 2.5, 2.6))
    array([], dtype=int64)
    >>> moved_out_of_order(strip(1.0, 2.0, 3.0), strip(1.0, 2.7, 2.6))
    array([0, 1, 2])
    """
    if not np.array_equal(design.ribbons, cut.ribbons) or not np.array_equal(design.closed, cut.closed):
        raise GeoweaveError("the order of crossings can be compared only of the same ribbons and crossings")
    changed = np.flatnonzero(design.following != cut.following)
    return np.unique(changed // 2)


def turned_over(design: ArrayLike, cut: ArrayLike) -> Indices:
    """Crossings at which the second ribbon heads to the other side of the first than in the design.

    Both are (C,) angles from the first ribbon to the second, in one unit, positive to the left.

    Examples
    --------
    >>> gw.weave.turned_over([1.0, -1.0, 0.5], [0.9, 0.1, 0.6])
    array([1])
    """
    return np.flatnonzero(np.sign(np.asarray(design)) != np.sign(np.asarray(cut)))
