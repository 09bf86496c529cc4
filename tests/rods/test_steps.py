"""Single steps; where they lead in the end is in test_equilibrium."""

import numpy as np
import pytest
from rodded import crumpled, ring

from geoweave.rods.elastic_energies import elastic_terms
from geoweave.rods.steps import NEWTON, Problem, Stepping


def problem_of(rods):
    still = np.zeros(rods.size, dtype=bool)
    return Problem(rods, elastic_terms(rods.layout), still, None, False, None)


def test_the_gradient_is_the_derivative_of_the_energy():
    rods = crumpled()
    problem = problem_of(rods)
    now = problem.completed(problem.tried(rods))
    step = 1e-6 * np.random.default_rng(1).normal(size=rods.size)
    ahead, behind = problem.moved(rods, step), problem.moved(rods, -step)
    assert ahead.energy - behind.energy == pytest.approx(2 * now.gradient @ step, rel=1e-6)


def test_the_full_second_derivative_is_that_of_the_energy():
    rods = crumpled()
    problem = problem_of(rods)
    now = problem.completed(problem.tried(rods))
    free = problem.pattern.free
    small, step = 1e-4, np.random.default_rng(2).normal(size=rods.size)
    ahead, behind = problem.moved(rods, small * step), problem.moved(rods, -small * step)
    change = (ahead.energy - 2 * now.energy + behind.energy) / small**2
    exact = step[free] @ (problem.matrix(now, now.residuals) @ step[free])
    assert change == pytest.approx(exact, rel=1e-5)
    gauss = step[free] @ (problem.matrix(now) @ step[free])
    assert change != pytest.approx(gauss, rel=1e-2)


def test_a_step_has_no_rigid_part_and_turns_no_segment_far():
    rods = crumpled()
    problem, numbers = problem_of(rods), Stepping(turn=0.05)
    now = problem.completed(problem.tried(rods))
    taken = problem.advanced(now, problem.factored(problem.matrix(now), 1e-6), numbers)
    assert taken.trial.energy < now.energy
    assert taken.whole < 1
    turned = np.arccos(np.clip((taken.trial.rods.tangents * rods.tangents).sum(axis=1), -1, 1))
    assert turned.max() < 0.06
    masses = np.bincount(rods.layout.ends.ravel(), np.repeat(rods.rest, 2))
    np.testing.assert_allclose(masses @ taken.trial.rods.points, masses @ rods.points, atol=1e-12)


def test_an_indefinite_matrix_gives_no_step():
    # a ring that is pushed together buckles: the second derivative is indefinite, Gauss-Newton's is not
    flat = ring(16)
    shorter = flat.stepped(np.concatenate([-0.2 * flat.points.ravel(), np.zeros(flat.layout.segments)]))
    problem = problem_of(shorter)
    now = problem.completed(problem.tried(shorter))
    assert problem.factored(problem.matrix(now, now.residuals), NEWTON[0]) is None
    assert problem.factored(problem.matrix(now), 1e-9) is not None
    taken, damping = problem.newton(now, NEWTON[1], now.residuals, Stepping())
    assert taken is None or damping > NEWTON[1]
