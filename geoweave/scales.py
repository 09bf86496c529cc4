"""Which scale gives so many ribbons: a short search over a function that counts in steps (Section 4.2.3).

The number of ribbons grows with the scale, but in steps, with jumps up and down where level sets merge or
are cut otherwise. So the search cannot end at a root; it takes the nearest count that a few tries meet.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geoweave.errors import FieldError

TRIES = 10
"""How many scales are tried at most."""

GROWTH = 1.4
"""First guess of p in ``count ~ scale^p``: ribbons lie denser, and the pruning spares shorter ones."""

DIGITS = 5
"""Significant digits of a scale, so that the one that is reported can be asked for."""

FARTHEST = 8.0
"""Factor by which a step after the first one changes the scale at most while all counts lie on one side."""


@dataclass(frozen=True)
class Search:
    """What a search met.

    Attributes
    ----------
    scale, count : the nearest count, and the scale that gives it
    tried : every scale and what it gave, in the order of the tries
    """

    scale: float
    count: int
    tried: tuple[tuple[float, int], ...]


def nearest_scale(
    count: Callable[[float], int], wanted: int, *, start: float = 1.0, tries: int = TRIES
) -> Search:
    """Find a scale at which a function counts ``wanted``, or as near to it as some tries come.

    Between two tries that enclose the wanted count the next scale is interpolated, the logarithm of the count
    over that of the scale; before that it is extrapolated. The search ends at the wanted count, when no
    scale of five digits is left between, or with the tries. Of two counts equally near it takes the smaller
    one, never 0, and of two scales with the same count the first.

    Parameters
    ----------
    count : number at a scale, 0 where nothing is left
    wanted : 1 or more
    start : first scale
    tries : at most so many calls, 1 or more

    Raises
    ------
    FieldError
        If a parameter is out of range, or every try counts nothing.
    """
    if wanted < 1:
        raise FieldError(f"a weave has one ribbon or more, not {wanted}")
    if tries < 1 or not (np.isfinite(start) and start > 0):
        raise FieldError(f"a search needs a positive first scale and one try or more, not {start}, {tries}")
    tried: dict[float, int] = {}
    scale = _rounded(start)
    while len(tried) < tries and scale not in tried:
        tried[scale] = count(scale)
        if tried[scale] == wanted:
            break
        scale = _rounded(_proposed(tried, wanted))
    if not any(tried.values()):
        raise FieldError(
            f"no ribbon is left at any scale from {min(tried):g} to {max(tried):g}; give the mesh more faces"
        )
    found = (scale for scale, number in tried.items() if number)
    best = min(found, key=lambda each: (abs(tried[each] - wanted), tried[each]))
    return Search(best, tried[best], tuple(tried.items()))


def _rounded(scale: float) -> float:
    return float(f"{scale:.{DIGITS}g}")


def _proposed(tried: dict[float, int], wanted: int) -> float:
    """Return the next scale to try."""
    below = [(n, x) for x, n in tried.items() if n < wanted]
    above = [(n, x) for x, n in tried.items() if n > wanted]
    if below and above:
        few, low = max(below)
        many, high = min(above)
        first, last = np.log(low), np.log(high)
        # Nothing at all tells no slope; half way then, and never nearer than a tenth to either.
        share = np.log(wanted / few) / np.log(many / few) if few else 0.5
        return float(np.exp(first + np.clip(share, 0.1, 0.9) * (last - first)))
    side = below or above
    count, last_scale = max(below) if below else min(above)
    if not count:
        return 2.0 * last_scale
    step = np.log(wanted / count) / GROWTH
    if len(side) > 1:  # the first step fell short: twice as far each time, within reason
        step = np.clip(step * 2.0 ** (len(side) - 1), -np.log(FARTHEST), np.log(FARTHEST))
    return float(last_scale * np.exp(step))
