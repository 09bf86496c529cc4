"""Where curves on a surface cross (Section 5.2): exactly, face by face."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from geoweave.arrays import Complexes, Flags, Indices, Scalars, Vectors, frozen
from geoweave.compiled import compiled
from geoweave.curves.curves import Curves
from geoweave.curves.face_walk import cross, planar

__all__ = ["Crossings", "crossings"]

POINTLIKE = 1e-12
"""Segments shorter than this share of the mean edge have no direction; they cross nothing."""

COINCIDENT = 1e-8
"""Crossings of the same two curves within this share of the mean edge are one crossing."""

PARALLEL = 1e-9
"""Sine of the angle up to which two segments count as parallel."""

ROUNDING = 0.01
"""Share of the distance `COINCIDENT` by which a crossing may lie outside its segment."""


@dataclass(frozen=True, eq=False)
class Crossings:
    """Where curves cross each other or themselves, in the order of the first curve and its arc length.

    Attributes
    ----------
    curves : (n, 2) the two curves, the first not after the second
    segments : (n, 2) point of the set of curves that starts the segment of each
    arclength : (n, 2) place on each curve, a length
    points : (n, 3) the place
    faces : (n,) the face it lies in
    angle : (n,) from the direction of the first curve to that of the second, radians in (-pi, pi), positive
        where the second heads to the left of the first

    Examples
    --------
    >>> import geoweave as gw
    >>> ball = gw.shapes.sphere(faces=320)
    >>> met = gw.crossings(gw.straightest(ball, [0, 0], [[1.0, 0.2, 0.0], [0.2, 1.0, 0.0]], 2.0, behind=2.0))
    >>> len(met) >= 1, met.curves[0].tolist()
    (True, [0, 1])
    """

    curves: Indices
    segments: Indices
    arclength: Scalars
    points: Vectors
    faces: Indices
    angle: Scalars

    def __post_init__(self) -> None:
        for each in (self.curves, self.segments, self.arclength, self.points, self.faces, self.angle):
            frozen(each)

    def __len__(self) -> int:
        return len(self.faces)

    def taken(self, which: Indices | Flags) -> Crossings:
        """Some of the crossings: those that are flagged or numbered, in that order."""
        return Crossings(*(getattr(self, each.name)[which] for each in fields(self)))


def crossings(curves: Curves) -> Crossings:
    """Find all places where two segments in the same face cross, of two curves or of one.

    Only segments of the same face are compared. Where both curves pass the same point of an edge they cross
    if they change sides and touch otherwise; touching is not counted, nor are parallel segments.

    Parameters
    ----------
    curves : on one mesh; a segment belongs to the face its curve says

    Returns
    -------
    Crossings
        Two curves that meet exactly in a vertex, without a face that both pass there, are not among them.

    Examples
    --------
    >>> import geoweave as gw
    >>> foliation = gw.foliate(gw.geodesic_field(gw.smoothest_field(gw.shapes.torus(faces=400))).field)
    >>> len(gw.crossings(gw.isolines(foliation)))
    0
    """
    mesh = curves.mesh
    running = np.flatnonzero(curves.segment_lengths > POINTLIKE * mesh.mean_edge)
    running = running[np.argsort(curves.faces[running], kind="stable")]
    face = curves.faces[running]
    begin = planar(mesh, face, curves.points[running] - mesh.vertices[mesh.faces[face, 0]])
    step = planar(mesh, face, curves.segments[running])
    bounds = np.flatnonzero(np.diff(np.concatenate([[-1], face, [mesh.n_faces]])))
    near = COINCIDENT * mesh.mean_edge
    pairs, shares = _pairs(bounds, running, begin, step, curves.following, ROUNDING * near)
    segments, met_in = running[pairs], face[pairs[:, 0]]
    # Rounding may put a crossing a little before its segment; on a closed curve zero follows the length.
    arclength = curves.arclength[segments] + np.clip(shares, 0.0, 1.0) * curves.segment_lengths[segments]
    owner = curves.curve_of_point[segments]
    around = curves.closed[owner] & (arclength > curves.lengths[owner] - near)
    arclength = np.where(around, 0.0, arclength)
    segments = np.where(around, curves.offsets[owner], segments)
    swap = (owner[:, 0] > owner[:, 1]) | ((owner[:, 0] == owner[:, 1]) & (arclength[:, 0] > arclength[:, 1]))
    turned = np.angle(step[pairs[:, 1]] * step[pairs[:, 0]].conj()) * np.where(swap, -1.0, 1.0)
    for each in (segments, arclength, owner):
        each[swap] = each[swap][:, ::-1]
    kept = _distinct(owner, arclength, turned, near)
    segments, arclength, owner, met_in = segments[kept], arclength[kept], owner[kept], met_in[kept]
    share = (arclength[:, 0] - curves.arclength[segments[:, 0]]) / curves.segment_lengths[segments[:, 0]]
    points = curves.points[segments[:, 0]] + share[:, None] * curves.segments[segments[:, 0]]
    return Crossings(owner, segments, arclength, points, met_in, turned[kept])


@compiled
def _pairs(
    bounds: Indices, running: Indices, begin: Complexes, step: Complexes, following: Indices, near: float
) -> tuple[Indices, Scalars]:
    """Pairs of segments that cross or touch within their face, and the share of each at which they do."""
    room, n = 1024, 0
    pairs, shares = np.empty((room, 2), dtype=np.int64), np.empty((room, 2))
    for bucket in range(len(bounds) - 1):
        for p in range(bounds[bucket], bounds[bucket + 1]):
            for q in range(p + 1, bounds[bucket + 1]):
                if following[running[p]] == running[q] or following[running[q]] == running[p]:
                    continue
                area = cross(step[p], step[q])
                one, two = abs(step[p]), abs(step[q])
                if abs(area) <= PARALLEL * one * two:
                    continue
                gap = begin[q] - begin[p]
                s, t = cross(gap, step[q]) / area, cross(gap, step[p]) / area
                if -near / one <= s <= 1.0 + near / one and -near / two <= t <= 1.0 + near / two:
                    if n == room:
                        room *= 2
                        more, more_shares = np.empty((room, 2), dtype=np.int64), np.empty((room, 2))
                        more[:n], more_shares[:n] = pairs, shares
                        pairs, shares = more, more_shares
                    pairs[n, 0], pairs[n, 1], shares[n, 0], shares[n, 1] = p, q, s, t
                    n += 1
    return pairs[:n], shares[:n]


def _distinct(owner: Indices, arclength: Scalars, angle: Scalars, near: float) -> Indices:
    """Of the findings at one place keep one, and none where they differ in sign: there the curves touch."""
    order = np.lexsort((arclength[:, 1], arclength[:, 0], owner[:, 1], owner[:, 0]))
    owner, arclength = owner[order], arclength[order]
    new = np.ones(len(order), dtype=bool)
    same = (owner[1:] == owner[:-1]).all(axis=1)
    new[1:] = ~(same & (np.abs(np.diff(arclength, axis=0)) < near).all(axis=1))
    group = np.cumsum(new) - 1
    sign = np.sign(angle[order])
    agreed = np.abs(np.bincount(group, sign)) == np.bincount(group) if len(group) else np.zeros(0, bool)
    first = order[new][np.asarray(agreed, dtype=bool)]
    begin = np.lexsort((arclength[new][agreed][:, 0], owner[new][agreed][:, 0]))
    return np.asarray(first[begin], dtype=np.int64)
