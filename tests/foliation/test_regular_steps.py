"""Steps of Eq. 8 with the phase in it: they lower both, and straight families end as a kagome."""

from __future__ import annotations

import numpy as np
import pytest
from eq8 import coupled, three_sheets

import geoweave as gw
from geoweave.errors import FieldError
from geoweave.foliation.phase_energy import PhaseEnergy
from geoweave.foliation.regular_steps import (
    EMPHASES,
    ETA,
    MOST,
    MOST_EMPHASIS,
    STIFFENING,
    RegularSteps,
    regular_course,
)
from geoweave.foliation.theta_and_s import FLOOR


def test_every_step_lowers_the_objective() -> None:
    steps, theta, s = coupled()
    energies = [steps.objective(theta, s)]
    assert energies[0] == pytest.approx(steps.energy(theta, s) + steps.phase(theta, s / steps.unit))
    for _ in range(4):
        theta, s = steps.improve_both(theta, s)
        energies.append(steps.objective(theta, s))
    assert (np.diff(energies) <= 0).all()
    assert energies[-1] < 0.5 * energies[0]
    assert (s >= FLOOR * steps.unit * (1 - 1e-12)).all()


def test_near_the_minimum_the_model_is_the_objective() -> None:
    """A full step ends where the slope vanishes, to second order: the coupled entries are the right ones."""
    field, triples = three_sheets()
    s = np.full(field.mesh.n_faces, 9.0)
    steps = RegularSteps(field, s, s, 1e-3, None, triples)
    *_, (theta, s) = regular_course(steps, s, 0)
    rng, slopes = np.random.default_rng(3), []
    theta, s = theta + 1e-3 * rng.normal(size=len(theta)), s * (1 + 1e-3 * rng.normal(size=len(s)))
    for _ in range(2):
        model = steps.joint_model(theta, s)
        slopes.append(np.abs(model.in_theta).max())
        theta, s = steps.improve_both(theta, s)
    assert slopes[1] < 1e-2 * slopes[0]


def test_three_straight_families_become_a_kagome() -> None:
    field, triples = three_sheets()
    foliation = gw.foliate(field, triples=triples, rescaling=None)
    unit = np.ones(field.mesh.n_faces)
    energy = PhaseEnergy(foliation.field, unit, triples.on(foliation.part))
    assert np.abs(energy.phase(foliation.circle.theta)).max() < 1e-3


def test_the_phase_stiffens_up_to_what_eq_8_asks_for() -> None:
    steps, _, s = coupled()
    weights = [steps.phase.kappa for _ in regular_course(steps, s, 0)]
    stiff = [kappa for kappa in weights[1:] if kappa > 0]
    growing = stiff[-STIFFENING - EMPHASES : -EMPHASES]
    assert (np.diff(growing) > 0).all()
    assert stiff[-EMPHASES:] == [growing[-1]] * EMPHASES
    assert growing[-1] <= MOST
    assert 1.0 <= steps.phase.emphasis.min() <= steps.phase.emphasis.max() <= MOST_EMPHASIS


def test_a_held_s_cannot_be_coupled() -> None:
    field, triples = three_sheets()
    with pytest.raises(FieldError, match="while s is held"):
        gw.foliate(field, triples=triples, steps="theta")


def test_steps_are_solved_to_rounding() -> None:
    """What a step leaves, the next ones enlarge: the numbers of vertices would decide where ribbons lie."""
    problem, theta, s = coupled()
    problem.phase.kappa, problem.phase.eta = 0.1, ETA
    for _ in range(2):
        model = problem.joint_model(theta, s)
        right = np.concatenate([model.in_theta, model.in_share])
        convex, _, _ = problem.energy.model(theta, s)
        weights = problem.phase.model(theta, s / problem.unit).weights
        free = np.ones(len(s))
        entries = problem.systems.joint_entries(convex, free) + problem.phase.entries(weights, free)
        matrix = problem._assembly(np.concatenate(entries))
        left = matrix @ model.factors_of(free).solve(right) - right
        assert np.linalg.norm(left) < 1e-9 * np.linalg.norm(right)
        theta, s = problem.improve_both(theta, s)
