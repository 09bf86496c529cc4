"""Surfaces where a function vanishes: Schwarz-P, surfaces of any genus, stand-ins for scans.

A level set is triangulated on a grid by marching cubes, then remeshed evenly. Newton steps along the gradient
then put its vertices onto the level set.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from geoweave.arrays import Scalars, Triangles, Vectors
from geoweave.errors import MeshError
from geoweave.meshing import isotropic_remesh
from geoweave.surface import TriMesh

Level = Callable[[Vectors], Scalars]
"""A function of points (..., 3), negative inside."""

FEWEST_CELLS = 8
"""Cells of the grid along the shortest side of a box, at least."""

CLEAR_OF_ZERO = 1e-3
"""Least size of a value at a grid point, as a share of the mean size over the cells along the longest side.

A value of zero would put a degenerate triangle there. Newton's steps undo the shift.
"""

NEWTON_STEPS = 4
"""Steps that take a vertex onto the level set; each squares its relative distance from it."""

ON_A_SIDE = 1e-7
"""A vertex closer than this share of the box to one of its sides lies on that side."""

DETAIL = 1e-3
"""Length, as a share of the longest side of the box, on which a level function is nearly linear."""

DIFFERENCE = 1e-3
"""Step of the central differences, as a share of such a length."""

WELD = 1e-7
"""Mirrored vertices closer than this share of a surface's size are one vertex."""


def level_set(
    level: Level, lower: Sequence[float], upper: Sequence[float], faces: int, *, resolution: int = 64
) -> TriMesh:
    """Triangulate the part of the surface ``level(x) = 0`` that lies inside a box.

    Where the surface crosses a side of the box it is cut open.

    Parameters
    ----------
    level : smooth function of points (..., 3), negative inside
    lower, upper : opposite corners of the box
    faces : wanted number of faces, reached to about 5 %
    resolution : cells of the grid along the longest side; narrow necks need more of them

    Returns
    -------
    TriMesh whose vertices lie on the level set, those of its boundary also on the sides of the box

    Raises
    ------
    MeshError
        If so few faces cannot keep the topology of the surface.

    Examples
    --------
    >>> from geoweave.models.implicit import level_set
    >>> ball = level_set(lambda x: np.linalg.norm(x, axis=-1) - 1, [-1.2] * 3, [1.2] * 3, 500, resolution=16)
    >>> bool(np.allclose(np.linalg.norm(ball.vertices, axis=1), 1.0))
    True
    """
    from skimage.measure import marching_cubes  # takes a third of a second to load

    low, high = np.asarray(lower, dtype=np.float64), np.asarray(upper, dtype=np.float64)
    cells = np.maximum(FEWEST_CELLS, np.round(resolution * (high - low) / (high - low).max()).astype(int))
    axes = [np.linspace(a, b, n + 1) for a, b, n in zip(low, high, cells, strict=True)]
    values = level(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1))
    least = CLEAR_OF_ZERO * np.abs(values).mean() / resolution
    values = np.where(np.abs(values) < least, least, values)
    points, triangles, _, _ = marching_cubes(values, 0.0)
    coarse = _oriented(
        low + points.astype(np.float64) * (high - low) / cells, triangles.astype(np.int64), level
    )
    even = isotropic_remesh(coarse, faces)
    return TriMesh(_settled(even.vertices, level, low, high), even.faces)


def _oriented(points: Vectors, triangles: Triangles, level: Level) -> TriMesh:
    """Make a mesh whose normals point to where the function grows."""
    mesh = TriMesh(points, triangles)
    outward = np.einsum("fx,fx->f", mesh.face_normals, _gradient(level, mesh.barycenters, mesh.mean_edge))
    return mesh if outward.sum() > 0 else TriMesh(points, triangles[:, [0, 2, 1]])


def _settled(points: Vectors, level: Level, low: Vectors, high: Vectors) -> Vectors:
    """Put points onto the level set by Newton steps; points on a side of the box stay on it."""
    size = float((high - low).max())
    held_low, held_high = np.abs(points - low) < ON_A_SIDE * size, np.abs(points - high) < ON_A_SIDE * size
    points = np.where(held_low, low, np.where(held_high, high, points))
    for _ in range(NEWTON_STEPS):
        slope = np.where(held_low | held_high, 0.0, _gradient(level, points, DETAIL * size))
        square = np.einsum("px,px->p", slope, slope)
        points = points - (level(points) / np.where(square > 0, square, 1.0))[:, None] * slope
    return points


