"""Surfaces made by formulas, one for every kind of topology the paper treats.

Flat and round surfaces are made of rows of nearly equilateral triangles. The others are level sets
(`geoweave.models.implicit`). None needs a file or a random number. Lengths have no unit.
"""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Indices, Scalars, Triangles
from geoweave.errors import MeshError
from geoweave.models.icosahedral import cut_icosahedron
from geoweave.models.implicit import bumpy_box, crown, genus_g, rocker_arm, schwarz_p, vessel
from geoweave.surface import TriMesh
from geoweave.wording import counted

__all__ = [
    "annulus",
    "bumpy_box",
    "cone",
    "crown",
    "cylinder",
    "disk",
    "genus_g",
    "icosahedron",
    "rocker_arm",
    "saddle",
    "schwarz_p",
    "sphere",
    "square",
    "torus",
    "vessel",
]

_ROW = np.sqrt(3.0) / 2.0
"""Height of an equilateral triangle of side one."""


def icosahedron(faces: int = 20) -> TriMesh:
    """Build the regular icosahedron with its 12 vertices on the unit sphere.

    Parameters
    ----------
    faces : wanted number; each of the 20 sides is cut into n^2 triangles, with 20 n^2 nearest to it

    Raises
    ------
    MeshError
        If fewer than 20 faces are asked for.

    Examples
    --------
    >>> gw.shapes.icosahedron(80).n_faces
    80
    """
    _at_least(faces, 20)
    points, triangles = cut_icosahedron(max(1, round(np.sqrt(faces / 20))))
    return TriMesh(points, triangles)


def sphere(faces: int = 20_480, *, subdivisions: int | None = None) -> TriMesh:
    """Build the unit sphere: an icosahedron whose edges are cut into n parts, 20 n^2 faces.

    Parameters
    ----------
    faces : wanted number; the nearest 20 n^2 is taken
    subdivisions : if given, n is 2 to this power: 5 gives the 20,480 faces of Fig. 7

    Raises
    ------
    MeshError
        If fewer than 20 faces are asked for.

    Examples
    --------
    >>> ball = gw.shapes.sphere(faces=2_000)
    >>> bool(abs(ball.face_areas.sum() / (4 * np.pi) - 1) < 0.01)
    True
    """
    _at_least(faces, 20)
    n = 2**subdivisions if subdivisions is not None else max(1, round(np.sqrt(faces / 20)))
    points, triangles = cut_icosahedron(n, bent=True)
    return TriMesh(points / np.linalg.norm(points, axis=1, keepdims=True), triangles)


def torus(major: float = 1.0, minor: float = 0.4, faces: int = 6_000) -> TriMesh:
    """Build the torus of tube radius `minor` around a circle of radius `major` in the plane z = 0.

    Parameters
    ----------
    major, minor : radius of the circle and of the tube
    faces : wanted number, reached to a few per cent

    Raises
    ------
    MeshError
        If not 0 < minor < major, or fewer than 60 faces are asked for.

    Examples
    --------
    >>> torus = gw.shapes.torus(major=1.0, minor=0.4, faces=400)
    >>> torus.genus, torus.boundary_loops
    (1, ())
    """
    if not 0 < minor < major:
        raise MeshError(f"a torus needs 0 < minor < major, not minor = {minor} and major = {major}")
    _at_least(faces, 60)
    around, rows = _grid(2 * np.pi * major, 2 * np.pi * minor, faces)
    rows += rows % 2  # every second row is shifted by half a step, so only an even number closes up
    u, v = _staggered(around, rows, closed=True)
    ring = major + minor * np.cos(2 * np.pi * v)
    points = np.stack(
        [ring * np.cos(2 * np.pi * u), ring * np.sin(2 * np.pi * u), minor * np.sin(2 * np.pi * v)], axis=1
    )
    return TriMesh(points, _band(around, rows, closed=True))


def cylinder(radius: float = 1.0, height: float = 2.0, faces: int = 4_000) -> TriMesh:
    """Build the open cylinder about the z axis between z = -height / 2 and height / 2.

    Parameters
    ----------
    radius, height : of the cylinder
    faces : wanted number, reached to a few per cent

    Raises
    ------
    MeshError
        If fewer than 12 faces are asked for.

    Examples
    --------
    >>> len(gw.shapes.cylinder(faces=400).boundary_loops)
    2
    """
    _at_least(faces, 12)
    around, rows = _grid(2 * np.pi * radius, height, faces)
    u, v = _staggered(around, rows, closed=False)
    points = np.stack(
        [radius * np.cos(2 * np.pi * u), radius * np.sin(2 * np.pi * u), height * (v - 0.5)], axis=1
    )
    return TriMesh(points, _band(around, rows, closed=False))


