"""Curves on a surface as flat arrays, and how much they bend within it (Section 3: geodesic curvature)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from geoweave.arrays import Flags, Indices, Scalars, Vectors, frozen
from geoweave.compiled import compiled
from geoweave.errors import FieldError
from geoweave.surface import Part, TriMesh

WINDOW_EDGES = 4.0
"""Half-width of the window over which a turning angle is spread, in mean edge lengths."""

TINY = 1e-300
"""In place of a length of zero, by which nothing can be divided."""


@dataclass(frozen=True, eq=False)
class Curve:
    """One polyline on the surface; the arrays are views into those of `Curves`.

    Attributes
    ----------
    points : (P, 3); a closed curve does not repeat its first point
    faces : (P,) face that holds the segment from each point to the next
    turning : (P,) signed angle turned at each point within the surface, radians, left is positive
    sliding : (P,) whether the segment from each point runs along an edge
    closed : whether a last segment leads back to the first point
    """

    points: Vectors
    faces: Indices
    turning: Scalars
    sliding: Flags
    closed: bool


@dataclass(frozen=True, eq=False)
class Curves:
    """Polylines on a surface whose segments each lie in one face.

    Attributes
    ----------
    mesh : the surface
    points : (P, 3) the points of all curves, one curve after the other
    faces : (P,) face that holds the segment starting at the point; the last point of an open curve has
        the face of the segment before it
    turning : (P,) signed angle in radians that the curve turns at the point within the surface, positive to
        the left; zero where unfolding the faces it passes makes it straight
    sliding : (P,) whether the segment starting at the point runs along an edge, because the vectors on both
        sides of that edge point to it
    offsets : (n + 1,) curve c owns the points ``offsets[c]:offsets[c + 1]``
    closed : (n,) whether a last segment leads from the last point of the curve to its first

    Raises
    ------
    FieldError
        If the arrays do not fit each other, or a curve has fewer than two points.

    Examples
    --------
    >>> import geoweave as gw
    >>> field = gw.geodesic_field(gw.smoothest_field(gw.shapes.torus(faces=400))).field
    >>> leaves = gw.isolines(gw.foliate(field))
    >>> len(leaves.lengths) == len(leaves), leaves[0].closed
    (True, True)
    """

    mesh: TriMesh
    points: Vectors
    faces: Indices
    turning: Scalars
    sliding: Flags
    offsets: Indices
    closed: Flags

    def __post_init__(self) -> None:
        total = len(self.points)
        if any(len(each) != total for each in (self.faces, self.turning, self.sliding)):
            raise FieldError("every point of a set of curves needs one face, one turning angle and one mark")
        if self.offsets[0] != 0 or self.offsets[-1] != total or (np.diff(self.offsets) < 2).any():
            raise FieldError("the offsets of a set of curves must give every curve two points or more")
        for each in (self.points, self.faces, self.turning, self.sliding, self.offsets, self.closed):
            frozen(each)

    def __len__(self) -> int:
        return len(self.closed)

    def __getitem__(self, index: int) -> Curve:
        own = slice(self.offsets[index], self.offsets[index + 1])
        return Curve(
            self.points[own],
            self.faces[own],
            self.turning[own],
            self.sliding[own],
            bool(self.closed[index]),
        )

    def __iter__(self) -> Iterator[Curve]:
        return (self[index] for index in range(len(self)))

    @classmethod
    def concatenate(cls, mesh: TriMesh, curves: Iterable[Curve]) -> Curves:
        """Put single curves on one mesh into one set, in their order; possibly none.

        A set of curves is iterated curve by curve, so that ``chain(one, two)`` joins two sets.
        """
        each = list(curves)
        return Curves(
            mesh,
            np.concatenate([np.zeros((0, 3)), *(one.points for one in each)]),
            np.concatenate([np.zeros(0, dtype=np.int64), *(one.faces for one in each)]),
            np.concatenate([np.zeros(0), *(one.turning for one in each)]),
            np.concatenate([np.zeros(0, dtype=bool), *(one.sliding for one in each)]),
            np.cumsum([0, *(len(one.faces) for one in each)]),
            np.array([one.closed for one in each], dtype=bool),
        )

    @cached_property
    def curve_of_point(self) -> Indices:
        """(P,) curve that owns each point."""
        return frozen(np.repeat(np.arange(len(self)), np.diff(self.offsets)))

    @cached_property
    def following(self) -> Indices:
        """(P,) the next point along the curve; the last point of an open curve follows itself."""
        following = np.arange(1, len(self.points) + 1)
        last = self.offsets[1:] - 1
        following[last] = np.where(self.closed, self.offsets[:-1], last)
        return frozen(following)

    @cached_property
    def segments(self) -> Vectors:
        """(P, 3) vector from each point to the next, zero at the end of an open curve."""
        return frozen(self.points[self.following] - self.points)

    @cached_property
    def segment_lengths(self) -> Scalars:
        """(P,) length of the segment starting at each point."""
        return frozen(np.linalg.norm(self.segments, axis=1))

    @cached_property
    def lengths(self) -> Scalars:
        """(n,) length of each curve."""
        return frozen(np.add.reduceat(self.segment_lengths, self.offsets[:-1]))

    @cached_property
    def arclength(self) -> Scalars:
        """(P,) distance of each point from the start of its curve."""
        before = np.cumsum(self.segment_lengths) - self.segment_lengths
        return frozen(before - before[self.offsets[:-1]][self.curve_of_point])

    @property
    def normals(self) -> Vectors:
        """(P, 3) unit normal of the face at each point."""
        return self.mesh.face_normals[self.faces]

    def segments_at(self, which: Indices, arclength: Scalars) -> Indices:
        """(n,) point that starts the segment of a curve at a distance from its start."""
        # One coordinate that grows over all curves finds every segment at once.
        begin = np.cumsum(self.lengths) - self.lengths
        axis = self.arclength + begin[self.curve_of_point]
        segment = np.searchsorted(axis, arclength + begin[which], side="right") - 1
        return np.clip(segment, self.offsets[which], self.offsets[which + 1] - 1)

    def sampled(self, step: float) -> CurveSamples:
        """Points at equal distances along each curve, about ``step`` apart and half of that from its ends."""
        number = np.maximum(np.ceil(self.lengths / step).astype(np.int64), 1)
        owner = np.repeat(np.arange(len(self)), number)
        rank = np.arange(len(owner)) - np.repeat(np.cumsum(number) - number, number)
        at = (rank + 0.5) * (self.lengths / number)[owner]
        segment = self.segments_at(owner, at)
        heading = self.segments[segment] / np.maximum(self.segment_lengths[segment], TINY)[:, None]
        points = self.points[segment] + (at - self.arclength[segment])[:, None] * heading
        return CurveSamples(owner, at, points, heading, self.normals[segment])


class CurveSamples(NamedTuple):
    """Points along curves."""

    curve: Indices
    """(n,) the curve, ascending."""
    arclength: Scalars
    """(n,) distance from its start, ascending on each curve."""
    points: Vectors
    """(n, 3) the place."""
    heading: Vectors
    """(n, 3) unit vector along the curve."""
    normals: Vectors
    """(n, 3) unit normal of the surface."""


def lifted(curves: Curves, part: Part) -> Curves:
    """Take curves drawn on a part of a surface to the whole surface: the same lines in the whole's faces.

    Raises
    ------
    FieldError
        If the curves lie on another mesh than the part's.
    """
    if curves.mesh is not part.mesh:
        raise FieldError("the curves do not lie on the mesh of the part that is to be lifted from")
    return replace(curves, mesh=part.whole, faces=part.faces[curves.faces])


def geodesic_curvature(curves: Curves, window: float | None = None) -> Scalars:
    """Signed geodesic curvature, the turning per length ``k(s) = sum_q turning_q K(s - s_q) / integral K``.

    The turning of a polyline is concentrated at its points. The hat ``K(t) = max(0, 1 - |t| / window)``
    spreads it over arc length. On a closed curve the hat runs round the curve. Near an end of an open one it
    stays where it just fits. For a fixed window the result converges under refinement. It is zero on a
    straightest geodesic.

    Parameters
    ----------
    curves : the curves
    window : half-width of the hat, a length; four mean edges of the mesh if not given

    Returns
    -------
    (P,) curvature at each point, 1 / length, positive where the curve bends left.

    Raises
    ------
    FieldError
        If the window is not a positive length.

    Examples
    --------
    >>> import geoweave as gw
    >>> ring = gw.shapes.torus(faces=400)
    >>> line = gw.straightest(ring, [0], ring.frames[[0], 0], 2.0)
    >>> float(abs(gw.geodesic_curvature(line)).max())
    0.0
    """
    width = WINDOW_EDGES * curves.mesh.mean_edge if window is None else float(window)
    if not (np.isfinite(width) and width > 0):
        raise FieldError(f"the window of a geodesic curvature must be a positive length, not {window}")
    return _spread(curves.arclength, curves.turning, curves.offsets, curves.closed, curves.lengths, width)


def bending(curves: Curves) -> float:
    """Mean of ``|kappa_g|`` over the length of all curves, times the bounding radius of their mesh: a number.

    It is 0 for geodesics and 1 for curves that turn one radian on a length of one bounding radius.

    Examples
    --------
    >>> import geoweave as gw
    >>> start = gw.smoothest_field(gw.shapes.torus(faces=400))
    >>> solved = gw.geodesic_field(start).field
    >>> gw.bending(gw.streamlines(solved)) < 2.0
    True
    """
    mean = float(np.average(np.abs(geodesic_curvature(curves)), weights=curves.segment_lengths))
    return mean * curves.mesh.bounding_radius


@compiled
def _spread(
    arclength: Scalars, turning: Scalars, offsets: Indices, closed: Flags, lengths: Scalars, width: float
) -> Scalars:
    out = np.zeros(len(arclength))
    for c in range(len(closed)):
        start, end, length = offsets[c], offsets[c + 1], lengths[c]
        # A hat wider than the closed curve would count a point twice.
        reach = min(width, 0.5 * length) if closed[c] else width
        for p in range(start, end):
            # Half a hat at an end would average over too few facets and show their noise.
            inset = 0.0 if closed[c] else min(width, 0.5 * length)
            s = min(max(arclength[p], inset), length - inset)
            total = 0.0
            for way in (-1, 1):
                q = p if way < 0 else p + 1
                lap = 0.0
                while True:
                    if q < start or q >= end:
                        if not closed[c]:
                            break
                        q -= way * (end - start)
                        lap += way * length
                    gap = arclength[q] + lap - s
                    if way * gap >= reach:
                        break
                    total += turning[q] * max(0.0, 1.0 - abs(gap) / reach)
                    q += way
            left = reach if closed[c] else min(s, reach)
            right = reach if closed[c] else min(length - s, reach)
            mass = left + right - 0.5 * (left * left + right * right) / reach
            out[p] = total / mass if mass > 0.0 else 0.0
    return out
