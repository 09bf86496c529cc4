"""A weave left to physics: relaxed to the shape it will take (Section 5.2, Appendix E.2).

The file ``relaxed.json`` is that of ``weave.json`` with the ribbons where they come to rest.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from geoweave.arrays import Vectors
from geoweave.files import replacing
from geoweave.rods.crossing_forces import FRICTION, ContactForces, contact_forces
from geoweave.rods.curved_weave import StripKind, curved
from geoweave.rods.departure import Departure, departure, held
from geoweave.rods.equilibrium import Equilibrium, Step, Stepping
from geoweave.rods.rods import Rods
from geoweave.rods.slid_weave import SlidWeave, elastic_rods, slide
from geoweave.rods.slide_and_relax import ROUNDS, Springs, relax_rods
from geoweave.rods.strip_fitting import CurvedStep, CurvedStrips
from geoweave.rods.weave_file import at_rest, crossings_at_rest
from geoweave.weave import Weave

__all__ = ["Relaxed", "relax", "relaxed_weave", "vertex_normals"]


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
    curving : how curved strips were chosen, if they were (`optimal_strips`)
    springs : stiffnesses of the contacts

    Examples
    --------
    >>> rest = gw.relaxed_weave(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8))
    >>> rest.document()["format"], len(rest.metrics()["worst"]["point"])
    ('geoweave-weave', 3)
    """

    weave: Weave
    designed: Rods
    slid: Equilibrium
    left: Equilibrium
    departure: Departure
    seconds: dict[str, float]
    curving: CurvedStrips | None = None
    springs: Springs = field(default_factory=Springs)

    @cached_property
    def forces(self) -> ContactForces:
        """The force at each contact of `left`."""
        return contact_forces(self.left.rods, self.springs)

    @property
    def converged(self) -> bool:
        """Whether the forces balance after sliding and after relaxing; `curving` says it of the strips."""
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
            "forces": self.forces.document(),
            **_curved_metrics(self),
        }

    def document(self) -> dict[str, Any]:
        """The contents of ``relaxed.json``: arc lengths along ribbons are what a maker measures."""
        rods, placement = self.left.rods, self.weave.placement
        points = placement.undo(self.departure.points)
        found = at_rest(self.weave.document(), rods, points, self._normals(), placement.scale, self.forces)
        return found | {"metrics": found["metrics"] | {"relax": self.metrics()}}

    def fasten(self, friction: float = FRICTION) -> list[dict[str, Any]]:
        """The crossings that need glue or a rivet, the greatest need first; the others hold by friction.

        They are the fewest that suffice for this shape at rest (`ContactForces.fasten`).

        Parameters
        ----------
        friction : coefficient of friction between two ribbons
        """
        rods, unit = self.left.rods, self.weave.placement.scale**2 / self.left.rods.material.young
        layout, names = rods.layout, self.weave.names
        number = crossings_at_rest(rods.contacts)
        found = []
        for contact in self.forces.fasten(friction).tolist():
            pair, share = rods.contacts.segments[contact], rods.contacts.places[contact]
            ends = self.departure.points[layout.ends[pair]]
            place = (ends[:, 0] + share[:, None] * (ends[:, 1] - ends[:, 0])).mean(axis=0)
            found.append(
                {
                    "crossing": number[contact],
                    "ribbons": [names[r] for r in layout.rod_of_segment[pair]],
                    "point": self.weave.placement.undo(place[None])[0].tolist(),
                    **self.forces.of_contact(contact, unit)["force"],
                }
            )
        return found

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


def _curved_metrics(found: Relaxed) -> dict[str, Any]:
    """What the report says of strips that are cut curved; nothing of straight ones."""
    rods = found.left.rods
    if not rods.natural.any():
        return {}
    bent = np.abs(rods.natural) / rods.spans * rods.joint_widths
    said: dict[str, Any] = {"kind": "designed", "sharpest": float(bent.max())}
    if found.curving is not None:
        history = [vars(step) for step in found.curving.steps]
        said |= {
            "kind": found.curving.kind,
            "converged": found.curving.converged,
            "ending": found.curving.ending,
        }
        said |= {"history": history}
    return {"curved_strips": said}


