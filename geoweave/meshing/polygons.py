"""Cut the polygons of a mesh file into triangles: none folds over, and no edge gets a third face.

A convex polygon becomes a fan from its first corner. A polygon whose fan would fold over, or whose fan needs
a diagonal that another face has already, is clipped ear by ear in its own plane.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geoweave.arrays import Flags, Indices, Scalars, Triangles, Vectors
from geoweave.errors import MeshError

MOST_CORNERS = 4_000
"""A polygon that is clipped may have so many corners; time grows with their square, to some seconds."""

THIN = 1e-6
"""A fan with a triangle whose area is below this share of its longest edge squared is not taken."""

REACH = 1e-9
"""A corner closer to an ear than this share of the ear's longest edge lies on the ear."""


class RawMesh(NamedTuple):
    """What a file says, unchecked.

    ``vertices`` (V, 3) and ``faces`` (F, 3); F = 0 for a point cloud. ``notes`` are sentences on what was
    read otherwise than the file says.
    """

    vertices: Vectors
    faces: Triangles
    notes: tuple[str, ...] = ()


def triangulated(points: Vectors, corners: Indices, counts: Indices) -> Triangles:
    """Cut polygons into triangles with the same vertices.

    Parameters
    ----------
    points : (V, 3) vertices of the file
    corners : (sum of counts,) vertices of all polygons, one after another
    counts : (P,) how many corners each polygon has

    Returns
    -------
    (F, 3) triangles, oriented like their polygons; polygons with n corners give n - 2 of them. Indices out of
    range and coordinates that are not finite are passed on as they are.

    Raises
    ------
    MeshError
        If a polygon that is no plain fan has more than `MOST_CORNERS` corners.

    Examples
    --------
    A dart: its reflex corner is seen from the first corner, and from no other.

    >>> from geoweave.meshing.polygons import triangulated
    >>> dart = np.array([[2, 0, 0], [0, 1, 0], [0.5, 0, 0], [0, -1, 0.0]])
    >>> triangulated(dart, np.array([1, 2, 3, 0]), np.array([4])).tolist()
    [[2, 3, 0], [2, 0, 1]]
    """
    counts = np.asarray(counts, dtype=np.int64)
    plain = _fans(corners, counts)
    many = counts > 3
    if not many.any() or corners.min() < 0 or corners.max() >= len(points):
        return plain
    if not np.isfinite(points[corners]).all():
        return plain

    folded = _folded(points, plain, counts)
    other = _rotated(corners, counts, folded & (counts == 4))
    quads = _fans(other, counts)
    mended = folded & (counts == 4) & ~_folded(points, quads, counts)
    corners = np.where(np.repeat(mended, counts), other, corners)
    faces = np.where(np.repeat(mended, counts - 2)[:, None], quads, plain)
    folded &= ~mended & (counts > 4)

    again = folded | _crowded(corners, counts, len(points))
    return _clipped_anew(points, corners, counts, faces, again) if again.any() else faces


def _fans(corners: Indices, counts: Indices) -> Triangles:
    """Triangles of each polygon that share its first corner."""
    pieces = np.maximum(counts - 2, 0)
    start = np.repeat(np.cumsum(counts) - counts, pieces)
    step = np.arange(pieces.sum()) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    return np.stack([corners[start], corners[start + step + 1], corners[start + step + 2]], axis=1)


def _rotated(corners: Indices, counts: Indices, which: Flags) -> Indices:
    """The corners, those of some polygons beginning with the second one."""
    place = np.arange(len(corners))
    last = np.cumsum(counts) - 1
    onward = place + 1
    onward[last] = last - counts + 1
    return corners[np.where(np.repeat(which, counts), onward, place)]


