"""Sheets, rolls and papers by their names."""

from __future__ import annotations

import math

import pytest

from geoweave.errors import FieldError
from geoweave.fabrication.sheet_sizes import PAPERS, paper_of, stock_of


@pytest.mark.parametrize(
    ("text", "width", "height"),
    [
        ("600x400", 600, 400),
        ("400 x 600", 600, 400),
        ("12x24in", 609.6, 304.8),
        ("30x60cm", 600, 300),
        ("A4", 297, 210),
        ("a3", 420, 297),
        ("letter", 279.4, 215.9),
        ("tabloid", 431.8, 279.4),
        ("roll:22x50000", 50_000, 22),
        ("roll:24in", math.inf, 609.6),
    ],
)
def test_sizes_are_those_of_their_names(text: str, width: float, height: float) -> None:
    stock = stock_of(text, 3.0, 1.0)
    assert (stock.width, stock.height) == (pytest.approx(width), pytest.approx(height))
    assert (stock.margin, stock.gap, stock.roll) == (3.0, 1.0, text.startswith("roll"))


def test_without_a_name_it_is_one_long_sheet() -> None:
    assert math.isinf(stock_of(None).width)
    assert not stock_of(None).roll


@pytest.mark.parametrize("text", ["", "600", "axb", "600x", "roll:", "b5", "-3x4", "600x400ft"])
def test_other_words_are_refused_with_those_there_are(text: str) -> None:
    with pytest.raises(FieldError, match=r"600x400.*12x24in.*roll:WIDTH.*a4, letter, a3, tabloid"):
        stock_of(text)


def test_papers_lie_on_their_long_sides() -> None:
    for name, paper in PAPERS.items():
        assert paper_of(name.upper()) == paper
        assert paper.width > paper.height
    with pytest.raises(FieldError, match="no paper 'b5'"):
        paper_of("b5")
