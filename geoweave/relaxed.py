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

from geoweave.arrays import Flags, Scalars, Vectors
from geoweave.departure import Departure, departure, held
from geoweave.equilibrium import Equilibrium, Step, Stepping
from geoweave.output import replacing
from geoweave.relaxation import ROUNDS, Springs, relax, slide
from geoweave.ribbon_rods import ends_on, rods_of_ribbons
from geoweave.rods import Rods
from geoweave.woven import Weave

__all__ = ["Relaxed", "boundary_ends", "relaxed_weave", "rods_of_weave"]


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
    departure : how far `left` is from the surface and from `slid`, after the best rigid fit
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
        base, rods = self.weave.document(), self.left.rods
        layout, place, unit = rods.layout, self.weave.placement.undo, self.weave.placement.scale
        points, normals, along = place(self.departure.points), self._normals(), _arclengths(rods)
        for ribbon in base["ribbons"]:
            r = ribbon["id"]
            own = slice(layout.offsets[r], layout.offsets[r + 1])
            segments = slice(layout.segment_offsets[r], layout.segment_offsets[r + 1])
            ribbon["length"] = float(rods.rest[segments].sum() * unit)
            ribbon["points"], ribbon["normals"] = points[own].tolist(), normals[own].tolist()
        contacts = rods.contacts
        assert contacts.group is not None
        known, first = np.unique(contacts.group, return_index=True)
        crossings: list[dict[str, Any]] = []
        for contact, x in sorted(zip(known.tolist(), first.tolist(), strict=True), key=lambda pair: pair[1]):
            if contact < 0:
                continue
            pair, share = contacts.segments[contact], contacts.places[contact]
            ends = layout.ends[pair]
            both = points[ends[:, 0]] + share[:, None] * (points[ends[:, 1]] - points[ends[:, 0]])
            cosine = abs(float(rods.tangents[pair[0]] @ rods.tangents[pair[1]]))
            ribbons = layout.rod_of_segment[pair].tolist()
            over = int(contacts.over[contact])
            crossings.append(
                base["crossings"][x]
                | {
                    "id": len(crossings),
                    "ribbons": ribbons,
                    "arclength": ((along[pair] + share * rods.rest[pair]) * unit).tolist(),
                    "point": both.mean(axis=0).tolist(),
                    "angle_deg": float(np.degrees(np.arccos(min(cosine, 1.0)))),
                    "over": ribbons[over],
                    "over_index": over,
                }
            )
        base["crossings"] = crossings
        base["metrics"] |= {"relax": self.metrics()}
        return base

    def save(self, path: str | PathLike[str]) -> None:
        """Write ``relaxed.json``, whole or not at all."""
        text = json.dumps(self.document(), allow_nan=False)
        with replacing(path) as temporary:
            temporary.write_text(text + "\n", encoding="utf-8")

    def _normals(self) -> Vectors:
        """(V, 3) unit thickness directions at the vertices, turned with the rigid fit."""
        rods = self.left.rods
        sums = np.zeros_like(rods.points)
        for end in (0, 1):
            np.add.at(sums, rods.layout.ends[:, end], rods.directors)
        # The fit is rigid, so it takes centred vertices to centred vertices.
        here, there = rods.points - rods.points.mean(axis=0), self.departure.points
        u, _, v = np.linalg.svd(here.T @ (there - there.mean(axis=0)))
        turned = sums @ (u @ v)
        return np.asarray(turned / np.linalg.norm(turned, axis=1)[:, None])


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
    away = departure(left.rods, start, weave.mesh)
    seconds = {"slide": between - clock, "relax": after - between, "departure": time.perf_counter() - after}
    return Relaxed(weave, rods, slid, left, away, seconds)


def _arclengths(rods: Rods) -> Scalars:
    """(S,) rest length from the start of its rod to the start of each segment."""
    before = np.cumsum(rods.rest) - rods.rest
    return np.asarray(before - before[rods.layout.segment_offsets[:-1]][rods.layout.rod_of_segment])
