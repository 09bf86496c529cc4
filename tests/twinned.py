"""Small weaves, designed and at rest, and the patterns exported from them, for the tests of twins."""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from geoweave.fabrication.flattening import pattern_of
from geoweave.fabrication.pattern import Pattern
from geoweave.models import shapes
from geoweave.rods.weave_at_rest import relaxed_weave
from geoweave.twin.pattern_surface import PatternSurface
from geoweave.twin.twin import Twin, assembled
from geoweave.weave.design import weave_pattern

SHAPES = {
    "cone": (lambda: shapes.cone(faces=1500), 12, "regular"),
    "sphere": (lambda: shapes.sphere(600), 16, "regular"),
    "saddle": (lambda: shapes.saddle(faces=1500), 20, "regular"),
    "torus": (lambda: shapes.torus(faces=1500), 20, "free"),
}
"""The surface, how many ribbons, and their phase: few regular ribbons do not hold a torus in shape."""


class Woven(NamedTuple):
    """A weave of which there are patterns."""

    designed: dict[str, Any]
    relaxed: dict[str, Any]
    genus: int


@cache
def woven(name: str) -> Woven:
    mesh, ribbons, phase = SHAPES[name]
    weave = weave_pattern(mesh(), ribbons=ribbons, phase=phase).sized(200.0)
    return Woven(weave.document(), relaxed_weave(weave).document(), weave.mesh.genus)


@cache
def pattern(name: str, state: str = "relaxed") -> Pattern:
    """What is exported, and nothing else: it is written and read back."""
    exported = pattern_of(getattr(woven(name), state)).document()
    assert not holds_places(exported)
    return Pattern.from_document(exported)


@cache
def twin(name: str, state: str = "relaxed", *, mirrored: bool = False) -> Twin:
    return assembled(pattern(name, state), anyway=True, mirrored=mirrored)


def holds_places(value: Any) -> bool:
    """Whether a document holds three numbers in a row, as a place in space is."""
    if isinstance(value, dict):
        return any(holds_places(each) for each in value.values())
    if isinstance(value, list):
        numbers = all(isinstance(each, int | float) for each in value)
        return (numbers and len(value) == 3) or any(holds_places(each) for each in value)
    return False


def inner(surface: PatternSurface) -> list[int]:
    """Crossings whose two strips both go on to both sides."""
    return np.flatnonzero((surface.partner.reshape(-1, 4) >= 0).all(axis=1)).tolist()
