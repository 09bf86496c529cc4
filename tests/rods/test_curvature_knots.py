from dataclasses import replace

import numpy as np
import pytest
from rodded import bar, crumpled, ring

from geoweave.rods.curvature_knots import STRAIN, Knots


def test_equal_knots_give_equal_curvature_and_length_everywhere():
    rods = crumpled()
    knots = Knots.of(rods)
    z = np.full(knots.number, 0.2)
    cut = knots.cut(z)
    np.testing.assert_allclose(cut.natural / rods.spans * rods.joint_widths, 0.2)
    np.testing.assert_allclose(cut.rest, rods.rest * (1 + 0.2 * STRAIN))
    assert abs(knots.second @ z).max() < 1e-12


@pytest.mark.parametrize("rods", [bar(17), ring(16)])
def test_the_start_is_the_nearest_curvature(rods):
    knots = Knots.of(rods)
    goal = np.random.default_rng(0).normal(size=knots.number)
    goal[knots.curved :] = 0.0
    same = replace(rods, natural=knots.cut(goal).natural)
    np.testing.assert_allclose(Knots.of(same).start(), goal, atol=1e-10)


def test_slopes_are_adjoint_to_changes():
    knots = Knots.of(crumpled())
    rng = np.random.default_rng(1)
    z = rng.normal(size=knots.number)
    natural, rest = rng.normal(size=len(knots.rods.natural)), rng.normal(size=len(knots.rods.rest))
    one, two = knots.change(z)
    assert knots.slope(natural, rest) @ z == pytest.approx(natural @ one + rest @ two)


def test_a_rod_of_one_segment_has_a_length_and_no_curvature():
    knots = Knots.of(bar(1))
    assert knots.curved == 0
    assert knots.number == 1
    assert knots.start().tolist() == [0.0]
