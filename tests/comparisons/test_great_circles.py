from __future__ import annotations

import numpy as np
import pytest
from surfaces import surface

from geoweave.comparisons.great_circles import meridian_angle, meridian_axis, meridian_field
from geoweave.fields.face_field import FaceField, total_curl
from geoweave.fields.singularities import singular_vertices

AXIS = np.array([2.0, -3.0, 6.0]) / 7


def anything() -> FaceField:
    ball = surface("sphere")
    return FaceField(ball, np.ones(ball.n_faces))


def test_meridians_are_geodesics_between_two_poles():
    field = meridian_field(anything(), AXIS)
    np.testing.assert_allclose(field.norms, 1)
    poles = field.mesh.vertices[singular_vertices(field)]
    assert len(poles) == 2
    # within an edge of the axis
    assert (1 - np.abs(poles @ AXIS) < field.mesh.mean_edge**2).all()
    parallels = FaceField(field.mesh, 1j * field.values)
    assert total_curl(field) < 0.15 * total_curl(parallels)


def test_axis_is_found_again_whichever_way_the_field_runs():
    field = meridian_field(anything(), AXIS)
    rng = np.random.default_rng(0)
    flipped = FaceField(field.mesh, field.values * rng.choice([-1, 1], field.mesh.n_faces))
    for each in (field, flipped):
        # flat faces instead of a sphere: the projection tilts by a part of h^2
        assert meridian_axis(each) @ AXIS == pytest.approx(1, abs=1e-5)


def test_angle_of_a_turned_field_is_the_turn():
    field = meridian_field(anything(), AXIS)
    np.testing.assert_allclose(meridian_angle(field, AXIS), 0, atol=1e-7)
    np.testing.assert_allclose(meridian_angle(field, -AXIS), 0, atol=1e-7)
    for turn, expected in ((0.3, 0.3), (-0.3, 0.3), (np.pi - 0.2, 0.2), (np.pi / 2, np.pi / 2)):
        turned = FaceField(field.mesh, field.values * np.exp(1j * turn))
        np.testing.assert_allclose(meridian_angle(turned, AXIS), expected, atol=1e-7)
