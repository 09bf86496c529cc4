"""Averages of face values at the vertices."""

from __future__ import annotations

import numpy as np
import pytest

import geoweave as gw
from geoweave.errors import RenderError
from geoweave.viz.smoothing import at_vertices, smoothed


def test_a_constant_stays_and_a_linear_function_nearly() -> None:
    disk = gw.shapes.disk(faces=800)
    assert np.allclose(smoothed(disk, np.full(disk.n_faces, 3.0)), 3.0)
    inside = np.linalg.norm(disk.barycenters, axis=1) < 0.8
    assert np.abs(smoothed(disk, disk.barycenters[:, 0]) - disk.barycenters[:, 0])[inside].max() < 0.02


def test_faces_without_a_value_are_left_out() -> None:
    mesh = gw.TriMesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    average = at_vertices(mesh, np.array([2.0, np.nan]))
    assert np.array_equal(average[:3], [2.0, 2.0, 2.0])
    assert np.isnan(average[3])


def test_one_value_a_face_is_asked_for() -> None:
    disk = gw.shapes.disk(faces=100)
    with pytest.raises(RenderError, match="values of faces need shape"):
        smoothed(disk, np.zeros(disk.n_vertices))