def _gradient(level: Level, points: Vectors, length: float) -> Vectors:
    """(..., 3) gradient at points by central differences; the function is nearly linear over `length`."""
    shifts = DIFFERENCE * length * np.eye(3)
    return np.stack(
        [(level(points + s) - level(points - s)) / (2.0 * DIFFERENCE * length) for s in shifts], axis=-1
    )


def schwarz_p(cells: int = 2, faces: int = 6_800) -> TriMesh:
    """Build a block of ``cells^3`` unit cells of ``cos x + cos y + cos z = 0``, close to Schwarz's P surface.

    Each side of the block is pierced by ``cells^2`` tunnels: with two cells, genus 5 and 24 boundary loops,
    the surface of Fig. 8. The block has side ``2 pi cells`` and is centred at the origin.

    Parameters
    ----------
    cells : along each side of the block, 1 or more
    faces : wanted number, reached to about 5 %

    Raises
    ------
    MeshError
        If there is no cell, or so few faces cannot keep the topology.

    Examples
    --------
    >>> cell = gw.shapes.schwarz_p(cells=1, faces=800)
    >>> cell.genus, len(cell.boundary_loops)
    (0, 6)
    """
    if cells < 1:
        raise MeshError(f"Schwarz-P needs at least one cell, not {cells}")
    part = max(8, round(faces / (8 * cells**3)))

    def level(x: Vectors) -> Scalars:
        return np.cos(x).sum(axis=-1)

    # One eighth of a cell is meshed and mirrored, so that the mesh has the symmetries of the surface.
    patch = level_set(level, [0.0] * 3, [np.pi] * 3, part, resolution=24)
    points, triangles = patch.vertices, patch.faces
    for axis in range(3):
        mirror = np.where(np.arange(3) == axis, -1.0, 1.0)
        triangles = np.concatenate([triangles, triangles[:, [0, 2, 1]] + len(points)])
        points = np.concatenate([points, points * mirror])
    corner = 2.0 * np.pi * np.array(list(np.ndindex(cells, cells, cells))) + np.pi * (1 - cells)
    copies = np.arange(len(corner))[:, None, None] * len(points)
    return _welded((points + corner[:, None]).reshape(-1, 3), (triangles + copies).reshape(-1, 3))


def _welded(points: Vectors, triangles: Triangles) -> TriMesh:
    """Join copies of a patch along their mirrors, where points coincide to rounding."""
    grid = np.round(points / (WELD * np.ptp(points))).astype(np.int64)
    _, first, number = np.unique(grid, axis=0, return_index=True, return_inverse=True)
    return TriMesh(points[first], number.reshape(-1)[triangles])


def genus_g(genus: int, faces: int = 6_000) -> TriMesh:
    """Build a closed surface of the given genus: that many smooth rings in a chain, a ball for genus 0.

    Parameters
    ----------
    genus : number of rings, not negative
    faces : wanted number, reached to about 5 %

    Raises
    ------
    MeshError
        If the genus is negative, or so few faces cannot keep the topology.

    Examples
    --------
    >>> gw.shapes.genus_g(2, faces=600).genus
    2
    """
    if genus < 0:
        raise MeshError(f"a genus cannot be negative: {genus}")
    centers = 2.3 * (np.arange(max(genus, 1)) - 0.5 * (max(genus, 1) - 1))

    def ring(x: Vectors) -> Scalars:
        around = np.hypot(x[..., 0], x[..., 1]) - 1.0 if genus else np.hypot(x[..., 0], x[..., 1])
        return np.hypot(around, x[..., 2]) - (0.42 if genus else 1.0)

    def level(x: Vectors) -> Scalars:
        distance = ring(x - [centers[0], 0.0, 0.0])
        for center in centers[1:]:
            distance = _joined(distance, ring(x - [center, 0.0, 0.0]), 0.25)
        return distance

    reach = [centers[-1] + 1.7, 1.7, 1.2 if not genus else 0.7]
    return level_set(level, [-r for r in reach], reach, faces, resolution=26 * max(genus, 1) + 20)


