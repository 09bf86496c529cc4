"""Polygons cut into triangles: the area stays, nothing folds over, and edges keep their two faces."""

import time

import numpy as np
import pytest

from geoweave.errors import MeshError
from geoweave.meshing.polygons import MOST_CORNERS, triangulated
from geoweave.meshing.prepare import prepare_arrays


def cut(points: np.ndarray, polygons: list[list[int]]) -> np.ndarray:
    counts = np.array([len(polygon) for polygon in polygons])
    return triangulated(np.asarray(points, dtype=float), np.concatenate(polygons), counts)


def areas(points: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Signed, for polygons in the plane z = 0."""
    a, b, c = (np.asarray(points)[faces[:, k]] for k in range(3))
    return 0.5 * np.cross(b - a, c - a)[:, 2]


def star(n: int, depth: float = 0.3) -> np.ndarray:
    """A star of 2 n corners, every second one reflex; its area is n depth sin(pi / n)."""
    angle = np.pi * np.arange(2 * n) / n
    radius = np.where(np.arange(2 * n) % 2, depth, 1.0)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=1)


def comb(teeth: int) -> np.ndarray:
    """A comb: a bar of height 1 with teeth of height 1 and width 1, a gap of 1 between them."""
    top = [(x + dx, y) for x in range(2 * (teeth - 1), -1, -2) for dx, y in ((1, 1), (1, 2), (0, 2), (0, 1))]
    return np.array([(0.0, 0.0), (2 * teeth - 1, 0.0), *top])[:, [0, 1, 1]] * [1, 1, 0]


def test_convex_polygons_are_fans_from_their_first_corners() -> None:
    ring = np.stack([np.cos(np.arange(6)), np.sin(np.arange(6)), np.zeros(6)], axis=1)
    faces = cut(np.concatenate([ring, ring + 3]), [[0, 1, 2], [0, 2, 3, 4, 5], [8, 9, 10, 11]])
    assert faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [8, 9, 10], [8, 10, 11]]


@pytest.mark.parametrize("turn", range(4))
def test_a_dart_is_cut_at_its_reflex_corner(turn: int) -> None:
    dart = np.array([[2, 0, 0], [0, 1, 0], [0.5, 0, 0], [0, -1, 0]])
    found = areas(dart, cut(dart, [np.roll(np.arange(4), turn).tolist()]))
    assert np.allclose(found, 0.75)


@pytest.mark.parametrize("turn", [0, 1, 7])
@pytest.mark.parametrize(
    ("shape", "area"),
    [(star(5), 10 * 0.5 * 0.3 * np.sin(np.pi / 5)), (comb(6), 11 + 6)],
    ids=["star", "comb"],
)
@pytest.mark.parametrize("tilt", [0.0, 1.0])
def test_concave_polygons_keep_their_area(shape: np.ndarray, area: float, turn: int, tilt: float) -> None:
    """Whatever corner comes first, in any plane: no triangle faces the other way, none has no area."""
    faces = cut(
        shape @ np.array([[1, 0, 0], [0, np.cos(tilt), np.sin(tilt)], [0, -np.sin(tilt), np.cos(tilt)]]),
        [np.roll(np.arange(len(shape)), turn).tolist()],
    )
    found = areas(shape, faces)
    assert len(faces) == len(shape) - 2
    assert found.min() > 1e-3
    assert found.sum() == pytest.approx(area)


def test_a_slit_to_a_hole_is_cut_round() -> None:
    """A square with a square hole, joined by a slit whose two corners stand twice."""
    outer = [(-3, -3), (3, -3), (3, 3), (-3, 3)]
    inner = [(-1, -1), (-1, 1), (1, 1), (1, -1)]
    points = np.array([*outer, *inner])[:, [0, 1, 1]] * [1.0, 1.0, 0.0]
    faces = cut(points, [[0, 1, 2, 3, 0, 4, 5, 6, 7, 4]])
    assert areas(points, faces).min() > 0.1
    assert areas(points, faces).sum() == pytest.approx(36 - 4)


def test_a_corner_on_a_straight_side_makes_no_triangle_without_area() -> None:
    points = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0.0]])
    assert areas(points, cut(points, [[0, 1, 2, 3, 4]])).min() > 0.5


def test_bent_quads_that_share_their_ends_stay_manifold() -> None:
    """n quads between two poles: the fan of each would be cut along the line between the poles."""
    n = 5
    angle = 2 * np.pi * np.arange(n) / n
    rim = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    points = np.concatenate([[[0, 0, 1], [0, 0, -1]], rim])
    faces = cut(points, [[0, 2 + k, 1, 2 + (k + 1) % n] for k in range(n)])
    mesh = prepare_arrays(points, faces).mesh
    assert (mesh.n_faces, mesh.genus, mesh.n_components, mesh.boundary_loops) == (2 * n, 0, 1, ())


def test_a_diagonal_that_is_another_faces_side_is_not_cut() -> None:
    """A square whose fan would be cut along the edge of two other faces."""
    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0.5, 1], [0.5, 0.4, -1]])
    faces = cut(points, [[0, 1, 2, 3], [0, 2, 4], [2, 0, 5]])
    assert not any({0, 2} <= set(face) for face in faces[:2].tolist())


def test_a_polygon_that_stands_twice_is_cut_the_same_way_twice() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    faces = cut(square, [[0, 1, 2, 3], [0, 1, 2, 3]])
    assert prepare_arrays(square, faces).report.duplicate_faces == 2


def test_what_cannot_be_judged_is_passed_on() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, np.nan, 0.0]])
    assert cut(square, [[0, 1, 2, 3]]).tolist() == [[0, 1, 2], [0, 2, 3]]
    assert cut(square[:3], [[0, 1, 2, 9]]).tolist() == [[0, 1, 2], [0, 2, 9]]


def test_a_polygon_without_extent_is_passed_on() -> None:
    assert len(cut(np.zeros((6, 3)), [[0, 1, 2, 3, 4, 5]])) == 4


def test_a_polygon_of_many_corners_takes_no_time() -> None:
    shape = comb(150)
    start = time.process_time()  # whatever else the machine does
    faces = cut(shape, [np.roll(np.arange(len(shape)), 1).tolist()])
    assert areas(shape, faces).sum() == pytest.approx(299 + 150)
    assert time.process_time() - start < 20.0


def test_a_polygon_of_too_many_corners_is_refused_unless_it_is_convex() -> None:
    with pytest.raises(MeshError, match="a face with 4,004 corners is not convex"):
        cut(comb(1 + MOST_CORNERS // 4), [list(range(MOST_CORNERS + 4))])
    angle = 2 * np.pi * np.arange(MOST_CORNERS + 4) / (MOST_CORNERS + 4)
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    assert len(cut(ring, [list(range(len(ring)))])) == MOST_CORNERS + 2
