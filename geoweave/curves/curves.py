"""Curves on a surface as flat arrays, and how much they bend within it (Section 3: geodesic curvature)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from geoweave.arrays import Flags, Indices, Scalars, Vectors, frozen
from geoweave.compiled import compiled
from geoweave.errors import FieldError
from geoweave.surface import Part, TriMesh

WINDOW_EDGES = 4.0
"""Half-width of the window over which a turning angle is spread, in mean edge lengths."""


@dataclass(frozen=True, eq=False)
class Curve:
    """One polyline on the surface; the arrays are views into those of `Curves`.

    Attributes
    ----------
    points : (P, 3); a closed curve does not repeat its first point
    faces : (P,) face that holds the segment from each point to the next
    turning : (P,) signed angle turned at each point within the surface, radians, left is positive
    closed : whether a last segment leads back to the first point
    """

    points: Vectors
    faces: Indices
    turning: Scalars
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
        return Curve(self.points[own], self.faces[own], self.turning[own], bool(self.closed[index]))

    def __iter__(self) -> Iterator[Curve]:
        return (self[index] for index in range(len(self)))

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

    The turning of a polyline sits in its points; the hat ``K(t) = max(0, 1 - |t| / window)`` spreads it over
    arc length and runs round a closed curve; near the ends of an open one it stays where it just fits. For a
    fixed window the result converges under refinement; it is zero on a straightest geodesic.

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
    """
    width = WINDOW_EDGES * curves.mesh.mean_edge if window is None else float(window)
    if not (np.isfinite(width) and width > 0):
        raise FieldError(f"the window of a geodesic curvature must be a positive length, not {window}")
    return _spread(curves.arclength, curves.turning, curves.offsets, curves.closed, curves.lengths, width)


def bending(curves: Curves) -> float:
    """Mean of ``|kappa_g|`` over the length of all curves, times the bounding radius of their mesh: a number.

    It is 0 for geodesics and 1 for curves that turn one radian on a length of one bounding radius.
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
            # Half a hat at an end would show the noise of single facets.
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
