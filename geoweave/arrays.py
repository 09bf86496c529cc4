"""Names for the arrays that every module passes around, and the algebra of vectors that rooms share."""

from __future__ import annotations

from typing import TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

Vectors: TypeAlias = NDArray[np.float64]
"""(N, 3) float64: points or vectors in space."""

Scalars: TypeAlias = NDArray[np.float64]
"""(N,) float64: one number per vertex, edge or face."""

Complexes: TypeAlias = NDArray[np.complex128]
"""(N,) complex128: one tangent vector per face in that face's frame, or a rotation per edge."""

Triangles: TypeAlias = NDArray[np.int64]
"""(F, 3) int64: vertex indices, counter-clockwise seen from outside."""

Indices: TypeAlias = NDArray[np.int64]
"""int64 indices into some other array."""

Flags: TypeAlias = NDArray[np.bool_]
"""(N,) bool."""

_Array = TypeVar("_Array", bound=NDArray[np.generic])


def frozen(array: _Array) -> _Array:
    """Return the array itself, made read-only."""
    array.flags.writeable = False
    return array


_NEXT, _LAST = np.array([1, 2, 0]), np.array([2, 0, 1])

OPPOSITE = 1e-12
"""Unit vectors count as opposite where one plus their cosine is below this."""


def cross(one: NDArray[np.float64], two: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cross product of vectors along the last axis, (..., 3).

    The result is that of `numpy.cross`, without the time it spends on its options.

    >>> from geoweave.arrays import cross
    >>> cross(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    array([0., 0., 1.])
    """
    return one[..., _NEXT] * two[..., _LAST] - one[..., _LAST] * two[..., _NEXT]


def parallel_transport(before: Vectors, after: Vectors, vectors: Vectors) -> Vectors:
    """Turn vectors by the smallest rotation that takes one unit vector to another.

    With ``a = t x t'`` and ``c = t . t'`` this is ``c v + a x v + (a . v) a / (1 + c)``. Tangents of a curve
    carry directors along it (Bergou et al. 2008); normals of a surface carry tangent vectors along it.

    Parameters
    ----------
    before, after : (N, 3) unit vectors t and t'
    vectors : (N, 3) vectors v

    Returns
    -------
    (N, 3) turned vectors. Where t and t' are opposite no rotation is smallest, and the result is ``-v``.

    Examples
    --------
    >>> from geoweave.arrays import parallel_transport
    >>> east, north = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 1.0, 0.0]])
    >>> parallel_transport(east, north, np.array([[1.0, 2.0, 3.0]]))
    array([[-2.,  1.,  3.]])
    """
    axis = cross(before, after)
    cosine = (before * after).sum(axis=1)
    share = (axis * vectors).sum(axis=1) / np.maximum(1.0 + cosine, OPPOSITE)
    return cosine[:, None] * vectors + cross(axis, vectors) + share[:, None] * axis
