"""What a user may say of the RoSy that a weave starts from: singularities, a direction, merging, symmetry.

Section 5.1 takes the singularities of the smoothest RoSy as they come. Here they may be prescribed, and pairs
that a weave could not tell apart are merged (DEVIATIONS.md, merged-pairs).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from geoweave.arrays import Indices
from geoweave.errors import FieldError
from geoweave.fields import (
    LAST_ETA,
    PRESCRIBED_ETA,
    FaceField,
    Guide,
    MirrorImages,
    RoSyField,
    aligned_connection,
    aligned_rosy,
    along_curve,
    along_direction,
    merged_pairs,
    prescribed_rosy,
    smoothest_rosy,
    symmetrized,
)
from geoweave.surface import (
    MIRROR_AXES,
    MirrorAxis,
    MirrorPlane,
    Similarity,
    TriMesh,
    closest_points,
    mirror_plane,
    triangle_tree,
)
from geoweave.weave.as_asked import Met, Mirrored, displaced, lifted_vectors
from geoweave.weave.cover import Cover

__all__ = [
    "SYMMETRIES",
    "Singularity",
    "Steering",
    "expected_spacing",
    "guide_of",
    "snapped",
    "steered_rosy",
    "steering_for",
    "steering_met",
]

PER_EDGE = 1.8
"""Spacing at scale 1 in `TriMesh.triangle_size`, before there is a field that says it."""

LENGTH = 0.7
"""Mean length of a ribbon in roots of the area of the surface, before there are ribbons."""

FARTHEST = 0.1
"""Bounding radii that a prescribed singularity may be from the nearest vertex; or two sides of a triangle."""

Point: TypeAlias = tuple[float, float, float]


SYMMETRIES = ("off", *MIRROR_AXES)
"""What may be asked of the mirror symmetry."""


class Singularity(NamedTuple):
    """A singularity that is prescribed."""

    position: Point
    """In the coordinates of the mesh file."""
    numerator: int
    """Its index, in N-ths of a turn for an N-RoSy: in sixths for a triaxial weave."""


@dataclass(frozen=True)
class Steering:
    """What is asked of the RoSy that a weave starts from.

    Attributes
    ----------
    singularities : all of them; None for those of the smoothest RoSy
    align : points of a curve that one family follows softly, or one point for a direction; None for neither
    merge : pairs of opposite index no farther apart than so many spacings are merged; 0 for none. What is
        prescribed is never merged
    spacing : between ribbons of the weave, in bounding radii; None for what is expected at scale 1
    symmetric : "auto" makes the RoSy its own image in the mirror plane of the surface, "x", "y" or "z" in
        one across that axis; "off" leaves it as it is

    Raises
    ------
    FieldError
        If a number is out of range.

    Examples
    --------
    >>> from geoweave.weave import Steering
    >>> Steering(merge=-1.0)
    Traceback (most recent call last):
    geoweave.errors.FieldError: pairs are merged within 0 spacings or more, not -1
    """

    singularities: tuple[Singularity, ...] | None = None
    merge: float = 0.0
    align: tuple[Point, ...] | None = None
    spacing: float | None = None
    symmetric: MirrorAxis | Literal["off"] = "off"

    @property
    def eta(self) -> float:
        """What weighs at the end of Algorithm 1 that families stay apart, see `geodesic_field`."""
        return LAST_ETA if self.singularities is None else PRESCRIBED_ETA

    def __post_init__(self) -> None:
        if not 0 <= self.merge < math.inf:
            raise FieldError(f"pairs are merged within 0 spacings or more, not {self.merge:g}")
        if self.symmetric not in SYMMETRIES:
            raise FieldError(f"there is no mirror symmetry '{self.symmetric}': {', '.join(SYMMETRIES)}")
        if self.symmetric != "off" and self.singularities is not None:
            raise FieldError(
                "prescribed singularities stay where they are, so the field cannot be made symmetric too; "
                "prescribe them in mirror pairs, or leave out the symmetry"
            )
        if self.align is not None and not np.any(
            self.align if len(self.align) == 1 else np.diff(self.align, axis=0)
        ):
            raise FieldError(
                "what a family is to follow has no length: give a direction, or points that are apart"
            )


def guide_of(mesh: TriMesh, placement: Similarity, symmetry: int, steering: Steering) -> Guide | None:
    """What is to be followed, on the surface where a placement has put it.

    Raises
    ------
    FieldError
        If a curve is far from the surface.
    """
    if steering.align is None:
        return None
    points = np.array(steering.align, dtype=np.float64)
    if len(points) == 1:
        return along_direction(mesh, symmetry, points[0])
    there = placement.apply(points)
    nearest, _ = closest_points(triangle_tree(mesh.vertices[mesh.faces]), there)
    apart = np.linalg.norm(nearest - there, axis=1)
    if apart.max() > FARTHEST * mesh.bounding_radius:
        said = "({:g}, {:g}, {:g})".format(*points[apart.argmax()])
        raise FieldError(
            f"the point {said} of the curve to follow is {apart.max() * placement.scale:.3g} from the surface"
            "; give points in the coordinates of the mesh file"
        )
    return along_curve(mesh, symmetry, there)


def snapped(mesh: TriMesh, placement: Similarity, singularities: tuple[Singularity, ...]) -> Indices:
    """(V,) prescribed numerators at the interior vertices nearest to their positions.

    Parameters
    ----------
    mesh : the surface, where a placement has put it
    placement : takes the coordinates of the mesh file there

    Raises
    ------
    FieldError
        If a position is far from the surface, or two have the same nearest vertex.
    """
    inside = np.flatnonzero(~mesh.boundary_vertices)
    if not len(inside):
        raise FieldError("the surface has no vertex inside that could be singular; refine it (--faces N)")
    reach = max(FARTHEST * mesh.bounding_radius, 2.0 * mesh.triangle_size)
    numerators = np.zeros(mesh.n_vertices, dtype=np.int64)
    owner: dict[int, Point] = {}
    for position, numerator in singularities:
        there = placement.apply(np.array([position]))[0]
        distance = np.linalg.norm(mesh.vertices[inside] - there, axis=1)
        vertex = int(inside[distance.argmin()])
        said = "({:g}, {:g}, {:g})".format(*position)
        if distance.min() > reach:
            raise FieldError(
                f"the singularity at {said} is {distance.min() * placement.scale:.3g} from the nearest "
                "vertex of the surface; give positions in the coordinates of the mesh file"
            )
        if vertex in owner:
            other = "({:g}, {:g}, {:g})".format(*owner[vertex])
            raise FieldError(
                f"the singularities at {other} and {said} have the same nearest vertex; sum them up in one "
                "line or refine the mesh (--faces N)"
            )
        owner[vertex] = position
        numerators[vertex] = numerator
    return numerators


def expected_spacing(mesh: TriMesh, families: int, scale: float | None, ribbons: int | None) -> float:
    """Spacing of a weave before there is a field, in bounding radii.

    From the size of the triangles for a scale, ``families A / length`` with a usual length for a number of
    ribbons.
    """
    radius = mesh.bounding_radius
    if ribbons is None:
        return float(PER_EDGE * mesh.triangle_size / radius / (1.0 if scale is None else scale))
    return float(families * np.sqrt(mesh.face_areas.sum()) / (LENGTH * ribbons) / radius)


def steering_for(
    mesh: TriMesh, families: int, scale: float | None, ribbons: int | None, steering: Steering | None
) -> Steering:
    """Return what is asked of a RoSy, with the spacing that is expected of the weave."""
    steering = steering or Steering()
    if not steering.merge or steering.spacing is not None:
        return steering
    return replace(steering, spacing=expected_spacing(mesh, families, scale, ribbons))


def steered_rosy(
    mesh: TriMesh, placement: Similarity, symmetry: int, seed: int, steering: Steering
) -> RoSyField:
    """Find the RoSy that a weave starts from: the smoothest one, with what is asked of it.

    Parameters
    ----------
    mesh : the surface, at bounding radius 1
    placement : how it got there
    symmetry : N
    seed : of the smoothest RoSy
    steering : what is asked
    """
    guide = guide_of(mesh, placement, symmetry, steering)
    rosy = smoothest_rosy(mesh, degree=symmetry, seed=seed) if guide is None else aligned_rosy(guide, seed)
    if steering.singularities is not None:
        numerators = snapped(mesh, placement, steering.singularities)
        found = prescribed_rosy(mesh, symmetry, numerators, like=rosy)
        return found if guide is None else aligned_connection(found, guide)
    plane = _plane_of(mesh, steering)
    if plane is not None:
        rosy = symmetrized(rosy, MirrorImages.of(mesh, plane))
    if not steering.merge:
        return rosy
    spacing = expected_spacing(mesh, 1, None, None) if steering.spacing is None else steering.spacing
    return merged_pairs(rosy, steering.merge * spacing).rosy


def steering_met(cover: Cover, field: FaceField, placement: Similarity, steering: Steering) -> Met:
    """How far a finished field on the quotient of a cover is what was asked of it."""
    mesh, moved = cover.rosy.mesh, None if steering.singularities is None else displaced(cover, field)
    guide, plane = guide_of(mesh, placement, cover.degree, steering), _plane_of(mesh, steering)
    if guide is None and plane is None:
        return Met(moved)
    faces, vectors = lifted_vectors(cover, field)
    aligned = mirrored = None
    if guide is not None and guide.weights[faces].sum() > 0:
        aligned = float(np.average(guide.deviation(vectors, faces), weights=guide.weights[faces]))
    if plane is not None:
        x, y, z = plane.normal.tolist()
        mirrored = Mirrored((x, y, z), plane.residual, MirrorImages.of(mesh, plane).departure(faces, vectors))
    return Met(moved, aligned, mirrored)


def _plane_of(mesh: TriMesh, steering: Steering) -> MirrorPlane | None:
    """The mirror plane of a surface, where a symmetric field is asked for."""
    return None if steering.symmetric == "off" else mirror_plane(mesh, steering.symmetric)
