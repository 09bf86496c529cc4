"""The steps of Eq. 8 lower it, keep s above its floor, and hold its mean where it must be held."""

from __future__ import annotations

import numpy as np
import pytest
from eq8 import NAMES, problem
from surfaces import surface

import geoweave as gw
from geoweave.foliation.foliation import punctured
from geoweave.foliation.theta_and_s import FLOOR, Alternation
from geoweave.models import shapes


@pytest.mark.parametrize("name", NAMES)
def test_every_step_lowers_the_energy_and_s_keeps_above_its_floor(name: str) -> None:
    steps, theta, s = problem(name)
    least, energies = FLOOR * s, [steps.energy(theta, s)]
    for _ in range(3):
        theta = steps.improve_theta(theta, s)
        energies.append(steps.energy(theta, s))
        theta, s = steps.improve_both(theta, s)
        energies.append(steps.energy(theta, s))
        s = steps.improve_s(theta, s)
        energies.append(steps.energy(theta, s))
    assert (np.diff(energies) <= 0).all()
    assert (s >= least * (1 - 1e-12)).all()


def test_where_no_loop_has_a_period_the_mean_of_s_is_held() -> None:
    """On a disk theta and s could shrink together; where punctures have periods s is free."""
    held, bettis = [], []
    for mesh in (shapes.saddle(faces=600), surface("jagged sphere")):
        field, part = punctured(gw.smoothest_field(mesh))
        mesh = part.mesh
        s = np.full(mesh.n_faces, 20.0)
        steps = Alternation(field, s, s, 1e-3)
        _, theta = steps.eigenvector(steps.start(0), None, s)
        for _ in range(3):
            theta, s = steps.improve_both(theta, s)
            s = steps.improve_s(theta, s)
        bettis.append(mesh.bundle.betti_numbers.tolist())
        held.append(np.average(s / steps.unit, weights=mesh.face_areas))
    assert bettis[0] == [0]
    assert bettis[1][0] > 0
    assert held[0] == pytest.approx(1.0, abs=1e-9)
    assert abs(held[1] - 1.0) > 1e-6
