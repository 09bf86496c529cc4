"""Whether the crossings of a weave at rest follow each other as in its design.

The order in which a ribbon meets the others is what a weave is. Where ribbons slid past each other it is
another weave, whose overs and unders nobody designed, and it must not be cut.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

__all__ = ["Reordered", "order_sentence", "reordered_crossings"]

ROUNDING = 1e-6
"""Crossings as near to each other on a ribbon as this share of its length have no order."""


class Reordered(NamedTuple):
    """Two crossings of a ribbon that are neighbours in the design, and stand the other way round at rest."""

    ribbon: str
    """Name of the ribbon."""
    first: str
    """Name of the ribbon that it crosses first in the design."""
    second: str
    """Name of the ribbon that it crosses next in the design."""
    back: float
    """By how much the second crossing lies before the first one at rest, in the unit of the weave."""


def reordered_crossings(document: Mapping[str, Any]) -> tuple[Reordered, ...]:
    """Where crossings follow each other in another order than in the design.

    Parameters
    ----------
    document : the contents of ``relaxed.json``, whose crossings say where they are in the design; nothing is
        found in ``weave.json``, which is the design

    Returns
    -------
    tuple
        One entry for each two neighbours of the design that stand the other way round, by ribbon. It is empty
        exactly if every ribbon meets its crossings in the order of the design.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6)
    >>> gw.fabrication.reordered_crossings(weave.document())
    ()
    """
    ribbons = document["ribbons"]
    met = [each for each in document["crossings"] if "designed" in each]
    passages: list[list[tuple[float, float, int]]] = [[] for _ in ribbons]
    for each in met:
        for side in (0, 1):
            ribbon, partner = each["ribbons"][side], each["ribbons"][1 - side]
            passages[ribbon].append((each["designed"][side], each["arclength"][side], partner))
    found = []
    for ribbon, along in zip(ribbons, passages, strict=True):
        along.sort()
        length = float(ribbon["length"])
        follow = list(pairwise(along))
        if ribbon["closed"] and len(along) > 1:
            (before, _, _), last = along[0], along[-1]
            # Once round: the first crossing of the design follows the last one.
            follow.append((last, (before + length, along[0][1] + length, along[0][2])))
        for (s, here, one), (t, there, other) in follow:
            step = there - here
            if ribbon["closed"]:
                # Crossings may have slid over the start of the ribbon, so places count modulo its length.
                step = t - s + (step - (t - s) + 0.5 * length) % length - 0.5 * length
            if step < -ROUNDING * length:
                found.append(
                    Reordered(
                        str(ribbon["label"]),
                        str(ribbons[one]["label"]),
                        str(ribbons[other]["label"]),
                        float(np.abs(step)),
                    )
                )
    return tuple(found)


def order_sentence(found: tuple[Reordered, ...], unit: str = "mm") -> str:
    """Say in one sentence where ribbons slid past each other, and where by the longest way.

    Parameters
    ----------
    found : what `reordered_crossings` found, one entry at least
    unit : of the lengths

    Examples
    --------
    >>> slipped = gw.fabrication.Reordered("A1", "B1", "B2", 3.0)
    >>> gw.fabrication.order_sentence((slipped,))
    'at one place ...; on A1 the one with B2 now comes 3 mm before the one with B1'
    """
    worst = max(found, key=lambda each: each.back)
    places = "one place" if len(found) == 1 else f"{len(found)} places"
    return (
        f"at {places} crossings stand in another order than in the design; on {worst.ribbon} the one with "
        f"{worst.second} now comes {worst.back:.3g} {unit} before the one with {worst.first}"
    )
