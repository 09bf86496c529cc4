"""Ribbons as elastic rods: centrelines, thickness directions, sections and contacts (Appendix E).

All rods of a weave are flat arrays, one rod after the other, so that energies need no loop over rods.

Conventions
-----------
Vertex ``p`` lies between segments; segment ``s`` runs from ``layout.ends[s, 0]`` to ``layout.ends[s, 1]`` and
carries the unit tangent ``t``, the thickness direction ``tau`` square to it, and the width direction
``t x tau``. Joint ``j`` is an inner vertex of a rod, between the segments ``layout.joints[j]``. The paper
keeps a reference director d and an angle theta; here tau itself is kept, and a step turns it by theta after
parallel transport. A strip has no upper side: tau and -tau are the same section, so a twist is known only up
to half a turn.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geoweave.arrays import Flags, Indices, Scalars, Vectors, cross, frozen, parallel_transport
from geoweave.errors import RodError

__all__ = ["DERIVED", "Contacts", "Layout", "Material", "Rods"]


DERIVED: Any = None
"""Stands for a field that is not given: it is derived from the others as the value is made."""


@dataclass(frozen=True)
class Material:
    """Thickness and moduli of the ribbons.

    Attributes
    ----------
    thickness : h, a length
    young : Young's modulus Y, force per area
    poisson : Poisson's ratio, between -1 and 1/2; with Y it gives the shear modulus ``Y / (2 + 2 nu)``
    density : mass per volume, used with gravity only

    Raises
    ------
    RodError
        If a number is out of range.

    Examples
    --------
    >>> card = gw.rods.Material(thickness=0.1, young=12.0)
    >>> round(float(card.bending(2.0)), 6), round(float(card.edgewise(2.0)), 6)
    (0.002, 0.8)
    """

    thickness: float
    young: float = 1e8
    poisson: float = 0.3
    density: float = 1.0

    def __post_init__(self) -> None:
        for name, value, right, words in (
            ("thickness", self.thickness, self.thickness > 0, "a positive number"),
            ("Young's modulus", self.young, self.young > 0, "a positive number"),
            ("Poisson's ratio", self.poisson, -1 < self.poisson <= 0.5, "a number from -1 to 0.5"),
            ("density", self.density, self.density >= 0, "zero or a positive number"),
        ):
            if not (np.isfinite(value) and right):
                raise RodError(f"the {name} of the rods is {value:g}; give {words}")

    def stretching(self, width: Scalars) -> Scalars:
        """Return the stretching stiffness ``Y w h``, force."""
        return self.young * width * self.thickness

    def bending(self, width: Scalars) -> Scalars:
        """Return the stiffness ``Y w h^3 / 12`` against normal curvature, force x length^2."""
        return self.young * width * self.thickness**3 / 12.0

    def edgewise(self, width: Scalars) -> Scalars:
        """Return the stiffness ``Y h w^3 / 12`` against geodesic curvature, force x length^2."""
        return self.young * self.thickness * width**3 / 12.0

    def twisting(self, width: Scalars) -> Scalars:
        """Return ``G J`` with ``J = w h^3 (1/3 - 0.21 (h/w) (1 - h^4 / (12 w^4)))``, force x length^2.

        J is the torsion constant of a rectangle, w >= h, within half a percent (Roark's formulas, table of
        torsional members).
        """
        ratio = self.thickness / width
        constant = width * self.thickness**3 * (1 / 3 - 0.21 * ratio * (1 - ratio**4 / 12))
        return self.young / (2.0 + 2.0 * self.poisson) * constant


@dataclass(frozen=True, eq=False)
class Layout:
    """How vertices make rods.

    Attributes
    ----------
    offsets : (R + 1,) rod r owns the vertices ``offsets[r]:offsets[r + 1]``
    closed : (R,) whether a last segment leads from the last vertex of the rod to its first

    Raises
    ------
    RodError
        If a rod has fewer than two vertices, or three when closed.

    Examples
    --------
    >>> layout = gw.rods.Layout(np.array([0, 3, 6]), np.array([False, True]))
    >>> layout.segments, layout.ends[-1].tolist()
    (5, [5, 3])
    """

    offsets: Indices
    closed: Flags

    def __post_init__(self) -> None:
        offsets, closed = np.array(self.offsets, dtype=np.int64), np.array(self.closed, dtype=bool)
        short = np.flatnonzero(np.diff(offsets) < 2 + closed)
        if len(short):
            raise RodError(f"rod {short[0]} has too few vertices; leave it out")
        object.__setattr__(self, "offsets", frozen(offsets))
        object.__setattr__(self, "closed", frozen(closed))

    def __len__(self) -> int:
        return len(self.closed)

    @property
    def vertices(self) -> int:
        """Number of vertices, V."""
        return int(self.offsets[-1])

    @cached_property
    def segments(self) -> int:
        """Number of segments, S."""
        return int(self.segment_offsets[-1])

    @cached_property
    def segment_offsets(self) -> Indices:
        """(R + 1,) rod r owns the segments ``segment_offsets[r]:segment_offsets[r + 1]``."""
        counts = np.diff(self.offsets) - ~self.closed
        return frozen(np.concatenate([[0], np.cumsum(counts)]))

    @cached_property
    def rod_of_vertex(self) -> Indices:
        """(V,) rod that owns each vertex."""
        return frozen(np.repeat(np.arange(len(self)), np.diff(self.offsets)))

    @cached_property
    def rod_of_segment(self) -> Indices:
        """(S,) rod that owns each segment."""
        return frozen(np.repeat(np.arange(len(self)), np.diff(self.segment_offsets)))

    @cached_property
    def ends(self) -> Indices:
        """(S, 2) vertices at the start and the end of each segment."""
        rod = self.rod_of_segment
        start = np.arange(self.segments) - self.segment_offsets[rod] + self.offsets[rod]
        end = np.where(start + 1 < self.offsets[rod + 1], start + 1, self.offsets[rod])
        return frozen(np.column_stack([start, end]))

    @cached_property
    def joints(self) -> Indices:
        """(J, 2) segments before and after each inner vertex; all vertices of a closed rod are inner ones."""
        rod = self.rod_of_segment
        before = np.arange(self.segments)
        last = before + 1 == self.segment_offsets[rod + 1]
        after = np.where(last, self.segment_offsets[rod], before + 1)
        return frozen(np.column_stack([before, after])[~last | self.closed[rod]])


@dataclass(frozen=True, eq=False)
class Contacts:
    """Places where two rods are held together.

    Attributes
    ----------
    segments : (C, 2) segment of each of the two rods
    places : (C, 2) how far along it, 0 to 1 (the paper's alpha)
    over : (C,) 0 or 1, which of the two lies above, on the side its thickness direction points to
    group : (X,) contact that stands for each crossing the rods were made with, -1 for none; if not given,
        each contact stands for one

    Examples
    --------
    >>> met = gw.rods.Contacts(segments=[[0, 5]], places=[[0.5, 0.0]], over=[1])
    >>> len(met), met.group.tolist()
    (1, [0])
    """

    segments: Indices
    places: NDArray[np.float64]
    over: Indices
    group: Indices = DERIVED

    def __post_init__(self) -> None:
        object.__setattr__(self, "segments", frozen(np.array(self.segments, dtype=np.int64).reshape(-1, 2)))
        object.__setattr__(self, "places", frozen(np.array(self.places, dtype=np.float64).reshape(-1, 2)))
        object.__setattr__(self, "over", frozen(np.array(self.over, dtype=np.int64).ravel()))
        group = np.arange(len(self)) if self.group is DERIVED else np.array(self.group, dtype=np.int64)
        object.__setattr__(self, "group", frozen(group))

    def __len__(self) -> int:
        return len(self.over)


@dataclass(frozen=True, eq=False)
class Rods:
    """Elastic rods in space and the contacts between them, immutable.

    Their natural shape is flat and untwisted, of the lengths ``rest``; within its plane it is as curved as
    ``natural`` says, by default straight.

    Attributes
    ----------
    layout : how vertices make rods
    points : (V, 3) centreline vertices, length
    directors : (S, 3) unit thickness directions tau, square to their segments
    widths : (S,) w, length, at least the thickness
    rest : (S,) rest lengths l
    contacts : where rods are held together
    material : thickness and moduli
    edges : (S, 3) segment vectors; kept apart from the points, of which they are the differences, because
        stiff contacts see their direction and a difference of points has lost its last digits
    twists : (J,) angle of tau against its parallel transport over each joint, radians; if not given, the
        branch within a quarter of a turn
    natural : (J,) natural geodesic curvature over each joint, in the measure of `geodesic`: the strip, cut
        free and laid flat, turns there by ``-2 atan(natural / 2)`` to its left, seen from where tau points
        to; if not given, zero: straight strips

    Raises
    ------
    RodError
        If shapes do not fit, a number is not finite, a segment has no length or is folded back on the one
        before it, a ribbon is not as wide as it is thick, or a contact names a place that is not there.

    Examples
    --------
    >>> layout = gw.rods.Layout(np.array([0, 3]), np.array([False]))
    >>> points, up = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), np.array([[0.0, 0, 1]] * 2)
    >>> none = gw.rods.Contacts([], [], [])
    >>> strip = gw.rods.Rods(layout, points, up, np.full(2, 0.1), np.ones(2), none, gw.rods.Material(0.01))
    >>> strip.across[0].tolist()
    [0.0, -1.0, 0.0]
    """

    layout: Layout
    points: Vectors
    directors: Vectors
    widths: Scalars
    rest: Scalars
    contacts: Contacts
    material: Material
    edges: Vectors = DERIVED
    twists: Scalars = DERIVED
    natural: Scalars = DERIVED

    def __post_init__(self) -> None:
        layout = self.layout
        if self.natural is DERIVED:
            object.__setattr__(self, "natural", np.zeros(len(layout.joints)))
        if self.edges is DERIVED:
            start, end = layout.ends.T
            object.__setattr__(self, "edges", self.points[end] - self.points[start])
        for name, shape in (
            ("points", (layout.vertices, 3)),
            ("directors", (layout.segments, 3)),
            ("widths", (layout.segments,)),
            ("rest", (layout.segments,)),
            ("edges", (layout.segments, 3)),
            ("natural", (len(layout.joints),)),
        ):
            array = getattr(self, name)
            if array.shape != shape:
                raise RodError(f"the {name} of the rods are of shape {array.shape}, not {shape}")
            if not np.isfinite(array).all():
                raise RodError(f"the {name} of the rods hold a number that is not finite")
            frozen(array)
        self._check()
        if self.twists is DERIVED:
            wrapped = _wrapped_twists(self)
            object.__setattr__(self, "twists", wrapped - np.pi * np.round(wrapped / np.pi))
        frozen(self.twists)

    def _check(self) -> None:
        rod = self.layout.rod_of_segment
        for bad, words in (
            (~((self.lengths > 0) & (self.rest > 0)), "has no length; merge its vertices"),
            (~(self.widths >= self.material.thickness), "is not as wide as thick; make it wider or thinner"),
        ):
            if bad.any():
                s = int(np.flatnonzero(bad)[0])
                raise RodError(
                    f"rod {rod[s]}: segment {s - self.layout.segment_offsets[rod[s]]} of it {words}"
                )
        folded = ~(self.openness > 0)
        if folded.any():
            s = int(self.layout.joints[np.flatnonzero(folded)[0], 1])
            own = s - self.layout.segment_offsets[rod[s]]
            raise RodError(f"rod {rod[s]}: segment {own} of it is folded back on the one before; merge them")
        where = self.contacts.segments
        if where.size and not 0 <= where.min() <= where.max() < self.layout.segments:
            raise RodError("a contact names a segment that is not there")

    def __len__(self) -> int:
        return len(self.layout)

    @property
    def size(self) -> int:
        """Number of unknowns, 3 V + S: the vertices, then an angle for each segment."""
        return 3 * self.layout.vertices + self.layout.segments

    @cached_property
    def lengths(self) -> Scalars:
        """(S,) length of each segment."""
        return frozen(np.sqrt((self.edges**2).sum(axis=1)))

    @cached_property
    def tangents(self) -> Vectors:
        """(S, 3) unit tangent t of each segment."""
        return frozen(self.edges / self.lengths[:, None])

    @cached_property
    def across(self) -> Vectors:
        """(S, 3) unit width direction ``t x tau``."""
        return frozen(cross(self.tangents, self.directors))

    @cached_property
    def openness(self) -> Scalars:
        """(J,) ``1 + t . t'`` over each joint: 2 where the rod is straight, 0 where it is folded back."""
        a, b = self.layout.joints.T
        return frozen(1.0 + (self.tangents[a] * self.tangents[b]).sum(axis=1))

    @cached_property
    def binormals(self) -> Vectors:
        """(J, 3) curvature binormal ``2 t x t' / (1 + t . t')`` (Bergou et al. 2008)."""
        a, b = self.layout.joints.T
        return frozen(2.0 * cross(self.tangents[a], self.tangents[b]) / self.openness[:, None])

    @cached_property
    def geodesic(self) -> Scalars:
        """(J,) geodesic curvature over each joint, ``-kb . tau`` with the mean of both tau; a pure number."""
        a, b = self.layout.joints.T
        return frozen(-0.5 * (self.binormals * (self.directors[a] + self.directors[b])).sum(axis=1))

    @cached_property
    def spans(self) -> Scalars:
        """(J,) rest length that belongs to each joint, half of both its segments."""
        a, b = self.layout.joints.T
        return frozen(0.5 * (self.rest[a] + self.rest[b]))

    @cached_property
    def joint_widths(self) -> Scalars:
        """(J,) mean width at each joint."""
        a, b = self.layout.joints.T
        return frozen(0.5 * (self.widths[a] + self.widths[b]))

    def stepped(self, step: Scalars) -> Rods:
        """Move by a step in all unknowns: directors are parallel-transported, then turned.

        Parameters
        ----------
        step : (3 V + S,) displacement of each vertex, then angle by which each section turns about its
            segment, radians

        Raises
        ------
        RodError
            If the rods would no longer be rods: a number is not finite, a segment vanishes or is folded.
        """
        moved = step[: 3 * self.layout.vertices].reshape(-1, 3)
        start, end = self.layout.ends.T
        edges = self.edges + (moved[end] - moved[start])
        length = np.sqrt((edges**2).sum(axis=1))
        if not (np.isfinite(step).all() and (length > 0).all()):
            raise RodError("a step makes a segment of the rods vanish, or is not finite")
        directors = parallel_transport(self.tangents, edges / length[:, None], self.directors)
        return self.placed(self.points + moved, edges, directors, step[3 * self.layout.vertices :])

    def placed(self, points: Vectors, edges: Vectors, directors: Vectors, angles: Scalars) -> Rods:
        """Return rods at new places, with directors turned by angles (S,); twists change continuously."""
        tangents = edges / np.linalg.norm(edges, axis=1)[:, None]
        turned = directors - (directors * tangents).sum(axis=1)[:, None] * tangents
        turned = np.cos(angles)[:, None] * turned + np.sin(angles)[:, None] * cross(tangents, turned)
        turned /= np.linalg.norm(turned, axis=1)[:, None]
        new = replace(self, points=points, edges=edges, directors=turned, twists=self.twists)
        wrapped = _wrapped_twists(new)
        twists = wrapped - np.pi * np.round((wrapped - self.twists) / np.pi)
        object.__setattr__(new, "twists", frozen(twists))
        return new


def _wrapped_twists(rods: Rods) -> Scalars:
    """(J,) angle from the transported director to the next one, in (-pi, pi]."""
    a, b = rods.layout.joints.T
    across = parallel_transport(rods.tangents[a], rods.tangents[b], rods.directors[a])
    sine = (rods.tangents[b] * cross(across, rods.directors[b])).sum(axis=1)
    return np.arctan2(sine, (across * rods.directors[b]).sum(axis=1))
