"""The surface that a weave was designed on, in the place and size of the weave."""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Vectors
from geoweave.errors import RodError
from geoweave.surface import TriMesh, closest_points, triangle_tree
from geoweave.weave import Weave

__all__ = ["surface_of_weave"]

AWAY = 0.05
"""A surface is not that of a weave if ribbons are farther from it in the mean, at bounding radius 1."""


def surface_of_weave(surface: TriMesh, weave: Weave, points: Vectors) -> TriMesh:
    """Take the surface that was woven to the place and size of a weave's mesh.

    The surface comes in the size in which the weave is written, or in the size in which it was woven:
    `Weave.sized` scales a weave about the origin, and the surface is then scaled in the same way.

    Parameters
    ----------
    surface : the surface that was woven
    weave : the weave
    points : (P, 3) points of its ribbons, in the place and size of the weave's mesh

    Raises
    ------
    RodError
        If the surface lies elsewhere than the ribbons.
    """
    extent = float(np.ptp(weave.mesh.vertices, axis=0).max()) * weave.placement.scale
    sizes = (1.0, extent / float(np.ptp(surface.vertices, axis=0).max()))
    found: list[tuple[float, TriMesh]] = []
    for size in sizes:
        placed = TriMesh(weave.placement.apply(size * surface.vertices), surface.faces)
        nearest, _ = closest_points(triangle_tree(placed.vertices[placed.faces]), points)
        found.append((float(np.linalg.norm(points - nearest, axis=1).mean()), placed))
        if found[-1][0] <= AWAY:
            return placed
    away = min(away for away, _ in found)
    raise RodError(
        f"the surface is {away:.2g} bounding radii from the ribbons in the mean; "
        "give the surface that was woven, or none"
    )
