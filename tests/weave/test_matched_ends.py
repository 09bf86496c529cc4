"""Ends are set where the ribbons beside them can alternate, by one crossing, and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import lines_on_square

from geoweave.curves.curve_crossings import crossings
from geoweave.models import shapes
from geoweave.weave.design import weave_field
from geoweave.weave.interlacing import EFFORT, optimal
from geoweave.weave.matched_ends import with_matched_ends
from geoweave.weave.ribbons import Cutting, Ribbons
from geoweave.weave.validity import violations

SPACING = 0.2
PLACES = [-0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6]
"""Of rows and columns, from side to side of the square; the middle row is left to the test."""

ASIDE = (0.003, 0.007)

COLUMNS = [(x, -0.98, x, 0.98) for x in PLACES]
ROWS = [(-0.98, y, 0.98, y) for y in PLACES if y]


def woven(*ends: tuple[float, float, float, float]) -> Ribbons:
    # a little aside, so that no crossing falls on a vertex of the mesh
    lines = lines_on_square(*[tuple(np.add(each, [*ASIDE, *ASIDE])) for each in ends])
    return Ribbons(lines, crossings(lines), np.arange(len(lines)), SPACING, Cutting(fewest=2))


def test_an_end_goes_on_to_the_cell_of_another_one() -> None:
    """Two ends face each other with one column between them; one of them crosses it."""
    given = woven(*COLUMNS, *ROWS, (-0.98, 0.0, -0.15, 0.0), (0.98, 0.0, 0.15, 0.0))
    found, turns = with_matched_ends(given, EFFORT, "plain")
    assert optimal(given.passages).broken.sum() == 1
    assert turns.broken.sum() == 0
    assert len(found.crossings) == len(given.crossings) + 1
    added = np.linalg.norm(found.crossings.points[:, :2] - ASIDE, axis=1).argmin()
    np.testing.assert_allclose(found.crossings.points[added, :2], ASIDE, atol=1e-9)
    # a tail stays beyond it, and every other ribbon stays as it is
    assert np.sort(found.curves.lengths - given.curves.lengths)[-2:] == pytest.approx([0.0, 0.2])


def test_an_end_is_drawn_back_to_the_cell_of_another_one() -> None:
    """A line from above ends at the middle row, which goes on by one column too many."""
    middle, above = (-0.98, 0.0, 0.05, 0.0), (-0.1, 0.98, -0.1, -0.05)
    given = woven(*COLUMNS, *ROWS, middle, above)
    assert optimal(given.passages).broken.sum() == 1
    found, turns = with_matched_ends(given, EFFORT, "plain")
    assert turns.broken.sum() == 0
    assert len(found.crossings) == len(given.crossings) - 1
    assert found.curves.lengths[len(COLUMNS) + len(ROWS)] == pytest.approx(0.93)


def test_ends_stay_where_all_alternate_or_a_crossing_would_be_crowded() -> None:
    alone = woven(*COLUMNS, *ROWS)
    assert with_matched_ends(alone, EFFORT, "plain")[0] is alone
    # as in the first test, but a row is so near that a crossing with it would lie beside the new one
    crowded = [(-0.98, 0.04, 0.98, 0.04), (-0.98, -0.04, 0.98, -0.04)]
    given = woven(*COLUMNS, *ROWS, *crowded, (-0.98, 0.0, -0.15, 0.0), (0.98, 0.0, 0.15, 0.0))
    assert optimal(given.passages).broken.sum() == 1
    assert with_matched_ends(given, EFFORT, "plain")[0] is given


def test_a_weave_breaks_fewer_relations_and_stays_valid() -> None:
    made = weave_field(shapes.torus(faces=2500)).pattern()
    found, turns = made.ribbons, made.interlacing
    assert turns.proven
    assert turns.alternation > 0.985  # 0.993, and 0.981 before
    assert violations(found, turns.over) == []
    assert not found.loose.any()
