"""What an object stands on: known answers on turned shapes, and what does not stand is said."""

from __future__ import annotations

import numpy as np
import pytest
from laidflat import circles, cone, flat
from meshfiles import sphere

from geoweave.errors import FieldError
from geoweave.fabrication.glb import UPRIGHT
from geoweave.fabrication.up_axes import AXES, base_axis, bases, check_axis, up_axis, upward
from geoweave.models import shapes


def laid(points: np.ndarray, axis: str) -> np.ndarray:
    """Points whose z axis was up, turned so that another axis is."""
    up = upward(axis)
    level = np.roll(np.abs(up), 1)
    return points @ np.stack([level, np.cross(up, level), up])


def cross(start: np.ndarray, end: np.ndarray, count: int = 40) -> np.ndarray:
    return start + np.linspace(0, 1, count)[:, None] * (end - start)


def table() -> np.ndarray:
    """A plate on four legs: the plate is wider than the legs stand apart, and lies high."""
    feet = np.array([(x, y, 0.0) for x in (-2.0, 2.0) for y in (-1.0, 1.0)])
    legs = np.concatenate([cross(foot, foot + (0.0, 0.0, 1.5)) for foot in feet])
    grid = np.stack(np.meshgrid(np.linspace(-2, 2, 40), np.linspace(-1, 1, 20)), axis=-1).reshape(-1, 2)
    return np.concatenate([legs, np.column_stack([grid, np.full(len(grid), 1.5)])])


@pytest.mark.parametrize("axis", AXES)
def test_a_cone_stands_on_its_base(axis: str) -> None:
    assert base_axis(laid(shapes.cone(faces=700).vertices, axis)) == axis


@pytest.mark.parametrize("axis", ["z", "y", "x"])
def test_a_table_stands_on_its_feet_or_its_plate_and_the_first_of_equals_is_taken(axis: str) -> None:
    found = bases(laid(table(), axis))
    assert found[axis].area == pytest.approx(8.0)
    assert found[f"-{axis}"].area == pytest.approx(8.0)
    assert base_axis(laid(table(), axis)) == axis


def test_a_ball_and_a_plane_are_as_their_file_has_them() -> None:
    ball = sphere(4)[0]
    widths = [base.area for base in bases(ball).values()]
    assert max(widths) < 1.2 * min(widths)
    assert base_axis(ball) in AXES
    assert up_axis(flat()) == "z"


def test_what_falls_over_does_not_stand() -> None:
    """A weight far beside its foot: the widest base does not count."""
    foot = np.array([(x, y, 0.0) for x in (-1.0, 0.0, 1.0) for y in (-1.0, 0.0, 1.0)])
    arm = cross(np.array((0.0, 0.0, 4.0)), np.array((9.0, 0.0, 4.0)), 200)
    found = bases(np.concatenate([foot, arm]))
    assert found["z"].area == pytest.approx(4.0)
    assert found["z"].inside < 0
    assert base_axis(cross(np.zeros(3), np.array((1.0, 0.0, 0.0)))) is None


def test_a_weave_stands_as_its_surface_does_or_as_it_is_asked_to() -> None:
    assert up_axis(cone()) == base_axis(shapes.cone(faces=700).vertices) == "z"
    assert up_axis(cone(), "-X") == "-x"
    assert up_axis(circles(), "+y") == "y"
    with pytest.raises(FieldError, match="no axis 'w'; what is up is one of x, y, z, -x, -y, -z"):
        check_axis("w")


@pytest.mark.parametrize("axis", AXES)
def test_the_glb_turns_it_to_y(axis: str) -> None:
    """Rodrigues' formula for the rotation of a quaternion."""
    *way, whole = UPRIGHT[axis]
    v, up = np.array(way), upward(axis)
    turned = up + 2 * np.cross(v, np.cross(v, up) + whole * up)
    np.testing.assert_allclose(turned, (0, 1, 0), atol=1e-12)
    assert np.hypot(np.linalg.norm(v), whole) == pytest.approx(1.0)
