"""Rows of the table of ``geoweave weave`` on what was asked of the singularities and of the field."""

from __future__ import annotations

from typing import Any

from geoweave.wording import counted


def prescribed(found: dict[str, Any] | None, symmetry: int) -> list[tuple[str, str]]:
    """Whether the finished field has the prescribed singularities; if not, where it differs first."""
    if found is None:
        return []
    if found["kept"]:
        return [("  prescribed", "all kept by the finished field, and no other")]
    places = found["displaced"]
    first, where = places[0], ", ".join(f"{x:.4g}" for x in places[0]["point"])
    other = f"index {first['found']}/{symmetry} in place of {first['index']}/{symmetry}"
    return [
        (
            "  prescribed",
            f"the finished field differs at {counted(len(places), 'point')}, first at ({where}): {other}",
        )
    ]


def mirrored(found: dict[str, Any] | None) -> list[tuple[str, str]]:
    """How nearly the finished field is its own mirror image, and the surface."""
    if found is None:
        return []
    normal = ", ".join(f"{x:.2f}" for x in found["normal"])
    said = f"the field is {found['field_deg']:.1f} degrees from its image in the mean"
    return [("  mirror", f"across ({normal}): {said}, the surface {found['surface']:.2%} of its size")]


def aligned(angle: float | None) -> list[tuple[str, str]]:
    """How well the nearest family follows what it was asked to."""
    return (
        [] if angle is None else [("  aligned", f"{angle:.1f} degrees from the nearest family in the mean")]
    )
