"""How well the level sets of a circle-valued function follow a field (the numbers behind Fig. 15)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from geoweave.arrays import Scalars, frozen
from geoweave.errors import FieldError
from geoweave.fields import FaceField
from geoweave.foliation.circle_function import TURN, CircleFunction
from geoweave.surface import TriMesh


@dataclass(frozen=True)
class Alignment:
    """The measures of `alignment`, over the area of the surface.

    Attributes
    ----------
    mean, median, p95 : mean, median and 95th percentile of `deviation`, degrees
    spacing_spread : `spacing_spread`, a number; 0 for evenly spaced level sets
    dislocations : faces that hold an edge dislocation
    """

    mean: float
    median: float
    p95: float
    spacing_spread: float
    dislocations: int


def alignment(field: FaceField, circle: CircleFunction) -> Alignment:
    """Measure how well the level sets of theta follow the field, and how evenly they are spaced.

    Parameters
    ----------
    field : the field w that the level sets should be tangent to
    circle : theta, on the mesh of the field
    """
    mesh = field.mesh
    angle = deviation(field, circle)
    median, p95 = area_percentiles(mesh, angle, [50.0, 95.0])
    return Alignment(
        mean=float(np.average(angle, weights=mesh.face_areas)),
        median=float(median),
        p95=float(p95),
        spacing_spread=spacing_spread(circle),
        dislocations=int(circle.dislocated.sum()),
    )


def deviation(field: FaceField, circle: CircleFunction) -> Scalars:
    """Angle between grad theta and w-perp on each face, ``|arg(grad theta / (-1j w))|`` (Eq. 6, Fig. 15).

    w-perp is the clockwise quarter turn of w. The angle is that between the level set, run through with
    larger theta on its right, and the field: beyond 90 degrees they run against each other, which a
    picture of the lines does not show but an orientation of the ribbons would. Faces that hold a
    dislocation count with the gradient of the nearest linear function; a face on which theta does not
    change has no direction and counts as 90 degrees.

    Returns
    -------
    (F,) degrees, 0 to 180

    Raises
    ------
    FieldError
        If the field and the function live on different meshes.
    """
    if not _same(field.mesh, circle.mesh):
        raise FieldError(
            f"the field lives on a mesh of {field.mesh.n_faces} faces and theta on another of "
            f"{circle.mesh.n_faces}: take both from the same part of the surface"
        )
    product = circle.gradient * (-1j * field.values).conj()
    return frozen(np.where(product != 0, np.degrees(np.abs(np.angle(product))), 90.0))


def _same(one: TriMesh, other: TriMesh) -> bool:
    return one is other or (
        np.array_equal(one.faces, other.faces) and np.array_equal(one.vertices, other.vertices)
    )


def spacing(circle: CircleFunction) -> Scalars:
    """Distance between neighbouring level sets one turn apart, ``2 pi / |grad theta|``, (F,), a length.

    Infinite on a face where theta does not change.
    """
    steepness = np.abs(circle.gradient)
    with np.errstate(divide="ignore"):
        return frozen(TURN / steepness)


def spacing_spread(circle: CircleFunction) -> float:
    """Half the distance of the 16th from the 84th percentile of log spacing, over the area: a number.

    For a log-normal spacing this is the standard deviation of its logarithm: 0 where all level sets are
    equally far apart, 0.7 where two thirds of the area have a spacing between half and twice the median.
    It does not depend on the frequency of theta, nor on a few faces of extreme spacing.
    """
    log = np.log(spacing(circle))
    low, high = _percentiles(log, circle.mesh.face_areas, np.array([15.87, 84.13]))
    return float(0.5 * (high - low))


def area_percentiles(mesh: TriMesh, values: Scalars, percents: ArrayLike) -> Scalars:
    """Values that so many percent of the area stay at or below.

    Parameters
    ----------
    mesh : the mesh that the values belong to
    values : (F,) a number per face
    percents : percentages between 0 and 100
    """
    return _percentiles(values, mesh.face_areas, np.asarray(percents, dtype=np.float64))


def _percentiles(values: Scalars, weights: Scalars, percents: Scalars) -> Scalars:
    order = np.argsort(values, kind="stable")
    share = np.cumsum(weights[order])
    place = np.searchsorted(share, percents / 100.0 * share[-1])
    return np.asarray(values[order][np.minimum(place, len(order) - 1)])
