"""From a surface to a weave: cover, foliation, ribbons, crossings, over and under (Sections 5.1 and 5.2)."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np

from geoweave import interlacing
from geoweave.arrays import Indices, Scalars, frozen
from geoweave.cover import Cover, branched_cover
from geoweave.curves import geodesic_curvature
from geoweave.errors import FieldError
from geoweave.geodesic import INTEGRABLE_END, geodesic_field, sharpening_schedule
from geoweave.integration import Foliation, foliate
from geoweave.interlacing import Interlacing
from geoweave.isolines import isolines
from geoweave.mesh import Similarity, TriMesh
from geoweave.output import replacing
from geoweave.ribbons import Cutting, Ribbons, ribbons
from geoweave.rosy import smoothest_rosy

FORMAT, VERSION = "geoweave-weave", 1
"""What the first lines of ``weave.json`` say."""

MOST_CROSSINGS = 200_000
"""A weave that would have more is refused: it is a slip of the scale, and its proof would not end."""

LEVEL = 0.5 * np.pi
"""Level set on every sheet; theta is odd on antipodal sheets, so theirs interleave by half a period."""


@dataclass(frozen=True, eq=False)
class Weave:
    """Ribbons on a surface, which cross over and under each other.

    Attributes
    ----------
    mesh : the surface, at bounding radius 1
    placement : how it got there from the position and size it was given in
    symmetry : N of the RoSy; ribbons come in N / 2 families (N for odd N)
    ribbons : centrelines and crossings
    families : (n,) family of each ribbon, that of most of its length: across a branch cut families change
    interlacing : which ribbon lies over at each crossing
    branch_points : vertices of the surface at which families are permuted
    foliation : theta and s on the surface it was solved on, half of the cover for even N
    seconds : wall-clock seconds of each stage
    """

    mesh: TriMesh
    placement: Similarity
    symmetry: int
    ribbons: Ribbons
    families: Indices
    interlacing: Interlacing
    branch_points: Indices
    foliation: Foliation
    seconds: dict[str, float]

    @property
    def crossing_angles(self) -> Scalars:
        """(C,) angle between the two ribbons at each crossing, degrees, at most 90."""
        angle = np.degrees(np.abs(self.ribbons.crossings.angle))
        return np.minimum(angle, 180.0 - angle)

    def metrics(self) -> dict[str, Any]:
        """What a maker wants to know, in the unit of the surface given."""
        curves, met = self.ribbons.curves, self.ribbons.crossings
        unit, angle, aligned = self.placement.scale, self.crossing_angles, self.foliation.alignment
        bending = np.abs(geodesic_curvature(curves)) / unit
        order = np.argsort(bending)
        share = np.cumsum(curves.segment_lengths[order])
        p95 = bending[order][np.searchsorted(share, 0.95 * share[-1])]
        return {
            "ribbons": len(self.ribbons),
            "crossings": len(met),
            "total_length": float(curves.lengths.sum() * unit),
            "spacing": float(self.ribbons.spacing * unit),
            "crossing_angle_deg": {
                "median": float(np.median(angle)),
                "p05": float(np.percentile(angle, 5)),
                "smallest": float(angle.min()),
            },
            "alternation": {
                "fraction": self.interlacing.alternation,
                "optimal_fraction_bound": self.interlacing.alternation_bound,
                "proven": self.interlacing.proven,
            },
            "deviation_deg": {"median": aligned.median, "p95": aligned.p95},
            "dislocations": aligned.dislocations,
            "interleaved_triples": {
                "count": self.interlacing.interleaved,
                "of": self.interlacing.triples,
            },
            "loose_ends": int(self.ribbons.loose.sum()),
            "geodesic_curvature": {
                "mean": float(np.average(bending, weights=curves.segment_lengths)),
                "p95": float(p95),
            },
        }

    def document(self) -> dict[str, Any]:
        """The contents of ``weave.json``, on the surface as it was given."""
        curves, met = self.ribbons.curves, self.ribbons.crossings
        place, unit = self.placement.undo, self.placement.scale
        points, normals = place(curves.points), curves.normals
        names = labels(self.families)
        return {
            "format": FORMAT,
            "version": VERSION,
            "units": "mesh",
            "symmetry": self.symmetry,
            "surface": {
                "faces": self.mesh.n_faces,
                "genus": self.mesh.genus,
                "boundary_loops": len(self.mesh.boundary_loops),
                "area": float(self.mesh.face_areas.sum() * unit**2),
                "branch_points": place(self.mesh.vertices[self.branch_points]).tolist(),
            },
            "ribbons": [
                {
                    "id": c,
                    "label": names[c],
                    "family": int(self.families[c]),
                    "closed": bool(curves.closed[c]),
                    "length": float(curves.lengths[c] * unit),
                    "points": points[curves.offsets[c] : curves.offsets[c + 1]].tolist(),
                    "normals": normals[curves.offsets[c] : curves.offsets[c + 1]].tolist(),
                }
                for c in range(len(curves))
            ],
            "crossings": [
                {
                    "id": x,
                    "ribbons": met.curves[x].tolist(),
                    "arclength": (met.arclength[x] * unit).tolist(),
                    "point": point,
                    "angle_deg": float(self.crossing_angles[x]),
                    "over": int(met.curves[x, self.interlacing.over[x]]),
                    # where a ribbon crosses itself its number does not tell the strands apart
                    "over_index": int(self.interlacing.over[x]),
                }
                for x, point in enumerate(place(met.points).tolist())
            ],
            "metrics": self.metrics(),
        }

    def save(self, path: str | PathLike[str]) -> None:
        """Write ``weave.json``, whole or not at all."""
        text = json.dumps(self.document(), allow_nan=False)
        with replacing(path) as temporary:
            temporary.write_text(text + "\n", encoding="utf-8")


def labels(families: Indices) -> list[str]:
    """Name each ribbon by its family and its number in it: A1, A2, ..., B1, ..."""
    count: dict[int, int] = {}
    names = []
    for family in families.tolist():
        count[family] = count.get(family, 0) + 1
        names.append(f"{chr(ord('A') + family)}{count[family]}")
    return names


def weave_pattern(
    mesh: TriMesh,
    *,
    symmetry: int = 6,
    scale: float = 1.0,
    seed: int = 0,
    cutting: Cutting | None = None,
    time_limit: float = 10.0,
    callback: Callable[[str], None] | None = None,
) -> Weave:
    """Design a weave of a surface, up to the point where physics begins (Section 5.2).

    Smoothest RoSy, branched cover, geodesic field, s and theta on one of each two antipodal sheets, level
    sets, ribbons, crossings, over and under. The frequency is the paper's, half a turn on the steepest edge
    (footnote 4), times ``scale``.

    Parameters
    ----------
    mesh : the surface, anywhere and of any size
    symmetry : N, 3 or more; 6 for a triaxial weave
    scale : factor on the number of ribbons
    seed : of the RoSy and of the first eigenvector
    cutting : the numbers of the clean-up of the ribbons
    time_limit : seconds for the proof that no choice of over and under alternates more often
    callback : called with the name of each stage as it begins

    Raises
    ------
    FieldError
        If a parameter is out of range, or nothing of the level sets is long enough.
    """
    if symmetry < 3:
        raise FieldError(f"a weave needs a symmetry of 3 or more, not {symmetry}")
    seconds: dict[str, float] = {}
    clock, stage = time.perf_counter(), ""

    def begin(name: str) -> None:
        nonlocal clock, stage
        now = time.perf_counter()
        if stage:
            seconds[stage] = now - clock
        clock, stage = now, name
        if callback is not None and name:
            callback(name)

    begin("rosy")
    surface, placement = mesh.normalized()
    rosy = smoothest_rosy(surface, degree=symmetry, seed=seed)
    begin("cover")
    cover = branched_cover(rosy)
    quotient = cover.quotient
    begin("field")
    schedule = sharpening_schedule(quotient.mesh, finest=INTEGRABLE_END)
    solve = geodesic_field(quotient.field, smoothness=schedule)
    begin("foliation")
    foliation = foliate(solve.field, scale=scale, quantile=1.0, seed=seed)
    sheets = symmetry // 2 if symmetry % 2 == 0 else symmetry
    _refuse_too_many(foliation, sheets)
    begin("ribbons")
    level_sets = isolines(quotient.lifted(foliation), [LEVEL])
    found = ribbons(cover.project(level_sets), sheets, cutting)
    families = _families(cover, level_sets.faces, level_sets.segment_lengths, level_sets.offsets, sheets)
    begin("interlacing")
    met = found.crossings
    sides = interlacing.optimal(
        interlacing.Crossings(met.curves, met.arclength, found.curves.closed), time_limit
    )
    begin("")
    return Weave(
        surface,
        placement,
        symmetry,
        found,
        frozen(families[found.origin]),
        sides,
        frozen(rosy.branch_points),
        foliation,
        seconds,
    )


def _refuse_too_many(foliation: Foliation, families: int) -> None:
    """Estimate the crossings of evenly spaced families, ``n (n - 1) / 2 A / d^2``; refuse too many."""
    areas = foliation.part.mesh.face_areas
    per_area = float(np.average(np.abs(foliation.circle.gradient), weights=areas)) / np.pi
    below = float(areas.sum()) / families
    expected = 0.5 * families * (families - 1) * below * per_area**2
    if expected > MOST_CROSSINGS:
        raise FieldError(
            f"the weave would have about {expected:,.0f} crossings, more than {MOST_CROSSINGS:,}; "
            "ask for a smaller scale"
        )


def _families(cover: Cover, faces: Indices, lengths: Scalars, offsets: Indices, count: int) -> Indices:
    """Family of each level set on the cover: the sheet, antipodes taken for one, of most of its length."""
    of_curve = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    table = np.zeros((len(offsets) - 1, count))
    np.add.at(table, (of_curve, cover.sheets[faces] % count), lengths)
    return np.asarray(table.argmax(axis=1), dtype=np.int64)
