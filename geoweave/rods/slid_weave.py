"""A weave as elastic rods, slid on its surface to release strain (Section 5.2, Appendix E.1)."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from geoweave.arrays import Flags, Vectors
from geoweave.errors import RodError
from geoweave.rods.equilibrium import Equilibrium, Step, Stepping
from geoweave.rods.from_ribbons import ends_on, rods_of_ribbons
from geoweave.rods.rods import DERIVED, Rods
from geoweave.rods.slide_and_relax import ROUNDS, Springs, slide_rods
from geoweave.rods.strip_fitting import CurvedStrips
from geoweave.surface import TriMesh, closest_points, triangle_tree
from geoweave.weave import Weave

__all__ = ["ElasticWeave", "SlidWeave", "boundary_ends", "elastic_rods", "slide", "surface_of_weave"]


@dataclass(frozen=True, eq=False)
class ElasticWeave:
    """A weave whose ribbons are elastic rods, as `elastic_rods` makes it.

    Attributes
    ----------
    weave : as designed
    rods : its ribbons, in the unit of the weave's mesh

    Examples
    --------
    >>> woven = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)
    >>> made = gw.elastic_rods(woven)
    >>> len(made.rods) == len(made.weave.names)
    True
    """

    weave: Weave
    rods: Rods


@dataclass(frozen=True, eq=False)
class SlidWeave:
    """A weave after its ribbons slid on their surface (Appendix E.1), as `slide` makes it.

    Attributes
    ----------
    weave : as designed
    designed : its ribbons as rods, as designed
    slid : where they slid to
    fixed : (V,) vertices that a boundary holds, all False if it does not
    seconds : wall-clock seconds of sliding
    cut : the strips, in the shape that the ribbons slid to: straight ones as long as the ribbons there,
        unless `curved` chose others
    curving : how they were chosen, if they were (`optimal_strips`)
    curving_seconds : wall-clock seconds of that

    Examples
    --------
    >>> slid = gw.slide(gw.elastic_rods(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)))
    >>> slid.slid.energies["geodesic curvature"] < slid.slid.steps[0].energies["geodesic curvature"]
    True
    """

    weave: Weave
    designed: Rods
    slid: Equilibrium
    fixed: Flags
    seconds: float
    cut: Rods = DERIVED
    curving: CurvedStrips | None = None
    curving_seconds: float = 0.0

    def __post_init__(self) -> None:
        if self.cut is DERIVED:
            rods = self.slid.rods
            object.__setattr__(self, "cut", replace(rods, rest=rods.lengths))


AWAY = 0.05
"""A surface is not that of a weave if ribbons are farther from it in the mean, at bounding radius 1."""


def elastic_rods(weave: Weave, *, width: float | None = None, thickness: float | None = None) -> ElasticWeave:
    """Make elastic rods of the ribbons of a weave (Section 5.2, Appendix E).

    Ribbons are cut into equal segments, a fifth of their spacing long. Their thickness directions are the
    normals of the surface, and they are as long at rest as they are now.

    Parameters
    ----------
    weave : as designed
    width, thickness : of a ribbon, in the unit in which the weave is written (`Weave.sized`); those of the
        weave if not given

    Raises
    ------
    RodError
        If a ribbon is too short for a segment, or not as wide as thick.
    FieldError
        If a number is not positive.

    Examples
    --------
    >>> woven = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)
    >>> made = gw.elastic_rods(woven, width=0.06, thickness=0.003)
    >>> bool(abs(made.rods.widths * woven.placement.scale - 0.06).max() < 1e-12)
    True
    """
    if width is not None or thickness is not None:
        weave = weave.sized(width=width, thickness=thickness)
    rods = rods_of_ribbons(weave.ribbons, weave.interlacing.over, weave.width, weave.thickness)
    return ElasticWeave(weave, rods)


def boundary_ends(weave: Weave, rods: Rods) -> Flags:
    """(V,) ends of ribbons that lie on the boundary of the surface."""
    rim = weave.mesh.vertices[weave.mesh.boundary_vertices]
    if not len(rim):
        return np.zeros(rods.layout.vertices, dtype=bool)
    return ends_on(rods, rim, weave.mesh.mean_edge)


def slide(
    weave: ElasticWeave,
    surface: TriMesh | None = None,
    *,
    springs: Springs | None = None,
    rounds: int = ROUNDS,
    stepping: Stepping | None = None,
    fixed_boundary: bool = False,
    callback: Callable[[Step], None] | None = None,
) -> SlidWeave:
    """Let the ribbons of a weave slide on their surface to release elastic strain (Appendix E.1).

    See `slide_rods` for what is minimised.

    Parameters
    ----------
    weave : its ribbons as rods
    surface : the one that was woven, in the size in which it was or in that of the weave (`Weave.sized`);
        the mesh of the weave if not given
    springs, rounds, stepping : as of `slide_rods`
    fixed_boundary : hold the ends of ribbons that lie on the boundary, here and in `relax`
    callback : called with every `Step`

    Raises
    ------
    RodError
        If the surface lies elsewhere than the weave, or a parameter is out of range.

    Examples
    --------
    >>> surface = gw.shapes.cone(faces=400)
    >>> slid = gw.slide(gw.elastic_rods(gw.weave_pattern(surface, ribbons=8)), surface)
    >>> slid.slid.converged
    True
    """
    clock = time.perf_counter()
    woven, rods = weave.weave, weave.rods
    fixed = boundary_ends(woven, rods) if fixed_boundary else np.zeros(rods.layout.vertices, dtype=bool)
    slid = slide_rods(
        rods,
        woven.mesh if surface is None else surface_of_weave(surface, woven, rods.points),
        springs=springs,
        rounds=rounds,
        stepping=stepping,
        fixed=fixed,
        callback=callback,
    )
    return SlidWeave(woven, rods, slid, fixed, time.perf_counter() - clock)


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
