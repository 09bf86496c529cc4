"""Evenly spaced streamlines of a face field, traced exactly from face to face.

A field is constant on each face, so its integral curves are polylines: straight inside a face, passing to
the neighbour at an edge. Where the vectors on both sides of an edge point to it the curve follows the edge to
its end (the solution of the discontinuous equation in Filippov's sense), unless they meet so sharply that the
edge is a domain wall. Curves are placed as by Jobard and Lefer (1997), with distances measured between points
of space whose normals agree, and seeds found by walking straight across the surface.
"""

from __future__ import annotations

from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from typing import NamedTuple

import numpy as np

from geoweave.arrays import Complexes, Flags, Indices, Scalars, Vectors
from geoweave.compiled import compiled
from geoweave.curves.curves import Curve, Curves, geodesic_curvature
from geoweave.curves.face_walk import (
    WALL,
    Ground,
    around_vertex,
    corner,
    cross,
    dot,
    ground,
    in_space,
    leave,
    on_edge_in_space,
    straight_walk,
    unfold,
)
from geoweave.curves.streamline_spacing import (
    Samples,
    blocked,
    enlarged,
    first_free,
    forget,
    remember,
    room_for,
)
from geoweave.errors import FieldError
from geoweave.fields import FaceField, vertex_indices
from geoweave.surface import TriMesh

__all__ = ["Curve", "Curves", "Spacing", "geodesic_curvature", "streamlines"]


BARE_TRIALS = 200
"""Faces from which the rounds before the last try to start a line that is beside no other."""


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


# -- one line -------------------------------------------------------------------------------------------


class _Buffer(NamedTuple):
    points: Vectors
    faces: Indices
    turning: Scalars
    sliding: Flags


@compiled
def _advance(
    g: Ground, q: Samples, count: int, end: Vectors, begin: Vectors, face: int, line: int, s: float,
    due: float, sign: float, start: Vectors, gauge: Scalars,
) -> tuple[int, float, float]:  # fmt: skip
    """Sample a segment; return the number of samples, the share of it that is free, where the next is due."""
    stop, free, close, zone, sample = gauge[0], gauge[1], gauge[2], gauge[3], gauge[4]
    length = np.sqrt(((end - begin) ** 2).sum())
    while due < s + length and count < len(q.line):
        share = max(0.0, due - s) / length
        point = begin + share * (end - begin)
        if blocked(q, point, g.normals[face], stop, line, sign * due, free, start, close, zone):
            return count, share, due
        remember(q, count, point, g.normals[face], line, sign * due)
        count += 1
        due += sample
    return count, 1.0, due


@compiled
def _unguarded(g: Ground, face: int, place: complex, way: complex, length: float) -> float:
    """How far a segment goes before it enters the guarded disk around a singular corner of its face."""
    reach = length
    for c in range(3):
        radius = g.guard[g.faces[face, c]]
        if radius > 0.0:
            centre = corner(g, face, c) - place
            foot, off = dot(way, centre), cross(way, centre)
            if abs(off) < radius:
                half = np.sqrt(radius * radius - off * off)
                if foot + half > 0.0:
                    reach = min(reach, max(0.0, foot - half))
    return reach


