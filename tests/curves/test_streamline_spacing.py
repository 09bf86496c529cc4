"""The store of samples finds what a search through all of them finds."""

from __future__ import annotations

import numpy as np
import pytest

from geoweave.curves.streamline_spacing import Samples, blocked, enlarged, forget, remember, room_for

NOWHERE = np.zeros((3, 3))


def store(points: np.ndarray, normals: np.ndarray, cell: float = 1.0) -> Samples:
    samples = room_for(len(points), cell, points.min(axis=0))
    for n in range(len(points)):
        remember(samples, n, points[n], normals[n], n % 7, float(n))
    return samples


def is_blocked(samples, point, normal, near, line=-1, s=0.0, free=0.0, start=NOWHERE, close=0.0, zone=0.0):
    return blocked(samples, point, normal, near, line, s, free, start, close, zone)


@pytest.fixture
def cloud() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(5)
    normals = rng.normal(size=(400, 3))
    return rng.uniform(-4, 4, (400, 3)), normals / np.linalg.norm(normals, axis=1, keepdims=True)


def test_it_agrees_with_a_search_through_all(cloud):
    points, normals = cloud
    samples = store(points, normals)
    rng = np.random.default_rng(6)
    answers = []
    for _ in range(300):
        point, normal, near = rng.uniform(-5, 5, 3), normals[rng.integers(400)], rng.uniform(0.2, 1.0)
        close = np.linalg.norm(points - point, axis=1) < near
        expected = bool((close & (normals @ normal > 0.3)).any())
        assert is_blocked(samples, point, normal, near) == expected
        answers.append(expected)
    assert 0.1 < np.mean(answers) < 0.9


def test_forgotten_samples_are_gone_and_the_others_stay(cloud):
    points, normals = cloud
    samples = store(points, normals)
    forget(samples, 250, 400)
    for n in (0, 100, 249):
        assert is_blocked(samples, points[n], normals[n], 1e-3)
    for n in (250, 300, 399):
        assert not is_blocked(samples, points[n], normals[n], 1e-3)
    remember(samples, 250, points[399], normals[399], 0, 0.0)
    assert is_blocked(samples, points[399], normals[399], 1e-3)


def test_enlarging_keeps_what_is_there(cloud):
    points, normals = cloud
    samples = enlarged(store(points, normals))
    assert len(samples.line) == 800
    for n in range(0, 400, 37):
        assert is_blocked(samples, points[n], normals[n], 1e-3)
    remember(samples, 400, np.array([20.0, 0.0, 0.0]), normals[0], 0, 0.0)
    assert is_blocked(samples, np.array([20.1, 0.0, 0.0]), normals[0], 0.5)


def test_a_line_passes_over_its_own_recent_samples():
    up = np.array([0.0, 0.0, 1.0])
    samples = room_for(20, 1.0, np.zeros(3))
    for n in range(20):
        remember(samples, n, np.array([0.1 * n, 0.0, 0.0]), up, 4, 0.1 * n)
    tip = np.array([2.0, 0.0, 0.0])
    assert is_blocked(samples, tip, up, 0.5, line=-1)
    assert is_blocked(samples, tip, up, 0.5, line=4, s=2.0, free=0.05)
    assert not is_blocked(samples, tip, up, 0.5, line=4, s=2.0, free=1.0)
    # the same place after a long way round is its own past
    assert is_blocked(samples, tip, up, 0.5, line=4, s=9.0, free=1.0)
    assert not is_blocked(samples, tip, -up, 0.5, line=4, s=9.0, free=1.0)


def test_a_line_may_come_back_to_its_start_from_behind():
    up = np.array([0.0, 0.0, 1.0])
    samples = room_for(20, 1.0, np.zeros(3))
    for n in range(20):
        remember(samples, n, np.array([0.1 * n, 0.0, 0.0]), up, 4, 0.1 * n)
    start = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])

    def arrives(x: float, y: float) -> bool:
        point = np.array([x, y, 0.0])
        return not is_blocked(
            samples, point, up, 0.5, line=4, s=9.0, free=1.0, start=start, close=0.2, zone=1.2
        )

    assert arrives(-0.1, 0.1)
    assert not arrives(-0.1, 0.3)
    assert not arrives(0.1, 0.1)
