"""A weave left to physics: slid on its surface, then relaxed to the shape it will take (Section 5.2, E).

The file ``relaxed.json`` is that of ``weave.json`` with the ribbons where they come to rest.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geoweave.arrays import Flags, Vectors
from geoweave.files import replacing
from geoweave.rods.departure import Departure, departure, held
from geoweave.rods.equilibrium import Equilibrium, Step, Stepping
from geoweave.rods.from_ribbons import ends_on, rods_of_ribbons
from geoweave.rods.rods import Rods
from geoweave.rods.slide_and_relax import ROUNDS, Springs, relax, slide
from geoweave.rods.weave_file import at_rest
from geoweave.weave import Weave

__all__ = ["Relaxed", "boundary_ends", "relaxed_weave", "rods_of_weave", "vertex_normals"]


@dataclass(frozen=True, eq=False)
class Relaxed:
    """A weave and the shape that it takes when it is left to itself.

    Lengths are those of the weave's mesh, at bounding radius 1; `metrics` and `document` give them in its
    units.

    Attributes
    ----------
    weave : as designed
    designed : its ribbons as rods, on the surface
    slid : after sliding on the surface to release elastic strain (E.1)
    left : after relaxing with nothing that holds them to the surface (E.2)
    departure : how far `left` is from the surface and from `slid`, after the best rigid fit unless a boundary
        holds it
    seconds : wall-clock seconds of each stage
    """

    weave: Weave
    designed: Rods
    slid: Equilibrium
    left: Equilibrium
    departure: Departure
    seconds: dict[str, float]

    @property
    def converged(self) -> bool:
        """Whether the forces balance after sliding and after relaxing."""
        return self.slid.converged and self.left.converged

    def metrics(self) -> dict[str, Any]:
        """What the report says of the relaxation: shares of the bounding diagonal, energies by term."""
        away, inside = self.departure, held(self.left.rods)
        far = away.distance / away.diagonal
        worst = int(np.flatnonzero(inside)[np.argmax(far[inside])]) if inside.any() else away.worst
        owner = int(self.left.rods.layout.rod_of_vertex[worst])
        before, after = self.left.steps[0], self.left.steps[-1]
        return {
            "converged": self.converged,
            "energy_before": before.energy,
            "energy_after": after.energy,
            "energies_before": before.energies,
            "energies_after": after.energies,
            "hausdorff": away.to_surface.largest,
            "mean": away.to_surface.mean,
            "rms": away.to_surface.rms,
            "hausdorff_held": float(far[worst]),
            "from_design": {"mean": away.from_design.mean, "hausdorff": away.from_design.largest},
            "worst": {
                "point": self.weave.placement.undo(away.points[[worst]])[0].tolist(),
                "ribbon": self.weave.names[owner],
                "distance": float(away.distance[worst] * self.weave.placement.scale),
            },
            "steps": {"slide": len(self.slid.steps), "relax": len(self.left.steps)},
            "ending": self.left.ending,
        }

    def document(self) -> dict[str, Any]:
        """The contents of ``relaxed.json``: arc lengths along ribbons are what a maker measures."""
        rods, placement = self.left.rods, self.weave.placement
        points = placement.undo(self.departure.points)
        found = at_rest(self.weave.document(), rods, points, self._normals(), placement.scale)
        return found | {"metrics": found["metrics"] | {"relax": self.metrics()}}

    def save(self, path: str | PathLike[str]) -> None:
        """Write ``relaxed.json``, whole or not at all."""
        text = json.dumps(self.document(), allow_nan=False)
        with replacing(path) as temporary:
            temporary.write_text(text + "\n", encoding="utf-8")

    def _normals(self) -> Vectors:
        """(V, 3) unit thickness directions at the vertices, turned with the rigid fit."""
        rods = self.left.rods
        # The fit is rigid, so it takes centred vertices to centred vertices.
        here, there = rods.points - rods.points.mean(axis=0), self.departure.points
        u, _, v = np.linalg.svd(here.T @ (there - there.mean(axis=0)))
        return np.asarray(vertex_normals(rods) @ (u @ v))


def vertex_normals(rods: Rods) -> Vectors:
    """(V, 3) unit thickness directions at the vertices, the mean of those of their segments."""
    sums = np.zeros_like(rods.points)
    for end in (0, 1):
        np.add.at(sums, rods.layout.ends[:, end], rods.directors)
    return np.asarray(sums / np.linalg.norm(sums, axis=1)[:, None])


def rods_of_weave(weave: Weave) -> Rods:
    """Make elastic rods of a weave's ribbons, in the unit of its mesh."""
    return rods_of_ribbons(weave.ribbons, weave.interlacing.over, weave.width, weave.thickness)


def boundary_ends(weave: Weave, rods: Rods) -> Flags:
    """(V,) ends of ribbons that lie on the boundary of the surface."""
    rim = weave.mesh.vertices[weave.mesh.boundary_vertices]
    if not len(rim):
        return np.zeros(rods.layout.vertices, dtype=bool)
    return ends_on(rods, rim, weave.mesh.mean_edge)


def relaxed_weave(
    weave: Weave,
    *,
    springs: Springs | None = None,
    rounds: int = ROUNDS,
    stepping: Stepping | None = None,
    fixed_boundary: bool = False,
    gravity: ArrayLike | None = None,
    callback: Callable[[str, Step], None] | None = None,
) -> Relaxed:
    """Slide the ribbons of a weave on its surface, then find the shape in which it comes to rest.

    Parameters
    ----------
    weave : as designed
    springs : stiffnesses of Appendix E
    rounds : of sliding
    stepping : numbers of each minimisation
    fixed_boundary : hold the ends of ribbons that lie on the boundary
    gravity : (3,) acceleration; it needs a fixed boundary to stand on
    callback : called with "slide" or "relax" and each step

    Raises
    ------
    RodError
        If a ribbon cannot be a rod, or a parameter is out of range.
    """
    clock = time.perf_counter()
    rods = rods_of_weave(weave)
    fixed = boundary_ends(weave, rods) if fixed_boundary else None

    def told(stage: str) -> Callable[[Step], None] | None:
        return None if callback is None else lambda step: callback(stage, step)

    slid = slide(
        rods,
        weave.mesh,
        springs=springs,
        rounds=rounds,
        stepping=stepping,
        fixed=fixed,
        callback=told("slide"),
    )
    between = time.perf_counter()
    # What a strip is cut to is its length on the surface, so nothing is stretched at the start.
    start = replace(slid.rods, rest=slid.rods.lengths)
    left = relax(
        start, springs=springs, stepping=stepping, fixed=fixed, gravity=gravity, callback=told("relax")
    )
    after = time.perf_counter()
    away = departure(left.rods, start, weave.mesh, placed=fixed is not None and bool(fixed.any()))
    seconds = {"slide": between - clock, "relax": after - between, "departure": time.perf_counter() - after}
    return Relaxed(weave, rods, slid, left, away, seconds)
