"""Passages of weaves that are no surface's: grids on a torus, chords of the plane, anything."""

from __future__ import annotations

import numpy as np

from geoweave.weave.passages import Passages


def grid(rows, columns):
    """A plain weave on a torus: closed rows and columns, each meeting all of the others once."""
    i, j = (each.ravel() for each in np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"))
    return Passages(np.c_[i, rows + j], np.c_[j, i], np.ones(rows + columns, dtype=bool))


def segments(start, end):
    """Crossings of straight ribbons in the plane, each of the two first by the toss of a coin."""
    d, length = end - start, np.linalg.norm(end - start, axis=1)
    i, j = np.triu_indices(len(start), 1)
    w, turn = start[j] - start[i], d[i, 0] * d[j, 1] - d[i, 1] * d[j, 0]
    keep = turn != 0
    i, j, w, turn = i[keep], j[keep], w[keep], turn[keep]
    s = (w[:, 0] * d[j, 1] - w[:, 1] * d[j, 0]) / turn
    t = (w[:, 0] * d[i, 1] - w[:, 1] * d[i, 0]) / turn
    inside = (s > 0) & (s < 1) & (t > 0) & (t < 1)
    ribbons, lengths = np.c_[i, j][inside], np.c_[s * length[i], t * length[j]][inside]
    turned = np.random.default_rng(0).random(len(ribbons)) < 0.5
    ribbons[turned], lengths[turned] = ribbons[turned, ::-1], lengths[turned, ::-1]
    return Passages(ribbons, lengths, np.zeros(len(start), dtype=bool))


def anything(seed):
    """Crossings of random ribbons at random places, some with themselves, in no plane."""
    rng = np.random.default_rng(seed)
    ribbons, crossings = rng.integers(1, 6), rng.integers(1, 11)
    return Passages(
        rng.integers(0, ribbons, (crossings, 2)), rng.random((crossings, 2)), rng.random(ribbons) < 0.5
    )
