import itertools

import numpy as np
import pytest
from flatweaves import anything, grid

from geoweave.weave.floating_sides import floating_sides
from geoweave.weave.interlacing import EFFORT
from geoweave.weave.passages import Passages
from geoweave.weave.rule_cycles import fewest_of_cycles
from geoweave.weave.weave_types import FLOATING, rules_of


@pytest.mark.parametrize("name", FLOATING)
def test_no_sides_go_below_the_bound_whatever_sides_it_starts_from(name):
    for crossings in (grid(3, 4), grid(3, 3), grid(2, 5), *(anything(seed) for seed in range(15))):
        rules = rules_of(crossings, name)
        every = [np.array(each) for each in itertools.product((0, 1), repeat=len(crossings))]
        least = min(int(rules.broken(each).sum()) for each in every)
        for over in (every[0], every[len(every) // 3]):
            assert fewest_of_cycles(rules, over, EFFORT) <= least


def test_cycles_of_both_kinds_prove_what_neither_proves_alone():
    """Columns of seven break a rule each, eight in all, and a twill of an odd number of rows more."""
    rules = rules_of(grid(7, 8), "twill")
    over, bound = floating_sides(rules, EFFORT)
    assert 12 < bound <= rules.broken(over).sum()  # by rows alone 8, by links alone 12


def test_a_crossing_that_is_two_apart_from_itself_breaks_its_rule():
    """A ribbon that passes one other twice, round and round: over two and under two cannot close."""
    crossings = Passages([[0, 1], [0, 1]], [[0.0, 0.0], [1.0, 1.0]], [True, True])
    rules = rules_of(crossings, "basket")
    least = min(int(rules.broken(np.array(each)).sum()) for each in itertools.product((0, 1), repeat=2))
    assert fewest_of_cycles(rules, np.zeros(2, dtype=np.int64), EFFORT) == least
    assert len(rules.row) == 4
