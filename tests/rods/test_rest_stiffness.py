from dataclasses import replace

import numpy as np
import pytest
from rodded import bar, grid, ring, three_great_circles

from geoweave.errors import RodError
from geoweave.rods.elastic_energies import elastic_terms
from geoweave.rods.equilibrium import minimized
from geoweave.rods.rest_stiffness import RestStiffness, on_the_floor
from geoweave.rods.slide_and_relax import relax_rods

BEAM = 1e6 * 0.1 * 0.01**3 / 12  # flatwise stiffness of the strips of rodded.py


def test_the_softest_motions_of_a_free_strip_are_those_of_a_beam():
    # B u'''' = k u with free ends: cos b cosh b = 1, k = B (b / L)^4; the softest are flatwise
    errors = []
    for count in (20, 40, 80):
        found = RestStiffness(bar(count)).softest(2).stiffness
        errors.append(np.abs(found / (BEAM * np.array([4.730041, 7.853205]) ** 4) - 1))
    assert (errors[-1] < 0.01).all()
    assert (errors[2] < 0.35 * errors[1]).all()
    assert (errors[1] < 0.35 * errors[0]).all()


def test_a_clamped_strip_gives_way_as_a_beam():
    errors = []
    for count in (20, 40):
        rods = bar(count, 1.0 + 1.0 / count)
        clamped = np.arange(count + 1) < 2
        load = np.zeros((count + 1, 3))
        load[-1, 2] = 3 * BEAM
        moved = RestStiffness(rods, fixed=clamped).moved(load)
        assert not moved[clamped].any()
        errors.append(abs(moved[-1, 2] - 1.0))
    # bending begins at the clamp, half a segment of which is clamped
    assert errors[-1] < 0.06
    assert errors[1] < 0.6 * errors[0]


@pytest.mark.parametrize("width", [0.05, 0.1])
def test_edgewise_a_strip_is_stiffer_by_the_square_of_width_over_thickness(width):
    rods = bar(30, width=width)
    clamped = np.arange(31) < 2
    flat, edge = np.zeros((31, 3)), np.zeros((31, 3))
    flat[-1, 2] = edge[-1, 1] = 1e-6
    stiff = RestStiffness(rods, fixed=clamped)
    assert stiff.moved(flat)[-1, 2] / stiff.moved(edge)[-1, 1] == pytest.approx((width / 0.01) ** 2, rel=1e-6)


def test_small_loads_move_rods_at_rest_as_the_whole_equilibrium_says():
    """A ring with its forces in it, pulled at two opposite points: linear in the load, and the same."""
    rods = minimized(ring(40), elastic_terms(ring(40).layout)).rods
    load = np.zeros((40, 3))
    load[0, 0], load[20, 0] = 1e-4, -1e-4
    linear = RestStiffness(rods).moved(load)
    found = minimized(rods, elastic_terms(rods.layout), load=load).rods
    away = found.points - rods.points
    away -= away.mean(axis=0)
    assert np.abs(away - linear).max() < 0.01 * np.abs(linear).max()


def rings():
    """Three rings about a ball at rest, and their stiffness."""
    rods = relax_rods(three_great_circles()).rods
    return rods, RestStiffness(rods)


def test_rigid_motions_are_left_out():
    """No soft motion moves the middle or turns the whole, and a load out of balance bends nothing."""
    rods, stiff = rings()
    soft = stiff.softest(3)
    assert (soft.stiffness > 0).all()
    for motion in soft.motions:
        force = stiff.weights[:, None] * motion
        assert np.abs(force.sum(axis=0)).max() < 1e-8
        assert np.abs(np.cross(rods.points, force).sum(axis=0)).max() < 1e-8
    mean = (stiff.weights[:, None] * soft.motions[0] ** 2).sum() / stiff.weights.sum()
    assert mean == pytest.approx(1.0)
    even = np.outer(stiff.weights, [0.0, 0.0, 1.0])
    assert np.abs(stiff.moved(even)).max() < 1e-6 * np.abs(stiff.moved(even * rods.points[:, :1] ** 2)).max()


def test_a_motion_resists_as_its_eigenvalue_says():
    _, stiff = rings()
    soft = stiff.softest(4)
    for value, motion in zip(*soft, strict=True):
        answer = value * stiff.moved(stiff.weights[:, None] * motion)
        assert np.abs(answer - motion).max() < 1e-5 * np.abs(motion).max()


def test_bars_that_cross_square_shear_freely():
    """Contacts let ribbons turn on each other, so a biaxial grid is a mechanism: it has one free motion."""
    stiffness = RestStiffness(relax_rods(grid(3)).rods).softest(3).stiffness
    assert stiffness[0] < 1e-6 * stiffness[1]


def test_a_contact_gives_way_as_much_as_a_load_on_it_moves_it():
    rods = relax_rods(grid(3)).rods
    stiff = RestStiffness(rods, fixed=rods.points[:, 0] < -0.5)
    up = np.tile([0.0, 0.0, 1.0], (len(rods.contacts), 1))
    found = stiff.at_contacts(up)
    assert (found > 0).all()
    # those farther from the clamped edge give way more
    x = rods.points[rods.layout.ends[rods.contacts.segments[:, 0], 0], 0]
    assert found[x > 1.5].min() > found[x < 0.5].max()


def test_what_is_on_a_saddle_of_the_energy_is_refused():
    """A strip pressed together along itself beyond Euler's load would buckle."""
    rods = bar(20)
    pressed = replace(rods, rest=1.01 * rods.rest)
    with pytest.raises(RodError, match="not at rest in a stable shape"):
        RestStiffness(pressed)


def test_feet_spread():
    """A ball on its lowest point takes more for feet than a table."""
    rng = np.random.default_rng(0)
    ball = rng.normal(size=(500, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    feet = on_the_floor(ball, np.array([0.0, 0.0, 1.0]))
    assert 3 <= feet.sum() < 100
    assert ball[feet, 2].max() < ball[~feet, 2].min()
    other = on_the_floor(ball, np.array([0.0, 0.0, -2.0]))
    assert ball[other, 2].min() > ball[~other, 2].max()
    with pytest.raises(RodError, match="ask for fewer"):
        RestStiffness(bar(4)).softest(100)
