"""Words are taken in order; a wrong one is named with its line."""

import numpy as np
import pytest

from geoweave.errors import RodError
from geoweave.rods.rod_words import Words


def test_words_are_taken_in_order():
    words = Words("3 0.5\n\n1e3 -2\n")
    assert words.whole("a count") == 3
    np.testing.assert_array_equal(words.numbers(2, "lengths"), [0.5, 1000.0])
    assert words.line() == 3
    with pytest.raises(RodError, match="line 3: a count is '-2', not a whole number from 0 on"):
        words.whole("a count")


def test_missing_and_wrong_words_are_told():
    with pytest.raises(RodError, match="line 1: widths need 3 more numbers but 2 follow"):
        Words("1 2").numbers(3, "widths")
    with pytest.raises(RodError, match="line 2: 'x' among widths is not a finite number"):
        Words("1\nx").numbers(2, "widths")
    with pytest.raises(RodError, match="from 0 to 1"):
        Words("2").whole("a flag", 0, 1)


@pytest.mark.parametrize("word", ["1e300", "-1e60", "1e400"])
def test_numbers_whose_squares_overflow_are_told(word):
    with pytest.raises(RodError, match=f"line 2: {word} among widths is beyond 1e\\+50; correct it"):
        Words(f"1\n{word}").numbers(2, "widths")
