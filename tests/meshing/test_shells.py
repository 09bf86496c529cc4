"""Components that run through each other are found, and those that only touch or nest are not."""

import numpy as np
import pytest

from geoweave.meshing.prepare import prepare_arrays
from geoweave.meshing.shells import crossing_shells
from geoweave.models import shapes
from geoweave.surface import TriMesh

BALL = shapes.sphere(faces=2_000)
CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
SQUARES = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
SIDES = np.concatenate([SQUARES[:, [0, 1, 2]], SQUARES[:, [0, 2, 3]]])


def both(points: np.ndarray, faces: np.ndarray, shift: np.ndarray, scale: float = 1.0) -> TriMesh:
    return TriMesh(
        np.concatenate([points, scale * points + shift]), np.concatenate([faces, faces + len(points)])
    )


@pytest.mark.parametrize("shift", [[1.2, 0, 0], [0.3, 0.4, 1.1], [0, 0, 1.99]])
@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e4])
def test_balls_that_cross_do_so_at_a_point_of_both(shift, unit):
    mesh = both(unit * BALL.vertices, BALL.faces, unit * np.array(shift))
    ((i, j, point),) = crossing_shells(mesh)
    assert (i, j) == (0, 1)
    for centre in (np.zeros(3), np.array(shift)):
        assert np.linalg.norm(point / unit - centre) == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(
    ("shift", "scale"),
    [([2.5, 0, 0], 1.0), ([0, 0, 0], 0.5), ([1.9, 1.9, 0], 1.0)],
    ids=["apart", "nested", "boxes"],
)
def test_balls_apart_or_nested_do_not(shift, scale):
    assert crossing_shells(both(BALL.vertices, BALL.faces, np.array(shift), scale)) == []


@pytest.mark.parametrize("shift", [[1, 0, 0], [1, 1, 0], [1, 0.5, 0], [1, 1, 1]])
def test_cubes_that_touch_do_not(shift):
    assert crossing_shells(both(CUBE, SIDES, np.array(shift, dtype=float))) == []


def test_the_report_names_them_with_a_place():
    mesh = both(BALL.vertices, BALL.faces, np.array([1.2, 0.0, 0.0]))
    (note,) = prepare_arrays(mesh.vertices, mesh.faces).report.notes
    assert "1 pair of components run through each other (first at (" in note