def rocker_arm(faces: int = 8_000) -> TriMesh:
    """Build a rocker arm as in an engine: a bored boss, two arms, a pad and a rounded tip; genus 1.

    It stands in for the scanned Rocker Arm of Fig. 8 where that is not on this machine. It has the same genus
    and flat, round and saddle-shaped regions too; the likeness ends there.

    Parameters
    ----------
    faces : wanted number, reached to about 5 %

    Raises
    ------
    MeshError
        If so few faces cannot keep the topology.

    Examples
    --------
    >>> gw.shapes.rocker_arm(faces=800).genus
    1
    """

    def level(x: Vectors) -> Scalars:
        boss = _cylinder(x, [0.0, 0.0, 0.0], 2, radius=0.50, half=0.42, round_=0.08)
        pad = _box(x, [-1.15, 0.16, 0.0], [0.26, 0.10, 0.30], 0.09)
        tip = _cylinder(x, [1.12, -0.26, 0.0], 2, radius=0.20, half=0.24, round_=0.08)
        left = _capsule(x, [-0.30, 0.05, 0.0], [-1.10, 0.14, 0.0], 0.24, 0.15)
        right = _capsule(x, [0.30, 0.05, 0.0], [0.80, 0.10, 0.0], 0.25, 0.18)
        hook = _capsule(x, [0.80, 0.10, 0.0], [1.12, -0.26, 0.0], 0.18, 0.16)
        body = boss
        for part, blend in ((left, 0.14), (right, 0.14), (hook, 0.10), (pad, 0.10), (tip, 0.08)):
            body = _joined(body, part, blend)
        bore = np.hypot(x[..., 0], x[..., 1]) - 0.26
        return -_joined(-body, bore, 0.06)

    return level_set(level, [-1.7, -0.75, -0.6], [1.6, 0.75, 0.6], faces, resolution=110)


def bumpy_box(faces: int = 8_000) -> TriMesh:
    """Build a rounded box with a bump in the middle of each side: a stand-in for the bumpy box of Fig. 19.

    Parameters
    ----------
    faces : wanted number, reached to about 5 %

    Raises
    ------
    MeshError
        If so few faces cannot keep the topology.

    Examples
    --------
    >>> box = gw.shapes.bumpy_box(faces=600)
    >>> box.genus, box.boundary_loops
    (0, ())
    """

    def level(x: Vectors) -> Scalars:
        solid = _box(x, [0.0, 0.0, 0.0], [1.0, 1.0, 1.0], 0.35)
        for axis in range(3):
            for side in (-1.0, 1.0):
                center = np.zeros(3)
                center[axis] = 0.75 * side
                solid = _joined(solid, np.linalg.norm(x - center, axis=-1) - 0.55, 0.5)
        return solid

    return level_set(level, [-1.5] * 3, [1.5] * 3, faces, resolution=60)


def vessel(faces: int = 8_000) -> TriMesh:
    """Build a blood vessel that branches in two, with an aneurysm at the fork; three open ends.

    It stands in for the scan of Fig. 18: a sac of high curvature sits on tubes that are nearly flat. The
    likeness ends there.

    Parameters
    ----------
    faces : wanted number, reached to about 5 %

    Raises
    ------
    MeshError
        If so few faces cannot keep the topology.

    Examples
    --------
    >>> len(gw.shapes.vessel(faces=800).boundary_loops)
    3
    """

    def level(x: Vectors) -> Scalars:
        rods = (
            ([0.15, 0.05, -2.4], [0.0, -0.05, -0.7], 0.33, 0.31),
            ([0.0, -0.05, -0.7], [0.0, 0.0, 0.0], 0.31, 0.30),
            ([0.0, 0.0, 0.0], [-0.62, 0.0, 0.75], 0.27, 0.25),
            ([-0.62, 0.0, 0.75], [-0.95, 0.15, 2.4], 0.25, 0.22),
            ([0.0, 0.0, 0.0], [0.66, 0.05, 0.60], 0.26, 0.23),
            ([0.66, 0.05, 0.60], [1.15, -0.15, 2.4], 0.23, 0.20),
        )
        solid = _capsule(x, *rods[0])
        for rod in rods[1:]:
            solid = _joined(solid, _capsule(x, *rod), 0.3)
        return _joined(solid, np.linalg.norm(x - [0.05, 0.42, 0.42], axis=-1) - 0.52, 0.25)

    return level_set(level, [-1.6, -0.8, -1.5], [1.8, 1.2, 1.5], faces, resolution=90)


