"""A weave and what a maker wants to know of it; the file ``weave.json`` (Section 5.2)."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace
from os import PathLike
from typing import Any, Literal, TypeAlias

import numpy as np

from geoweave.arrays import Indices, Scalars, Vectors
from geoweave.curves import geodesic_curvature
from geoweave.errors import FieldError
from geoweave.files import replacing
from geoweave.foliation import Foliation
from geoweave.surface import Similarity, TriMesh
from geoweave.weave.as_asked import Met
from geoweave.weave.cover import family_count
from geoweave.weave.interlacing import Interlacing, greedy
from geoweave.weave.passages import Passages
from geoweave.weave.ribbon_ends import openings_reached
from geoweave.weave.ribbons import Ribbons
from geoweave.weave.weave_format import WEAVE_FORMAT, WEAVE_VERSION

__all__ = [
    "Design",
    "Units",
    "Weave",
    "boundary_normals",
    "default_width",
    "labels",
]

Units: TypeAlias = Literal["mesh", "mm"]
"""Of everything that is written: that of the mesh file, or millimetres."""

COVERED = 0.9
"""Default width of a ribbon times the number of families, as a share of the spacing."""

THINNESS = 20.0
"""Width over thickness of ribbons whose thickness is not given, as of the cone in the paper's Fig. 25."""


def default_width(spacing: float, symmetry: int) -> float:
    """Width ``0.9 d / families`` of ribbons d apart; at d / 3 a flat triaxial weave has no triangles left."""
    return COVERED * spacing / family_count(symmetry)


