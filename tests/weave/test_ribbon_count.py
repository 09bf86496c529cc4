"""The search for a scale: finds what is there, says the nearest where it is not, ends."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from geoweave.errors import FieldError
from geoweave.weave.ribbon_count import TRIES, nearest_scale


def power(factor: float, growth: float, step: int = 1) -> Callable[[float], int]:
    """Counts that grow as a power, in steps."""
    return lambda scale: step * int(factor * scale**growth / step)


@pytest.mark.parametrize("growth", [1.0, 1.4, 2.0])
@pytest.mark.parametrize("wanted", [3, 20, 108, 1000])
def test_it_finds_every_count_that_a_power_takes(growth: float, wanted: int) -> None:
    found = nearest_scale(power(111, growth), wanted)
    assert found.count == wanted == power(111, growth)(found.scale)
    assert len(found.tried) <= TRIES


def test_where_counts_jump_it_takes_the_nearest_and_the_fewer_of_two() -> None:
    in_fours = nearest_scale(power(111, 1.2, step=4), 50)
    assert in_fours.count == 48  # as far from 50 as 52
    in_tens = nearest_scale(power(111, 1.2, step=10), 57)
    assert in_tens.count == 60
    assert {count for _, count in in_tens.tried} >= {50, 60}


def test_a_noisy_count_is_met_within_the_noise() -> None:
    def noisy(scale: float) -> int:
        return int(111 * scale**1.4) + round(2 * np.sin(700 * scale))

    for wanted in (17, 60, 111, 300):
        found = nearest_scale(noisy, wanted)
        assert abs(found.count - wanted) <= 2
        assert found.count == noisy(found.scale)
        assert dict(found.tried)[found.scale] == found.count
        assert found == nearest_scale(noisy, wanted)


def test_a_start_at_which_nothing_is_left_and_a_count_that_never_comes() -> None:
    assert nearest_scale(lambda scale: 0 if scale < 3 else int(10 * scale), 40).count == 40
    least = nearest_scale(lambda scale: 0 if scale < 0.1 else 8, 2)
    assert least.count == 8
    assert len(least.tried) <= TRIES
    with pytest.raises(FieldError, match="no ribbon is left at any scale from 1 to 512;"):
        nearest_scale(lambda scale: 0, 5)


def test_an_answer_at_once_takes_one_try_and_bad_numbers_are_refused() -> None:
    assert nearest_scale(lambda scale: 7, 7).tried == ((1.0, 7),)
    assert nearest_scale(lambda scale: 7, 9, tries=1).count == 7
    with pytest.raises(FieldError, match="one ribbon or more, not 0"):
        nearest_scale(lambda scale: 7, 0)
    with pytest.raises(FieldError, match="positive first scale"):
        nearest_scale(lambda scale: 7, 9, start=0.0)
