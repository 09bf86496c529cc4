"""Stretches of curves, from one arc length to another (the cutting and trimming of Section 5.2)."""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Indices, Scalars
from geoweave.curves.curves import TINY, Curve, Curves

__all__ = ["stretches"]

ROUNDING = 1e-9
"""Points nearer than this share of a curve's length to the end of a stretch are left to the end."""

WHOLE = 1e-12
"""A stretch of a closed curve shorter by at most this share of its length is all of it."""


def stretches(
    curves: Curves, which: Indices, start: Scalars | None = None, end: Scalars | None = None
) -> Curves:
    """Take stretches of curves, from one arc length to another.

    Parameters
    ----------
    curves : the curves
    which : (n,) the curve of each stretch
    start, end : (n,) arc lengths, ``start < end``; the whole curve if not given. On a closed curve the end
        may lie beyond its length, and a stretch as long as the curve stays closed.

    Examples
    --------
    >>> import numpy as np
    >>> import geoweave as gw
    >>> ring = gw.shapes.torus(faces=400)
    >>> line = gw.straightest(ring, [0], ring.frames[[0], 0], 2.0)
    >>> gw.curves.stretches(line, np.array([0, 0]), np.array([0.0, 1.5]), np.array([0.5, 2.0])).lengths
    array([0.5, 0.5])
    """
    begin = np.zeros(len(which)) if start is None else start
    stop = curves.lengths[which] if end is None else end
    return Curves.concatenate(
        curves.mesh, [_stretch(curves, c, a, b) for c, a, b in zip(which, begin, stop, strict=True)]
    )


def _stretch(curves: Curves, c: int, a: float, b: float) -> Curve:
    """Curve c from arc length a to b."""
    own = np.arange(curves.offsets[c], curves.offsets[c + 1])
    length = float(curves.lengths[c])
    if curves.closed[c] and b - a >= length * (1 - WHOLE):
        return curves[c]
    at = curves.arclength[own]
    if curves.closed[c]:  # twice round, so that a stretch may pass the first point
        own, at = np.concatenate([own, own]), np.concatenate([at, at + length])
    near = ROUNDING * length
    inner = np.flatnonzero((at > a + near) & (at < b - near))
    first = max(int(np.searchsorted(at, a + near, side="right")) - 1, 0)
    last = int(inner[-1]) if len(inner) else first
    ends = [
        curves.points[own[k]]
        + (s - at[k]) / max(curves.segment_lengths[own[k]], TINY) * curves.segments[own[k]]
        for k, s in ((first, a), (last, b))
    ]
    return Curve(
        np.concatenate([ends[:1], curves.points[own[inner]], ends[1:]]),
        curves.faces[np.concatenate([own[[first]], own[inner], own[[last]]])],
        np.concatenate([[0.0], curves.turning[own[inner]], [0.0]]),
        np.concatenate([curves.sliding[own[[first]]], curves.sliding[own[inner]], [False]]),
        False,
    )
