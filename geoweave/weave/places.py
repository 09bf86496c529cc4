"""Places of a weave that will not weave: what kinds there are, and what is said of each (Section 6)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geoweave.arrays import Scalars, Vectors
from geoweave.weave.weave import Weave

__all__ = ["KINDS", "Place", "places"]

KINDS = {
    "near_parallel": "crossings at a small angle; value: the angle, degrees",
    "alongside": "ribbons that run side by side and overlap; value: the length of the stretch",
    "lap": "ends that lie on each other, one ribbon going on where the other stops; value: the length",
    "crowded": "crossings next to each other that overlap; value: the width that would fit between them",
    "knot": "short ribbons that hold mostly each other; value: how many of them",
    "gap": "holes; value: how far their middle is from the nearest ribbon",
    "loose_end": "ends that nothing holds; value: the length beyond the last crossing",
    "bare_component": "pieces of the surface without any ribbon; value: the area",
}
"""The kinds of places that will not weave, and what is measured there."""


class Place(NamedTuple):
    """A place that will not weave."""

    kind: str
    """One of `KINDS`."""
    point: tuple[float, float, float]
    """Where, in the unit of the weave."""
    ribbons: tuple[str, ...]
    """Names of the ribbons that meet there."""
    value: float
    """What `KINDS` says."""


def places(
    weave: Weave,
    kind: str,
    points: Vectors,
    ribbons: list[tuple[int, ...]],
    values: Scalars,
    least_first: bool,
) -> list[Place]:
    """Places in the unit and with the names of the weave, the worst first."""
    names, where = weave.names, weave.placement.undo(points).tolist()
    order = np.argsort(values if least_first else -values, kind="stable")
    return [
        Place(kind, tuple(where[k]), tuple(names[c] for c in ribbons[k]), float(values[k]))
        for k in order.tolist()
    ]
