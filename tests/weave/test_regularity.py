"""Regularity is 1 for a kagome, and counts what is not regular."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from laidlines import SPACING, kagome, laid, made

from geoweave.models import shapes
from geoweave.weave.design import weave_pattern
from geoweave.weave.inspection import inspected
from geoweave.weave.passages import Passages
from geoweave.weave.regularity import Cells, Regularity, local_spacing, near_ideal, phase_order, piled


def test_a_kagome_has_nothing_but_triangles_and_hexagons() -> None:
    found = Regularity.of(laid(kagome(0.5)))
    assert (found.piled, found.bare) == (0.0, 0.0)
    assert found.spacing_spread == pytest.approx(0.0, abs=1e-9)
    assert found.phase_order == pytest.approx(1.0)
    assert found.triangles == pytest.approx(2 / 3, abs=0.03)  # two to each hexagon, but for the boundary
    assert found.triangles + found.hexagons == pytest.approx(1.0)
    assert (found.near_ideal, found.parts) == (1.0, 1)


@pytest.mark.parametrize("phase", [0.55, 0.7, 0.9])
def test_the_order_is_the_cosine_of_twice_the_phase(phase: float) -> None:
    found = Regularity.of(laid(kagome(phase)))
    assert found.phase_order == pytest.approx(-np.cos(2 * np.pi * phase), abs=1e-6)
    # the smaller triangles have the side (1 - phase) 2 d / sqrt 3, and are piled where it is under 0.3 d
    assert (found.piled > 0.9) == ((1 - phase) * 2 / np.sqrt(3) < 0.3)


def test_spacing_is_that_of_the_lines_for_any_number_of_families() -> None:
    weave = laid(kagome(0.6))
    local = local_spacing(weave.passages, weave.ribbons.curves.lengths, 3)
    assert local == pytest.approx(SPACING)
    ticks = [(k + 0.513) * SPACING - 1.0 for k in range(9)]
    square = laid([(0, 0.0, x) for x in ticks] + [(90, x, 0.0) for x in ticks])
    assert local_spacing(square.passages, square.ribbons.curves.lengths, 2) == pytest.approx(SPACING)
    assert Cells.of(square.ribbons.curves, square.ribbons.crossings).corners.tolist() == [4] * 64


def test_a_bare_strip_and_a_ribbon_of_few_crossings_are_counted() -> None:
    lines = [line for line in kagome(0.5) if line[0] != 0.0]
    half = [line for line in lines if line[1] * np.cos(np.radians(line[0] + 90)) < 0.1]
    found = Regularity.of(laid(half))
    assert found.bare > 0.1
    assert found.fewest_crossings < 4
    assert found.few_crossings > 0


def test_a_wall_between_two_crossings_keeps_them_apart() -> None:
    points, up = (
        np.array([[0.0, 0, 0], [0, 0, 0.01], [0.02, 0, 0]]),
        np.array([[0.0, 0, 1], [0, 0, -1], [0, 0, 1]]),
    )
    assert piled(points, up, 0.1).tolist() == [True, False, True]


def test_angles_are_compared_with_those_of_evenly_turned_families() -> None:
    assert near_ideal(np.array([39.0, 41.0, 79.0, 81.0]), 3).tolist() == [False, True, True, False]
    assert near_ideal(np.array([69.0, 71.0, 90.0]), 2).tolist() == [False, True, True]


def test_gaps_go_round_a_closed_ribbon() -> None:
    """Crossings at 0.5, 1.5 and 3.5 of a ring of length 4: gaps of 1, 2 and 1."""
    ring = Passages(
        np.array([[0, 1], [0, 2], [0, 3]]),
        np.array([[0.5, 0.0], [1.5, 0.0], [3.5, 0.0]]),
        np.array([True, False, False, False]),
    )
    shares = np.array([1 / 3, 2 / 3, 1 / 2])
    assert phase_order(ring, np.array([4.0, 1, 1, 1])) == pytest.approx(-np.cos(2 * np.pi * shares).mean())


def test_cells_of_a_closed_surface_obey_eulers_formula() -> None:
    """On a torus without loose tips each cell is a disk: corners of all cells are four for each crossing,
    less those at ends."""
    weave = made()
    cells = Cells.of(weave.ribbons.curves, weave.ribbons.crossings)
    ways = sum(len(weave.passages.relations.first) for _ in range(2))
    crossings = len(weave.ribbons.crossings)
    assert len(cells.corners) == ways / 2 - crossings  # chi = 0: V - E + F = 0
    # four of a crossing without ends; an end takes one way out of a crossing
    assert 4.0 <= cells.corners.mean() <= ways / len(cells.corners)


def test_the_report_says_how_regular_the_weave_is() -> None:
    found = inspected(made())
    assert found.document()["regularity"] == found.regularity.document()
    assert found.regularity == Regularity.of(made())
    assert Regularity.of(weave_pattern(shapes.torus(faces=600), symmetry=4, scale=0.5)).phase_order is None


def test_turned_normals_give_the_same_cells() -> None:
    """Mirrored, left is right: the same cells."""
    weave = laid(kagome(0.6))
    met = weave.ribbons.crossings
    one = Cells.of(weave.ribbons.curves, met).corners
    other = Cells.of(weave.ribbons.curves, replace(met, angle=-met.angle)).corners
    assert sorted(one) == sorted(other)
