"""Evenly spaced streamlines of a face field, placed as by Jobard and Lefer (1997).

Distances are measured in space, between points whose normals agree. New lines start beside lines that are
there: at points found by walking straight across the surface, at a right angle to the line.
"""

from __future__ import annotations

from dataclasses import dataclass
from heapq import heapify, heappop, heappush

import numpy as np

from geoweave.arrays import Complexes, Flags, Indices
from geoweave.curves.curves import Curve, Curves
from geoweave.curves.face_walk import Ground, ground
from geoweave.curves.integral_curve import Buffer, places_beside, trace
from geoweave.curves.streamline_spacing import enlarged, first_free, forget, room_for
from geoweave.errors import FieldError
from geoweave.fields import FaceField, vertex_indices
from geoweave.surface import TriMesh

__all__ = ["Spacing", "streamlines"]

BARE_TRIALS = 200
"""Faces from which the rounds before the last one try to start a line that is beside no other."""

ROUNDS = (8.0, 3.0, 1.0)
"""Lengths of the shortest lines in each round, as multiples of the shortest line that stays."""

OWN_SAMPLES = 1.0
"""A line is not kept away from its own points nearer than this along it, in separations."""

CLOSING_ZONE = 1.2
"""A line that comes back to its start may pass its own points up to this far along it, in separations."""

FIRST_POINTS = 4096
"""Points of a line for which there is room before it is doubled."""


@dataclass(frozen=True)
class Spacing:
    """How streamlines keep their distance; all but ``separation`` are shares of the separation.

    Attributes
    ----------
    separation : wanted distance between neighbours, a length
    stop : a line ends where another comes nearer than this
    seed : a new line starts only where no other is nearer than this
    shortest : open lines shorter than this are dropped
    close : a line that returns to its start within this distance is closed
    sample : distance between the points at which distances are tested
    """

    separation: float
    stop: float = 0.6
    seed: float = 0.9
    shortest: float = 2.0
    close: float = 0.25
    sample: float = 0.1


def streamlines(
    field: FaceField,
    *,
    separation: float | None = None,
    share: float = 0.04,
    singular: Flags | None = None,
    guard: float = 0.25,
    stop: float = 0.6,
    shortest: float = 2.0,
    seed: int = 0,
) -> Curves:
    """Trace evenly spaced integral curves of a field over the whole surface (Jobard and Lefer 1997).

    Lines end at the boundary, at singular vertices, at walls where the field on both sides points to an edge
    with more than 60 degrees between, and where they come too near to another line or to themselves.

    Parameters
    ----------
    field : the field; its vectors' lengths do not matter, faces where it is zero are not entered
    separation : distance between neighbouring lines, in the unit of the mesh
    share : the separation as a share of the bounding radius (farthest vertex from the vertex mean), used if
        ``separation`` is not given
    singular : (V,) vertices where lines end; by default those of non-zero index
    guard : lines end at this share of the shortest edge around a singular vertex
    stop : lines end nearer to each other than this share of the separation
    shortest : open lines shorter than this share of the separation are left out
    seed : the order in which leftover faces are tried

    Returns
    -------
    Curves
        Directed along the field, the same for the same arguments.

    Raises
    ------
    FieldError
        If the separation is not a positive length, or a share is out of range, or the flags do not fit.

    Examples
    --------
    >>> import geoweave as gw
    >>> lines = gw.streamlines(gw.smoothest_field(gw.shapes.torus(faces=400)), share=0.2)
    >>> bool((lines.lengths > 0.4 * lines.mesh.bounding_radius).all())
    True
    """
    mesh = field.mesh
    if separation is None:
        separation = share * mesh.bounding_radius
    if not (np.isfinite(separation) and separation > 0):
        raise FieldError(f"the separation of streamlines must be a positive length, not {separation}")
    if not 0 < stop <= 0.9:
        raise FieldError(f"the stopping distance must be a share of the separation in (0, 0.9], not {stop}")
    if singular is None:
        singular = vertex_indices(field) != 0
    if singular.shape != (mesh.n_vertices,):
        raise FieldError(f"flags of singular vertices need shape ({mesh.n_vertices},), not {singular.shape}")
    nearest = np.full(mesh.n_vertices, np.inf)
    np.minimum.at(nearest, mesh.edges.ravel(), np.repeat(mesh.edge_lengths, 2))
    radius = np.where(singular, guard * nearest, 0.0)
    placement = _Placement(
        ground(mesh, field.values, radius), Spacing(separation, stop=stop, shortest=shortest)
    )
    placement.fill(np.random.default_rng(seed).permutation(mesh.n_faces))
    return placement.curves(mesh)


def _buffer(points: int) -> Buffer:
    return Buffer(
        np.empty((points, 3)),
        np.empty(points, dtype=np.int64),
        np.empty(points),
        np.zeros(points, dtype=bool),
    )


