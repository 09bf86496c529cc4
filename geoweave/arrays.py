"""Names for the arrays that every module passes around, and how they are made read-only."""

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
