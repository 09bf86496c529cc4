from dataclasses import replace

import numpy as np
import pytest
from rodded import any_rotation, helix

from geoweave.models import shapes
from geoweave.rods.departure import departure
from geoweave.rods.distance_at_rest import DistanceAtRest
from geoweave.rods.rods import DERIVED


def case(seed=0):
    """A helix on a cylinder's radius, moved and a little crumpled, and a sphere that it is not on."""
    design = helix(30, 1.0, 0.4)
    rng = np.random.default_rng(seed)
    moved = (design.points + 0.05 * rng.normal(size=design.points.shape)) @ any_rotation().T + 0.3
    return design, at(design, moved), shapes.sphere(600)


def at(design, points):
    edges = points[design.layout.ends[:, 1]] - points[design.layout.ends[:, 0]]
    tangents = edges / np.linalg.norm(edges, axis=1)[:, None]
    square = design.directors - (design.directors * tangents).sum(axis=1)[:, None] * tangents
    square /= np.linalg.norm(square, axis=1)[:, None]
    return replace(design, points=points, edges=edges, directors=square, twists=DERIVED)


@pytest.mark.parametrize("placed", [False, True])
def test_the_derivative_takes_the_rigid_fit_into_account(placed):
    design, rods, surface = case()
    goal = DistanceAtRest(surface, design, placed=placed)
    miss = goal.miss(rods)
    slope = miss.backward(miss.residuals)
    way = np.random.default_rng(1).normal(size=rods.points.shape)
    small = 1e-6
    values = [goal.miss(at(design, rods.points + sign * small * way)).value for sign in (1, -1)]
    assert (values[0] - values[1]) / (2 * small) == pytest.approx((slope * way).sum(), rel=1e-6)
    assert miss.forward(way) @ miss.residuals == pytest.approx((slope * way).sum(), rel=1e-10)


def test_it_is_half_the_mean_square_that_is_reported():
    design, rods, surface = case(3)
    found = departure(rods, design, surface).to_surface
    assert DistanceAtRest(surface, design).miss(rods).value == pytest.approx(0.5 * found.rms**2, rel=1e-12)


def test_rigid_motions_change_nothing_unless_something_holds_the_rods():
    design, rods, surface = case()
    turn = np.cross(np.array([0.3, -0.2, 0.5]), rods.points) + [0.1, 0.2, 0.3]
    assert abs(DistanceAtRest(surface, design).miss(rods).forward(turn)).max() < 1e-12
    assert abs(DistanceAtRest(surface, design, placed=True).miss(rods).forward(turn)).max() > 1e-3