class _Placement:
    """The lines placed so far and the samples that keep further ones apart."""

    def __init__(self, surface: Ground, spacing: Spacing) -> None:
        self.ground, self.spacing = surface, spacing
        corners = surface.vertices[surface.faces]
        area = 0.5 * np.linalg.norm(
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
        )
        d = spacing.separation
        self._samples_of_line = FIRST_POINTS
        capacity = int(min(1e6, area.sum() / (d * d * spacing.sample))) + 4 * self._samples_of_line
        self.samples = room_for(capacity, d, surface.vertices.min(axis=0))
        self.count = 0
        self.buffers = (_buffer(FIRST_POINTS), _buffer(FIRST_POINTS))
        self.lines: list[Curve] = []
        self.length: list[float] = []
        self.least = 0.0
        # In the order in which `trace` reads them.
        self.gauge = d * np.array([spacing.stop, OWN_SAMPLES, spacing.close, CLOSING_ZONE, spacing.sample])

    def fill(self, order: Indices) -> None:
        """Place lines beside lines until none fits, then one from the centre of the next bare face.

        In several rounds, long lines first: the later and shorter ones close the gaps between them.
        """
        sides = self.ground.sides[order]
        centres = (sides[:, 2] - sides[:, 1]) / 3.0
        for least in ROUNDS:
            self.least = least * self.spacing.shortest * self.spacing.separation
            # Bare faces are many before there are lines, and all but a few are beside a line later.
            stride = len(order) // BARE_TRIALS if least > 1.0 else 1
            self._fill(order[:: max(1, stride)], centres[:: max(1, stride)])

    def _fill(self, faces: Indices, places: Complexes) -> None:
        near, bare = self.spacing.seed * self.spacing.separation, 0
        waiting = [(-self.length[number], number) for number in range(len(self.lines))]
        heapify(waiting)
        while bare < len(faces) or waiting:
            while waiting:
                _, number = heappop(waiting)
                line, distance = self.lines[number], self.spacing.separation
                beside = places_beside(self.ground, line.points, line.faces, line.closed, distance)
                c = 0
                while c < len(beside[0]):
                    c = first_free(self.ground, self.samples, *beside, c, near)
                    if c < len(beside[0]) and self._add(int(beside[0][c]), complex(beside[1][c])):
                        heappush(waiting, (-self.length[-1], len(self.lines) - 1))
                    c += 1
            bare = first_free(self.ground, self.samples, faces, places, bare, near)
            if bare < len(faces) and self._add(int(faces[bare]), complex(places[bare])):
                heappush(waiting, (-self.length[-1], len(self.lines) - 1))
            bare += 1

    def _add(self, face: int, place: complex) -> bool:
        """Trace both ways from a place; keep the line if it is long enough, and say whether it was."""
        first = self.count
        while True:
            ahead, back = self.buffers
            n, self.count, closed = trace(
                self.ground, self.samples, first, ahead, face, place, 1.0, len(self.lines), self.gauge
            )
            m = 1
            if not closed and n < len(ahead.faces):
                m, self.count, _ = trace(
                    self.ground,
                    self.samples,
                    self.count,
                    back,
                    face,
                    place,
                    -1.0,
                    len(self.lines),
                    self.gauge,
                )
            if n < len(ahead.faces) and m < len(back.faces):
                break
            forget(self.samples, first, self.count)
            self._grow()
        # Going back, the segment between points i and i + 1 lies in face i; turned round it starts at i + 1.
        behind = slice(m - 1, 0, -1)
        points = np.concatenate([back.points[behind], ahead.points[:n]])
        faces = np.concatenate([back.faces[: m - 1][::-1], ahead.faces[:n]])
        sliding = np.concatenate([back.sliding[: m - 1][::-1], ahead.sliding[:n]])
        turning = np.concatenate([-back.turning[behind], ahead.turning[:n]])
        turning[[0, -1]] *= closed
        length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
        if len(points) < 2 or length < self.least:
            forget(self.samples, first, self.count)
            self.count = first
            return False
        self.length.append(float(length))
        self.lines.append(Curve(points, faces, turning, sliding, bool(closed)))
        if len(self.samples.line) - self.count < self._samples_of_line:
            self._grow()
        return True

    def _grow(self) -> None:
        """Double the room for samples and for the points of a line."""
        self.buffers = (_buffer(2 * len(self.buffers[0].faces)), _buffer(2 * len(self.buffers[1].faces)))
        self.samples, self._samples_of_line = enlarged(self.samples), 2 * self._samples_of_line

    def curves(self, mesh: TriMesh) -> Curves:
        """All lines as one set."""
        if not self.lines:
            raise FieldError(
                "no streamline of the asked length fits on the surface: choose a smaller separation"
            )
        return Curves.concatenate(mesh, self.lines)
