"""Up to which width ribbons that cross next to each other lie side by side (footnote 5)."""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Scalars
from geoweave.weave.passages import Passages

FLATTEST = 1e-12
"""Least sine of the angle of a crossing, so that nothing is divided by zero."""

__all__ = ["Neighbours", "widths_that_fit"]


def widths_that_fit(distance: Scalars, first: Scalars, second: Scalars) -> Scalars:
    """Width up to which two straight ribbons that cross a third one do not overlap on it.

    A strip of width W that crosses at the angle a covers ``y cot a +- W / (2 sin a)`` at the height y of the
    one it crosses, ``|y| <= W/2``. Two of them at a distance x keep clear of each other up to

        W = 2 x / (1 / sin a + 1 / sin b + |cot a - cot b|).

    Parameters
    ----------
    distance : (n,) between the crossings along the third ribbon, a length
    first, second : (n,) angles from the third ribbon to the two, radians, modulo a half turn
    """
    one, two = (np.maximum(np.abs(np.sin(angle)), FLATTEST) for angle in (first, second))
    lean = np.cos(first) * np.sign(np.sin(first)) / one - np.cos(second) * np.sign(np.sin(second)) / two
    return np.asarray(2.0 * distance / (1.0 / one + 1.0 / two + np.abs(lean)))


class Neighbours:
    """Pairs of crossings that follow each other on a ribbon.

    Parameters
    ----------
    passages : the crossings along the ribbons
    angle : (C,) from the first ribbon of each crossing to the second, radians, positive to the left
    lengths : (R,) length of each ribbon

    Attributes
    ----------
    ribbon : (M,) the ribbon
    first, second : (M,) the two crossings, in the order in which they come on it
    others : (M, 2) the two ribbons that it crosses there
    distance : (M,) between the two crossings, along the ribbon
    widths : (M,) largest width at which these two do not overlap, a length
    triangles : (T, 3) pairs that form a triangle, see `Passages.triples`
    """

    def __init__(self, passages: Passages, angle: Scalars, lengths: Scalars) -> None:
        ribbons = passages.ribbons.ravel()
        here = passages.order[passages.following[passages.order] >= 0]
        there = passages.following[here]
        self.ribbon = ribbons[here]
        self.first, self.second = here // 2, there // 2
        self.others = np.stack([ribbons[here ^ 1], ribbons[there ^ 1]], axis=1)
        at = passages.arclengths.ravel()
        apart = at[there] - at[here]
        # Round a closed ribbon the first crossing follows the last.
        apart = np.where(apart <= 0, apart + lengths[self.ribbon], apart)
        turned = np.stack([angle, -angle], axis=1).ravel()
        self.distance = apart
        self.widths = widths_that_fit(apart, turned[here], turned[there])
        self.triangles = passages.triples

    def fitting(self, share: float) -> float:
        """Return the largest width at which this share of the pairs fits."""
        return float(np.quantile(self.widths, 1.0 - share, method="lower"))
