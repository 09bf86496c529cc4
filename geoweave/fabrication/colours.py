"""Colours of figures: those that tell a laser cutter what to do, or those of the families on paper."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal, NamedTuple

from geoweave.errors import FieldError
from geoweave.fabrication.strip_figures import ROLES, Figure

__all__ = ["FAMILIES", "Colours", "Ink", "ink", "mixed"]

FAMILIES = ("#3f7d8c", "#d9a441", "#a8516a", "#5b6a99", "#8aa05a")
"""Colours of the families of ribbons, as in the pictures; more families begin again."""

INK = "#22262b"

GROUND, BAND, WRITING = 0.16, 0.42, 0.62
"""How strong a family's colour is on its own strip, where it lies on another one, and in writing."""


@dataclass(frozen=True)
class Colours:
    """Colours as ``#rrggbb``.

    Attributes
    ----------
    style : "laser" draws every layer in its one colour and fills nothing but marks; "paper" draws families
        in their colours
    cut, hole, score, guide, label : of the layers of a laser, by default the usual ones
    families : of the families, on paper

    Raises
    ------
    FieldError
        If one is not such a colour, or two layers of a laser share theirs.
    """

    style: Literal["laser", "paper"] = "laser"
    cut: str = "#ff0000"
    hole: str = "#ff00ff"
    score: str = "#0000ff"
    guide: str = "#009a3e"
    label: str = "#000000"
    families: tuple[str, ...] = FAMILIES

    def __post_init__(self) -> None:
        if self.style not in ("laser", "paper"):
            raise FieldError(f"the style of a drawing is 'laser' or 'paper', not '{self.style}'")
        layers = (self.cut, self.hole, self.score, self.guide, self.label)
        for colour in (*layers, *self.families):
            if not re.fullmatch("#[0-9a-fA-F]{6}", colour):
                raise FieldError(f"a colour is written as #rrggbb, not '{colour}'")
        if not self.families:
            raise FieldError("at least one colour of a family is needed")
        if len({colour.lower() for colour in layers}) < len(layers):
            raise FieldError("a laser tells layers apart by their colours; give each its own")

    def of_family(self, family: int) -> str:
        """Colour of a family."""
        return self.families[family % len(self.families)]


class Ink(NamedTuple):
    """How a figure is drawn."""

    stroke: str | None
    width: float
    """Of the line, mm."""
    fill: str | None


def ink(figure: Figure, colours: Colours) -> Ink | None:
    """How a figure is drawn, None if it is left out."""
    role = figure.role
    if colours.style == "laser":
        colour = {
            "cut": colours.cut,
            "hole": colours.hole,
            "score": colours.score,
            "guide": colours.guide,
            "label": colours.label,
        }.get(ROLES[role])
        if colour is None:
            return None
        return Ink(colour, figure.pen or 0.1, colour if role == "solid" else None)
    family = colours.of_family(figure.family)
    dark = mixed(family, INK, WRITING)
    if role == "ground":
        return Ink(None, 0.0, mixed(family, "#ffffff", GROUND))
    if role == "band":
        return Ink(None, 0.0, mixed(family, "#ffffff", BAND))
    if role in ("label", "name"):
        return Ink(INK if role == "name" else dark, figure.pen, None)
    return {
        "outline": Ink(INK, 0.2, None),
        "fold": Ink(INK, 0.12, None),
        "under": Ink(dark, 0.18, None),
        "over": Ink(dark, 0.14, None),
        "heading": Ink(dark, 0.16, None),
        "nick": Ink(INK, 0.12, None),
        "hole": Ink(INK, 0.15, "#ffffff"),
        "hollow": Ink(dark, 0.22, "#ffffff"),
        "solid": Ink(dark, 0.22, dark),
    }[role]


def mixed(colour: str, other: str, share: float) -> str:
    """Mix a share of a colour with the rest of another one."""
    parts = (
        round(share * int(colour[k : k + 2], 16) + (1 - share) * int(other[k : k + 2], 16)) for k in (1, 3, 5)
    )
    return "#" + "".join(f"{part:02x}" for part in parts)
