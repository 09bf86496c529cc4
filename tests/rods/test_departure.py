from dataclasses import replace

import numpy as np
import pytest
from rodded import any_rotation, bar, circle, rods_of, turned

from geoweave.errors import RodError
from geoweave.models.shapes import sphere
from geoweave.rods.departure import departure, fitted, held, mean_tilt, rigid_fit, vertex_weights
from geoweave.rods.rods import DERIVED, Contacts


def hoops():
    """Two great circles of the unit ball."""
    flat = circle(60)
    return rods_of(
        [flat, flat[:, [1, 2, 0]]],
        np.concatenate([flat, flat[:, [1, 2, 0]]]),
        closed=True,
        contacts=Contacts([[15, 60]], [[0.0, 0.0]], [1]),
    )


def test_the_fit_finds_a_rigid_motion_and_never_a_reflection():
    rng = np.random.default_rng(0)
    points, weights = rng.normal(size=(20, 3)), rng.uniform(0.1, 1, 20)
    rotation, shift = any_rotation(), np.array([1.0, -2, 3])
    found = rigid_fit(points, points @ rotation.T + shift, weights)
    np.testing.assert_allclose(found[0], rotation, atol=1e-12)
    np.testing.assert_allclose(found[1], shift, atol=1e-12)
    mirrored, _ = rigid_fit(points, points * [1, 1, -1], weights)
    assert np.linalg.det(mirrored) == pytest.approx(1)


def test_no_rigid_motion_fits_better():
    rng = np.random.default_rng(1)
    points, targets, weights = rng.normal(size=(9, 3)), rng.normal(size=(9, 3)), rng.uniform(0.1, 1, 9)

    def cost(rotation, shift):
        return weights @ ((points @ rotation.T + shift - targets) ** 2).sum(1)

    rotation, shift = rigid_fit(points, targets, weights)
    least = cost(rotation, shift)
    for k in range(20):
        axis = 0.05 * rng.normal(size=3)
        generator = np.cross(np.eye(3), axis)
        turn, _ = np.linalg.qr(np.eye(3) + generator)
        turn *= np.sign(np.diag(turn))
        assert cost(turn @ rotation, shift + 0.02 * rng.normal(size=3) * (k % 2)) >= least


def test_tilt_is_the_angle_that_directors_turn_and_no_rigid_motion_counts():
    rods = hoops()
    assert mean_tilt(turned(rods, any_rotation(), np.array([1.0, 2.0, 3.0])), rods) == pytest.approx(
        0, abs=1e-9
    )
    ends = rods.points[rods.layout.ends]
    tangents = ends[:, 1] - ends[:, 0]
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    angle = np.radians(np.where(np.arange(len(tangents)) % 2, 10.0, -20.0))[:, None]
    aside = np.cross(tangents, rods.directors)
    tilted = replace(rods, directors=np.cos(angle) * rods.directors + np.sin(angle) * aside)
    assert mean_tilt(tilted, rods) == pytest.approx(15.0)


def test_rods_that_are_held_are_not_fitted():
    rods, ball = hoops(), sphere(5120)
    lifted = turned(rods, np.eye(3), np.array([0.0, 0.0, 0.2]))
    found = departure(lifted, rods, ball, placed=True)
    assert found.from_design.largest == pytest.approx(0.2 / found.diagonal)
    np.testing.assert_array_equal(found.points, lifted.points)


def test_rods_that_moved_as_a_whole_have_not_departed():
    rods, ball = hoops(), sphere(5120)
    moved = turned(rods, any_rotation(), np.array([4.0, 5, 6]))
    found = departure(moved, rods, ball)
    assert found.from_design.largest < 1e-14
    # the chords of a mesh lie inside the ball
    assert found.to_surface.largest < 2e-3
    np.testing.assert_allclose(found.points, rods.points, atol=1e-13)


def test_rods_that_grew_depart_by_their_growth():
    rods, ball = hoops(), sphere(5120)
    grown = replace(rods, points=1.1 * rods.points, edges=DERIVED)
    found = departure(grown, rods, ball)
    diagonal = 2 * np.sqrt(3)
    assert found.diagonal == pytest.approx(diagonal, rel=1e-3)
    for size in (found.from_design.mean, found.from_design.rms, found.from_design.largest):
        assert size == pytest.approx(0.1 / diagonal, rel=1e-2)
    assert found.to_surface.mean == pytest.approx(0.1 / diagonal, rel=2e-2)
    assert found.distance[found.worst] == found.distance.max()


def test_the_other_side_measures_the_holes():
    ball = sphere(1280)
    found = departure(hoops(), hoops(), ball)
    # the points farthest from two great circles lie in the middle between them, a right angle over root 2
    far = np.sqrt(2 - np.sqrt(2))
    assert found.from_surface.largest * found.diagonal == pytest.approx(far, rel=0.02)


def test_tails_are_not_held():
    rods = rods_of(
        [bar(10).points, bar(4).points + [0, 1, 0]],
        np.array([0, 0, 1.0]),
        contacts=Contacts([[2, 11], [6, 12]], [[0.5, 0.5], [0.5, 0.5]], [0, 1]),
    )
    assert np.flatnonzero(held(rods)).tolist() == [2, 3, 4, 5, 6, 7, 12, 13, 14]
    assert held(hoops()).all()
    assert not held(bar(3)).any()


def test_weights_are_the_length_of_ribbon():
    assert vertex_weights(bar(4, 2.0)).tolist() == [0.25, 0.5, 0.5, 0.5, 0.25]


def test_other_rods_are_refused():
    with pytest.raises(RodError, match="other vertices"):
        fitted(bar(3), bar(4))
