"""One line of a field: where it goes, where it closes and where it ends."""

from __future__ import annotations

import numpy as np

from geoweave.curves.face_walk import ground
from geoweave.curves.integral_curve import Buffer, places_beside, trace
from geoweave.curves.streamline_spacing import room_for
from geoweave.fields.face_field import FaceField
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh


def line_from_the_centre(mesh: TriMesh, face: int, vectors: np.ndarray, sign: float, room: int = 4096):
    """Follow vectors in space from the centre of a face; no line is there before."""
    field = FaceField.from_ambient(mesh, vectors)
    surface = ground(mesh, field.values, np.zeros(mesh.n_vertices))
    samples = room_for(20_000, 0.1, mesh.vertices.min(axis=0))
    buffer = Buffer(np.empty((room, 3)), np.empty(room, np.int64), np.empty(room), np.zeros(room, bool))
    place = (surface.sides[face, 2] - surface.sides[face, 1]) / 3.0
    gauge = np.array([0.06, 0.1, 0.025, 0.12, 0.01])
    count, _, closed = trace(surface, samples, 0, buffer, face, place, sign, 0, gauge)
    return surface, buffer, count, closed


def test_a_constant_field_in_a_plane_is_followed_to_the_boundary_both_ways() -> None:
    mesh = shapes.square(faces=800)
    vectors = np.tile([1.0, 0.3, 0.0], (mesh.n_faces, 1))
    for sign in (1.0, -1.0):
        _, line, count, closed = line_from_the_centre(mesh, 410, vectors, sign)
        points = line.points[:count]
        assert not closed
        step = points[-1] - points[0]
        assert abs(np.cross(step, [1.0, 0.3, 0.0])[2]) < 1e-9 * np.linalg.norm(step)
        assert np.sign(step[0]) == sign
        assert np.isclose(np.abs(points[-1, :2]).max(), mesh.vertices[:, :2].max())


def test_a_line_round_a_torus_closes() -> None:
    mesh = shapes.torus(faces=3000)
    x, y, _ = mesh.barycenters.T
    _, line, count, closed = line_from_the_centre(mesh, 0, np.stack([-y, x, 0 * x], axis=1), 1.0)
    assert closed
    radius = np.linalg.norm(line.points[:count, :2], axis=1)
    assert np.ptp(radius) < 0.01 * radius.mean()


def test_a_buffer_that_is_too_short_is_said_to_be_full() -> None:
    mesh = shapes.square(faces=800)
    vectors = np.tile([1.0, 0.3, 0.0], (mesh.n_faces, 1))
    _, _, count, closed = line_from_the_centre(mesh, 410, vectors, 1.0, room=6)
    assert (count, closed) == (6, False)


def test_places_beside_a_line_lie_at_the_distance_to_either_side() -> None:
    mesh = shapes.square(faces=800)
    vectors = np.tile([1.0, 0.0, 0.0], (mesh.n_faces, 1))
    surface, line, count, _ = line_from_the_centre(mesh, 410, vectors, 1.0)
    faces, places = places_beside(surface, line.points[:count], line.faces[:count], False, 0.1)
    origin, frames = mesh.vertices[mesh.faces[faces, 0]], mesh.frames[faces]
    points = origin + places.real[:, None] * frames[:, 0] + places.imag[:, None] * frames[:, 1]
    assert len(points) > 4
    np.testing.assert_allclose(np.abs(points[:, 1] - line.points[0, 1]), 0.1, atol=1e-9)
    assert {-1.0, 1.0} == set(np.sign(points[:, 1] - line.points[0, 1]))
