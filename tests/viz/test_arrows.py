"""Arrows of fields start and end where they should."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from pictures import along

from geoweave import viz
from geoweave.errors import RenderError
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh


@cache
def square() -> TriMesh:
    return shapes.square(faces=200)


def test_arrows_of_a_field_are_centred_and_as_long_as_asked() -> None:
    field = along(square(), [0.0, 1.0, 0.0])
    arrows = viz.face_arrows(field, length=0.05)
    np.testing.assert_allclose(arrows.vectors, np.tile([0, 0.05, 0], (square().n_faces, 1)), atol=1e-15)
    np.testing.assert_allclose(arrows.points + 0.5 * arrows.vectors, square().barycenters, atol=1e-15)


def test_scattered_faces_are_apart_and_everywhere() -> None:
    disk = shapes.disk(faces=4000)
    points = disk.barycenters[viz.scattered(disk, 0.2)]
    gaps = np.linalg.norm(points[:, None] - points, axis=2) + np.eye(len(points))
    assert gaps.min() > 0.05
    # 79 squares of that side have the area of the disk; some at its rim have no face near their middle
    assert 60 < len(points) < 90


def test_arrows_of_a_second_field_start_at_the_tips_of_the_first() -> None:
    first, second = along(square(), [1.0, 0, 0]), along(square(), [0, 0.5, 0])
    some = np.arange(square().n_faces) % 3 == 0
    w = viz.face_arrows(first, length=0.1, faces=some)
    delta = viz.face_arrows(second, length=0.1, faces=some, start=first)
    assert len(w.points) == some.sum()
    np.testing.assert_allclose(delta.points, w.points + w.vectors, atol=1e-15)
    np.testing.assert_allclose(delta.vectors, 0.1 * second.ambient[some], atol=1e-15)


def test_a_mark_is_centred() -> None:
    arrow = viz.mark([0.5, 0, 0], [0, 0.2, 0], "#ff0000")
    np.testing.assert_allclose(arrow.points + 0.5 * arrow.vectors, [[0.5, 0, 0]])


def test_arrows_need_as_many_vectors_as_points() -> None:
    with pytest.raises(RenderError, match="one shape"):
        viz.Arrows(np.zeros((2, 3)), np.zeros((3, 3)))