@compiled
def _trace(
    g: Ground, q: Samples, count: int, out: _Buffer, face: int, place: complex, sign: float, line: int,
    gauge: Scalars,
) -> tuple[int, int, bool]:  # fmt: skip
    """Follow ``sign`` times the field from a place; fill the buffer.

    Returns
    -------
    number of points (the capacity of the buffer if it did not suffice), samples so far, whether it closed
    """
    first_face, first_place = face, place
    way = sign * g.field[face]
    start = np.zeros((3, 3))
    in_space(g, face, place, start[0])
    in_space(g, face, place + way, start[1])
    in_space(g, face, place + 1j * way, start[2])
    start[1] -= start[0]
    start[2] -= start[0]
    out.points[0], out.faces[0], out.turning[0] = start[0], face, 0.0
    # The backward half leaves the sample in the seed to the forward half.
    n, s, due = 1, 0.0, 0.0 if sign > 0 else gauge[4]
    sliding, entry, k, share = False, -1, -1, 0.0
    while n + 2 < len(out.faces) and count + 2 < len(q.line):
        out.faces[n - 1], out.sliding[n - 1] = face, sliding
        if sliding:
            # Along the edge from corner k of the face to the next one.
            target = corner(g, face, (k + 1) % 3)
            way = (target - place) / abs(target - place)
        else:
            way = sign * g.field[face]
            gap = first_place - place
            home = face == first_face and s > gauge[1] and abs(cross(way, gap)) <= gauge[2]
            if home and dot(way, gap) > 0.0:
                count, clear, _ = _advance(
                    g, q, count, start[0], out.points[n - 1], face, line, s, due, sign, start, gauge
                )
                if clear == 1.0:
                    return n, count, True
                break
            k, share = leave(g, face, place, way, entry)
            target = corner(g, face, (k + 1) % 3) + share * g.sides[face, k]
        length = abs(target - place)
        reach = _unguarded(g, face, place, way, length)
        if way == 0j or reach <= 0.0:
            break
        if reach < length:
            in_space(g, face, place + reach * way, out.points[n])
        elif sliding:
            out.points[n] = g.vertices[g.faces[face, (k + 1) % 3]]
        else:
            on_edge_in_space(g, face, k, share, out.points[n])
        count, clear, due = _advance(
            g, q, count, out.points[n], out.points[n - 1], face, line, s, due, sign, start, gauge
        )
        if clear <= 0.0:
            break
        out.points[n] = out.points[n - 1] + clear * (out.points[n] - out.points[n - 1])
        s += clear * reach
        n += 1
        out.faces[n - 1], out.sliding[n - 1], out.turning[n - 1] = face, False, 0.0
        if clear < 1.0 or reach < length:
            break
        if sliding:
            vertex = g.faces[face, (k + 1) % 3]
            if g.around[vertex] == 0.0 or g.guard[vertex] > 0.0:
                break
            kind, face, k, turned = around_vertex(g, face, (k + 2) % 3, sign)
            if kind < 0:
                break
            out.turning[n - 1] = turned
            sliding, place, entry = kind == 1, corner(g, face, k), 3 + k
            continue
        other = g.across[face, k]
        if other < 0:
            break
        rotation = unfold(g, face, k)
        there, side = other // 3, other % 3
        onward, beyond = sign * g.field[there], g.sides[there, side]
        way = rotation * way
        out.turning[n - 1] = np.angle(onward * way.conjugate())
        if cross(beyond, onward) <= 0.0:
            # Both vectors point to this edge: the line follows it to its end, unless it is a wall.
            if onward == 0j or dot(onward, way) < WALL:
                out.turning[n - 1] = 0.0
                break
            sliding = True
            if dot(beyond, way + onward) < 0.0:
                # It runs from tail to head in the face left behind.
                way, k, beyond = way * rotation.conjugate(), (k + 1) % 3, g.sides[face, k]
                place = target
                out.turning[n - 1] = np.angle(beyond * way.conjugate())
                continue
            out.turning[n - 1] = np.angle(beyond * way.conjugate())
        face, entry, k = there, side, (side + 1) % 3
        place = corner(g, face, k) + (1.0 - share) * g.sides[face, side]
    if n + 2 >= len(out.faces) or count + 2 >= len(q.line):
        return len(out.faces), count, False
    # The tip is seldom at a sample; later lines must keep away from it too.
    remember(q, count, out.points[n - 1], g.normals[out.faces[n - 1]], line, sign * s)
    return n, count + 1, False


