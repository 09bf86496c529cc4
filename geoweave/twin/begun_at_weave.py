"""A twin begun where its weave is: which of the shapes is it that the strips would rather rest in?

Strips may come to rest in more than one shape, for a dent has nearly the lengths of a bump. Which of these
shapes is the object's is a matter of their energies, and not of where a search began.
"""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from geoweave.arrays import frozen
from geoweave.rods import relax_rods
from geoweave.twin.laid_strips import laid
from geoweave.twin.twin import STEPPING, Twin

__all__ = ["begun_at"]


def begun_at(alone: Twin, document: Mapping[str, Any], name: str = "weave.json") -> Twin | None:
    """Lay the strips of a twin where a weave has them, and let them come to rest there.

    Parameters
    ----------
    alone : the twin that was made of the strips alone
    document : the contents of ``weave.json`` or ``relaxed.json``, in mm
    name : what it is called in a refusal

    Returns
    -------
    Twin or None
        The strips at rest, with `Twin.alone` for the other rest; None if they have no less energy so than as
        they came to rest by themselves, or the weave lacks one of their crossings.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.sphere(600), ribbons=8).sized(200.0)
    >>> twin = gw.twin.assembled(gw.fabrication.pattern_of(weave))
    >>> found = gw.twin.begun_at(twin, weave.document())  # at best a hair lower, in the same shape
    >>> found is None or found.compared(weave.document()).comes_back
    True
    """
    clock = time.perf_counter()
    places = alone.lines_and_places(document, name)[1]
    if np.isnan(places).any():
        return None
    start = laid(alone.surface, places, alone.start.unit)
    rest = relax_rods(start.rods, stepping=STEPPING)
    reached = rest.steps[-1].energy
    if reached >= alone.rest.steps[-1].energy:
        return None
    more = time.perf_counter() - clock
    return replace(
        alone,
        placed=frozen(places),
        start=start,
        rest=rest,
        tried=(*alone.tried, reached),
        seconds=alone.seconds | {"relax": alone.seconds["relax"] + more},
        alone=alone.compared(document, name),
    )
