"""How rigid a woven object is when it is made of a stated material, in millimetres (Section 6).

A model of bounding radius 1 is an object of radius u mm. Its stiffness is that of the model times
``u Y / Y_model``, its weight ``density g`` times its volume. The thickness of the material changes the shape
at rest, so the weave is relaxed with it first.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geoweave.arrays import Vectors
from geoweave.errors import RodError
from geoweave.fabrication import SheetMaterial, material_of, up_axis, upward
from geoweave.rods import Relaxed, RestStiffness, Rods, Springs, contact_forces, on_the_floor, relax_rods

__all__ = ["Rigidity", "rigidity"]

GRAVITY = 9.81
"""In m/s2, which is N/kg."""

KG_PER_MM3 = 1e-6
"""Of 1 g/cm3."""

STIFF = Springs(position=1e5)
"""Contacts that are fastened: they give far less than the ribbons between them."""

CANDIDATES = 12
"""The contacts that give way most in the softest motions are tried with a load."""

MOTIONS = 8
"""So many of these motions are found."""

SMALL = 0.02
"""Where a load moves something by more than this share of the height, twice the load will not move it twice
as far."""


@dataclass(frozen=True)
class Rigidity:
    """How an object that stands on its lowest places answers loads; a linear answer, for small ones.

    Attributes
    ----------
    material : its name or description
    grams : weight of the ribbons
    stiffness : (k,) the smallest eigenvalues of its stiffness without supports, N per mm of displacement
        and mm of ribbon
    own_weight : how far its own weight moves it, at most, mm
    load : N
    under_load : how far a crossing gives way under the load, at most, mm
    worst : the two ribbons of that crossing
    height : of the object, mm
    friction : coefficient at which nine tenths of the crossings hold, None if none does
    fasten : how many crossings the friction of the material does not hold
    linear : whether both answers are small against the height
    """

    material: str
    grams: float
    stiffness: tuple[float, ...]
    own_weight: float
    load: float
    under_load: float
    worst: tuple[str, str]
    height: float
    friction: float | None
    fasten: int
    linear: bool

    def document(self) -> dict[str, Any]:
        """For reports."""
        return asdict(self)


def rigidity(
    relaxed: Relaxed,
    material: str | SheetMaterial,
    *,
    up: str | ArrayLike | None = None,
    load: float = 1.0,
) -> Rigidity:
    """Measure how rigid a weave at rest is when it is made of a material.

    Crossings are fastened. The object stands on what lies within a fiftieth of its height above its lowest
    point (`on_the_floor`). The load pushes one crossing at a time along its normal.

    Parameters
    ----------
    relaxed : the weave at rest, in mm
    material : a name of `geoweave.fabrication.MATERIALS`, or what it would say
    up : the axis that is up, as ``--up`` names it, or a (3,) direction against gravity; without one, that of
        the widest base, as in the guide (`geoweave.fabrication.up_axis`)
    load : N

    Raises
    ------
    RodError
        If the weave is not in mm, the material is thicker than its ribbons are wide, or it does not come to
        rest.

    Examples
    --------
    >>> rest = gw.relaxed_weave(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8).sized(size=100.0))
    >>> thick, thin = (gw.pipeline.rigidity(rest, each) for each in ("birch veneer", "vellum"))
    >>> thick.own_weight < thin.own_weight
    True
    """
    sheet = material_of(material) if isinstance(material, str) else material
    weave = relaxed.weave
    if weave.units != "mm":
        raise RodError("the weave is not in mm; give the object a size ('--size', 'Weave.sized')")
    if up is None or isinstance(up, str):
        up = upward(up_axis(relaxed.document(), up))
    against = np.asarray(up, dtype=np.float64)
    if against.shape != (3,) or not (np.isfinite(against).all() and against.any()):
        raise RodError(f"upwards is three finite numbers that are not all zero, not {against.tolist()}")
    against = against / np.linalg.norm(against)
    unit = weave.placement.scale
    rods = _made_of(relaxed.left.rods, sheet, unit)
    # the model's modulus stays; forces and stiffness are scaled to the material's
    modulus = sheet.young / rods.material.young
    feet = on_the_floor(rods.points, against)
    free, stands = RestStiffness(rods, STIFF), RestStiffness(rods, STIFF, feet)
    height = float(np.ptp(rods.points @ against)) * unit
    ends = rods.layout.ends
    volume = rods.widths * sheet.thickness / unit * rods.rest * unit**3
    newtons = KG_PER_MM3 * sheet.density * GRAVITY * volume
    shares = np.bincount(ends.ravel(), np.repeat(0.5 * newtons, 2), minlength=len(rods.points))
    compliance = 1.0 / (modulus * unit)  # mm per newton, of the model's unit of both
    sunk = compliance * stands.moved(-shares[:, None] * against)
    soft = free.softest(min(MOTIONS, 3 * len(rods.points) - 8))
    forces = contact_forces(rods, STIFF)
    gives, worst = _worst(stands, forces.normals)
    under = load * compliance * gives
    pair = rods.layout.rod_of_segment[rods.contacts.segments[worst]]
    own = float(np.linalg.norm(sunk, axis=1).max())
    needed = forces.percentiles()[-1]
    return Rigidity(
        material if isinstance(material, str) else sheet.says,
        float(newtons.sum() / GRAVITY * 1000),
        # the length that the eigenvalues are per is in the model's unit
        tuple((modulus * soft.stiffness[:3]).tolist()),
        own,
        load,
        float(under),
        (weave.names[int(pair[0])], weave.names[int(pair[1])]),
        height,
        needed if np.isfinite(needed) else None,
        len(forces.fasten(sheet.friction)),
        bool(max(own, under) <= SMALL * height),
    )


def _made_of(rods: Rods, sheet: SheetMaterial, unit: float) -> Rods:
    """The rods at rest with the thickness of a material and with contacts that are fastened."""
    thickness = sheet.thickness / unit
    if thickness > rods.widths.min():
        raise RodError(
            f"{sheet.says} is {sheet.thickness:g} mm thick, and the ribbons are only "
            f"{rods.widths.min() * unit:.3g} mm wide; make the object larger or the ribbons wider"
        )
    made = replace(rods.material, thickness=thickness, poisson=sheet.poisson)
    found = relax_rods(replace(rods, material=made), springs=STIFF)
    if not found.converged:
        raise RodError(f"made of {sheet.says}, the weave does not come to rest: {found.ending}")
    return found.rods


def _worst(stands: RestStiffness, normals: Vectors) -> tuple[float, int]:
    """The largest displacement per force of a contact along its normal, and which contact that is.

    A contact that gives way much moves much in a soft motion. So the soft motions say which are tried.
    """
    rods = stands.rods
    motions = stands.softest(MOTIONS)
    ends = rods.layout.ends[rods.contacts.segments[:, 0], 0]
    along = np.einsum("kcx,cx->kc", motions.motions[:, ends], normals)
    guess = (along**2 / motions.stiffness[:, None]).sum(axis=0)
    tried = np.argsort(-guess, kind="stable")[:CANDIDATES]
    gives = stands.at_contacts(normals, tried)
    best = int(np.argmax(gives))
    return float(gives[best]), int(tried[best])