def annulus(inner: float = 0.4, outer: float = 1.0, faces: int = 4_000) -> TriMesh:
    """Build the flat ring between two radii in the plane z = 0; triangles grow outwards with the radius.

    Parameters
    ----------
    inner, outer : radii of the two boundary circles
    faces : wanted number, reached to a few per cent

    Raises
    ------
    MeshError
        If not 0 < inner < outer, or fewer than 12 faces are asked for.

    Examples
    --------
    >>> ring = gw.shapes.annulus(inner=0.5, outer=1.0, faces=2_000)
    >>> bool(abs(ring.face_areas.sum() / (0.75 * np.pi) - 1) < 0.01)
    True
    """
    if not 0 < inner < outer:
        raise MeshError(f"an annulus needs 0 < inner < outer, not inner = {inner} and outer = {outer}")
    _at_least(faces, 12)
    # In the logarithm of the radius an annulus is a cylinder.
    around, rows = _grid(2 * np.pi, np.log(outer / inner), faces)
    u, v = _staggered(around, rows, closed=False)
    radius = outer * (inner / outer) ** v
    points = np.stack([radius * np.cos(2 * np.pi * u), radius * np.sin(2 * np.pi * u), 0 * u], axis=1)
    return TriMesh(points, _band(around, rows, closed=False))


def disk(faces: int = 4_000) -> TriMesh:
    """Build the flat unit disk in the plane z = 0 from n rings of triangles round its centre.

    Parameters
    ----------
    faces : wanted number; the nearest 6 n^2 is taken

    Raises
    ------
    MeshError
        If fewer than 6 faces are asked for.

    Examples
    --------
    >>> gw.shapes.disk(faces=600).euler_characteristic
    1
    """
    _at_least(faces, 6)
    n = max(1, round(np.sqrt(faces / 6)))
    # A hexagon of triangles; (q, r) counts steps from the middle along two of its three directions.
    q, r = np.meshgrid(np.arange(-n, n + 1), np.arange(-n, n + 1), indexing="ij")
    inside = np.abs(q + r) <= n
    number = np.full((2 * n + 2, 2 * n + 2), -1)
    number[: 2 * n + 1, : 2 * n + 1][inside] = np.arange(inside.sum())
    a, b = np.indices((2 * n + 1, 2 * n + 1))
    up = np.stack([number[a, b], number[a + 1, b], number[a, b + 1]], axis=-1)
    down = np.stack([number[a + 1, b], number[a + 1, b + 1], number[a, b + 1]], axis=-1)
    faces_ = np.concatenate([up.reshape(-1, 3), down.reshape(-1, 3)])
    q, r = q[inside], r[inside]
    ring = np.maximum(np.maximum(np.abs(q), np.abs(r)), np.abs(q + r))
    # Hexagonal rings become circles: a share of a side becomes that share of 60 degrees.
    x, y = q + 0.5 * r, _ROW * r
    sextant = np.floor(np.arctan2(y, x) / (np.pi / 3) + 1e-9)
    turn = np.exp(-1j * sextant * np.pi / 3) * (x + 1j * y)
    along = np.where(ring > 0, turn.imag / _ROW / np.maximum(ring, 1), 0.0)
    z = ring / n * np.exp(1j * (sextant + along) * np.pi / 3)
    points = np.stack([z.real, z.imag, np.zeros(len(z))], axis=1)
    return TriMesh(points, faces_[(faces_ >= 0).all(axis=1)])


def cone(half_angle: float = 60.0, faces: int = 4_000) -> TriMesh:
    """Build the cone with its apex at the origin, opening downwards, of side length 1; its rim is open.

    The angle at the apex is ``2 pi sin(half_angle)``, all curvature sits there. The cone of Fig. 25 and of
    RibbonSim's cone60 has 60 degrees between axis and side.

    Parameters
    ----------
    half_angle : between the axis and the side, degrees, above 10 and below 90
    faces : wanted number, reached to a few per cent

    Raises
    ------
    MeshError
        If the angle is out of range or too few faces are asked for.

    Examples
    --------
    >>> cone = gw.shapes.cone(half_angle=60.0, faces=500)
    >>> len(cone.boundary_loops), round(float(cone.vertices[:, 2].min()), 9)
    (1, -0.5)
    """
    if not 10.0 < half_angle < 90.0:
        raise MeshError(f"the half angle of a cone lies between 10 and 90 degrees, not at {half_angle}")
    slope = np.radians(half_angle)
    # The cone is cut into sectors of nearly equilateral triangles; ring r has r points in each sector.
    sectors = max(3, round(6.0 * np.sin(slope)))
    _at_least(faces, sectors)
    n = max(1, round(np.sqrt(faces / sectors)))
    ring = np.repeat(np.arange(1, n + 1), sectors * np.arange(1, n + 1))
    start = 1 + sectors * np.arange(n + 1) * (np.arange(n + 1) - 1) // 2
    place = 1 + np.arange(len(ring)) - start[ring]

    def point(ring: Indices, sector: Indices, step: Indices) -> Indices:
        around = (sector * ring + step) % np.maximum(sectors * ring, 1)
        return np.where(ring == 0, 0, start[ring] + around)

    sector, step = np.divmod(place, ring)
    outer = [point(ring, sector, step), point(ring, sector, step + 1)]
    up = np.stack([point(ring - 1, sector, step), *outer], axis=1)
    inner = [point(ring - 1, sector, step), point(ring - 1, sector, step + 1)]
    down = np.stack([inner[0], outer[1], inner[1]], axis=1)[step < ring - 1]
    angle = 2.0 * np.pi * place / (sectors * ring)
    side = ring / n
    points = np.stack(
        [side * np.sin(slope) * np.cos(angle), side * np.sin(slope) * np.sin(angle), -side * np.cos(slope)],
        axis=1,
    )
    return TriMesh(np.concatenate([np.zeros((1, 3)), points]), np.concatenate([up, down]))


