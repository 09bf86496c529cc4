"""Small defects of .rod files that RibbonSim reads, put right with a sentence for each kind."""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Scalars, Vectors

__all__ = ["ALONG", "DIRECTOR_TOLERANCE", "squared"]

DIRECTOR_TOLERANCE = 1e-3
"""How far directors may be from unit length and from square to their segments: files hold six digits."""

ALONG = 0.9
"""A director with a larger share of its length along its segment gives no direction square to it."""


def squared(points: Vectors, directors: Vectors, closed: bool) -> tuple[Vectors, int]:
    """Make directors unit vectors square to their segments.

    Parameters
    ----------
    points : (n, 3) vertices
    directors : (m, 3), m = n if closed and n - 1 if not
    closed : whether a last segment joins the last vertex to the first

    Returns
    -------
    (m, 3) directors, and how many were changed by more than the digits that files hold. A director that has
    no length, or points along its segment, stays as it is, for `Rod` to refuse.
    """
    edges = np.roll(points, -1, axis=0)[: len(directors)] - points[: len(directors)]
    with np.errstate(all="ignore"):
        tangents = edges / np.linalg.norm(edges, axis=1)[:, None]
        along: Scalars = (directors * tangents).sum(axis=1)
        square = directors - along[:, None] * tangents
        size = np.linalg.norm(directors, axis=1)
        unit = square / np.linalg.norm(square, axis=1)[:, None]
        possible = (size > 0) & (np.abs(along) < ALONG * size) & np.isfinite(unit).all(axis=1)
        off = np.linalg.norm(directors - unit, axis=1) > DIRECTOR_TOLERANCE
    change = possible & off
    return np.where(change[:, None], unit, directors), int(change.sum())
