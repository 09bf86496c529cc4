"""The energy of the phase: its zeros, its slopes, and what a turn of one family does to it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from eq8 import coupled, three_sheets

from geoweave.arrays import Scalars
from geoweave.foliation.phase_energy import PhaseEnergy


def flat(phase: float, ribbons: int = 2) -> tuple[PhaseEnergy, Scalars]:
    """Three families of straight lines on a disk, whose theta sum to a phase."""
    field, triples = three_sheets()
    mesh = field.mesh
    angle = 0.3 + 2 / 3 * np.pi * np.arange(3) - np.pi / 2  # of w-perp
    direction = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    family = np.repeat(np.arange(3), mesh.n_vertices // 3)
    theta = (
        9.0 * (mesh.vertices[:, :2] * direction[family]).sum(axis=1) + np.array([0.4, phase, -0.4])[family]
    )
    energy = PhaseEnergy(field, np.full(mesh.n_faces, 9.0), replace(triples, ribbons=ribbons))
    energy.kappa, energy.eta = 1.0, 1.0
    return energy, theta


@pytest.mark.parametrize(("ribbons", "kagome"), [(2, 0.0), (2, np.pi), (1, np.pi / 2)])
def test_a_kagome_costs_nothing_and_three_in_a_point_most(ribbons: int, kagome: float) -> None:
    energy, theta = flat(kagome, ribbons)
    ones = np.ones(energy.mesh.n_faces)
    area = energy.mesh.face_areas.sum() / 3
    assert energy(theta, ones) == pytest.approx(0.0, abs=1e-9)
    assert energy.order(theta) == pytest.approx(1.0)
    energy, theta = flat(kagome + np.pi / ribbons, ribbons)
    assert energy(theta, ones) == pytest.approx(2 * area / ribbons**2)
    energy, theta = flat(kagome + 0.2, ribbons)
    np.testing.assert_allclose(energy.phase(theta), 0.2, atol=1e-9)


def test_frequencies_that_fit_together_cost_nothing() -> None:
    energy, theta = flat(0.0)
    count = energy.mesh.n_faces
    assert energy(theta, np.ones(count)) == pytest.approx(0.0, abs=1e-9)
    one = np.where(np.arange(count) < count // 3, 1.2, 1.0)  # one family is denser by a fifth
    assert energy(theta, one) == pytest.approx(0.5 * 0.2**2 * energy.mesh.face_areas.sum() / 3)


def test_slopes_are_those_of_the_energy() -> None:
    steps, theta, s = coupled()
    share, rng, h = s / steps.unit, np.random.default_rng(2), 1e-6
    model = steps.phase.model(theta, share)
    way = rng.normal(size=len(theta)), rng.normal(size=len(share))
    ends = [steps.phase(theta + k * h * way[0], share) for k in (-1, 1)]
    assert -model.in_theta @ way[0] == pytest.approx((ends[1] - ends[0]) / (2 * h), rel=1e-5)
    ends = [steps.phase(theta, share + k * h * way[1]) for k in (-1, 1)]
    assert -model.in_share @ way[1] == pytest.approx((ends[1] - ends[0]) / (2 * h), rel=1e-5)


def test_the_constant_of_a_component_is_free_and_set_to_the_best_phase() -> None:
    energy, theta = flat(1.1)
    assert energy.order(theta) < 0
    assert energy.order(energy.aligned(theta)) == pytest.approx(1.0)


def test_components_over_one_place_share_the_turn() -> None:
    """A third of it each, so that the numbers of the components decide nothing."""
    energy, theta = flat(1.1)
    np.testing.assert_allclose(energy.aligned(theta) - theta, -1.1 / 3, atol=1e-9)
