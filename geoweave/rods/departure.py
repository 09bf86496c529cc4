"""How far a weave has gone from its design and from its target surface (Figs. 19 and 22).

Distances are shares of the diagonal of the target's bounding box. Relaxed rods may lie anywhere in space. So
they are first moved rigidly, such that each place of a ribbon comes as near as possible to where it was
designed to be (Kabsch 1976); a boundary that holds them makes this needless. This fit has one answer. A fit
to the surface (ICP) would slide along a torus and turn on a sphere, and would give smaller distances than a
maker sees.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geoweave.arrays import Flags, Scalars, Vectors, frozen
from geoweave.errors import RodError
from geoweave.rods.rods import Rods
from geoweave.surface import TriMesh, closest_points, segment_tree, triangle_tree

__all__ = [
    "Departure",
    "Distances",
    "departure",
    "fitted",
    "held",
    "mean_tilt",
    "rigid_fit",
    "vertex_weights",
]


@dataclass(frozen=True)
class Distances:
    """Sizes of one set of distances, as shares of the bounding diagonal."""

    mean: float
    rms: float
    largest: float


@dataclass(frozen=True, eq=False)
class Departure:
    """Where rods have gone, after the best rigid fit unless something holds them.

    Attributes
    ----------
    to_surface : from the rods to the surface, one side of the Hausdorff distance
    from_surface : from the vertices of the surface to the rods, the other side. A weave has holes, so this is
        not zero for the design either; compare the two
    from_design : from each place of a ribbon to where that place was designed to be
    points : (V, 3) vertices of the rods after the fit
    distance : (V,) from each of these to the surface, in the unit of the model
    worst : vertex that is farthest from the surface
    diagonal : of the bounding box of the surface
    """

    to_surface: Distances
    from_surface: Distances
    from_design: Distances
    points: Vectors
    distance: Scalars
    worst: int
    diagonal: float


def vertex_weights(rods: Rods) -> Scalars:
    """(V,) rest length that belongs to each vertex, half of each segment it ends."""
    ends = rods.layout.ends
    return np.bincount(ends.ravel(), np.repeat(0.5 * rods.rest, 2), minlength=rods.layout.vertices).astype(
        np.float64
    )


def held(rods: Rods) -> Flags:
    """(V,) whether a vertex lies between two contacts of its rod; the others belong to free ends."""
    layout, pair = rods.layout, rods.contacts.segments.ravel()
    rod = layout.rod_of_segment[pair]
    first = layout.offsets[1:].copy()
    last = layout.offsets[:-1] - 1
    np.minimum.at(first, rod, layout.ends[pair, 0])
    past = layout.offsets[rod] + (pair - layout.segment_offsets[rod]) + 1
    np.maximum.at(last, rod, past)
    vertex, owner = np.arange(layout.vertices), layout.rod_of_vertex
    inside = (vertex >= first[owner]) & (vertex <= last[owner])
    met = np.bincount(rod, minlength=len(rods)) > 0
    return inside | (layout.closed & met)[owner]


def rigid_fit(points: Vectors, targets: Vectors, weights: Scalars) -> tuple[Vectors, Vectors]:
    """Rotation R and shift t that minimise ``sum w |p R' + t - q|^2`` (Kabsch 1976).

    Parameters
    ----------
    points, targets : (N, 3) corresponding points p and q
    weights : (N,) w, not negative

    Returns
    -------
    (3, 3) rotation, never a reflection, and (3,) shift; apply as ``points @ R.T + t``.

    Examples
    --------
    >>> square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    >>> rotation, shift = gw.rods.rigid_fit(square, square + 2.0, np.ones(4))
    >>> np.round(shift, 9).tolist()
    [2.0, 2.0, 2.0]
    """
    share = weights / weights.sum()
    middle, goal = share @ points, share @ targets
    u, _, v = np.linalg.svd(((points - middle) * share[:, None]).T @ (targets - goal))
    u[:, 2] *= np.sign(np.linalg.det(u @ v))
    rotation = (u @ v).T
    return rotation, goal - rotation @ middle


def mean_tilt(rods: Rods, design: Rods) -> float:
    """Mean angle, in degrees, by which ribbons have turned out of the plane that they were designed in.

    It is the angle between the thickness directions of a place now and as designed, after the rigid motion
    of `rigid_fit`, averaged over the length.

    Parameters
    ----------
    rods, design : the same rods, now and as designed

    Examples
    --------
    >>> rods = gw.elastic_rods(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)).rods
    >>> round(gw.rods.mean_tilt(rods, rods), 6)
    0.0
    """
    rotation, _ = rigid_fit(rods.points, design.points, vertex_weights(rods))
    now, then = rods.directors @ rotation.T, design.directors
    # By half the angle: the arc cosine of a cosine near 1 would lose half of the digits.
    half = np.arctan2(np.linalg.norm(now - then, axis=1), np.linalg.norm(now + then, axis=1))
    return float(np.degrees(np.average(2.0 * half, weights=rods.rest)))


def fitted(rods: Rods, design: Rods, *, placed: bool = False) -> Vectors:
    """(V, 3) vertices of rods, put on those of their design by the best rigid motion unless they are placed.

    Raises
    ------
    RodError
        If the two are not the same rods.
    """
    if rods.layout is not design.layout and not np.array_equal(rods.layout.offsets, design.layout.offsets):
        raise RodError("the rods have other vertices than their design; compare rods made of one another")
    if placed:
        return rods.points
    rotation, shift = rigid_fit(rods.points, design.points, vertex_weights(design))
    return rods.points @ rotation.T + shift


def departure(rods: Rods, design: Rods, surface: TriMesh, *, placed: bool = False) -> Departure:
    """Measure how far rods are from their design and from the target surface.

    Parameters
    ----------
    rods : relaxed
    design : the same rods as designed, on the surface
    surface : the target
    placed : whether something holds the rods in space, such as a fixed boundary: then they are not moved

    Raises
    ------
    RodError
        If the two are not the same rods.
    """
    points = fitted(rods, design, placed=placed)
    diagonal = float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))
    weights = vertex_weights(design)
    nearest, _ = closest_points(triangle_tree(surface.vertices[surface.faces]), points)
    distance = np.linalg.norm(points - nearest, axis=1)
    back, _ = closest_points(segment_tree(points[rods.layout.ends]), surface.vertices)
    gap = np.linalg.norm(surface.vertices - back, axis=1)
    areas = np.bincount(
        surface.faces.ravel(), np.repeat(surface.face_areas / 3.0, 3), minlength=surface.n_vertices
    ).astype(np.float64)
    moved = np.linalg.norm(points - design.points, axis=1)
    return Departure(
        _distances(distance, weights, diagonal),
        _distances(gap, areas, diagonal),
        _distances(moved, weights, diagonal),
        frozen(points),
        frozen(distance),
        int(np.argmax(distance)),
        diagonal,
    )


def _distances(values: Scalars, weights: Scalars, diagonal: float) -> Distances:
    mean = float(np.average(values, weights=weights))
    rms = float(np.sqrt(np.average(values**2, weights=weights)))
    return Distances(mean / diagonal, rms / diagonal, float(values.max()) / diagonal)
