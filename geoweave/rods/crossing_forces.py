"""The forces that hold the ribbons of a weave together at rest (Section 6, Appendix E.2).

"Contact forces at the crossings balance residual internal forces within the ribbons" (E.2). The shape at rest
fixes the internal forces of every ribbon, and so the force at each of its crossings: it is minus the elastic
gradient of one of the two ribbons there. The model gives it as the derivative of the contact's energy by a
shift of one ribbon.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geoweave.arrays import Indices, Scalars, Vectors, frozen
from geoweave.errors import RodError
from geoweave.rods.contact_energies import contact_position
from geoweave.rods.rods import Rods
from geoweave.rods.slide_and_relax import Springs

__all__ = ["FRICTION", "ContactForces", "contact_forces"]

FRICTION = 0.3
"""Default coefficient of friction between two ribbons, the lowest of `geoweave.fabrication.MATERIALS`."""

NONE_AT_ALL = 1e-9
"""A force below this share of the largest one is rounding."""

SHARES = (50, 75, 90)
"""Percentiles of the friction that crossings need, as Ren et al. (2021) report them."""


@dataclass(frozen=True, eq=False)
class ContactForces:
    """The force at each contact of rods at rest, on its upper ribbon; the lower one gets its opposite.

    Attributes
    ----------
    on_upper : (C, 3) force of the lower ribbon on the upper one
    normals : (C, 3) unit normals of the crossings, from the lower ribbon to the upper one
    """

    on_upper: Vectors
    normals: Vectors

    def __len__(self) -> int:
        return len(self.on_upper)

    @cached_property
    def separation(self) -> Scalars:
        """(C,) force that pulls the two ribbons apart; negative where they press on each other."""
        return frozen(-(self.on_upper * self.normals).sum(axis=1))

    @cached_property
    def along(self) -> Vectors:
        """(C, 3) the part of the force that pushes the upper ribbon along the lower one."""
        return frozen(self.on_upper + self.separation[:, None] * self.normals)

    @cached_property
    def sliding(self) -> Scalars:
        """(C,) size of the force that pushes the two ribbons along each other."""
        return frozen(np.linalg.norm(self.along, axis=1))

    @cached_property
    def friction(self) -> Scalars:
        """(C,) coefficient of friction that a crossing needs, ``sliding / pressing``.

        It is infinite where ribbons are pulled apart, and zero where there is no force.
        """
        size = np.linalg.norm(self.on_upper, axis=1)
        there = size > NONE_AT_ALL * max(float(size.max(initial=0.0)), np.finfo(float).tiny)
        pressed = there & (self.separation < 0)
        found = np.where(there, np.inf, 0.0)
        found[pressed] = self.sliding[pressed] / -self.separation[pressed]
        return frozen(found)

    def lacking(self, friction: float = FRICTION) -> Scalars:
        """(C,) force along the ribbons that friction does not bear, ``sliding + friction x separation``.

        Positive where a crossing needs glue or a rivet.
        """
        return np.asarray(self.sliding + friction * self.separation)

    def fasten(self, friction: float = FRICTION) -> Indices:
        """Contacts that need a fastener with this coefficient of friction, the greatest need first.

        The shape at rest fixes the force at every crossing. So these are the fewest that suffice to keep this
        shape: each of the others holds by itself, and none of these does.

        Parameters
        ----------
        friction : coefficient of friction between two ribbons

        Raises
        ------
        RodError
            If it is negative or not finite.
        """
        if not (np.isfinite(friction) and friction >= 0):
            raise RodError(f"the coefficient of friction is {friction:g}; give zero or a positive number")
        need = np.flatnonzero(self.friction > friction)
        return frozen(need[np.argsort(-self.lacking(friction)[need], kind="stable")])

    def percentiles(self, without: Indices | None = None) -> tuple[float, ...]:
        """The friction that 50, 75 and 90 % of the contacts hold with, infinite if none suffices.

        Parameters
        ----------
        without : contacts that are fastened; they are left out
        """
        kept = np.delete(self.friction, [] if without is None else without)
        if not len(kept):
            return (0.0,) * len(SHARES)
        return tuple(float(np.percentile(kept, share, method="higher")) for share in SHARES)

    def of_contact(self, contact: int, unit: float, friction: float = FRICTION) -> dict[str, Any]:
        """What ``relaxed.json`` says of one crossing.

        Parameters
        ----------
        contact : which
        unit : of the forces that are wanted, over that of these
        friction : coefficient of friction between two ribbons
        """
        needed = float(self.friction[contact])
        return {
            "force": {
                "separation": float(self.separation[contact]) * unit,
                "sliding": float(self.sliding[contact]) * unit,
                "friction": needed if np.isfinite(needed) else None,
            },
            "fasten": needed > friction,
        }

    def document(self, friction: float = FRICTION) -> dict[str, Any]:
        """What the report says of the forces; a percentile that no friction reaches is None."""
        shares = [value if np.isfinite(value) else None for value in self.percentiles()]
        return {
            "friction": friction,
            "needed": dict(zip((f"p{share}" for share in SHARES), shares, strict=True)),
            "contacts": len(self),
            "pulled_apart": int((self.friction == np.inf).sum()),
            "fasten": len(self.fasten(friction)),
        }


def contact_forces(rods: Rods, springs: Springs | None = None) -> ContactForces:
    """Find the force that holds the two ribbons of each crossing together.

    The force on ribbon a is ``-dE_c / dc_a``, the derivative of the contact's energy by a shift of a. The
    couples that hold ribbons flush have no part in it. At rest the forces of all crossings of a ribbon sum to
    zero, as nothing else acts on it.

    Parameters
    ----------
    rods : at rest under these springs
    springs : stiffnesses that they were relaxed with

    Returns
    -------
    ContactForces
        Forces in the unit of the rods: that of Young's modulus times length squared.

    Examples
    --------
    >>> rest = gw.relaxed_weave(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8))
    >>> forces = gw.rods.contact_forces(rest.left.rods)
    >>> bool(len(forces.fasten(0.2)) >= len(forces.fasten(0.6)))
    True
    """
    if not len(rods.contacts):
        return ContactForces(frozen(np.zeros((0, 3))), frozen(np.zeros((0, 3))))
    term = contact_position(rods, (springs or Springs()).position)
    local = np.einsum("nr,nrk->nk", term.residual(rods), term.derivative(rods))
    on_first = -(local[:, :3] + local[:, 3:6])
    one, two = rods.contacts.segments.T
    agree = np.where((rods.directors[one] * rods.directors[two]).sum(axis=1) < 0, -1.0, 1.0)
    up = rods.directors[one] + agree[:, None] * rods.directors[two]
    up /= np.linalg.norm(up, axis=1)[:, None]
    on_upper = np.where(rods.contacts.over[:, None] == 0, on_first, -on_first)
    return ContactForces(frozen(on_upper), frozen(up))