@dataclass(frozen=True, eq=False, kw_only=True)
class Design:
    """What the ribbons of a weave come from.

    Attributes
    ----------
    symmetry : N of the RoSy; ribbons come in N / 2 families (N for odd N)
    branch_points : vertices of the surface at which families are permuted
    foliation : theta and s on the surface they were solved on, half of the cover for even N; nothing where
        the weave was made of given curves
    scale : factor on the number of ribbons
    tried : the scales that were tried for a number of ribbons, and how many ribbons each gave
    seconds : wall-clock seconds of each stage
    met : how far the field is what was asked of it; None if it is not known
    numerators : (V,) index of the RoSy at each vertex, in N-ths; None where the weave was made of curves
    """

    symmetry: int
    branch_points: Indices
    foliation: Foliation | None = None
    scale: float = 1.0
    tried: tuple[tuple[float, int], ...] = ()
    seconds: dict[str, float] = field(default_factory=dict)
    met: Met | None = None
    numerators: Indices | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Weave:
    """Ribbons on a surface, which cross over and under each other.

    Lengths are those of `mesh`; `document` and `metrics` give them in `units`.

    Attributes
    ----------
    ribbons : centrelines and crossings
    families : (n,) family of each ribbon, that of most of its length: across a branch cut families change
    interlacing : which ribbon lies over at each crossing
    width, thickness : of a ribbon
    design : what the ribbons come from
    placement : how the surface got where it is from the position and size in which the weave is written
    units : of the position and size in which it is written
    kept_names : names of the ribbons, where they are kept from a weave of more ribbons

    Examples
    --------
    >>> import geoweave as gw
    >>> weave = gw.weave_pattern(gw.shapes.torus(faces=600), scale=0.5).sized(200.0)
    >>> weave.units, len(weave.ribbons) == len(weave.names)
    ('mm', True)
    """

    ribbons: Ribbons
    families: Indices
    interlacing: Interlacing
    width: float
    thickness: float
    design: Design
    placement: Similarity
    units: Units = "mesh"
    kept_names: tuple[str, ...] | None = None

    @property
    def mesh(self) -> TriMesh:
        """The surface, on which the ribbons lie."""
        return self.ribbons.curves.mesh

    @property
    def symmetry(self) -> int:
        """N of the RoSy."""
        return self.design.symmetry

    @property
    def branch_points(self) -> Indices:
        """Vertices of the surface at which families are permuted."""
        return self.design.branch_points

    @property
    def scale(self) -> float:
        """Factor on the number of ribbons."""
        return self.design.scale

    def sized(
        self, size: float | None = None, width: float | None = None, thickness: float | None = None
    ) -> Weave:
        """Return the same weave as it is to be made.

        Parameters
        ----------
        size : largest extent of the bounding box of the surface in mm; it is scaled about the origin of its
            file, and everything is then written in mm. If not given, the size and the unit stay as they are
        width, thickness : of a ribbon, in the unit in which the weave is then written. If not given, what
            they were; if only the width is, the thickness becomes a twentieth of it

        Raises
        ------
        FieldError
            If a number is not positive.
        """
        for name, value in (("size", size), ("width", width), ("thickness", thickness)):
            if value is not None and not (np.isfinite(value) and value > 0):
                raise FieldError(f"the {name} of a weave must be a positive number, not {value}")
        placement, units = self.placement, self.units
        if size is not None:
            factor = size / (float(np.ptp(self.mesh.vertices, axis=0).max()) * placement.scale)
            placement = Similarity(placement.center * factor, placement.scale * factor)
            units = "mm"
        wide = self.width if width is None else width / placement.scale
        thin = self.thickness if width is None else wide / THINNESS
        if thickness is not None:
            thin = thickness / placement.scale
        return replace(self, placement=placement, units=units, width=wide, thickness=thin)

    @property
    def names(self) -> list[str]:
        """Name of each ribbon: family and number in it."""
        return labels(self.families) if self.kept_names is None else list(self.kept_names)

    @property
    def passages(self) -> Passages:
        """The crossings in the order in which each ribbon meets the others."""
        return self.ribbons.passages

    @property
    def crossing_angles(self) -> Scalars:
        """(C,) angle between the two ribbons at each crossing, degrees, at most 90."""
        angle = np.degrees(np.abs(self.ribbons.crossings.angle))
        return np.minimum(angle, 180.0 - angle)

    def metrics(self) -> dict[str, Any]:
        """What a maker wants to know, in `units`; metres of ribbon too where these are millimetres."""
        curves, met = self.ribbons.curves, self.ribbons.crossings
        unit, angle = self.placement.scale, self.crossing_angles
        bending = np.abs(geodesic_curvature(curves)) / unit
        order = np.argsort(bending)
        share = np.cumsum(curves.segment_lengths[order])
        p95 = bending[order][np.searchsorted(share, 0.95 * share[-1])]
        total = float(curves.lengths.sum() * unit)
        return {
            "ribbons": len(self.ribbons),
            "crossings": len(met),
            "total_length": total,
            **({"metres": total / 1000.0} if self.units == "mm" else {}),
            "spacing": float(self.ribbons.spacing * unit),
            "crossing_angle_deg": {
                "median": float(np.median(angle)),
                "p05": float(np.percentile(angle, 5)),
                "smallest": float(angle.min()),
            },
            "pattern": self.interlacing.document(),
            "alternation": {
                "fraction": self.interlacing.alternation,
                "optimal_fraction_bound": self.interlacing.alternation_bound,
                "proven": self.interlacing.proven and self.interlacing.unmet is None,
                "greedy_fraction": greedy(self.passages).alternation,
            },
            **self._of_the_foliation(),
            **self._of_the_steering(),
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

    def _of_the_steering(self) -> dict[str, Any]:
        """How far the finished field is what was asked of it, where anything was."""
        met = self.design.met
        if met is None:
            return {}
        said: dict[str, Any] = {}
        if met.displaced is not None:
            places = [
                {
                    "point": self.placement.undo(self.mesh.vertices[[each.vertex]])[0].tolist(),
                    "index": each.numerator,
                    "found": each.found,
                }
                for each in met.displaced
            ]
            said["prescribed_singularities"] = {"kept": not places, "displaced": places}
        if met.mirrored is not None:
            plane = met.mirrored
            said["mirror"] = {
                "normal": list(plane.normal),
                "surface": plane.surface,
                "field_deg": plane.field,
            }
        return said if met.aligned is None else said | {"aligned_deg": met.aligned}

    def _of_the_foliation(self) -> dict[str, Any]:
        """How well level sets follow the field, where the weave was made of a foliation."""
        if self.design.foliation is None:
            return {}
        aligned = self.design.foliation.alignment
        return {
            "deviation_deg": {"median": aligned.median, "p95": aligned.p95},
            "dislocations": aligned.dislocations,
        }

    def document(self) -> dict[str, Any]:
        """The contents of ``weave.json``, on the surface as it was given, or at the size asked for."""
        curves, met = self.ribbons.curves, self.ribbons.crossings
        place, unit = self.placement.undo, self.placement.scale
        points, normals = place(curves.points), curves.normals
        names, reached = self.names, openings_reached(curves)
        return {
            "format": WEAVE_FORMAT,
            "version": WEAVE_VERSION,
            "units": self.units,
            "symmetry": self.symmetry,
            "scale": self.scale,
            "width": self.width * unit,
            "thickness": self.thickness * unit,
            "surface": {
                "faces": self.mesh.n_faces,
                "genus": self.mesh.genus,
                "boundary_loops": len(self.mesh.boundary_loops),
                "area": float(self.mesh.face_areas.sum() * unit**2),
                "branch_points": place(self.mesh.vertices[self.branch_points]).tolist(),
                "singularities": self._singularities(),
                "openings": [
                    {"points": place(self.mesh.vertices[loop]).tolist(), "normals": normals.tolist()}
                    for loop, normals in zip(
                        self.mesh.boundary_loops, boundary_normals(self.mesh), strict=True
                    )
                ],
            },
            "ribbons": [
                {
                    "id": c,
                    "label": names[c],
                    "family": int(self.families[c]),
                    "closed": bool(curves.closed[c]),
                    "length": float(curves.lengths[c] * unit),
                    # the boundary loop of the surface that each end lies on, -1 for an end inside
                    "openings": reached[c].tolist(),
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

    def _singularities(self) -> list[dict[str, Any]]:
        """All singularities of the RoSy with their indices in N-ths, as `Singularity` takes them."""
        numerators = self.design.numerators
        if numerators is None:
            return []
        there = np.flatnonzero(numerators)
        points = self.placement.undo(self.mesh.vertices[there]).tolist()
        return [
            {"point": point, "index": index}
            for point, index in zip(points, numerators[there].tolist(), strict=True)
        ]

    def save(self, path: str | PathLike[str]) -> None:
        """Write ``weave.json``, whole or not at all."""
        text = json.dumps(self.document(), allow_nan=False)
        with replacing(path) as temporary:
            temporary.write_text(text + "\n", encoding="utf-8")


def boundary_normals(mesh: TriMesh) -> list[Vectors]:
    """For each boundary loop the (L, 3) unit normals of the faces along it, from each vertex to the next."""
    edges = mesh.edges[mesh.boundary_edges]
    normal = mesh.face_normals[mesh.edge_faces[mesh.boundary_edges, 0]]
    after = dict(zip(edges[:, 0].tolist(), normal, strict=True))
    return [np.array([after[vertex] for vertex in loop.tolist()]) for loop in mesh.boundary_loops]


def labels(families: Indices) -> list[str]:
    """Name each ribbon by its family and its number in it: A1, A2, ..., B1, ..., Z9, AA1, ..."""
    count: dict[int, int] = {}
    names = []
    for family in families.tolist():
        count[family] = count.get(family, 0) + 1
        names.append(f"{_letters(family)}{count[family]}")
    return names


def _letters(family: int) -> str:
    """A to Z, then AA, AB, ... as the columns of a spreadsheet."""
    letters, rest = "", family + 1
    while rest:
        rest, digit = divmod(rest - 1, 26)
        letters = chr(ord("A") + digit) + letters
    return letters
