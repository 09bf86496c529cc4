"""Level sets that lie on each other: of two that do, the longer one stays (Section 5.2)."""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Flags
from geoweave.curves import Curves

PARALLEL = np.cos(np.radians(20.0))
"""Cosine of the angle up to which two curves run along each other."""

SAME_SIDE = 0.5
"""Least cosine between the normals at two points on the same side of a thin wall."""


def doubled(curves: Curves, near: float) -> Flags:
    """(n,) curves that double a longer one: parallel to longer ones and near them for over half their length.

    Two families may turn into one at a wall of the field. Their level sets then lie on each other. The longer
    curves are looked at first, and only those that stay count against the shorter ones.

    Parameters
    ----------
    curves : the curves
    near : distance in space, between points whose normals agree; a length
    """
    from scipy.spatial import KDTree

    owner, _, points, heading, normals = curves.sampled(0.5 * near)
    sizes = np.bincount(owner, minlength=len(curves))
    pairs = KDTree(points).query_pairs(near, output_type="ndarray")
    one, other = pairs.T
    parallel = np.abs((heading[one] * heading[other]).sum(axis=1)) > PARALLEL
    facing = (normals[one] * normals[other]).sum(axis=1) > SAME_SIDE
    pairs = pairs[parallel & facing & (owner[one] != owner[other])]
    both = np.concatenate([pairs, pairs[:, ::-1]])
    both = both[np.argsort(owner[both[:, 0]], kind="stable")]
    bounds = np.searchsorted(owner[both[:, 0]], np.arange(len(curves) + 1))
    out = np.zeros(len(curves), dtype=bool)
    done = np.zeros(len(curves), dtype=bool)
    for c in np.argsort(-curves.lengths, kind="stable"):
        mine = both[bounds[c] : bounds[c + 1]]
        against = owner[mine[:, 1]]
        beside = np.unique(mine[done[against] & ~out[against], 0])
        out[c] = 2 * len(beside) > sizes[c]
        done[c] = True
    return out
