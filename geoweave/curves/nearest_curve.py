"""How far points of a surface are from the curves on it, on their side of a thin wall."""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Indices, Scalars, Vectors
from geoweave.compiled import compiled
from geoweave.curves.curves import Curves
from geoweave.surface import BoxTree, nearest, segment_tree

__all__ = ["nearest_curves"]


def nearest_curves(curves: Curves, points: Vectors, normals: Vectors) -> tuple[Scalars, Indices]:
    """Distance from points to the nearest curve on their side of the surface, and that curve.

    The distance is a straight one. Where no curve lies on that side, it is the nearest of all.

    Parameters
    ----------
    curves : one or more
    points : (n, 3) places on the surface or near it
    normals : (n, 3) normals of the surface there; a curve whose face looks the other way is on the other side

    Returns
    -------
    (n,) lengths and (n,) numbers of curves

    Examples
    --------
    >>> import geoweave as gw
    >>> ball = gw.shapes.sphere(faces=320)
    >>> line = gw.straightest(ball, [0], [[1.0, 0.2, 0.0]], 1.0)
    >>> gw.curves.nearest_curves(line, line.points[[1]], line.normals[[1]])
    (array([0.]), array([0]))
    """
    running = np.flatnonzero(curves.segment_lengths > 0)
    ends = np.stack([curves.points[running], curves.points[curves.following[running]]], axis=1)
    tree = segment_tree(ends)._replace(normals=np.ascontiguousarray(curves.normals[running]))
    distance, piece = _distances(tree, np.ascontiguousarray(points), np.ascontiguousarray(normals))
    return distance, curves.curve_of_point[running[piece]]


@compiled
def _distances(tree: BoxTree, points: Vectors, normals: Vectors) -> tuple[Scalars, Indices]:
    """Distance to the nearest piece of a ribbon on the same side of the surface, and that piece.

    Where there is none on that side, the nearest of all.
    """
    distance, piece = np.empty(len(points)), np.empty(len(points), dtype=np.int64)
    found, anywhere = np.empty(3), np.zeros(3)
    for i in range(len(points)):
        piece[i] = nearest(tree, points[i], normals[i], found)
        if piece[i] < 0:
            piece[i] = nearest(tree, points[i], anywhere, found)
        distance[i] = np.sqrt(((found - points[i]) ** 2).sum())
    return distance, piece
