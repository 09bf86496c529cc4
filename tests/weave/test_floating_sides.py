import itertools

import numpy as np
import pytest
from flatweaves import anything, grid, segments

from geoweave.weave.floating_sides import floating_sides
from geoweave.weave.interlacing import EFFORT, judged, optimal
from geoweave.weave.weave_types import FLOATING, rules_of


def fewest(rules, crossings):
    """By trying all sides."""
    return min(
        int(rules.broken(np.array(each)).sum()) for each in itertools.product((0, 1), repeat=crossings)
    )


def every_small_weave():
    yield from (grid(rows, columns) for rows, columns in ((2, 4), (3, 4), (3, 3), (4, 3), (2, 5)))
    yield from (anything(seed) for seed in range(25))
    rng = np.random.default_rng(2)
    for _ in range(4):
        start, end = rng.normal(size=(2, 7, 2))
        crossings = segments(start, end)
        if len(crossings) <= 12:
            yield crossings


@pytest.mark.parametrize("name", FLOATING)
def test_on_everything_small_no_choice_goes_below_the_bound_and_few_go_below_what_is_found(name):
    found = exact = 0
    for crossings in every_small_weave():
        rules = rules_of(crossings, name)
        over, bound = floating_sides(rules, EFFORT)
        broken, least = int(rules.broken(over).sum()), fewest(rules, len(crossings))
        assert bound <= least <= broken
        found += broken == least
        exact += bound == least
    assert found == len(list(every_small_weave()))  # the search is exact on all of these
    assert exact >= 0.7 * found


@pytest.mark.parametrize("name", FLOATING)
def test_on_a_torus_of_fours_nothing_is_broken(name):
    found = optimal(grid(12, 8), pattern=name)
    assert found.proven
    assert found.defects == 0
    assert found.met == found.met_bound == 1.0
    assert found.alternation == 0.5  # over two, under two
    assert found.document()["name"] == name


@pytest.mark.parametrize("name", FLOATING)
def test_a_ribbon_of_six_crossings_breaks_two_rules(name):
    """Over two and under two has a period of four; round a ribbon sides change an even number of times."""
    found = optimal(grid(6, 8), pattern=name)
    assert found.proven
    assert found.defects == found.bound == 2 * 8


def test_the_search_ends_at_once_and_with_little_effort_the_bound_still_holds():
    crossings = grid(7, 8)
    rules = rules_of(crossings, "twill")
    over, bound = floating_sides(rules, 1)
    most = floating_sides(rules, EFFORT)
    assert 0 <= bound <= most[1] <= rules.broken(most[0]).sum() <= rules.broken(over).sum() + 8
    again, _ = floating_sides(rules, 1)
    np.testing.assert_array_equal(over, again)


def test_a_floating_weave_is_judged_by_its_own_rules():
    crossings = grid(8, 8)
    i, j = np.arange(64) // 8, np.arange(64) % 8
    twill = judged(crossings, (i + j) % 4 // 2, "twill")
    plain = judged(crossings, (i + j) % 4 // 2)
    assert (twill.defects, plain.defects) == (0, 64)
    assert twill.alternation == plain.alternation == 0.5
    assert twill.alternation_bound == 1.0
