"""Where a model is looked at from, and the view that is kept for each named model."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geoweave.arrays import Vectors
from geoweave.errors import RenderError


@dataclass(frozen=True)
class View:
    """Where a model is looked at from.

    Attributes
    ----------
    azimuth : degrees turned about the up axis; 0 looks along the second horizontal axis
    elevation : degrees above the horizon
    up : the axis that stands upright, "x", "y" or "z", with a minus sign if it points down
    opening : vertical angle of the lens in degrees; small is nearly parallel
    """

    azimuth: float = 30.0
    elevation: float = 15.0
    up: str = "z"
    opening: float = 14.0

    @property
    def axes(self) -> Vectors:
        """(3, 3) rows: to the right, up in the picture, towards the eye."""
        if self.up.lstrip("-") not in ("x", "y", "z"):
            raise RenderError(
                f"the up axis of a view is x, y or z, perhaps with a minus sign, not '{self.up}'"
            )
        k = "xyz".index(self.up[-1])
        up = np.zeros(3)
        up[k] = -1.0 if self.up.startswith("-") else 1.0
        front = np.zeros(3)
        front[(k + 1) % 3 if k != 1 else 2] = 1.0
        side = np.cross(up, front)
        turn, lift = np.radians(self.azimuth), np.radians(self.elevation)
        level = np.cos(turn) * front + np.sin(turn) * side
        eye = np.cos(lift) * level + np.sin(lift) * up
        right = np.cross(up, level)
        return np.stack([right, np.cross(eye, right), eye])


FROM_ABOVE = View(azimuth=-90.0, elevation=90.0, up="z")
"""Down on the plane z = 0: x to the right, y up."""

VIEWS = {
    "armadillo": View(azimuth=205, elevation=8, up="y"),
    "bunny": View(azimuth=-15, elevation=12, up="y"),
    "bumpy-box": View(azimuth=28, elevation=24, up="z"),
    "camel": View(azimuth=68, elevation=8, up="y"),
    "cone": View(azimuth=0, elevation=38, up="z"),
    "cow": View(azimuth=50, elevation=12, up="y"),
    "crown": View(azimuth=20, elevation=30, up="z"),
    "fertility": View(azimuth=0, elevation=10, up="y"),
    "genus-4": View(azimuth=20, elevation=35, up="z"),
    "icosahedron": View(azimuth=14, elevation=16, up="z"),
    "rocker-arm": View(azimuth=225, elevation=38, up="x"),
    "rocker-like": View(azimuth=25, elevation=28, up="y"),
    "saddle": View(azimuth=12, elevation=48, up="z"),
    "schwarz-p": View(azimuth=30, elevation=22, up="z"),
    "sphere": View(azimuth=20, elevation=25, up="z"),
    "spot": View(azimuth=128, elevation=12, up="y"),
    "torus": View(azimuth=-38, elevation=-34, up="z"),
    "vessel": View(azimuth=60, elevation=12, up="z"),
}
"""How each named model is looked at, standing upright."""


def view_of(view: View | str) -> View:
    """Look a view up if it is given by the name of a model in `VIEWS`.

    Raises
    ------
    RenderError
        If no view of that name is kept.
    """
    if isinstance(view, View):
        return view
    if view not in VIEWS:
        raise RenderError(f"no view is kept for '{view}': give a View, or one of {', '.join(VIEWS)}")
    return VIEWS[view]
