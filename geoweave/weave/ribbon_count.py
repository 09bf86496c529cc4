"""Which scale gives a wanted number of ribbons (Section 4.2.3).

The number of ribbons grows with the scale in steps. It also jumps up and down where level sets merge or are
cut at other places. There may be no scale with the wanted number. So the search tries a few scales and takes
the one whose number is nearest. A try integrates the field anew. What it gives tells what to expect at other
scales, so that the next try is near.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from geoweave.errors import FieldError

TRIES = 10
"""How many scales are tried at most."""

ENOUGH = 3
"""After so many tries a near count is good enough."""

NEAR = 0.05
"""Share of the wanted count by which a near one misses it at most."""

GUESSES = 6
"""How often a number is expected from a try before the next one."""

GROWTH = 1.4
"""First guess of p in ``count ~ scale^p``: more than 1, because shorter ribbons are kept at larger scales."""

DIGITS = 5
"""Significant digits of a scale. A scale that is reported can then be given again exactly."""

FINEST = 0.25
"""Between scales whose logarithms differ by less than this share of ``1 / wanted`` none is tried."""

NEARBY = 0.01
"""Share of the scale by which a scale next to the best differs from it."""

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
    count: Callable[[float], int],
    wanted: int,
    *,
    start: float = 1.0,
    tries: int = TRIES,
    expected: Callable[[float], float] | None = None,
) -> Search:
    """Find a scale at which a function counts ``wanted``, or as near to it as some tries come.

    With expectations, the first three scales are those at which the wanted count is expected from the nearest
    try, and a count within 5 % of it then ends the search. Without them, and later, the scale is interpolated
    between two neighbouring tries that enclose the wanted count, the logarithm of the count over that of the
    scale; before that it is extrapolated. Where neighbours that enclose it lie too close to hope for it
    between them, the count jumps there, and scales next to the best are tried. The search ends at the wanted
    count or with the tries. Of two counts equally near it takes the smaller one, never 0, and of two scales
    with the same count the first.

    Parameters
    ----------
    count : number at a scale, 0 where nothing is left
    wanted : 1 or more
    start : first scale
    tries : at most so many calls of ``count``, 1 or more
    expected : number to expect at another scale, judged by the nearest try so far, and 0 where nothing is;
        it costs less than a count

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
        if tried[scale] == wanted or (expected is not None and _enough(tried, wanted)):
            break
        scale = _next(tried, wanted, expected)
    if not any(tried.values()):
        raise FieldError(
            f"no ribbon is left at any scale from {min(tried):g} to {max(tried):g}; give the mesh more faces"
        )
    best = _nearest(tried, wanted)
    return Search(best, tried[best], tuple(tried.items()))


def _nearest(tried: dict[float, int], wanted: int) -> float:
    """The scale of the nearest count, 0 not counted."""
    found = (scale for scale, number in tried.items() if number)
    return min(found, key=lambda each: (abs(tried[each] - wanted), tried[each]))


def _enough(tried: dict[float, int], wanted: int) -> bool:
    """Whether the nearest of three tries or more is near."""
    return (
        len(tried) >= ENOUGH
        and any(tried.values())
        and abs(tried[_nearest(tried, wanted)] - wanted) <= NEAR * wanted
    )


def _next(tried: dict[float, int], wanted: int, expected: Callable[[float], float] | None) -> float:
    """Return the next scale to try, rounded; one that was tried ends the search."""
    if expected is not None and len(tried) < ENOUGH and any(tried.values()):
        scale = _rounded(_expected_scale(_nearest(tried, wanted), wanted, expected))
        if scale not in tried:
            return scale
    return _rounded(_proposed(tried, wanted))


def _expected_scale(best: float, wanted: int, expected: Callable[[float], float]) -> float:
    """Return a scale at which the wanted count is expected: by secants of logarithms, from the nearest try.

    What is expected grows in small steps, so that the search ends within half a count.
    """
    scale, slope, last = best, GROWTH, (0.0, 0.0)
    nearest, miss = best, np.inf
    for number in range(GUESSES):
        guess = expected(scale)
        if abs(guess - wanted) < miss:
            nearest, miss = scale, abs(guess - wanted)
        if miss <= 0.5 or guess <= 0:
            break
        here = float(np.log(scale)), float(np.log(guess))
        if number and here[0] != last[0]:
            # Between near scales small steps of the count can make any slope.
            slope = float(np.clip((here[1] - last[1]) / (here[0] - last[0]), 0.5 * GROWTH, 2.0 * GROWTH))
        last = here
        scale = float(scale * np.clip((wanted / guess) ** (1.0 / slope), 1.0 / FARTHEST, FARTHEST))
    return nearest


def _rounded(scale: float) -> float:
    return float(f"{scale:.{DIGITS}g}")


def _proposed(tried: dict[float, int], wanted: int) -> float:
    """Return the next scale to try."""
    below = [(n, x) for x, n in tried.items() if n < wanted]
    above = [(n, x) for x, n in tried.items() if n > wanted]
    if below and above:
        return _between(tried, wanted)
    side = below or above
    count, last_scale = max(below) if below else min(above)
    if not count:
        return 2.0 * last_scale
    step = np.log(wanted / count) / GROWTH
    if len(side) > 1:  # the first step fell short: twice as far each time, within reason
        step = np.clip(step * 2.0 ** (len(side) - 1), -np.log(FARTHEST), np.log(FARTHEST))
    return float(last_scale * np.exp(step))


def _between(tried: dict[float, int], wanted: int) -> float:
    """Return a scale between two tries, or next to the best one; one that was tried if there is none."""
    scales = sorted(tried)
    miss = {scale: abs(tried[scale] - wanted) for scale in scales}
    gaps = [(low, high) for low, high in pairwise(scales) if np.log(high / low) > FINEST / wanted]
    enclosing = [each for each in gaps if (tried[each[0]] < wanted) != (tried[each[1]] < wanted)]
    if enclosing:
        low, high = min(enclosing, key=lambda each: miss[each[0]] + miss[each[1]])
        one, two = tried[low], tried[high]
        # Nothing at all tells no slope; half way then, and never nearer than a tenth to either.
        share = np.log(wanted / one) / np.log(two / one) if one and two else 0.5
        return float(low * (high / low) ** np.clip(share, 0.1, 0.9))
    for best in sorted(scales, key=lambda scale: miss[scale]):
        for low, high in gaps:
            if best in (low, high):
                step = min(NEARBY, 0.5 * float(np.log(high / low)))
                return float(best * np.exp(step if best == low else -step))
    return scales[0]


def check_asked(scale: float | None, ribbons: int | None) -> None:
    """Refuse what cannot be asked for, before any work."""
    if scale is not None and ribbons is not None:
        raise FieldError(f"a weave has a scale ({scale:g}) or a number of ribbons ({ribbons}), not both")
    if scale is not None and not (np.isfinite(scale) and scale > 0):
        raise FieldError(f"the scale of a weave must be a positive number, not {scale}")
    if ribbons is not None and ribbons < 1:
        raise FieldError(f"a weave has one ribbon or more, not {ribbons}")
