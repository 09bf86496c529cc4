"""Ribbons laid through what the level sets leave bare (Sections 5.2 and 6).

Level sets end at punctures, and short pieces of them are pruned. What they leave bare lies at the tips of
ears and feet, where no level set runs far enough. A maker would lay a ribbon across it (DEVIATIONS.md, bare).
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np

from geoweave.arrays import Flags, Indices, Scalars, Vectors
from geoweave.curves import Curve, Curves, crossings, nearest_curves, straightest, stretches
from geoweave.surface import TriMesh
from geoweave.weave.ribbon_ends import holding, joined, off_ideal, on_boundary, turned

__all__ = ["Filling", "Laid", "bridged", "filled"]

DIRECTIONS = 36
"""Directions that are tried through a place, evenly turned over half a circle."""

ALONG = 30.0
"""Degrees within which a ribbon runs along another one."""

FARTHEST = (4.0, 12.0)
"""Spacings that a ribbon may go on after the distance of its middle from the nearest one; the second where
the first leaves no way, as from the tip of a bare leg."""

STEP = 0.1
"""Distance between the samples of ribbons that may run along each other, in spacings."""

PIECE = 1.0
"""Length of the pieces in which lines are followed at a time, in spacings."""

MOST = 8
"""Crossings that are looked at on either side of the place."""

PLACES = 8
"""Places between two parts of a weave at which a ribbon that joins them is tried."""

NARROW = (0.2, 0.1)
"""Spacings that such a ribbon may keep from those that it runs along, where it finds no other way."""


class Filling(NamedTuple):
    """What is asked of a ribbon through a bare place, lengths in spacings."""

    families: int
    bare: float
    """A place farther than this from every ribbon is bare."""
    apart: tuple[float, ...]
    """Distances to keep from ribbons that it runs along, the next one where the one before leaves no way."""
    fewest: int
    """Least number of crossings."""
    shallowest: float
    """Least angle of its crossings, degrees."""
    tail: float
    """Length beyond its last crossing."""


class Laid(NamedTuple):
    """Curves with new ones at the end."""

    curves: Curves
    along: Indices
    """(k,) which of the given curves each new one is most nearly parallel to."""


def filled(curves: Curves, spacing: float, asked: Filling) -> Laid:
    """Lay straightest geodesics through the barest places until none is left that takes one.

    Of all directions through the barest place, the one is taken whose crossings are nearest to the angle of
    evenly turned families. The new ribbon ends at the second crossing on either side, or farther out if it
    would have too few.
    """
    mesh, given = curves.mesh, len(curves)
    along = list[int]()
    distance, _ = nearest_curves(curves, mesh.barycenters, mesh.face_normals)
    distance[~np.isin(mesh.face_components, mesh.face_components[curves.faces])] = 0.0
    for farthest, apart in product(FARTHEST, asked.apart):
        left = distance.copy()
        while True:
            face = int(left.argmax())
            if left[face] <= asked.bare * spacing:
                break
            line = _through(curves, face, left[face] + farthest * spacing, spacing, asked, apart)
            if line is None:
                left[_around(mesh, face, spacing)] = 0.0
                continue
            along.append(_parallel(curves, line, given))
            new = Curves.concatenate(mesh, [line])
            curves = Curves.concatenate(mesh, [*curves, line])
            reached, _ = nearest_curves(new, mesh.barycenters, mesh.face_normals)
            distance, left = np.minimum(distance, reached), np.minimum(left, reached)
    return Laid(curves, np.array(along, dtype=np.int64))


def bridged(curves: Curves, one: Flags, spacing: float, asked: Filling) -> Laid | None:
    """Lay a straightest geodesic between two parts of a weave, so that it crosses ribbons of both.

    Parameters
    ----------
    one : (n,) which curves are of the one part; the others are of the other one

    Returns
    -------
    the curves and the new one, or nothing if there is no room for it
    """
    mesh = curves.mesh
    sides = [stretches(curves, np.flatnonzero(part)) for part in (one, ~one)]
    away = np.maximum(*(nearest_curves(each, mesh.barycenters, mesh.face_normals)[0] for each in sides))
    component = mesh.face_components
    away[component != component[sides[0].faces[0]]] = np.inf
    for _ in range(PLACES):
        face = int(away.argmin())
        if np.isinf(away[face]):
            break
        for apart in (*asked.apart, *NARROW):
            line = _through(curves, face, away[face] + FARTHEST[0] * spacing, spacing, asked, apart, one)
            if line is not None:
                along = np.array([_parallel(curves, line, len(curves))])
                return Laid(Curves.concatenate(mesh, [*curves, line]), along)
        away[_around(mesh, face, spacing)] = np.inf
    return None


def _around(mesh: TriMesh, face: int, spacing: float) -> Flags:
    """(F,) faces within a spacing of one."""
    return np.linalg.norm(mesh.barycenters - mesh.barycenters[face], axis=1) < spacing


class _Ray(NamedTuple):
    """A geodesic from a place, and where it may end."""

    at: Scalars
    """Arc lengths of its crossings, up to where it is blocked."""
    off: Scalars
    """By how many degrees each is off the ideal."""
    others: Indices
    """The curves that it crosses there."""
    blocked: float
    """Arc length from which on it runs along another curve or crosses one at too small an angle."""
    rim: bool
    """Whether it comes to the boundary before that."""


def _through(
    curves: Curves,
    face: int,
    reach: float,
    spacing: float,
    asked: Filling,
    apart: float,
    one: Flags | None = None,
) -> Curve | None:
    """The best geodesic through the middle of a face, nothing if no direction serves."""
    mesh, count = curves.mesh, 2 * DIRECTIONS
    # From the longest side on: the shape of the face decides, not which of its corners is the first.
    sides = mesh.halfedge_vectors[face]
    turn = np.angle(sides[np.abs(sides).argmax()]) + np.pi * np.arange(count) / DIRECTIONS
    first, second = mesh.frames[face]
    ways = np.cos(turn)[:, None] * first + np.sin(turn)[:, None] * second
    lines = straightest(mesh, np.full(count, face), ways, reach)
    rays = _rays(curves, lines, spacing, asked, apart)

    def joins(met: Indices) -> bool:
        return one is None or (bool(one[met].any()) and not one[met].all())

    best, chosen = np.inf, None
    for k in range(DIRECTIONS):
        pair = (rays[k], rays[k + DIRECTIONS])
        numbers = _crossed(*pair, asked.fewest, joins)
        if numbers is None:
            continue
        off = np.concatenate([ray.off[:number] for ray, number in zip(pair, numbers, strict=True)])
        if off.mean() < best:
            best, chosen = float(off.mean()), (k, numbers)
    if chosen is None:
        return None
    k, numbers = chosen
    halves = []
    for which, number in zip((k, k + DIRECTIONS), numbers, strict=True):
        ray, length = rays[which], float(lines.lengths[which])
        if number < len(ray.at) or not ray.rim:
            last = float(ray.at[number - 1])
            length = min(last + asked.tail * spacing, 0.5 * (last + ray.blocked), length)
        halves.append(stretches(lines, np.array([which]), np.zeros(1), np.array([length]))[0])
    return joined(turned(halves[1]), halves[0])


def _rays(curves: Curves, lines: Curves, spacing: float, asked: Filling, apart: float) -> list[_Ray]:
    """Where each line from a place may end."""
    seen = np.zeros(curves.mesh.n_faces, dtype=bool)
    seen[lines.faces] = True
    near = np.unique(curves.curve_of_point[seen[curves.faces]])
    some, count = stretches(curves, near), len(near)
    met = crossings(Curves.concatenate(curves.mesh, [*some, *lines]))
    met = met.taken((met.curves[:, 0] < count) & (met.curves[:, 1] >= count))
    met = met.taken(np.lexsort((met.arclength[:, 1], met.curves[:, 1])))
    firm, off = holding(met, asked.shallowest), off_ideal(met.angle, asked.families)
    bounds = np.searchsorted(met.curves[:, 1] - count, np.arange(len(lines) + 1))
    shallow = np.full(len(lines), np.inf)
    np.minimum.at(shallow, met.curves[~firm, 1] - count, met.arclength[~firm, 1])
    blocks = _beside(some, lines, spacing, apart * spacing, shallow)
    rim = on_boundary(lines)[:, 1]
    found = []
    for k in range(len(lines)):
        own = slice(bounds[k], bounds[k + 1])
        at, blocked = met.arclength[own, 1], float(blocks[k])
        free = at < blocked
        others = near[met.curves[own, 0][free]]
        found.append(_Ray(at[free], off[own][free], others, blocked, bool(rim[k]) and np.isinf(blocked)))
    return found


def _crossed(one: _Ray, other: _Ray, fewest: int, joins: Callable[[Indices], bool]) -> tuple[int, int] | None:
    """How many crossings to take on either side, few and evenly shared; None if there are too few."""
    most, least = [], []
    for ray in (one, other):
        most.append(min(len(ray.at), MOST))
        # A side without a boundary needs a crossing that holds its end, and takes a second one if it can.
        least.append(min(2, most[-1]) if len(ray.at) or ray.rim else MOST + 1)
    tried = [
        (a, b) for a in range(least[0], most[0] + 1) for b in range(least[1], most[1] + 1) if a + b >= fewest
    ]
    for a, b in sorted(tried, key=lambda each: (sum(each), abs(each[0] - each[1]))):
        if joins(np.concatenate([one.others[:a], other.others[:b]])):
            return a, b
    return None


def _beside(curves: Curves, lines: Curves, spacing: float, apart: float, ends: Scalars) -> Scalars:
    """(n,) arc length at which each line first comes too near to a curve that it runs along, at most its end.

    Lines are followed from their start together, a piece at a time, and each as far as it is free.
    """
    from scipy.spatial import KDTree

    mine, given = lines.sampled(STEP * spacing), curves.sampled(STEP * spacing)
    middle = lines.points[0]
    local = np.flatnonzero(np.linalg.norm(given.points - middle, axis=1) < lines.lengths.max() + apart)
    tree, found = KDTree(given.points[local]), ends.copy()
    piece = np.floor(mine.arclength / (PIECE * spacing))
    for number in range(int(piece.max(initial=-1)) + 1):
        here = np.flatnonzero((piece == number) & (mine.arclength < found[mine.curve]))
        near = KDTree(mine.points[here]).sparse_distance_matrix(tree, apart, output_type="ndarray")
        a, b = here[near["i"]], local[near["j"]]
        parallel = np.abs((mine.heading[a] * given.heading[b]).sum(axis=1)) > np.cos(np.radians(ALONG))
        parallel &= (mine.normals[a] * given.normals[b]).sum(axis=1) > 0
        np.minimum.at(found, mine.curve[a[parallel]], mine.arclength[a[parallel]])
    return found


def _parallel(curves: Curves, line: Curve, count: int) -> int:
    """Which of the first so many curves is most nearly parallel to a line, of those near its middle."""
    middle = len(line.points) // 2
    way = line.points[middle] - line.points[middle - 1]
    running = np.flatnonzero((curves.curve_of_point < count) & (curves.segment_lengths > 0))
    away = np.linalg.norm(curves.points[running] - line.points[middle], axis=1)
    near = running[away <= 2.0 * away.min()]
    heading: Vectors = curves.segments[near] / curves.segment_lengths[near, None]
    return int(curves.curve_of_point[near[np.abs(heading @ way).argmax()]])