def saddle(depth: float = 0.5, faces: int = 4_000) -> TriMesh:
    """Build the saddle ``z = depth (x^2 - y^2)`` over the unit disk, negatively curved everywhere.

    Parameters
    ----------
    depth : height of the highest point, above 0 and at most 1; beyond, triangles would become thin
    faces : wanted number; the nearest 6 n^2 is taken

    Raises
    ------
    MeshError
        If the depth is out of range, or fewer than 6 faces are asked for.

    Examples
    --------
    >>> float(gw.shapes.saddle(depth=0.5, faces=600).vertices[:, 2].max())
    0.5
    """
    if not 0.0 < depth <= 1.0:
        raise MeshError(f"the depth of a saddle lies between 0 and 1, not at {depth}")
    flat = disk(faces)
    x, y, _ = flat.vertices.T
    return TriMesh(np.stack([x, y, depth * (x**2 - y**2)], axis=1), flat.faces)


def square(faces: int = 4_000) -> TriMesh:
    """Build the flat square [-1, 1]^2 in the plane z = 0, the diagonals of its cells alternating.

    Parameters
    ----------
    faces : wanted number; the nearest 8 n^2 is taken

    Raises
    ------
    MeshError
        If fewer than 8 faces are asked for.

    Examples
    --------
    >>> float(gw.shapes.square(faces=512).face_areas.sum())
    4.0
    """
    _at_least(faces, 8)
    n = 2 * max(1, round(np.sqrt(faces / 8)))
    x, y = np.meshgrid(np.linspace(-1, 1, n + 1), np.linspace(-1, 1, n + 1), indexing="ij")
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    even = (np.add.outer(np.arange(n), np.arange(n)) % 2 == 0)[..., None]
    first = np.where(even, np.stack([a, b, c], axis=-1), np.stack([a, b, d], axis=-1))
    second = np.where(even, np.stack([a, c, d], axis=-1), np.stack([b, c, d], axis=-1))
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    return TriMesh(points, np.concatenate([first.reshape(-1, 3), second.reshape(-1, 3)]))


def _at_least(faces: int, least: int) -> None:
    """Refuse a number of faces that a surface cannot be made of."""
    if faces < least:
        raise MeshError(f"this surface cannot have {counted(faces, 'face')}: ask for at least {least}")


def _grid(around: float, across: float, faces: int) -> tuple[int, int]:
    """How many points around and rows across give a band of two given lengths even triangles."""
    side = np.sqrt(around * across / (faces * 0.5 * _ROW))
    columns = max(3, round(around / side))
    return columns, max(1, round(faces / (2 * columns)))


def _staggered(around: int, rows: int, *, closed: bool) -> tuple[Scalars, Scalars]:
    """Parameters in [0, 1] of a band's points: u around, odd rows shifted by half a step; v across."""
    lines = rows if closed else rows + 1
    row, column = np.divmod(np.arange(lines * around), around)
    return (column + 0.5 * (row % 2)) / around, row / rows


def _band(around: int, rows: int, *, closed: bool) -> Triangles:
    """(2 around rows, 3) triangles of a band; counter-clockwise where u grows to the right and v upwards."""
    row, column = np.divmod(np.arange(rows * around), around)
    above = (row + 1) % rows if closed else row + 1
    shift = row % 2

    def point(line: Indices, place: Indices) -> Indices:
        return line * around + place % around

    low, low_next = point(row, column), point(row, column + 1)
    high, high_next = point(above, column + shift), point(above, column + shift + 1)
    first = np.stack([low, low_next, high], axis=1)
    second = np.stack([low_next, high_next, high], axis=1)
    return np.concatenate([first, second])
