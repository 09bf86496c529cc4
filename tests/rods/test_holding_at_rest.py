import numpy as np
import pytest
from rodded import crumpled, grid, three_great_circles
from scipy.interpolate import CubicSpline

from geoweave.models.shapes import sphere
from geoweave.rods.crossing_forces import contact_forces
from geoweave.rods.holding_at_rest import HoldingAtRest, interlacing_force
from geoweave.rods.slide_and_relax import Springs, relax_rods
from geoweave.rods.strip_fitting import Fitting, optimal_strips


def test_a_strip_that_alternates_presses_with_the_force_of_a_clamped_beam():
    """Each of two grids of three bars, alternating: the middle crossing is pressed by four clamped spans."""
    rods = grid(3)
    stiffness = float(rods.material.bending(rods.widths[0]))
    assert interlacing_force(rods) == pytest.approx(24 * stiffness * 0.01)  # one unit apart


@pytest.mark.parametrize(
    ("pattern", "sides"), [("plain", [1, -1]), ("kagome", [1, -1]), ("twill", [1, 1, -1, -1]),
                           ("basket", [1, 1, -1, -1])]
)  # fmt: skip
def test_what_a_weave_asks_is_the_force_of_a_beam_over_such_supports(pattern, sides):
    """The third derivative of a cubic spline through the crossings jumps by the force on each of them."""
    rods = grid(3)
    apart, stiffness = 1.0, float(rods.material.bending(rods.widths[0]))
    heights = 0.5 * 0.01 * np.resize([*sides, *sides, sides[0]], 2 * len(sides) + 1)
    beam = CubicSpline(apart * np.arange(len(heights)), heights, bc_type="periodic")
    third = 6.0 * stiffness * beam.c[0]
    pressed = np.abs(third - np.roll(third, 1))
    np.testing.assert_allclose(interlacing_force(rods, pattern), pressed, rtol=1e-9)


def test_residuals_are_the_forces_that_friction_must_bear():
    rods = crumpled()
    goal = HoldingAtRest(rods, Springs(position=50.0), 2.0)
    lack, forces = goal.lack(rods), contact_forces(rods, Springs(position=50.0))
    found = lack.residuals.reshape(-1, 4) * goal.unit / np.sqrt(2.0 / 3)
    np.testing.assert_allclose(np.linalg.norm(found[:, :3], axis=1), forces.sliding)
    np.testing.assert_allclose(found[:, 3], np.maximum(forces.separation + goal.unit, 0.0))
    assert lack.value == pytest.approx(0.5 * (lack.residuals**2).sum())


def test_the_derivative_is_that_of_the_forces():
    """Compared with differences while the normals hold still: ribbons are shifted, and not turned."""
    rods = crumpled()
    goal = HoldingAtRest(rods, Springs(position=50.0), 1.0)
    lack, step = goal.lack(rods), np.zeros(rods.size)
    first = rods.layout.rod_of_vertex == 0
    step[: rods.points.size].reshape(-1, 3)[first] = [1e-6, 2e-6, -1e-6]
    ahead, behind = goal.lack(rods.stepped(step)), goal.lack(rods.stepped(-step))
    difference = 0.5 * (ahead.residuals - behind.residuals)
    np.testing.assert_allclose(lack.forward(step), difference, atol=1e-6 * np.abs(difference).max())


def test_backwards_is_the_transpose_of_forwards():
    rods, rng = crumpled(), np.random.default_rng(0)
    lack = HoldingAtRest(rods, Springs(), 1.0).lack(rods)
    moved, slope = rng.normal(size=rods.size), rng.normal(size=len(lack.residuals))
    assert lack.forward(moved) @ slope == pytest.approx(moved @ lack.backward(slope), rel=1e-9)


def test_strips_that_are_to_hold_slide_less():
    """Three rings that bend within a ball: less force along the ribbons, and still near the ball."""
    rods = three_great_circles(tilt=0.01)
    ball = sphere(faces=2000)
    found = [
        optimal_strips(rods, ball, numbers=Fitting(hold=hold, most_steps=12)).rest.rods
        for hold in (0.0, 1e-6)
    ]
    free, holding = (np.median(contact_forces(each).sliding) for each in found)
    start = np.median(contact_forces(relax_rods(rods).rods).sliding)
    assert holding < 0.5 * min(free, start)
