from dataclasses import replace

import numpy as np
import pytest
from rodded import any_rotation, bar, crumpled, helix, ring, turned
from scipy.optimize import brentq
from scipy.special import ellipeinc, ellipkinc

from geoweave.errors import FieldError
from geoweave.rods.elastic_energies import elastic_terms
from geoweave.rods.equilibrium import Stepping, minimized
from geoweave.rods.hessian import analysed


def clamped(rods):
    """The first two vertices, and so the first segment, do not move."""
    still = np.zeros(rods.layout.vertices, dtype=bool)
    still[:2] = True
    return np.concatenate([np.repeat(still, 3), still[rods.layout.ends].all(axis=1)])


def cantilever(count, force, normal=(0.0, 0.0, 1.0)):
    """A bar clamped at its start with a force on its end."""
    rods = bar(count, 1.0 + 1.0 / count, normal=normal)
    load = np.zeros((rods.layout.vertices, 3))
    load[-1] = force
    return minimized(rods, elastic_terms(rods.layout), fixed=clamped(rods), load=load)


@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.0, 1.0, 0.0)])
def test_a_cantilever_under_a_small_end_load_bends_by_p_l3_over_3ei(normal):
    stiffness = 1e6 * (0.1 * 0.01**3 if normal[2] else 0.01 * 0.1**3) / 12
    errors = []
    for count in (10, 20, 40):
        force = 1e-3 * 3 * stiffness  # an end that sinks by a thousandth of the length
        found = cantilever(count, np.array([0, 0, -force]), normal)
        assert found.converged
        sunk = -found.rods.points[-1, 2]
        # bending begins at the joint at the clamp, half a segment of which is clamped
        errors.append(abs(sunk / 1e-3 - 1))
    assert errors[-1] < 0.05
    assert errors[2] < 0.6 * errors[1] < 0.4 * errors[0]


def test_a_cantilever_under_a_large_end_load_is_the_elastica():
    # B theta'' = -P cos(theta): with k = sin(alpha), sqrt(P / B) L = K(k) - F(phi0, k), tip angle theta_L,
    # 2 k^2 = 1 + sin(theta_L), sin(phi0) = 1 / (k sqrt 2); with m = sqrt(P / B) L,
    # drop / L = 1 - 2 (E(k) - E(phi0, k)) / m
    ratio = 4.0
    stiffness = 1e6 * 0.1 * 0.01**3 / 12

    def span(k):
        phi = np.arcsin(1 / (k * np.sqrt(2)))
        return ellipkinc(np.pi / 2, k * k) - ellipkinc(phi, k * k) - np.sqrt(ratio)

    k = brentq(span, np.sqrt(0.5) + 1e-9, 1 - 1e-9)
    phi = np.arcsin(1 / (k * np.sqrt(2)))
    drop = 1 - 2 * (ellipeinc(np.pi / 2, k * k) - ellipeinc(phi, k * k)) / np.sqrt(ratio)
    errors = []
    for count in (20, 40):
        found = cantilever(count, np.array([0, 0, -ratio * stiffness]))
        assert found.converged
        errors.append(abs(-found.rods.points[-1, 2] - drop))
    assert 0.6 < drop < 0.7
    assert errors[1] < 0.6 * errors[0]
    assert errors[1] < 0.02


def curved_bar(count, curvature, length=1.0):
    """A bar that lies straight along x, its z up, cut with a curvature to the left."""
    rods = bar(count, length)
    return replace(rods, natural=-2 * np.tan(0.5 * curvature * rods.spans))


def test_a_cantilever_cut_to_an_arc_springs_back_to_it():
    # radius 1 / c: after an arc length s it is at (sin(c s), 1 - cos(c s)) / c
    errors = []
    for count in (20, 40):
        rods = curved_bar(count, 1.5)
        found = minimized(rods, elastic_terms(rods.layout), fixed=clamped(rods))
        assert found.converged
        assert sum(found.energies.values()) < 1e-12
        end = np.array([np.sin(1.5), 1 - np.cos(1.5), 0]) / 1.5
        errors.append(np.linalg.norm(found.rods.points[-1] - end))
    # the clamped half segment is straight, so the error falls with the size of a segment
    assert errors[1] < 0.6 * errors[0] < 0.03


def test_a_small_load_moves_an_arc_as_castigliano_says():
    # A quarter of a ring, radius R = 1, clamped at its start at angle 0. A force F at its end, back along x,
    # has the moment F R cos, so it moves the end by F R^3 / B times the integral of cos^2: pi / 4.
    stiffness = 1e6 * 0.01 * 0.1**3 / 12
    moved = []
    for count in (40, 80):
        rods = curved_bar(count, 1.0, np.pi / 2)
        still = clamped(rods)
        free = minimized(rods, elastic_terms(rods.layout), fixed=still).rods
        load = np.zeros((rods.layout.vertices, 3))
        load[-1, 0] = -1e-4 * stiffness
        bent = minimized(free, elastic_terms(rods.layout), fixed=still, load=load, stepping=Stepping(1e-9))
        moved.append((free.points[-1, 0] - bent.rods.points[-1, 0]) / 1e-4)
    errors = abs(np.array(moved) / (np.pi / 4) - 1)
    assert errors[1] < 0.6 * errors[0] < 0.1


def test_a_strip_cut_to_a_ring_closes():
    rods = curved_bar(60, 2 * np.pi * 59 / 60 / 1.0, 1.0)  # joints turn by 2 pi / 60
    found = minimized(rods, elastic_terms(rods.layout))
    assert found.converged
    assert np.linalg.norm(found.rods.points[-1] - found.rods.points[0]) < 0.02


