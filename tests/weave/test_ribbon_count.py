"""The search for a scale: finds what is there, says the nearest where it is not, ends."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from geoweave.errors import FieldError
from geoweave.weave.ribbon_count import ENOUGH, NEAR, TRIES, check_asked, nearest_scale


def power(factor: float, growth: float, step: int = 1) -> Callable[[float], int]:
    """Counts that grow as a power, in steps."""
    return lambda scale: step * int(factor * scale**growth / step)


@pytest.mark.parametrize("growth", [1.0, 1.4, 2.0])
@pytest.mark.parametrize("wanted", [3, 20, 108, 1000])
def test_it_finds_every_count_that_a_power_takes(growth: float, wanted: int) -> None:
    found = nearest_scale(power(111, growth), wanted, tries=10)
    assert found.count == wanted == power(111, growth)(found.scale)
    assert len(found.tried) <= 10


def test_where_counts_jump_it_takes_the_nearest_and_the_fewer_of_two() -> None:
    in_fours = nearest_scale(power(111, 1.2, step=4), 50, tries=10)
    assert in_fours.count == 48  # as far from 50 as 52
    in_tens = nearest_scale(power(111, 1.2, step=10), 57, tries=10)
    assert in_tens.count == 60
    assert {count for _, count in in_tens.tried} >= {50, 60}


def test_a_noisy_count_is_met_within_the_noise() -> None:
    def noisy(scale: float) -> int:
        return int(111 * scale**1.4) + round(2 * np.sin(700 * scale))

    for wanted in (17, 60, 111, 300):
        found = nearest_scale(noisy, wanted, tries=10)
        assert abs(found.count - wanted) <= 2
        assert found.count == noisy(found.scale)
        assert dict(found.tried)[found.scale] == found.count
        assert found == nearest_scale(noisy, wanted, tries=10)


def test_a_start_at_which_nothing_is_left_and_a_count_that_never_comes() -> None:
    assert nearest_scale(lambda scale: 0 if scale < 3 else int(10 * scale), 40, tries=10).count == 40
    least = nearest_scale(lambda scale: 0 if scale < 0.1 else 8, 2, tries=10)
    assert least.count == 8
    assert len(least.tried) <= 10
    with pytest.raises(FieldError, match="no ribbon is left at any scale from 1 to 512;"):
        nearest_scale(lambda scale: 0, 5, tries=10)


def test_an_answer_at_once_takes_one_try_and_bad_numbers_are_refused() -> None:
    assert nearest_scale(lambda scale: 7, 7).tried == ((1.0, 7),)
    assert nearest_scale(lambda scale: 7, 9, tries=1).count == 7
    with pytest.raises(FieldError, match="one ribbon or more, not 0"):
        nearest_scale(lambda scale: 7, 0)
    with pytest.raises(FieldError, match="positive first scale"):
        nearest_scale(lambda scale: 7, 9, start=0.0)


@pytest.mark.parametrize("wanted", [17, 60, 111, 300])
def test_with_an_expectation_three_tries_come_within_the_noise(wanted: int) -> None:
    """Counts of another power than the guessed one, with a noise; the expectation knows the power."""
    calls: list[float] = []

    def count(scale: float) -> int:
        calls.append(scale)
        return int(111 * scale**1.1) + round(2 * np.sin(700 * scale))

    def expected(scale: float) -> float:
        best = min(calls, key=lambda each: abs(111 * each**1.1 - wanted))
        return (int(111 * best**1.1) + round(2 * np.sin(700 * best))) * (scale / best) ** 1.1

    found = nearest_scale(count, wanted, expected=expected)
    assert len(calls) == len(found.tried) <= ENOUGH < TRIES
    assert abs(found.count - wanted) <= 4


def test_where_three_tries_are_not_near_it_goes_on() -> None:
    def count(scale: float) -> int:
        return 100 if scale > 0.75 else 60 if scale > 0.7 else 30

    found = nearest_scale(count, 61, expected=lambda scale: 100 * scale)
    assert ENOUGH < len(found.tried) <= TRIES
    assert abs(found.count - 61) <= NEAR * 61


def test_an_expectation_of_nothing_falls_back_on_the_tries() -> None:
    found = nearest_scale(power(111, 1.4), 20, tries=10, expected=lambda scale: 0.0)
    assert abs(found.count - 20) <= NEAR * 20


def test_a_scale_and_a_number_of_ribbons_exclude_each_other() -> None:
    check_asked(None, 7)
    check_asked(0.5, None)
    for scale, ribbons, said in ((1.0, 7, "not both"), (0.0, None, "positive"), (None, 0, "one ribbon")):
        with pytest.raises(FieldError, match=said):
            check_asked(scale, ribbons)
