"""What Appendix E says of ribbons as elastic rods, on weaves of a dozen ribbons."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from geoweave.arrays import Flags
from geoweave.models import shapes
from geoweave.rods.elastic_energies import elastic_terms, energy_density
from geoweave.rods.rods import DERIVED, Contacts, Rods
from geoweave.rods.slid_weave import elastic_rods
from geoweave.rods.slide_and_relax import relax_rods, relaxing_terms
from geoweave.rods.steps import Problem
from geoweave.rods.weave_at_rest import Relaxed, relaxed_weave
from geoweave.weave.design import Weave, weave_pattern

CLOSED = {"bumpy box": 15, "icosahedron": 15, "sphere": 16, "torus": 20}
"""Models and about how many ribbons they get."""


@cache
def woven(name: str) -> Weave:
    mesh = {
        "bumpy box": lambda: shapes.bumpy_box(faces=2500),
        "cone": lambda: shapes.cone(faces=1000),
        "icosahedron": lambda: shapes.icosahedron(faces=2000),
        "sphere": lambda: shapes.sphere(1280),
        "torus": lambda: shapes.torus(faces=2000),
    }[name]()
    return weave_pattern(mesh, ribbons=CLOSED.get(name, 9))


@cache
def rested(name: str) -> Relaxed:
    return relaxed_weave(woven(name))


def elastic(rods: Rods, which: Flags) -> float:
    """Energy within some of the ribbons, without that of contacts."""
    density = sum(energy_density(rods).values())
    return float((density * rods.rest)[which[rods.layout.rod_of_segment]].sum())


@pytest.mark.parametrize("name", CLOSED)
def test_closed_weaves_come_to_rest_near_their_surface(name: str) -> None:
    """E.2: for closed surfaces "the equilibrium shape is almost always very close to the input target"."""
    found = rested(name)
    assert found.converged
    assert found.left.gradient <= 1e-6
    away = found.departure.to_surface
    # between a dozen ribbons the holes are wide; those of one click, 35 to 109, stay within 3.1 %
    assert away.largest < 0.06
    assert away.mean < 0.015


@pytest.mark.parametrize("name", ["cone", *CLOSED])
def test_the_iteration_quickly_comes_to_rest(name: str) -> None:
    """E.2: Gauss-Newton with a line search "quickly converges to a weave equilibrium state"."""
    found = relax_rods(elastic_rods(woven(name)).rods)
    assert found.converged
    # RibbonSim takes 20 to 150 on weaves of 10 to 28 rods
    assert len(found.steps) <= 100
    assert found.steps[-1].energy < found.steps[0].energy


@pytest.mark.parametrize("name", ["cone", "sphere"])
def test_contacts_hold_the_shape_that_ribbons_would_leave(name: str) -> None:
    """E.2: "Contact forces at the crossings balance residual internal forces within the ribbons ... without
    contact forces each ribbon would unravel into a straight, flat strip"."""
    rest = rested(name).left.rods
    # each force within a ribbon is balanced by one at a contact
    within = sum(term.gradient(rest) for term in elastic_terms(rest.layout))
    without = sum(term.gradient(rest) for term in relaxing_terms(rest)[len(elastic_terms(rest.layout)) :])
    np.testing.assert_allclose(within, -without, atol=1e-5 * np.linalg.norm(within))
    assert np.linalg.norm(within) > 0
    free = replace(rest, contacts=Contacts(np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0)))
    found = relax_rods(free)
    assert found.converged
    hoops = found.rods.layout.closed  # closed ribbons become hoops
    assert elastic(found.rods, ~hoops) < 1e-6 * elastic(rest, ~hoops)
    ends = found.rods.layout.offsets
    for first, past, hoop in zip(ends[:-1], ends[1:], hoops, strict=True):
        if not hoop:
            own = found.rods.points[first:past]
            length = np.linalg.norm(np.diff(own, axis=0), axis=1).sum()
            assert np.linalg.norm(own[-1] - own[0]) > 0.999 * length


@pytest.mark.parametrize("name", ["cone", "sphere"])
def test_a_line_search_must_carry_directors(name: str) -> None:
    """E.2: directors left behind "stop being normal to their corresponding rod segments, so that the estimate
    of the post-step energy in the line search is incorrect"; the paper finds it too optimistic, here it is
    off either way, and mostly too high."""
    rods = elastic_rods(woven(name)).rods
    problem = Problem(
        rods, relaxing_terms(rods), np.zeros(rods.size, dtype=bool), None, anchored=False, pattern=None
    )
    for _ in range(2):  # into the valley where sections lie flush
        now = problem.completed(problem.tried(rods))
        step = problem.solved(rods, problem.factored(problem.matrix(now), 1e-9), now.gradient)
        rods = problem.moved(rods, step).rods
    now = problem.completed(problem.tried(rods))
    step = problem.solved(rods, problem.factored(problem.matrix(now), 1e-9), now.gradient)
    small = 1e-3
    slope = small * float(now.gradient @ step)
    carried = problem.moved(rods, small * step).energy - now.energy
    start, end = rods.layout.ends.T
    moved = small * step[: 3 * rods.layout.vertices].reshape(-1, 3)
    angles = small * step[3 * rods.layout.vertices :, None]
    left = replace(
        rods,
        points=rods.points + moved,
        edges=rods.edges + moved[end] - moved[start],
        directors=np.cos(angles) * rods.directors + np.sin(angles) * rods.across,
        twists=DERIVED,
    )
    behind = problem.tried(left).energy - now.energy
    assert carried == pytest.approx(slope, rel=0.01)
    assert abs(behind - slope) > 0.1 * abs(slope)
