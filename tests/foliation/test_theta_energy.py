"""Eq. 8: slopes against finite differences, and what its terms are zero on."""

from __future__ import annotations

import numpy as np
import pytest
from eq8 import NAMES, problem

from geoweave.fields.face_field import FaceField
from geoweave.foliation.theta_energy import LEAST_COSINE, ThetaEnergy
from geoweave.models import shapes


@pytest.mark.parametrize("name", NAMES)
def test_downhill_is_minus_the_gradient(name: str) -> None:
    steps, theta, s = problem(name)
    _, in_theta, in_share = steps.energy.model(theta, s)
    rng, width = np.random.default_rng(1), 1e-6
    along_theta, along_share = rng.normal(size=len(theta)), rng.normal(size=len(s))
    for downhill, way in (
        (in_theta @ along_theta, (along_theta, 0.0)),
        (in_share @ along_share, (0.0, along_share * steps.unit)),
    ):
        ahead, back = (steps.energy(theta + h * way[0], s + h * way[1]) for h in (width, -width))
        assert -(ahead - back) / (2 * width) == pytest.approx(downhill, rel=1e-6)


def test_theta_that_follows_the_field_has_no_energy() -> None:
    """On a flat disk with w along x and s = 3, theta = -3 y rises at the rate s along w-perp."""
    disk = shapes.disk(faces=300)
    field = FaceField.from_ambient(disk, np.tile([1.0, 0.0, 0.0], (disk.n_faces, 1)))
    s = np.full(disk.n_faces, 3.0)
    eq8 = ThetaEnergy(field, s, 1e-3)
    theta = -3.0 * disk.vertices[:, 1]
    assert eq8(theta, s) < 1e-20
    assert eq8(-theta, s) > 0.1
    # Full turns at single vertices are not seen.
    turns = 2.0 * np.pi * np.random.default_rng(0).integers(-2, 3, disk.n_vertices)
    assert eq8(theta + turns, s) < 1e-20


@pytest.mark.parametrize("name", NAMES)
def test_the_model_is_convex(name: str) -> None:
    steps, theta, s = problem(name)
    weights = steps.energy.model(theta, s).weights
    assert (weights >= LEAST_COSINE * steps.energy.weight * (1 - 1e-12)).all()
