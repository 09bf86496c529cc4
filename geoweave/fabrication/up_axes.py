"""Which way an object stands: the axis that is up in the guide, the viewer and the GLB.

Files of meshes seldom say it. A model is nearly always drawn along one of the six directions of its axes, and
what it stands on is the widest of its bases: the part of its convex hull that lies on the floor. A direction
counts only if the object does not fall over.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geoweave.arrays import Vectors
from geoweave.errors import FieldError
from geoweave.fabrication.flattening import WeaveLike, weave_document

__all__ = ["AXES", "Base", "base_axis", "bases", "check_axis", "up_axis", "upward"]

AXES = ("z", "y", "x", "-z", "-y", "-x")
"""What may be up; of bases that are equally wide the first of these is taken."""

FLOOR = 0.02
"""What lies within so much of the longest side above the lowest point is on the floor."""

EQUAL = 0.95
"""Bases are equally wide from this share of the widest on."""


class Base(NamedTuple):
    """What an object stands on with one of the axes up."""

    area: float
    """Of the convex hull of what is on the floor."""
    inside: float
    """How far the middle of the object is within the edge of that hull, seen from above; negative outside."""


def check_axis(axis: str) -> str:
    """Return the name of an axis as `AXES` has it.

    Raises
    ------
    FieldError
        If there is no such axis.

    Examples
    --------
    >>> gw.fabrication.check_axis("-X")
    '-x'
    """
    name = axis.strip().lower().removeprefix("+")
    if name not in AXES:
        raise FieldError(f"there is no axis '{axis}'; what is up is one of x, y, z, -x, -y, -z")
    return name


def upward(axis: str) -> Vectors:
    """(3,) the unit vector of an axis of `AXES`.

    Examples
    --------
    >>> gw.fabrication.upward("-y").tolist()
    [0.0, -1.0, 0.0]
    """
    found = np.zeros(3)
    found["xyz".index(axis[-1])] = -1.0 if axis.startswith("-") else 1.0
    return found


def bases(points: Vectors, middle: Vectors | None = None) -> dict[str, Base]:
    """What an object would stand on with each of the axes up.

    Parameters
    ----------
    points : (P, 3) of the object, close to each other against its size
    middle : (3,) where its weight is; the mean of the points if not given
    """
    from scipy.spatial import ConvexHull, QhullError

    centre = points.mean(axis=0) if middle is None else middle
    reach = FLOOR * float(np.ptp(points, axis=0).max())
    found = {}
    for axis in AXES:
        level = np.flatnonzero(upward(axis) == 0)
        height = points @ upward(axis)
        floor = points[height <= height.min() + reach][:, level]
        try:
            hull = ConvexHull(floor)
        except (QhullError, ValueError):  # a point or a line
            found[axis] = Base(0.0, -np.inf)
            continue
        outside = hull.equations[:, :2] @ centre[level] + hull.equations[:, 2]
        found[axis] = Base(float(hull.volume), float(-outside.max()))
    return found


def base_axis(points: Vectors, middle: Vectors | None = None) -> str | None:
    """The axis that is up if an object stands on the widest of its bases; None if it stands on none.

    Parameters
    ----------
    points : (P, 3) of the object, close to each other against its size
    middle : (3,) where its weight is; the mean of the points if not given

    Examples
    --------
    >>> cone = gw.shapes.cone(faces=400).vertices  # z is up
    >>> gw.fabrication.base_axis(cone), gw.fabrication.base_axis(cone[:, [1, 2, 0]])
    ('z', 'y')
    >>> gw.fabrication.base_axis(-cone)
    '-z'
    """
    stable = {axis: base for axis, base in bases(points, middle).items() if base.inside > 0}
    widest = max((base.area for base in stable.values()), default=0.0)
    return next((axis for axis, base in stable.items() if base.area >= EQUAL * widest), None)


def up_axis(weave: WeaveLike, up: str | None = None) -> str:
    """The axis of a weave that is up, one of `AXES`.

    Parameters
    ----------
    weave : a weave, or the contents of ``weave.json`` or ``relaxed.json``
    up : the axis, if it is known. Otherwise it is that of the widest base of the ribbons, and z if they stand
        on none

    Raises
    ------
    FieldError
        If there is no such axis, or the document is no weave.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6)
    >>> gw.fabrication.up_axis(weave), gw.fabrication.up_axis(weave, "+y")
    ('z', 'y')
    """
    if up is not None:
        return check_axis(up)
    points = np.concatenate([np.asarray(each["points"]) for each in weave_document(weave)["ribbons"]])
    return base_axis(points) or AXES[0]
