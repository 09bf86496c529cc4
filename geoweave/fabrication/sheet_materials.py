"""What strips are made of, as the mechanics needs it: modulus, density, thickness and friction.

Thickness and density are those of the presets of makers (`geoweave.fabrication.presets`). Moduli differ by a
third between sheets of one kind, and paper and wood are stiffer along the grain than across it.
"""

from __future__ import annotations

from typing import NamedTuple

from geoweave.errors import FieldError
from geoweave.fabrication.presets import PRESETS

__all__ = ["MATERIALS", "SheetMaterial", "material_of"]


class SheetMaterial(NamedTuple):
    """A sheet that strips are cut from."""

    says: str
    """What it is, for people."""
    young: float
    """Young's modulus along a strip, N/mm2."""
    poisson: float
    friction: float
    """Coefficient of friction of the sheet on itself."""
    thickness: float
    """In mm."""
    density: float
    """In g/cm3."""
    source: str
    """Where the modulus and the friction come from."""


def _of_preset(
    preset: str, says: str, young: float, poisson: float, friction: float, source: str
) -> SheetMaterial:
    found = PRESETS[preset]
    return SheetMaterial(says, young, poisson, friction, found.thickness, found.density, source)


MATERIALS = {
    "vellum": _of_preset(
        "bristol-a4",
        "Bristol vellum, 250 g/m2",
        3200.0,
        0.3,
        0.3,
        "geometric mean of 5.4 kN/mm2 along and 1.9 across the machine direction of paperboard (Xia, "
        "Boyce and Parks, Int. J. Solids Struct. 39, 2002); paper on paper 0.3 to 0.6, the least is taken",
    ),
    "birch veneer": _of_preset(
        "veneer-laser",
        "birch veneer, strips along the grain",
        13_900.0,
        0.4,
        0.3,
        "yellow birch at 12 % moisture 13.9 kN/mm2; dry wood on smooth surfaces 0.3 to 0.5, the least is "
        "taken (Wood Handbook, USDA Forest Products Laboratory, 2010, Tables 5-3 and Chapter 5)",
    ),
    "polypropylene": _of_preset(
        "polypropylene-laser",
        "polypropylene homopolymer sheet",
        1450.0,
        0.4,
        0.3,
        "flexural modulus 1.4 to 1.5 kN/mm2 (makeitfrom.com, unfilled PP homopolymer); on itself 0.3 "
        "(tables of plastics give 0.25 to 0.4)",
    ),
}
"""Materials by name: the paper's vellum and birch (Section 5.4), and a plastic that bends often."""


def material_of(name: str) -> SheetMaterial:
    """The material of a name.

    Raises
    ------
    FieldError
        If there is none.

    Examples
    --------
    >>> gw.fabrication.material_of("polypropylene").young  # N/mm2
    1450.0
    >>> gw.fabrication.material_of("granite")
    Traceback (most recent call last):
    geoweave.errors.FieldError: there is no material 'granite'; there are vellum, birch veneer, polypropylene
    """
    if name not in MATERIALS:
        raise FieldError(f"there is no material '{name}'; there are {', '.join(MATERIALS)}")
    return MATERIALS[name]