def vertex_normals(rods: Rods) -> Vectors:
    """(V, 3) unit thickness directions at the vertices, the mean of those of their segments."""
    sums = np.zeros_like(rods.points)
    for end in (0, 1):
        np.add.at(sums, rods.layout.ends[:, end], rods.directors)
    return np.asarray(sums / np.linalg.norm(sums, axis=1)[:, None])


def relax(
    weave: SlidWeave,
    *,
    springs: Springs | None = None,
    stepping: Stepping | None = None,
    gravity: ArrayLike | None = None,
    callback: Callable[[Step], None] | None = None,
) -> Relaxed:
    """Find the shape in which a weave comes to rest when nothing holds it to its surface (Appendix E.2).

    Strips are cut to their lengths on the surface, so nothing is stretched at the start, unless `curved`
    chose other ones. See `relax_rods`
    for what is minimised, and for rods that are no weave.

    Parameters
    ----------
    weave : after `slide`
    springs, stepping : as of `relax_rods`
    gravity : (3,) acceleration; it needs a fixed boundary to stand on
    callback : called with every `Step`

    Raises
    ------
    RodError
        If a parameter is out of range.

    Examples
    --------
    >>> slid = gw.slide(gw.elastic_rods(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)))
    >>> rest = gw.relax(slid)
    >>> rest.left.steps[-1].energy < rest.left.steps[0].energy
    True
    """
    clock = time.perf_counter()
    start, stiff = weave.cut, springs or Springs()
    left = relax_rods(
        start, springs=stiff, stepping=stepping, fixed=weave.fixed, gravity=gravity, callback=callback
    )
    after = time.perf_counter()
    away = departure(left.rods, start, weave.weave.mesh, placed=bool(weave.fixed.any()))
    seconds = {
        "slide": weave.seconds,
        "relax": after - clock,
        "departure": time.perf_counter() - after,
    }
    if weave.curving is not None:
        seconds["curve"] = weave.curving_seconds
    return Relaxed(weave.weave, weave.designed, weave.slid, left, away, seconds, weave.curving, stiff)


def relaxed_weave(
    weave: Weave,
    *,
    springs: Springs | None = None,
    rounds: int = ROUNDS,
    stepping: Stepping | None = None,
    fixed_boundary: bool = False,
    gravity: ArrayLike | None = None,
    strips: StripKind = "straight",
    callback: Callable[[str, Step | CurvedStep], None] | None = None,
) -> Relaxed:
    """Slide the ribbons of a weave on its surface, then find the shape in which it comes to rest.

    This is `elastic_rods`, `slide`, `curved` and `relax` in one call.

    Parameters
    ----------
    weave : as designed
    springs : stiffnesses of Appendix E
    rounds : of sliding
    stepping : numbers of each minimisation
    fixed_boundary : hold the ends of ribbons that lie on the boundary
    gravity : (3,) acceleration; it needs a fixed boundary to stand on
    strips : how they are cut: "straight" as in the paper, "designed", "optimal" or "holding" (`curved`)
    callback : called with "slide", "curve" or "relax" and each step

    Raises
    ------
    RodError
        If a ribbon cannot be a rod, or a parameter is out of range.

    Examples
    --------
    >>> rest = gw.relaxed_weave(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8))
    >>> rest.departure.to_surface.mean < 0.05
    True
    """

    def told(stage: str) -> Callable[[Step | CurvedStep], None] | None:
        return None if callback is None else lambda step: callback(stage, step)

    slid = slide(
        elastic_rods(weave),
        springs=springs,
        rounds=rounds,
        stepping=stepping,
        fixed_boundary=fixed_boundary,
        callback=told("slide"),
    )
    bent = curved(slid, strips, springs=springs, callback=told("curve"))
    return relax(bent, springs=springs, stepping=stepping, gravity=gravity, callback=told("relax"))