def _folded(points: Vectors, fans: Triangles, counts: Indices) -> Flags:
    """(P,) polygons with a fan triangle that faces against its polygon, or has hardly any area."""
    a, b, c = (points[fans[:, k]] for k in range(3))
    area = 0.5 * np.cross(b - a, c - a)
    longest = np.max([((q - p) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    owner = np.repeat(np.arange(len(counts)), counts - 2)
    whole = np.stack([np.bincount(owner, area[:, k], len(counts)) for k in range(3)], axis=1)
    size = np.linalg.norm(whole, axis=1)
    upward = np.einsum("fx,fx->f", area, whole[owner]) <= THIN * longest * size[owner]
    return np.asarray((np.bincount(owner, upward, len(counts)) > 0) & (counts > 3) & (size > 0.0))


def _sides(corners: Indices, counts: Indices, size: int) -> Indices:
    """A number for each side of each polygon, the same for both directions."""
    onward = _rotated(corners, counts, np.ones(len(counts), dtype=bool))
    return np.minimum(corners, onward) * size + np.maximum(corners, onward)


def _diagonals(corners: Indices, counts: Indices, size: int) -> tuple[Indices, Indices]:
    """Numbers of the diagonals of all fans, as in `_sides`, and the polygon of each."""
    pieces = np.maximum(counts - 3, 0)
    start = np.repeat(np.cumsum(counts) - counts, pieces)
    step = np.arange(pieces.sum()) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    a, b = corners[start], corners[start + step + 2]
    return np.minimum(a, b) * size + np.maximum(a, b), np.repeat(np.arange(len(counts)), pieces)


def _crowded(corners: Indices, counts: Indices, size: int) -> Flags:
    """(P,) polygons with a fan diagonal that is a side, or a diagonal, of another face."""
    diagonal, owner = _diagonals(corners, counts, size)
    _, inverse, often = np.unique(diagonal, return_inverse=True, return_counts=True)
    taken = (often[inverse] > 1) | np.isin(diagonal, _sides(corners, counts, size))
    return np.asarray(np.bincount(owner, taken, len(counts)) > 0)


def _clipped_anew(
    points: Vectors, corners: Indices, counts: Indices, faces: Triangles, again: Flags
) -> Triangles:
    """The triangles, those of some polygons cut anew so that they keep clear of all other edges."""
    size = len(points)
    diagonal, owner = _diagonals(corners, counts, size)
    taken = set(np.unique(_sides(corners, counts, size)).tolist())
    taken.update(diagonal[~again[owner]].tolist())
    faces = faces.copy()
    first_corner, first_face = np.cumsum(counts) - counts, np.cumsum(counts - 2) - (counts - 2)
    known: dict[tuple[int, ...], Triangles] = {}
    for polygon in np.flatnonzero(again).tolist():
        n = int(counts[polygon])
        if n > MOST_CORNERS:
            raise MeshError(
                f"a face with {n:,} corners is not convex, and at most {MOST_CORNERS:,} are cut into "
                "triangles here; cut it in a mesh editor"
            )
        ring = corners[first_corner[polygon] : first_corner[polygon] + n]
        name = tuple(sorted(ring.tolist()))
        if name not in known:  # a polygon that stands in the file twice is cut the same way twice
            known[name] = ring[_ears(points[ring], ring, taken, size)]
        faces[first_face[polygon] : first_face[polygon] + n - 2] = known[name]
    return faces


def _ears(points: Vectors, ring: Indices, taken: set[int], size: int) -> Triangles:
    """Clip the ears of one polygon, the best-shaped first; enter its diagonals into `taken`.

    An ear is a triangle of three corners in a row that turns like the polygon and holds no other corner. Its
    diagonal is free if no other face has that edge. Where no ear has a free diagonal, one that is free is cut
    all the same: a fold can be mended later, an edge of three faces cannot.
    """
    flat = _projected(points)
    rest = np.arange(len(ring))
    cut = []
    while len(rest) > 3:
        triangles = np.stack([np.roll(rest, 1), rest, np.roll(rest, -1)], axis=1)
        area, quality = _shapes(flat, triangles)
        low, high = np.sort(ring[triangles[:, [0, 2]]], axis=1).T
        free = np.array([key not in taken for key in (low * size + high).tolist()]) & (low != high)
        turning, every = area > 0.0, np.ones(len(rest), dtype=bool)
        for allowed, empty in (
            (free & turning, True),
            (free & turning, False),
            (free, False),
            (turning, True),
            (every, False),
        ):
            ranked = np.flatnonzero(allowed)[np.argsort(-quality[allowed], kind="stable")].tolist()
            found = (k for k in ranked if not empty or _is_empty(flat, rest, triangles[k]))
            choice = next(found, -1)
            if choice >= 0:
                break
        cut.append(triangles[choice])
        taken.add(int(low[choice] * size + high[choice]))
        rest = np.delete(rest, choice)
    return np.array([*cut, rest])


def _projected(points: Vectors) -> Vectors:
    """(n, 2) coordinates of a polygon's corners in its mean plane, counter-clockwise round it."""
    points = points - points[0]
    normal = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
    size = np.linalg.norm(normal)
    normal = normal / size if size > 0.0 else np.array([0.0, 0.0, 1.0])
    first = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    first /= np.linalg.norm(first)
    return np.stack([points @ first, points @ np.cross(normal, first)], axis=1)


def _shapes(flat: Vectors, triangles: Triangles) -> tuple[Scalars, Scalars]:
    """Signed areas of triangles in the plane, and qualities (1 equilateral, 0 flat, below 0 turned over)."""
    a, b, c = (flat[triangles[:, k]] for k in range(3))
    area = 0.5 * _cross(b - a, c - a)
    squares = sum(((q - p) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a)))
    return area, 4.0 * np.sqrt(3.0) * area / np.where(squares > 0.0, squares, 1.0)


def _cross(a: Vectors, b: Vectors) -> Scalars:
    """Signed area of the parallelogram of two vectors in the plane."""
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _is_empty(flat: Vectors, rest: Indices, triangle: Indices) -> bool:
    """Whether a triangle that turns counter-clockwise holds no other corner, on its sides neither."""
    corners = flat[triangle]
    others = flat[rest]
    sides = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(sides, axis=1)
    inside = np.ones(len(rest), dtype=bool)
    for corner, side, length in zip(corners, sides, lengths, strict=True):
        inside &= _cross(side, others - corner) >= -REACH * length * lengths.max()
    # A corner at the same place as one of the three belongs to a slit, which has two corners there.
    apart = np.abs(others[:, None] - corners).max(axis=2).min(axis=1) > REACH * lengths.max()
    return not (inside & apart).any()
