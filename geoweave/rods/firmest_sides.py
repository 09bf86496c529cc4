"""Over and under chosen so that friction holds more crossings where ribbons alternate as well (Section 6)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geoweave.arrays import Indices
from geoweave.rods.contact_order import positions
from geoweave.rods.crossing_forces import FRICTION, contact_forces
from geoweave.rods.equilibrium import Equilibrium
from geoweave.rods.rods import Rods
from geoweave.rods.slide_and_relax import Springs, relax_rods
from geoweave.weave import Passages, WeaveType, interlacing

__all__ = ["firmest"]


def firmest(
    rods: Rods,
    *,
    springs: Springs | None = None,
    friction: float = FRICTION,
    pattern: WeaveType = "plain",
) -> Equilibrium:
    """Choose over and under at rest so that fewer crossings need a fastener.

    What the weave was designed for comes first: ribbons alternate at least as often, and then at least as
    many triangles interleave; a twill or a basket breaks no more of its rules. Sides may still be exchanged
    at all crossings together, and at a crossing where half of the relations to its neighbours are broken
    anyhow. Each such choice is relaxed, the crossing with the greatest need first, and kept if fewer
    crossings need a fastener. So the search ends.

    Parameters
    ----------
    rods : a weave, at rest or not
    springs : stiffnesses of the contacts
    friction : coefficient of friction between two ribbons
    pattern : the weave that is meant

    Returns
    -------
    Equilibrium
        The weave at rest with the sides that were kept; they are those of its contacts.

    Examples
    --------
    >>> rods = gw.elastic_rods(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)).rods
    >>> start, best = gw.rods.relax_rods(rods), gw.rods.firmest(rods)
    >>> len(gw.rods.contact_forces(best.rods).fasten()) <= len(gw.rods.contact_forces(start.rods).fasten())
    True
    """
    layout = rods.layout
    passages = Passages(layout.rod_of_segment[rods.contacts.segments], positions(rods), layout.closed)

    def worth(over: Indices) -> tuple[int, int]:
        found = interlacing.judged(passages, over, pattern)
        return -found.defects, found.interleaved if found.unmet is None else 0

    best = relax_rods(rods, springs=springs)
    if not len(rods.contacts):
        return best
    need = len(contact_forces(best.rods, springs).fasten(friction))
    designed = worth(rods.contacts.over)
    lower = True
    while lower:
        lower = False
        forces = contact_forces(best.rods, springs)
        flips = [np.ones(len(forces), dtype=bool)]
        flips += [np.arange(len(forces)) == c for c in forces.fasten(friction)]
        for flip in flips:
            over = np.where(flip, 1 - best.rods.contacts.over, best.rods.contacts.over)
            if worth(over) < designed:
                continue
            start = replace(best.rods, contacts=replace(best.rods.contacts, over=over))
            found = relax_rods(start, springs=springs)
            count = len(contact_forces(found.rods, springs).fasten(friction))
            if found.converged and count < need:
                best, need, lower = found, count, True
                break
    return best
