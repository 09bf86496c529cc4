"""Alignment of level sets with a field: exact on a cylinder, blind to frequency, sees orientation."""

import numpy as np
import pytest

from geoweave.errors import FieldError
from geoweave.fields.face_field import FaceField
from geoweave.fields.operators import differences
from geoweave.foliation.circle_function import CircleFunction
from geoweave.foliation.level_set_alignment import (
    alignment,
    area_percentiles,
    deviation,
    spacing,
    spacing_spread,
)
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh

FLAT = shapes.square(faces=800)


def plane_wave(mesh: TriMesh, wave: list[float]) -> CircleFunction:
    values = mesh.vertices @ np.array(wave)
    return CircleFunction(mesh, values, differences(mesh) @ values)


def constant(mesh: TriMesh, vector: list[float]) -> FaceField:
    return FaceField.from_ambient(mesh, np.broadcast_to(vector, (mesh.n_faces, 3)))


@pytest.mark.parametrize("angle", [0.0, 25.0, 90.0, 155.0, 180.0])
def test_a_known_angle(angle: float) -> None:
    # w along x has its clockwise quarter turn along -y; the wave vector is turned away from it.
    turn = np.radians(angle)
    circle = plane_wave(FLAT, [7 * np.sin(turn), -7 * np.cos(turn), 0.0])
    # 1e-6 degrees: the angle of nearly parallel vectors has half the digits of its cosine.
    np.testing.assert_allclose(deviation(constant(FLAT, [1, 0, 0]), circle), angle, atol=1e-6)


def test_orientation_counts() -> None:
    field, circle = constant(FLAT, [1, 0, 0]), plane_wave(FLAT, [0.0, -5.0, 0.0])
    assert alignment(field, circle).mean == pytest.approx(0.0, abs=1e-6)
    assert alignment(FaceField(FLAT, -field.values), circle).mean == pytest.approx(180.0)


def test_even_level_sets_have_no_spread() -> None:
    circle = plane_wave(FLAT, [3.0, 4.0, 0.0])
    np.testing.assert_allclose(spacing(circle), 2 * np.pi / 5)
    assert spacing_spread(circle) == pytest.approx(0.0, abs=1e-12)


def test_spread_of_a_known_spacing_does_not_depend_on_the_frequency() -> None:
    # theta = k e^x has log spacing -x + constant, uniform on [-1, 1]: 68.26 % of that is 1.3652 wide.
    mesh = shapes.square(faces=20_000)
    for frequency in (1.0, 9.0):
        values = frequency * np.exp(mesh.vertices[:, 0])
        circle = CircleFunction(mesh, values, differences(mesh) @ values)
        assert spacing_spread(circle) == pytest.approx(0.6826, abs=0.02)  # one column of faces is 0.02


def test_a_constant_function_has_no_direction() -> None:
    circle = CircleFunction(FLAT, np.zeros(FLAT.n_vertices), np.zeros(FLAT.n_edges))
    field = constant(FLAT, [1, 0, 0])
    assert (deviation(field, circle) == 90.0).all()
    assert np.isinf(spacing(circle)).all()


def test_dislocations_are_counted() -> None:
    mesh = shapes.disk(faces=800)
    inside = int(np.argmin(np.linalg.norm(mesh.barycenters, axis=1)))
    x, y = (mesh.vertices - mesh.barycenters[inside]).T[:2]
    circle = CircleFunction.nearest(mesh, np.arctan2(y, x), np.zeros(mesh.n_edges))
    # theta turns counter-clockwise: its level sets are rays, with larger theta on their right inwards.
    radial = FaceField.from_ambient(mesh, -(mesh.barycenters - mesh.barycenters[inside]) - 1e-9).normalized()
    result = alignment(radial, circle)
    assert result.dislocations == 1
    # A face half a radius out spans some ten degrees, over which theta is linear and rays are not parallel.
    assert result.median < 2.0


def test_percentiles_weigh_areas() -> None:
    mesh = TriMesh(
        np.array([[0.0, 0, 0], [3, 0, 0], [0, 1, 0], [0, -2, 0]]), np.array([[0, 1, 2], [1, 0, 3]])
    )
    # A third of the area holds 1.0, two thirds hold 2.0.
    assert area_percentiles(mesh, np.array([1.0, 2.0]), [20.0, 33.0, 34.0, 100.0]).tolist() == [1, 1, 2, 2]


def test_other_meshes_are_refused() -> None:
    with pytest.raises(FieldError, match="same part of the surface"):
        deviation(constant(FLAT, [1, 0, 0]), plane_wave(shapes.square(faces=72), [1.0, 0.0, 0.0]))
