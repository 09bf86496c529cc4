import numpy as np
import pytest
from rodded import MATERIAL, any_rotation, bar, circle, crumpled, helix, ring, rods_of, turned

from geoweave.arrays import parallel_transport
from geoweave.errors import RodError
from geoweave.rods.rods import Contacts, Layout, Material, Rods


def test_moduli_are_the_textbooks():
    steel = Material(thickness=0.002, young=2.1e11, poisson=0.3)
    width = np.array([0.03])
    assert steel.stretching(width)[0] == pytest.approx(2.1e11 * 6e-5)
    # 30 x 2 mm: I = 20 mm^4 flatwise, 4500 mm^4 edgewise
    assert steel.bending(width)[0] == pytest.approx(2.1e11 * 20e-12)
    assert steel.edgewise(width)[0] == pytest.approx(2.1e11 * 4500e-12)
    # Timoshenko and Goodier, torsion of rectangles: J = 0.1406 a^4 for a square, 0.312 b a^3 for 10 : 1
    shear = 2.1e11 / 2.6
    square = Material(thickness=0.03, young=2.1e11).twisting(width)[0]
    assert square == pytest.approx(0.1406 * shear * 0.03**4, rel=5e-3)
    flat = Material(thickness=0.003, young=2.1e11).twisting(width)[0]
    assert flat == pytest.approx(0.3123 * shear * 0.03 * 0.003**3, rel=5e-3)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"thickness": 0.0}, "thickness"),
        ({"young": np.nan}, "Young's modulus"),
        ({"poisson": 0.6}, "Poisson's ratio"),
        ({"density": -1.0}, "density"),
    ],
)
def test_materials_that_are_none_are_refused(change, words):
    with pytest.raises(RodError, match=words):
        Material(**({"thickness": 0.1} | change))


def test_the_layout_of_an_open_and_a_closed_rod():
    layout = Layout(np.array([0, 3, 6]), np.array([False, True]))
    assert (layout.vertices, layout.segments) == (6, 5)
    assert layout.ends.tolist() == [[0, 1], [1, 2], [3, 4], [4, 5], [5, 3]]
    assert layout.joints.tolist() == [[0, 1], [2, 3], [3, 4], [4, 2]]
    assert layout.rod_of_segment.tolist() == [0, 0, 1, 1, 1]
    with pytest.raises(RodError, match="rod 1 has too few"):
        Layout(np.array([0, 3, 5]), np.array([False, True]))


def test_directors_stay_unit_and_square_after_a_step_and_turn_by_its_angle():
    rods = crumpled()
    step = 0.1 * np.random.default_rng(3).normal(size=rods.size)
    moved = rods.stepped(step)
    np.testing.assert_allclose(np.linalg.norm(moved.directors, axis=1), 1, atol=1e-14)
    np.testing.assert_allclose((moved.directors * moved.tangents).sum(1), 0, atol=1e-14)
    start, end = rods.layout.ends.T
    np.testing.assert_allclose(moved.edges, moved.points[end] - moved.points[start], atol=1e-14)
    carried_over = parallel_transport(rods.tangents, moved.tangents, rods.directors)
    sine = (moved.tangents * np.cross(carried_over, moved.directors)).sum(1)
    angle = np.arctan2(sine, (carried_over * moved.directors).sum(1))
    np.testing.assert_allclose(angle, step[3 * rods.layout.vertices :], atol=1e-12)


def test_the_twist_of_a_ring_is_that_of_its_directors():
    # Directors that turn twice about a ring: a twist of 4 pi in all.
    flat = ring(40)
    turn = 4 * np.pi * np.arange(40) / 40
    across = np.cross(flat.tangents, flat.directors)
    directors = np.cos(turn)[:, None] * flat.directors + np.sin(turn)[:, None] * across
    twisted = Rods(flat.layout, flat.points, directors, flat.widths, flat.rest, flat.contacts, flat.material)
    np.testing.assert_allclose(twisted.twists, 4 * np.pi / 40, atol=1e-12)
    np.testing.assert_allclose(flat.twists, 0, atol=1e-12)


def test_a_strip_that_closes_after_half_a_turn_has_the_twist_of_a_moebius_strip():
    flat = ring(40)
    turn = np.pi * np.arange(40) / 40
    across = np.cross(flat.tangents, flat.directors)
    directors = np.cos(turn)[:, None] * flat.directors + np.sin(turn)[:, None] * across
    strip = Rods(flat.layout, flat.points, directors, flat.widths, flat.rest, flat.contacts, flat.material)
    np.testing.assert_allclose(strip.twists, np.pi / 40, atol=1e-12)


def test_twist_goes_on_beyond_a_quarter_turn_when_it_grows_in_steps():
    rods = bar(2)
    step = np.zeros(rods.size)
    step[-1] = 0.4
    for _ in range(10):
        rods = rods.stepped(step)
    np.testing.assert_allclose(rods.twists, 4.0, atol=1e-12)


def test_rigid_motions_change_no_shape():
    rods = crumpled()
    moved = turned(rods, any_rotation(), np.array([1.0, 2.0, 3.0]))
    np.testing.assert_allclose(moved.lengths, rods.lengths, atol=1e-13)
    np.testing.assert_allclose(
        np.linalg.norm(moved.binormals, axis=1), np.linalg.norm(rods.binormals, axis=1)
    )


def test_the_curvature_of_a_helix_converges():
    # k = r / (r^2 + c^2) with c the pitch over 2 pi; kb is the curvature times the length of a joint
    exact = 1.0 / (1.0 + (2.0 / (2 * np.pi)) ** 2)
    errors = []
    for count in (40, 80):
        rods = helix(count, 1.0, 2.0)
        curvature = np.linalg.norm(rods.binormals, axis=1) / rods.spans
        errors.append(abs(curvature - exact).max())
    assert errors[1] < 0.3 * errors[0] < 1e-3


def test_bad_rods_are_refused_with_their_place():
    line = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    good = np.array([[0.0, 0, 1]])
    with pytest.raises(RodError, match="rod 1: segment 1 of it has no length"):
        Rods(
            Layout(np.array([0, 3, 6]), np.array([False, False])),
            np.concatenate([line, line[[0, 1, 1]]]),
            np.tile(good, (4, 1)),
            np.full(4, 0.1),
            np.ones(4),
            Contacts([], [], []),
            MATERIAL,
        )
    with pytest.raises(RodError, match="rod 0: segment 1 of it is folded back"):
        rods_of([line[[0, 2, 1]]], good[0])
    with pytest.raises(RodError, match="not as wide as thick"):
        rods_of([line], good[0], width=0.001)
    with pytest.raises(RodError, match="not finite"):
        rods_of([np.where(line == 2, np.nan, line)], good[0])
    with pytest.raises(RodError, match="a segment that is not there"):
        rods_of([line], good[0], contacts=Contacts([[0, 2]], [[0.5, 0.5]], [0]))


def test_a_step_that_is_no_step_is_refused():
    rods = bar(3)
    with pytest.raises(RodError, match="vanish, or is not finite"):
        rods.stepped(np.full(rods.size, np.nan))
    step = np.zeros(rods.size)
    step[0] = 1 / 3
    with pytest.raises(RodError, match="vanish"):
        rods.stepped(step)


def test_arrays_are_read_only():
    rods = ring(6)
    for array in (rods.points, rods.directors, rods.rest, rods.edges, rods.twists, rods.contacts.over):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0
    assert circle(4).shape == (4, 3)
