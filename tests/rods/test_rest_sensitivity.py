from dataclasses import replace

import numpy as np
import pytest
from rodded import bar, grid

from geoweave.errors import RodError
from geoweave.rods.contact_energies import contact_position
from geoweave.rods.elastic_energies import elastic_terms
from geoweave.rods.equilibrium import minimized
from geoweave.rods.rest_sensitivity import RestSensitivity
from geoweave.rods.slide_and_relax import relaxing_terms
from geoweave.rods.steps import Stepping

SHARP = Stepping(tolerance=1e-12, most_steps=200)


def at_rest(seed=0):
    """A grid of strips with any curvatures and lengths, at rest, and its energies.

    Contacts hold places together and let strips tilt: the second derivative of what keeps them flush is exact
    only where they are.
    """
    rng = np.random.default_rng(seed)
    rods = grid(2)
    natural, stretch = (
        0.05 * rng.normal(size=len(rods.layout.joints)),
        0.02 * rng.normal(size=len(rods.rest)),
    )
    rods = replace(rods, natural=natural, rest=rods.rest * (1 + stretch))
    terms = (*elastic_terms(rods.layout), contact_position(rods, 10.0))
    ends = np.concatenate([rods.layout.offsets[:-1], rods.layout.offsets[1:] - 1])
    held = np.zeros(rods.size, dtype=bool)
    held[(3 * ends[:, None] + np.arange(3)).ravel()] = True  # else the grid could shear freely
    start = rods.stepped(np.where(held, 0.0, 0.02 * rng.normal(size=rods.size)))
    return minimized(start, terms, stepping=SHARP, fixed=held).rods, terms, held


def test_the_adjoint_gives_the_derivative_of_any_measure_of_the_shape_at_rest():
    rods, terms, held = at_rest()
    rng = np.random.default_rng(1)
    measure = np.concatenate([rng.normal(size=rods.points.size), np.zeros(rods.layout.segments)])
    by_natural, by_rest = RestSensitivity(rods, terms, held).pulled(measure)
    for name, slope, small in (("natural", by_natural, 1e-5), ("rest", by_rest, 1e-6)):
        way = rng.normal(size=len(slope))
        found = []
        for sign in (1, -1):
            other = replace(rods, **{name: getattr(rods, name) + sign * small * way})
            new = minimized(other, terms, stepping=SHARP, fixed=held).rods
            found.append(measure[: rods.points.size] @ new.points.ravel())
        assert (found[0] - found[1]) / (2 * small) == pytest.approx(slope @ way, rel=1e-5)


def test_forward_and_backward_are_adjoint():
    rods, terms, held = at_rest(2)
    sensitivity = RestSensitivity(rods, terms, held)
    rng = np.random.default_rng(3)
    natural, rest = rng.normal(size=len(rods.natural)), rng.normal(size=len(rods.rest))
    slope = np.where(held, 0.0, rng.normal(size=rods.size))
    by_natural, by_rest = sensitivity.pulled(slope)
    forward = sensitivity.moved(natural, rest) @ slope
    assert forward == pytest.approx(by_natural @ natural + by_rest @ rest, rel=1e-8)


def test_a_shape_that_is_not_stable_is_refused():
    rods = bar(8)
    squeezed = replace(rods, rest=2 * rods.rest)  # straight and under pressure: it would buckle
    with pytest.raises(RodError, match="stable"):
        RestSensitivity(squeezed, relaxing_terms(squeezed), np.zeros(rods.size, dtype=bool))
