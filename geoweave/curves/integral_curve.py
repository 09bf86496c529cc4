"""One integral curve of a face field, traced exactly from face to face.

A field is constant on each face, so its integral curves are polylines: straight inside a face, passing to
the neighbour at an edge. Where the vectors on both sides of an edge point to it, the curve follows the edge
to its end (the solution of the discontinuous equation in Filippov's sense). Where they meet at more than 60
degrees the edge is a wall, and the curve ends.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geoweave.arrays import Complexes, Flags, Indices, Scalars, Vectors
from geoweave.compiled import compiled
from geoweave.curves.face_walk import (
    WALL,
    Ground,
    around_vertex,
    corner,
    cross,
    dot,
    in_space,
    leave,
    on_edge_in_space,
    straight_walk,
    unfold,
)
from geoweave.curves.streamline_spacing import Samples, blocked, remember


class Buffer(NamedTuple):
    """Room for the points of one line; see `geoweave.curves.Curve`."""

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
def _start(g: Ground, face: int, place: complex, way: complex) -> Vectors:
    """(3, 3) first point of a line, its heading there and the direction to its left."""
    start = np.zeros((3, 3))
    in_space(g, face, place, start[0])
    in_space(g, face, place + way, start[1])
    in_space(g, face, place + 1j * way, start[2])
    start[1] -= start[0]
    start[2] -= start[0]
    return start


@compiled
def _over_edge(
    g: Ground, face: int, k: int, share: float, place: complex, way: complex, sign: float
) -> tuple[int, int, int, complex, float]:
    """Cross half-edge k of a face at a share of it, where the place is ``place``.

    Returns
    -------
    kind (0 goes on inside the face, 1 along the edge, -1 ends at a wall), face, corner of it (the edge leads
    from that corner to the next), place there, turning angle
    """
    other, rotation = g.across[face, k], unfold(g, face, k)
    there, side = other // 3, other % 3
    onward, beyond = sign * g.field[there], g.sides[there, side]
    way = rotation * way
    turned = np.angle(onward * way.conjugate())
    along = 0
    if cross(beyond, onward) <= 0.0:
        # Both vectors point to this edge: the line follows it to its end, unless it is a wall.
        if onward == 0j or dot(onward, way) < WALL:
            return -1, face, k, place, 0.0
        if dot(beyond, way + onward) < 0.0:
            # It runs from tail to head in the face left behind.
            way = way * rotation.conjugate()
            return 1, face, (k + 1) % 3, place, np.angle(g.sides[face, k] * way.conjugate())
        along, turned = 1, np.angle(beyond * way.conjugate())
    first = (side + 1) % 3
    return along, there, first, corner(g, there, first) + (1.0 - share) * beyond, turned


@compiled
def _end(
    g: Ground, face: int, place: complex, k: int, share: float, inside: bool, sliding: bool, out: Vectors
) -> None:
    """Write the end of a segment: a place inside the face, or the same to the last bit from either side."""
    if inside:
        in_space(g, face, place, out)
    elif sliding:
        out[:] = g.vertices[g.faces[face, (k + 1) % 3]]
    else:
        on_edge_in_space(g, face, k, share, out)


@compiled
def trace(
    g: Ground, q: Samples, count: int, out: Buffer, face: int, place: complex, sign: float, line: int,
    gauge: Scalars,
) -> tuple[int, int, bool]:  # fmt: skip
    """Follow ``sign`` times the field from a place and fill the buffer; ``gauge`` is that of `_advance`.

    Returns
    -------
    number of points (the capacity of the buffer if it did not suffice), samples so far, whether it closed
    """
    first_face, first_place = face, place
    way = sign * g.field[face]
    start = _start(g, face, place, way)
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
        _end(g, face, place + reach * way, k, share, reach < length, sliding, out.points[n])
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
        if g.across[face, k] < 0:
            break
        kind, face, k, place, turned = _over_edge(g, face, k, share, target, way, sign)
        if kind < 0:
            break
        out.turning[n - 1] = turned
        sliding, entry = kind == 1, (k + 2) % 3
    if n + 2 >= len(out.faces) or count + 2 >= len(q.line):
        return len(out.faces), count, False
    # The tip is seldom at a sample; later lines must keep away from it too.
    remember(q, count, out.points[n - 1], g.normals[out.faces[n - 1]], line, sign * s)
    return n, count + 1, False


@compiled
def places_beside(
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