@compiled
def _sideways(
    g: Ground, points: Vectors, faces: Indices, closed: bool, distance: float
) -> tuple[Indices, Complexes]:
    """Places at a distance to the left and right of a line, at every half of the distance along it."""
    n = len(faces)
    segments = n if closed else n - 1
    length = 0.0
    for i in range(segments):
        length += np.sqrt(((points[(i + 1) % n] - points[i]) ** 2).sum())
    room = 2 * (int(length / (0.5 * distance)) + 2)
    out_faces, out_places = np.empty(room, dtype=np.int64), np.empty(room, dtype=np.complex128)
    m, s, due = 0, 0.0, 0.25 * distance
    for i in range(segments):
        face = faces[i]
        a, b = 0j, 0j
        origin = g.vertices[g.faces[face, 0]]
        for x in range(3):
            frame = complex(g.frames[face, 0, x], g.frames[face, 1, x])
            a += (points[i, x] - origin[x]) * frame
            b += (points[(i + 1) % n, x] - origin[x]) * frame
        step = abs(b - a)
        while due < s + step:
            place = a + (b - a) * ((due - s) / step)
            for way in (1j, -1j):
                end, where, arrived = straight_walk(g, face, place, way * (b - a) / step, distance)
                if arrived and m < room:
                    out_faces[m], out_places[m] = end, where
                    m += 1
            due += 0.5 * distance
        s += step
    return out_faces[:m], out_places[:m]


# -- all lines ------------------------------------------------------------------------------------------


def _room(points: int) -> _Buffer:
    return _Buffer(
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
        self._samples_of_line = 4096
        capacity = int(min(1e6, area.sum() / (d * d * spacing.sample))) + 4 * self._samples_of_line
        self.samples = room_for(capacity, d, surface.vertices.min(axis=0))
        self.count = 0
        self.buffers = (_room(4096), _room(4096))
        self.lines: list[tuple[Vectors, Indices, Scalars, Flags, bool]] = []
        self.length: list[float] = []
        self.least = 0.0
        # In the order _advance reads them: stop, own samples passed over, closing, zone of the start, step.
        self.gauge = d * np.array([spacing.stop, 1.0, spacing.close, 1.2, spacing.sample])

    def fill(self, order: Indices) -> None:
        """Place lines beside lines until none fits, then one from the centre of the next bare face.

        In several rounds, long lines first: the later and shorter ones close the gaps between them.
        """
        sides = self.ground.sides[order]
        centres = (sides[:, 2] - sides[:, 1]) / 3.0
        for least in (8.0, 3.0, 1.0):
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
                points, own, _, _, closed = self.lines[number]
                beside = _sideways(self.ground, points, own, closed, self.spacing.separation)
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
            n, self.count, closed = _trace(
                self.ground, self.samples, first, ahead, face, place, 1.0, len(self.lines), self.gauge
            )
            m = 1
            if not closed and n < len(ahead.faces):
                m, self.count, _ = _trace(
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
        self.lines.append((points, faces, turning, sliding, bool(closed)))
        if len(self.samples.line) - self.count < self._samples_of_line:
            self._grow()
        return True

    def _grow(self) -> None:
        """Double the room for samples and for the points of a line."""
        self.buffers = (_room(2 * len(self.buffers[0].faces)), _room(2 * len(self.buffers[1].faces)))
        self.samples, self._samples_of_line = enlarged(self.samples), 2 * self._samples_of_line

    def curves(self, mesh: TriMesh) -> Curves:
        """Gather the lines."""
        sizes = np.array([len(line[1]) for line in self.lines], dtype=np.int64)
        if not len(sizes):
            raise FieldError(
                "no streamline of the asked length fits on the surface: choose a smaller separation"
            )
        points, faces, turning, sliding = (
            np.concatenate([line[part] for line in self.lines]) for part in range(4)
        )
        offsets = np.concatenate([[0], np.cumsum(sizes)])
        return Curves(
            mesh, points, faces, turning, sliding, offsets, np.array([line[4] for line in self.lines])
        )
