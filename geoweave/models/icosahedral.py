"""The regular icosahedron, its sides cut into triangles: the base of the sphere."""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Triangles, Vectors

_GOLDEN = 0.5 * (1.0 + np.sqrt(5.0))
"""The golden ratio; the twelve points (0, +-1, +-golden ratio) and their rotations span an icosahedron."""


def cut_icosahedron(n: int, *, bent: bool = False) -> tuple[Vectors, Triangles]:
    """Cut each edge of the regular icosahedron of radius 1 into n parts, and its sides accordingly.

    Parameters
    ----------
    n : parts of each edge
    bent : place the points on the flat sides such that they are spread evenly once projected to the sphere

    Returns
    -------
    (10 n^2 + 2, 3) points on the flat sides and (20 n^2, 3) triangles, counter-clockwise seen from outside
    """
    corners, sides = _icosahedron()
    # Barycentric grid on each face of the icosahedron; points on shared edges are welded below.
    i, j = np.nonzero(np.add.outer(np.arange(n + 1), np.arange(n + 1)) <= n)
    weights = np.stack([n - i - j, i, j], axis=1)
    number = np.full((n + 2, n + 2), -1)
    number[i, j] = np.arange(len(i))
    up = np.stack([number[i, j], number[i + 1, j], number[i, j + 1]], axis=1)
    down = np.stack([number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]], axis=1)
    local = np.concatenate([up, down])
    local = local[(local >= 0).all(axis=1)]
    # A point is named by its corners and weights, the same from either side of an edge.
    present = np.broadcast_to(weights, (20, *weights.shape)) > 0
    name = np.where(present, sides[:, None, :] * (n + 1) + weights, -1)
    name = np.sort(name.reshape(-1, 3), axis=1)
    key = (name[:, 0] + 1) * (13 * (n + 1)) ** 2 + (name[:, 1] + 1) * 13 * (n + 1) + name[:, 2]
    _, first, welded = np.unique(key, return_index=True, return_inverse=True)
    share = _bent(weights / n) if bent else weights / n
    points = np.einsum("pc,fcx->fpx", share, corners[sides]).reshape(-1, 3)[first]
    triangles = (local[None] + len(weights) * np.arange(20)[:, None, None]).reshape(-1, 3)
    return points, welded.reshape(-1)[triangles]


def _bent(weights: Vectors) -> Vectors:
    """Replace barycentric weights by ones whose points are spread more evenly on the sphere."""
    # Along an edge the points then lie at equal angles; neighbouring corners are arccos(1 / sqrt 5) apart.
    angle = np.arccos(1.0 / np.sqrt(5.0))
    return np.sin(weights * angle) / np.sin(angle)


def _icosahedron() -> tuple[Vectors, Triangles]:
    """Corners (12, 3) on the unit sphere and sides (20, 3), counter-clockwise seen from outside."""
    corners = [(0.0, s, t * _GOLDEN) for s in (-1, 1) for t in (-1, 1)]
    vertices = np.array([np.roll(corner, turn) for turn in range(3) for corner in corners])
    side = np.linalg.norm(vertices[:, None] - vertices[None], axis=2)
    near = np.isclose(side, 2.0)
    a, b, c = np.nonzero(near[:, :, None] & near[:, None, :] & near[None, :, :])
    faces = np.stack([a, b, c], axis=1)[(a < b) & (b < c)]
    normal = np.cross(
        vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]]
    )
    inward = np.einsum("fx,fx->f", normal, vertices[faces[:, 0]]) < 0
    faces[inward] = faces[inward][:, [0, 2, 1]]
    return vertices / np.hypot(1.0, _GOLDEN), faces
