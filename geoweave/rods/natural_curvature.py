"""From the flat curves of strips to natural curvatures over the joints of rods, and back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geoweave.arrays import Scalars
from geoweave.rods.rods import Rods
from geoweave.weave import FlatCurve

__all__ = ["curvature_knots", "natural_of_strips"]


def _starts(rods: Rods) -> Scalars:
    """(S,) rest length before each segment along its rod."""
    before = np.cumsum(rods.rest) - rods.rest
    return np.asarray(before - before[rods.layout.segment_offsets[:-1]][rods.layout.rod_of_segment])


def natural_of_strips(rods: Rods, curves: Sequence[FlatCurve | None]) -> Scalars:
    """(J,) natural curvatures of rods whose strips are cut along flat curves.

    A joint turns by the integral of the curvature over the half segments on both its sides, and its natural
    curvature is ``-2 tan(turn / 2)`` (`Rods.natural`): thickness directions point to the side from which a
    strip is seen.

    Parameters
    ----------
    rods : one for each strip; their rest lengths may be in another unit
    curves : of the strips; None for a straight one
    """
    layout = rods.layout
    a = layout.joints[:, 0]
    owner = layout.rod_of_segment[a]
    starts = _starts(rods)
    whole = np.add.reduceat(rods.rest, layout.segment_offsets[:-1])
    turned = np.zeros(len(a))
    for r, curve in enumerate(curves):
        if curve is None:
            continue
        mine = np.flatnonzero(owner == r)
        unit = curve.length / whole[r]
        middle = unit * (starts[a[mine]] + 0.5 * rods.rest[a[mine]])
        turned[mine] = curve.heading(middle + unit * rods.spans[mine]) - curve.heading(middle)
    return np.asarray(-2.0 * np.tan(0.5 * turned))


def curvature_knots(rods: Rods, unit: float) -> list[list[list[float]]]:
    """For each rod the places of its joints and the natural curvature there, left is positive.

    Parameters
    ----------
    rods : with natural curvatures
    unit : of the places that are wanted, over that of the rods; curvatures are per length in this unit

    Returns
    -------
    list
        One list of ``[place, curvature]`` for each rod, empty where it is straight.
    """
    layout = rods.layout
    a, b = layout.joints.T
    owner = layout.rod_of_segment[a]
    place = _starts(rods)[b] * unit
    bend = -2.0 * np.arctan(0.5 * rods.natural) / (rods.spans * unit)
    found: list[list[list[float]]] = []
    for r in range(len(rods)):
        mine = np.flatnonzero(owner == r)
        mine = mine[np.argsort(place[mine])]
        pairs = np.column_stack([place[mine], bend[mine]]).tolist()
        found.append(pairs if rods.natural[mine].any() else [])
    return found