def wobbly(count=24, size=0.02, seed=0):
    """A ring with every vertex and every section a little out of place."""
    hoop = ring(count)
    return hoop.stepped(size * np.random.default_rng(seed).normal(size=hoop.size))


def test_a_coiled_strip_unravels_into_a_straight_flat_one():
    rods = helix(24, 1.0, 1.0, 0.6)
    found = minimized(rods, elastic_terms(rods.layout))
    assert found.converged
    np.testing.assert_allclose(found.rods.lengths, rods.rest, rtol=1e-6)
    np.testing.assert_allclose(found.rods.tangents @ found.rods.tangents[0], 1, atol=1e-6)
    np.testing.assert_allclose(found.rods.twists, 0, atol=1e-4)


def test_a_hoop_becomes_round_and_the_energy_never_rises():
    rods = wobbly()
    found = minimized(rods, elastic_terms(rods.layout))
    assert found.converged
    energies = np.array([step.energy for step in found.steps])
    assert (np.diff(energies) <= 1e-13 * energies[0]).all()
    bent = np.linalg.norm(found.rods.binormals, axis=1)
    np.testing.assert_allclose(bent, bent.mean(), rtol=1e-3)


def test_rods_at_rest_take_no_step():
    rods = bar(10)
    seen = []
    found = minimized(rods, elastic_terms(rods.layout), callback=seen.append)
    assert found.converged
    assert found.steps == tuple(replace(step, rods=None) for step in seen)
    assert seen[-1].rods is not None
    np.testing.assert_array_equal(seen[-1].rods.points, found.rods.points)
    assert [step.number for step in found.steps] == [0]
    assert found.gradient == 0


def test_the_centre_of_mass_stays():
    rods = crumpled()
    # the two rods have contacts, so they are one part
    found = minimized(rods, elastic_terms(rods.layout), stepping=Stepping(most_steps=10))
    masses = np.bincount(rods.layout.ends.ravel(), np.repeat(rods.rest, 2))
    assert np.linalg.norm(found.rods.points - rods.points, axis=1).max() > 0.1
    np.testing.assert_allclose(masses @ found.rods.points, masses @ rods.points, atol=1e-12)


def test_the_result_does_not_depend_on_where_the_rods_are():
    rods = wobbly()
    moved = turned(rods, any_rotation(), np.array([5.0, 0, -2]))
    one, two = (minimized(each, elastic_terms(each.layout)) for each in (rods, moved))
    assert one.converged
    assert two.converged
    assert sum(two.energies.values()) == pytest.approx(sum(one.energies.values()), rel=1e-9)


def test_newton_steps_save_steps():
    rods = wobbly()
    terms = elastic_terms(rods.layout)
    newton = minimized(rods, terms)
    gauss = minimized(rods, [replace(term, curvature=None) for term in terms])
    assert newton.converged
    assert gauss.converged
    assert len(newton.steps) < len(gauss.steps)
    assert sum(newton.energies.values()) == pytest.approx(sum(gauss.energies.values()), rel=1e-9)
    before, last = (step.gradient for step in newton.steps[-2:])
    assert last < 0.05 * before  # Gauss-Newton alone gains a factor near one; damping falls by four a step


def test_a_pattern_is_used_again():
    rods = wobbly()
    terms = elastic_terms(rods.layout)
    pattern = analysed(rods.size, terms, np.zeros(rods.size, dtype=bool))
    again, fresh = minimized(rods, terms, pattern=pattern), minimized(rods, terms)
    np.testing.assert_array_equal(again.rods.points, fresh.rods.points)


def test_it_ends_and_says_so_when_steps_run_out():
    rods = crumpled()
    found = minimized(rods, elastic_terms(rods.layout), stepping=Stepping(most_steps=2))
    assert not found.converged
    assert len(found.steps) == 3
    assert "after 2 steps" in found.ending


def test_it_ends_when_nothing_can_be_won():
    rods = wobbly()
    found = minimized(rods, elastic_terms(rods.layout), stepping=Stepping(tolerance=1e-300, most_steps=200))
    assert not found.converged
    assert np.isfinite(found.rods.points).all()
    assert min(step.gradient for step in found.steps) < 1e-6
    assert "no step lowers" in found.ending or len(found.steps) == 201


def test_an_energy_that_turns_into_nan_is_never_accepted():
    from geoweave.rods.elastic_energies import Term

    rods = ring(12)
    (stretch, *_) = elastic_terms(rods.layout)

    def trap(each):
        residual = stretch.residual(each) + 1.0
        return np.where(each.lengths[:, None] < 0.98 * each.rest[:, None], np.nan, residual)

    found = minimized(
        rods, [Term("trap", stretch.unknowns, trap, stretch.derivative)], stepping=Stepping(most_steps=5)
    )
    assert np.isfinite(sum(found.energies.values()))
    assert len(found.steps) > 1
    assert (found.rods.lengths >= 0.98 * rods.rest).all()
    assert not found.converged


@pytest.mark.parametrize("name", ["tolerance", "most_steps", "turn", "sufficient", "shortest"])
def test_numbers_that_make_no_sense_are_refused(name):
    with pytest.raises(FieldError, match=name):
        Stepping(**{name: 0})


def test_an_iteration_may_end_where_the_energy_is_level():
    rods = crumpled()
    terms = elastic_terms(rods.layout)
    whole = minimized(rods, terms)
    short = minimized(rods, terms, stepping=Stepping(least_gain=0.05))
    assert not short.converged
    assert len(short.steps) < len(whole.steps)
    assert short.steps[-2].energy - short.steps[-1].energy <= 0.05 * short.steps[-2].energy
    assert "0.05" in short.ending
