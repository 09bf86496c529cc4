"""Where a weave will be hard to make, and how wide its ribbons can be (Sections 5.2 and 6).

The paper notes that its model does nothing about the width of ribbons (footnote 5). This is what a maker
would otherwise find out at the bench: each place with its position and the ribbons that meet there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from geoweave.errors import FieldError
from geoweave.weave.as_cut import AsCut
from geoweave.weave.holes import bare_components, gaps, hanging_ends
from geoweave.weave.places import KINDS, Place
from geoweave.weave.regularity import Regularity
from geoweave.weave.tight_spots import alongside, crowded, knots, near_parallel
from geoweave.weave.validity import violations
from geoweave.weave.weave import Weave

__all__ = ["FORMAT", "VERSION", "Inspection", "Limits", "inspected"]

FORMAT, VERSION = "geoweave-report", 1
"""What the first lines of ``report.json`` say."""

SHARES = (0.95, 0.75, 0.5, 0.25)
"""Shares of the neighbouring crossings for which the report says up to which width they fit."""

STEERED = ("prescribed_singularities", "aligned_deg", "mirror")
"""What the metrics say of what was asked of the field."""


@dataclass(frozen=True)
class Limits:
    """From where on a place is reported.

    Attributes
    ----------
    angle : degrees; ribbons that meet or run alongside each other at less are near parallel
    gap : spacings; a place of the surface farther than this from any ribbon is a hole. In a flat triaxial
        weave no place is farther than 0.5
    short : spacings; three open ribbons or more, no longer than this, that cross each other are a knot
    fitting : share of the neighbouring crossings that fit side by side at the suggested width. Three families
        often cross nearly in one point, and then three ribbons lie on each other: at the width in RibbonSim's
        file of the torus that the authors made half of the neighbouring crossings fit, on their cone all

    Raises
    ------
    FieldError
        If a number is out of range.
    """

    angle: float = 20.0
    gap: float = 1.0
    fitting: float = 0.5
    short: float = 6.0

    def __post_init__(self) -> None:
        for name, value, most in (
            ("angle", self.angle, 90),
            ("gap", self.gap, np.inf),
            ("fitting", self.fitting, 1),
            ("short", self.short, np.inf),
        ):
            if not 0 < value <= most or value == np.inf:
                raise FieldError(f"the limit '{name}' of an inspection is out of range: {value}")


@dataclass(frozen=True, eq=False)
class Inspection:
    """What a maker should know before cutting.

    Attributes
    ----------
    weave : the weave
    limits : from where on a place was reported
    suggested_width : the largest at which the wanted share of the neighbouring crossings fits, in the unit of
        the weave; nothing where no ribbon has two crossings
    widths : (share, width) up to which width a share of the neighbouring crossings fits, in that unit
    share_that_fits : of the neighbouring crossings at the width of the weave, 1 where there are none
    regularity : how regular the weave is
    places : those that will not weave, by kind, the worst first
    violations : rules of a valid weave that it breaks (`geoweave.weave.validity`), nothing for a valid one
    """

    weave: Weave
    limits: Limits
    suggested_width: float | None
    widths: tuple[tuple[float, float], ...]
    share_that_fits: float
    regularity: Regularity
    places: tuple[Place, ...]
    violations: tuple[str, ...]

    @property
    def counts(self) -> dict[str, int]:
        """Number of places of each kind."""
        return {kind: sum(place.kind == kind for place in self.places) for kind in KINDS}

    def document(self) -> dict[str, Any]:
        """The contents of ``report.json``."""
        metrics = self.weave.metrics()
        spacing = metrics["spacing"]
        return {
            "format": FORMAT,
            "version": VERSION,
            "units": self.weave.units,
            "ribbons": metrics["ribbons"],
            "crossings": metrics["crossings"],
            "total_length": metrics["total_length"],
            **({"metres": metrics["metres"]} if "metres" in metrics else {}),
            "spacing": spacing,
            "width": self.weave.width * self.weave.placement.scale,
            "thickness": self.weave.thickness * self.weave.placement.scale,
            "suggested_width": self.suggested_width,
            "share_that_fits": self.share_that_fits,
            "widths_that_fit": [{"share": share, "width": width} for share, width in self.widths],
            "crossing_angle_deg": metrics["crossing_angle_deg"],
            "pattern": metrics["pattern"],
            "alternation": metrics["alternation"],
            "regularity": self.regularity.document(),
            **{key: metrics[key] for key in STEERED if key in metrics},
            "limits": {
                "angle_deg": self.limits.angle,
                "gap": self.limits.gap * spacing,
                "short": self.limits.short * spacing,
                "fitting": self.limits.fitting,
            },
            "violations": list(self.violations),
            "counts": self.counts,
            "kinds": KINDS,
            "places": [
                {
                    "kind": each.kind,
                    "point": list(each.point),
                    "ribbons": list(each.ribbons),
                    "value": each.value,
                }
                for each in self.places
            ],
        }


def inspected(weave: Weave, limits: Limits | None = None) -> Inspection:
    """Look for the places of a weave that will not weave at its width.

    Positions and lengths come in the unit of the weave. Distances are straight ones, to ribbons on the same
    side of a thin wall; holes are found at vertices and middles of faces, to within half an edge.
    """
    asked = limits or Limits()
    unit = weave.placement.scale
    pairs = AsCut.of(weave).neighbours
    widths = [(share, pairs.fitting(share) * unit) for share in SHARES] if len(pairs.widths) else []
    suggested = pairs.fitting(asked.fitting) * unit if widths else None
    fits = float((pairs.widths >= weave.width).mean()) if widths else 1.0
    found = [
        *near_parallel(weave, asked.angle),
        *alongside(weave, asked.angle),
        *crowded(weave, pairs, asked.angle),
        *knots(weave, asked.short),
        *gaps(weave, asked.gap),
        *hanging_ends(weave),
        *bare_components(weave),
    ]
    broken = tuple(violations(weave.ribbons, weave.interlacing.over))
    return Inspection(
        weave, asked, suggested, tuple(widths), fits, Regularity.of(weave), tuple(found), broken
    )
