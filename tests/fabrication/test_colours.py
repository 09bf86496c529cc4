"""Layers are told apart by colour, families on paper too, and wrong colours are refused."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest

from geoweave.errors import FieldError
from geoweave.fabrication.colours import FAMILIES, Colours, ink, mixed
from geoweave.fabrication.strip_figures import ROLES, Figure, Role


def figure(role: Role, family: int = 0) -> Figure:
    return Figure(role, (np.zeros((2, 2)),), False, family, pen=0.3)


def test_a_laser_sees_one_colour_per_layer() -> None:
    colours = Colours(score="#123456")
    seen: dict[str, set[str | None]] = {}
    for role in get_args(Role):
        look = ink(figure(role), colours)
        if look is not None:
            seen.setdefault(ROLES[role], set()).add(look.stroke)
            assert look.fill is None or role == "solid"
    assert seen == {
        "cut": {"#ff0000"},
        "hole": {"#ff00ff"},
        "score": {"#123456"},
        "guide": {"#009a3e"},
        "label": {"#000000"},
    }


def test_paper_shows_families_and_over_differs_from_under() -> None:
    colours = Colours("paper")
    for role in get_args(Role):
        assert ink(figure(role), colours) is not None
    for role in ("ground", "band", "solid", "label"):
        assert ink(figure(role, 0), colours) != ink(figure(role, 1), colours)
        assert ink(figure(role, 0), colours) == ink(figure(role, len(FAMILIES)), colours)
    hollow, solid = (ink(figure(role), colours) for role in ("hollow", "solid"))
    assert hollow is not None
    assert solid is not None
    assert (hollow.fill, solid.fill) == ("#ffffff", solid.stroke)


def test_pens_are_those_of_the_letters() -> None:
    for style in ("laser", "paper"):
        look = ink(figure("label"), Colours(style))
        assert look is not None
        assert look.width == 0.3


def test_mixing() -> None:
    assert mixed("#ffffff", "#000000", 0.5) == "#808080"
    assert mixed("#3f7d8c", "#ffffff", 1.0) == "#3f7d8c"


def test_refusals() -> None:
    with pytest.raises(FieldError, match="#rrggbb"):
        Colours(cut="red")
    with pytest.raises(FieldError, match="give each its own"):
        Colours(cut="#0000FF")
    with pytest.raises(FieldError, match="'laser' or 'paper'"):
        Colours("wood")  # type: ignore[arg-type]
    with pytest.raises(FieldError, match="at least one"):
        Colours(families=())
