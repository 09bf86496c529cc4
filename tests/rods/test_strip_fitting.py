from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from geoweave.errors import FieldError
from geoweave.models import shapes
from geoweave.rods.slid_weave import elastic_rods
from geoweave.rods.slide_and_relax import Springs
from geoweave.rods.steps import Stepping
from geoweave.rods.strip_fitting import Fitting, _Inverse, _Linear, optimal_strips
from geoweave.weave.design import weave_pattern


@cache
def torus():
    """A torus of few ribbons, which is far from its surface with straight strips."""
    return weave_pattern(shapes.torus(faces=1500), ribbons=20, phase="free")


@cache
def designed():
    rods = elastic_rods(torus()).rods
    return replace(rods, natural=rods.geodesic)


@cache
def found():
    return optimal_strips(designed(), torus().mesh, numbers=Fitting(most_steps=20))


def test_it_brings_the_weave_to_its_surface():
    steps = found().steps
    taken = [step for step in steps if step.taken]
    assert found().ending
    assert [step.number for step in steps] == list(range(len(steps)))
    assert all(after.rms < before.rms for before, after in pairwise(taken))
    assert taken[-1].rms < 0.4 * taken[0].rms
    assert found().rest.converged


def test_strips_stay_within_their_bounds():
    numbers = Fitting(sharpest=0.05, longest=0.002, most_steps=6)
    start = designed()
    cut = optimal_strips(start, torus().mesh, numbers=numbers).cut
    assert (abs(cut.natural) / cut.spans * cut.joint_widths).max() < 0.05 * 1.003  # lengths change spans
    assert abs(cut.rest / start.rest - 1).max() <= 0.002 * (1 + 1e-9)


def test_the_gradient_is_that_of_finite_differences():
    start = designed()
    still = np.zeros(start.layout.vertices, dtype=bool)
    problem = _Inverse(start, torus().mesh, Springs(), still, Fitting(smooth=1e-3), "plain")
    problem.stepping = Stepping(tolerance=1e-12, most_steps=100)
    z = problem.knots.start()
    linear = _Linear(problem, problem.nearby(problem.anew(z).rods, z).rods, z)
    way = np.random.default_rng(0).normal(size=len(z))
    small = 1e-5
    values = []
    for sign in (1, -1):
        there = z + sign * small * way
        values.append(problem.target(problem.nearby(linear.rods, there).rods, there).value)
    assert (values[0] - values[1]) / (2 * small) == pytest.approx(linear.gradient @ way, rel=1e-5)


def test_it_ends_and_says_that_it_has_not_converged():
    short = optimal_strips(designed(), torus().mesh, numbers=Fitting(most_steps=1))
    assert len(short.steps) == 2
    assert not short.converged
    assert "1 trials" in short.ending


@pytest.mark.parametrize("wrong", [{"sharpest": 2.0}, {"enough": 0.0}, {"smooth": float("nan")}])
def test_numbers_out_of_range_are_refused(wrong):
    with pytest.raises(FieldError, match=next(iter(wrong))):
        Fitting(**wrong)
