"""Curves as arrays, and the curvature spread over arc length."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from geoweave.curves.curves import Curves, bending, geodesic_curvature
from geoweave.curves.tracing import streamlines
from geoweave.errors import FieldError
from geoweave.fields.face_field import FaceField
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh


@pytest.fixture(scope="module")
def square() -> TriMesh:
    return TriMesh([[0, 0, 0], [8, 0, 0], [8, 8, 0], [0, 8, 0]], [[0, 1, 2], [0, 2, 3]])


def polyline(mesh: TriMesh, *paths: np.ndarray, closed: bool = False) -> Curves:
    """Plane paths with the turning of their corners; the faces play no part in a plane."""
    points, turning, sizes = [], [], []
    for path in paths:
        step = np.roll(path, -1) - path
        turn = np.angle(step * np.roll(step, 1).conj())
        if not closed:
            turn[[0, -1]] = 0.0
        points.append(np.stack([path.real, path.imag, 0 * path.real], axis=1))
        turning.append(turn)
        sizes.append(len(path))
    total = sum(sizes)
    return Curves(
        mesh,
        np.concatenate(points),
        np.zeros(total, dtype=np.int64),
        np.concatenate(turning),
        np.zeros(total, dtype=bool),
        np.concatenate([[0], np.cumsum(sizes)]),
        np.full(len(paths), closed),
    )


def circle(count: int, radius: float = 2.0) -> np.ndarray:
    return 4 + 4j + radius * np.exp(2j * np.pi * np.arange(count) / count)


def test_lengths_and_arclength_count_the_closing_segment(square):
    closed = polyline(square, circle(400), circle(60, 1.0), closed=True)
    assert closed.lengths == pytest.approx([4 * np.pi, 2 * np.pi], rel=2e-3)
    assert closed.arclength[[0, 400]] == pytest.approx([0.0, 0.0])
    opened = polyline(square, circle(400))
    assert opened.lengths[0] == pytest.approx(closed.lengths[0] * 399 / 400)
    assert opened.segment_lengths[-1] == 0.0
    assert opened.arclength[-1] == pytest.approx(opened.lengths[0])


def test_curves_are_a_sequence_of_read_only_views(square):
    curves = polyline(square, circle(10), circle(7, 1.0))
    assert len(curves) == 2
    assert [len(curve.points) for curve in curves] == [10, 7]
    assert not curves[1].closed
    assert np.array_equal(curves[1].points, curves.points[10:])
    assert np.array_equal(curves.curve_of_point, np.repeat([0, 1], [10, 7]))
    with pytest.raises(ValueError, match="read-only"):
        curves[0].points[0] = 0.0


@pytest.mark.parametrize("window", [0.15, 0.3, 1.0, 50.0])
def test_a_closed_circle_has_one_over_its_radius(square, window):
    curves = polyline(square, circle(300), circle(250, 0.5), closed=True)
    curvature = geodesic_curvature(curves, window)
    # a hat over seven corners of a polygon counts them a little unevenly
    tolerance = 0.05 if window < 0.2 else 0.01
    assert curvature[:300] == pytest.approx(0.5, rel=tolerance)
    assert curvature[300:] == pytest.approx(2.0, rel=tolerance)
    clockwise = polyline(square, circle(300)[::-1], closed=True)
    assert geodesic_curvature(clockwise, window) == pytest.approx(-0.5, rel=tolerance)


def test_an_open_arc_keeps_its_curvature_to_the_ends(square):
    curves = polyline(square, circle(400)[:120])
    assert geodesic_curvature(curves, 0.3) == pytest.approx(0.5, rel=0.02)


def test_an_arc_shorter_than_the_window_shows_its_mean(square):
    arc = circle(400)[:12]
    curves = polyline(square, arc)
    expected = 10 * (2 * np.pi / 400) / curves.lengths[0]  # ten corners turn
    assert geodesic_curvature(curves, 1e3) == pytest.approx(expected, rel=1e-3)


def test_a_single_corner_is_spread_as_a_hat(square):
    path = np.concatenate([np.linspace(0, 4, 81), 4 + 1j * np.linspace(0, 4, 81)[1:]])
    curves = polyline(square, path)
    curvature = geodesic_curvature(curves, 0.5)
    expected = 0.5 * np.pi * np.maximum(0, 1 - np.abs(curves.arclength - 4) / 0.5) / 0.5
    assert curvature == pytest.approx(expected, abs=1e-9)
    step = np.diff(curves.arclength)
    total = np.sum(0.5 * (curvature[1:] + curvature[:-1]) * step)
    assert total == pytest.approx(0.5 * np.pi)


def test_neighbouring_curves_do_not_mix(square):
    straight = np.linspace(0, 8, 50) + 1j
    both = polyline(square, straight, circle(100))
    assert np.abs(geodesic_curvature(both, 3.0)[:50]).max() < 1e-12


def test_the_default_window_follows_the_mesh():
    ball = trimesh.creation.icosphere(2)
    mesh = TriMesh(ball.vertices, ball.faces)
    curves = polyline(mesh, circle(100))
    assert np.array_equal(geodesic_curvature(curves), geodesic_curvature(curves, 4 * mesh.mean_edge))


def test_arrays_that_do_not_fit_are_refused(square):
    good = polyline(square, circle(10))
    with pytest.raises(FieldError, match="two points or more"):
        Curves(square, good.points, good.faces, good.turning, good.sliding, np.array([0, 9, 10]), good.closed)
    with pytest.raises(FieldError, match="one turning angle"):
        Curves(square, good.points, good.faces, good.turning[1:], good.sliding, good.offsets, good.closed)
    for window in (0.0, np.nan):
        with pytest.raises(FieldError, match="positive length"):
            geodesic_curvature(good, window)


@pytest.mark.parametrize("size", [1.0, 50.0])
def test_bending_is_a_number_without_unit(size):
    """Circles of radius r turn 1 / r per length: on a disk of radius R the mean of R / r over the lines."""
    disk = shapes.disk(3000)
    mesh = type(disk)(disk.vertices * size, disk.faces)
    x, y, _ = mesh.barycenters.T
    straight = FaceField.from_ambient(mesh, np.stack([0 * x + 1, 0 * x, 0 * x], axis=1))
    assert bending(streamlines(straight, separation=0.1 * size)) < 1e-6
    round_ = FaceField.from_ambient(mesh, np.stack([-y, x, 0 * x], axis=1)).normalized()
    curves = streamlines(round_, separation=0.1 * size)
    mean = np.average(np.abs(geodesic_curvature(curves)), weights=curves.segment_lengths)
    assert bending(curves) == pytest.approx(mean * size, rel=0.02)
    assert 1.0 < bending(curves) < 4.0
