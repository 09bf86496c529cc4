"""What crossings lack to hold by friction alone, as one number with its derivative.

A contact is a spring, so its force is a linear function of the shape at rest. That makes the force that
friction does not bear one more residual of the inverse problem (`geoweave.rods.strip_fitting`).
"""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Scalars
from geoweave.rods.contact_energies import contact_position
from geoweave.rods.contact_order import gaps_of
from geoweave.rods.crossing_forces import contact_forces
from geoweave.rods.rods import Rods
from geoweave.rods.slide_and_relax import Springs
from geoweave.weave import FLOATING, WeaveType

__all__ = ["HoldingAtRest", "Lack", "interlacing_force"]

ALTERNATING, FLOATS = 24.0, 3.0
"""Forces of a strip of stiffness B that crosses every d, in ``B h / d^3``; h is how far it goes up and down.

Its heights at crossings i are waves ``u cos(a i + b)``. A beam over such supports presses on each with
``6 u (2 - 2 cos a)^2 / (4 + 2 cos a) B / d^3``, as the three moments of its spans say. Where it goes over
and under in turn, ``a = pi`` and ``u = h / 2``; over two and under two, ``a = pi / 2``, ``u cos b = h / 2``.
"""


def interlacing_force(rods: Rods, pattern: WeaveType = "plain") -> float:
    """Force with which ribbons press on each other because of how they interlace, a median distance apart.

    Parameters
    ----------
    rods : with contacts
    pattern : the weave that is meant; in a twill and a basket ribbons pass over two others in a row

    Returns
    -------
    ``24 B h / d^3``, or ``3 B h / d^3`` of a twill or a basket.
    """
    factor = FLOATS if pattern in FLOATING else ALTERNATING
    apart = float(np.median(gaps_of(rods).lengths))
    stiffness = float(rods.material.bending(rods.widths).mean())
    return factor * stiffness * rods.material.thickness / apart**3


class Lack:
    """Residuals of the contacts at one state: ``s / F`` and ``max(f + F, 0) / F``, times ``sqrt(w / C)``.

    s is the part of a contact's force along the ribbons, f the part that pulls them apart. F is the force
    with which they are to press, that of `interlacing_force`. Normals are those of the state: their change is
    not part of the derivative.

    Attributes
    ----------
    residuals : (4 C,) three and one for each contact
    """

    def __init__(self, rods: Rods, goal: HoldingAtRest) -> None:
        forces = contact_forces(rods, goal.springs)
        self.term = contact_position(rods, goal.springs.position)
        self.size = rods.size
        pulled = forces.separation + goal.unit
        scale = np.sqrt(goal.weight / len(forces)) / goal.unit
        acts = (pulled > 0)[:, None]
        self.residuals: Scalars = (
            scale * np.concatenate([forces.along, np.where(acts, pulled[:, None], 0.0)], axis=1)
        ).ravel()
        n = forces.normals
        frame = np.concatenate([np.eye(3) - n[:, :, None] * n[:, None, :], -(acts * n)[:, None, :]], axis=1)
        upper = np.where(rods.contacts.over == 0, 1.0, -1.0)
        jacobian = self.term.derivative(rods)
        # The force on the first ribbon is what the two residuals of a contact pull its point by.
        weight = jacobian[:, :3, :3] + jacobian[:, :3, 3:6]
        force = -np.einsum("nxy,nxk->nyk", weight, jacobian[:, :3] - jacobian[:, 3:])
        self.local = (scale * upper)[:, None, None] * (frame @ force)

    @property
    def value(self) -> float:
        """Half the sum of squares."""
        return 0.5 * float(self.residuals @ self.residuals)

    def forward(self, moved: Scalars) -> Scalars:
        """(4 C,) change of the residuals as vertices and angles move by (3 V + S,)."""
        return np.asarray(np.einsum("nrk,nk->nr", self.local, moved[self.term.unknowns]).ravel())

    def backward(self, slope: Scalars) -> Scalars:
        """(3 V + S,) derivative by the shape of what has this derivative (4 C,) by the residuals."""
        pulled = np.einsum("nrk,nr->nk", self.local, slope.reshape(-1, 4)).ravel()
        return np.bincount(self.term.unknowns.ravel(), pulled, minlength=self.size).astype(np.float64)


class HoldingAtRest:
    """The target: crossings that hold by friction.

    Parameters
    ----------
    rods : with the contacts
    springs : stiffnesses of the contacts
    weight : of the mean of these squares
    pattern : the weave that is meant
    """

    def __init__(self, rods: Rods, springs: Springs, weight: float, pattern: WeaveType = "plain") -> None:
        self.springs, self.weight = springs, weight
        self.unit = interlacing_force(rods, pattern)

    def lack(self, rods: Rods) -> Lack:
        """Measure rods at rest."""
        return Lack(rods, self)
