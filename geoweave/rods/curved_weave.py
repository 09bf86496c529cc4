"""Strips that are cut curved: as the design bends within its surface, or so that the weave rests on it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Literal, TypeAlias, get_args

import numpy as np

from geoweave.errors import RodError
from geoweave.rods.rods import Rods
from geoweave.rods.slid_weave import SlidWeave
from geoweave.rods.slide_and_relax import Springs
from geoweave.rods.strip_fitting import CurvedStep, Fitting, optimal_strips

__all__ = ["STRIPS", "StripKind", "curved"]

StripKind: TypeAlias = Literal["straight", "designed", "optimal", "holding"]
"""How strips are cut."""

STRIPS: tuple[StripKind, ...] = get_args(StripKind)
"""All ways to cut strips."""

HOLD = 1e-5
"""`Fitting.hold` of strips that are to hold by friction."""


def curved(
    weave: SlidWeave,
    strips: StripKind = "optimal",
    *,
    springs: Springs | None = None,
    numbers: Fitting | None = None,
    callback: Callable[[CurvedStep], None] | None = None,
) -> SlidWeave:
    """Choose how the strips of a weave are cut, before it is relaxed (DEVIATIONS, curved).

    Straight strips follow geodesics only, and a weave of them leaves its surface where its ribbons bend
    within it. Designed strips have the geodesic curvature that the ribbons have on the surface. Optimal ones
    are those, changed until the weave at rest lies on the surface (`optimal_strips`). Holding ones are
    changed so that, besides, ribbons press on each other where they cross, and slide along each other little:
    then friction holds more crossings (DEVIATIONS, fastened). Ribbons of a twill or a basket bend
    less and press on each other with an eighth of the force; that is what is asked of them.

    Parameters
    ----------
    weave : after `slide`
    strips : "straight", "designed", "optimal" or "holding"
    springs, numbers : as of `optimal_strips`; holding strips have a weight `Fitting.hold` if it is zero there
    callback : called with every trial of `optimal_strips`

    Returns
    -------
    SlidWeave
        The same ribbons, with other strips (`SlidWeave.cut`).

    Raises
    ------
    RodError
        If there is no such kind of strips.

    Examples
    --------
    >>> slid = gw.slide(gw.elastic_rods(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)))
    >>> near, far = gw.relax(gw.rods.curved(slid, "designed")), gw.relax(slid)
    >>> near.departure.to_surface.mean < far.departure.to_surface.mean
    True
    """
    if strips not in STRIPS:
        raise RodError(f"there are no '{strips}' strips; cut them {', '.join(STRIPS)}")
    clock = time.perf_counter()
    rods = weave.slid.rods
    start = replace(rods, rest=rods.lengths, natural=np.zeros(len(rods.layout.joints)))
    if strips == "straight":
        return replace(weave, cut=start, curving=None, curving_seconds=0.0)
    numbers = numbers or Fitting()
    start = _as_designed(start, numbers.sharpest)
    if strips == "designed":
        return replace(weave, cut=start, curving=None, curving_seconds=0.0)
    if strips == "holding" and not numbers.hold:
        numbers = replace(numbers, hold=HOLD)
    found = optimal_strips(
        start,
        weave.weave.mesh,
        springs=springs,
        numbers=numbers,
        fixed=weave.fixed,
        pattern=weave.weave.interlacing.pattern,
        callback=callback,
    )
    return replace(weave, cut=found.cut, curving=found, curving_seconds=time.perf_counter() - clock)


def _as_designed(rods: Rods, sharpest: float) -> Rods:
    """Strips with the geodesic curvature of the ribbons; curvature x width is at most ``sharpest``."""
    most = sharpest * rods.spans / rods.joint_widths
    return replace(rods, natural=np.clip(rods.geodesic, -most, most))
