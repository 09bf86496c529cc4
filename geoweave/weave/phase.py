"""Whether three families of ribbons are brought to form a kagome (beyond the paper: DEVIATIONS.md, phase)."""

from __future__ import annotations

from typing import Literal, TypeAlias

from geoweave.errors import FieldError

__all__ = ["PHASES", "Phase", "phase_of"]

Phase: TypeAlias = Literal["regular", "free"]
"""Triangles and hexagons where they can be, or each family where it happens to lie, as in the paper."""

PHASES: tuple[Phase, ...] = ("regular", "free")
"""All of them."""

TRIAXIAL = 6
"""The symmetry for which "regular" is the default."""


def phase_of(symmetry: int, phase: Phase | None) -> Phase:
    """The phase that is meant for a symmetry; refuses what there is not.

    Raises
    ------
    FieldError
        If the symmetry is less than 3, there is no such phase, or a regular one is asked for and 3 does not
        divide N.
    """
    if symmetry < 3:
        raise FieldError(f"a weave needs a symmetry of 3 or more, not {symmetry}")
    if phase not in (None, *PHASES):
        raise FieldError(f"there is no phase '{phase}': regular or free")
    if phase == "regular" and symmetry % 3:
        raise FieldError(f"a regular phase needs a symmetry that 3 divides, as 6, not {symmetry}; use free")
    return phase or ("regular" if symmetry == TRIAXIAL else "free")
