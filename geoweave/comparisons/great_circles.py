"""Fields of great circles on a sphere, the known answer of Fig. 7, and how far a field is from one."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from geoweave.arrays import Scalars, Vectors
from geoweave.fields import FaceField

__all__ = ["meridian_angle", "meridian_axis", "meridian_field"]


def meridian_field(field: FaceField, axis: ArrayLike) -> FaceField:
    """Build the unit field along the great circles through two poles, on the mesh of a given field.

    ``t(x) = (a - (a . x) x) / |...|``, from the pole -a to the pole a.

    Parameters
    ----------
    field : any field on a sphere about the origin; only its mesh is used
    axis : (3,) direction of the pole a
    """
    a = np.asarray(axis, dtype=np.float64)
    x = _directions(field)
    return FaceField.from_ambient(field.mesh, a - (x @ a)[:, None] * x).normalized()


def meridian_angle(field: FaceField, axis: ArrayLike) -> Scalars:
    """Angle between a field and the great circles through two poles, whichever way these run.

    Returns
    -------
    (F,) radians, from 0 to pi / 2
    """
    turn = field.values * meridian_field(field, axis).values.conj()
    return np.asarray(0.5 * np.abs(np.angle(turn**2)))


def meridian_axis(field: FaceField) -> Vectors:
    """Axis of the great circles that fit a field best, ``argmin over |a| = 1 of integral (a . (x x w))^2``.

    A vector w runs along the great circle through x and the poles exactly when it lies in the plane of x and
    a. The smallest eigenvector of a 3 x 3 matrix; its sign is that of its largest coordinate.

    Returns
    -------
    (3,) unit vector
    """
    normal = np.cross(_directions(field), field.ambient)
    form = (normal * field.mesh.face_areas[:, None]).T @ normal
    axis = np.linalg.eigh(form)[1][:, 0]
    return np.asarray(axis * np.sign(axis[np.abs(axis).argmax()]))


def _directions(field: FaceField) -> Vectors:
    centres = field.mesh.barycenters
    return np.asarray(centres / np.linalg.norm(centres, axis=1, keepdims=True))