def crown(prongs: int = 9, faces: int = 12_000) -> TriMesh:
    """Build the splash of a drop: a ring of water that rises into prongs, each ending in a droplet.

    A stand-in for the crowning droplet of Fig. 22, which needs more singularities than a weave can take.

    Parameters
    ----------
    prongs : 3 to 16; more of them would touch
    faces : wanted number, reached to about 5 %

    Raises
    ------
    MeshError
        If the number of prongs is out of range, or so few faces cannot keep the topology.

    Examples
    --------
    >>> gw.shapes.crown(prongs=5, faces=2_000).euler_characteristic
    2
    """
    if not 3 <= prongs <= 16:
        raise MeshError(f"a crown has 3 to 16 prongs, not {prongs}")

    def level(x: Vectors) -> Scalars:
        out = np.hypot(x[..., 0], x[..., 1])
        # One prong stands for all: the plane is folded into its sector.
        sector = 2.0 * np.pi / prongs
        angle = np.arctan2(x[..., 1], x[..., 0])
        angle = np.abs(angle - sector * np.round(angle / sector))
        folded = np.stack([out * np.cos(angle), out * np.sin(angle), x[..., 2]], axis=-1)
        pool = _cylinder(x, [0.0, 0.0, -0.1], 2, radius=1.1, half=0.16, round_=0.12)
        wall = np.stack([out, 0.0 * out, x[..., 2]], axis=-1)
        solid = _joined(pool, _capsule(wall, [0.92, 0.0, 0.0], [1.06, 0.0, 0.45], 0.16, 0.12), 0.15)
        prong = _capsule(folded, [1.06, 0.0, 0.40], [1.30, 0.0, 0.95], 0.13, 0.085)
        drop = np.linalg.norm(folded - [1.33, 0.0, 1.02], axis=-1) - 0.17
        return _joined(solid, _joined(prong, drop, 0.08), 0.15)

    return level_set(level, [-1.6, -1.6, -0.4], [1.6, 1.6, 1.3], faces, resolution=110)


def _joined(a: Scalars, b: Scalars, blend: float) -> Scalars:
    """Unite two solids with a fillet of about the radius `blend`: a smooth minimum of their distances."""
    overlap = np.maximum(blend - np.abs(a - b), 0.0) / blend
    return np.minimum(a, b) - overlap**3 * blend / 6.0


def _capsule(x: Vectors, start: Sequence[float], end: Sequence[float], first: float, last: float) -> Scalars:
    """(...,) distance to a rod between two points, whose radius grows evenly from `first` to `last`."""
    a, b = np.asarray(start), np.asarray(end)
    share = np.clip(((x - a) @ (b - a)) / ((b - a) @ (b - a)), 0.0, 1.0)
    return np.linalg.norm(x - a - share[..., None] * (b - a), axis=-1) - (first + share * (last - first))


def _cylinder(
    x: Vectors, center: Sequence[float], axis: int, *, radius: float, half: float, round_: float
) -> Scalars:
    """(...,) distance to a cylinder along a coordinate axis; `half` is its half length."""
    local = x - np.asarray(center)
    across = np.linalg.norm(np.delete(local, axis, axis=-1), axis=-1) - radius + round_
    along = np.abs(local[..., axis]) - half + round_
    outside = np.hypot(np.maximum(across, 0.0), np.maximum(along, 0.0))
    return outside + np.minimum(np.maximum(across, along), 0.0) - round_


def _box(x: Vectors, center: Sequence[float], half: Sequence[float], round_: float) -> Scalars:
    """(...,) distance to a box with rounded edges; `half` holds half its three sides."""
    gap = np.abs(x - np.asarray(center)) - np.asarray(half) + round_
    outside = np.linalg.norm(np.maximum(gap, 0.0), axis=-1)
    return outside + np.minimum(gap.max(axis=-1), 0.0) - round_
