"""Counts of the bill, against what they count."""

from __future__ import annotations

from dataclasses import replace

import pytest
from laidflat import NAMES, patterns

from geoweave.fabrication.bill import MINUTES, bill_of
from geoweave.fabrication.pieces import Making, pieces_of


@pytest.mark.parametrize("name", NAMES)
def test_it_counts_what_is_cut(name: str) -> None:
    pattern, making = patterns()[name], Making(overlap=10.0)
    pieces = pieces_of(pattern, making, 120.0)
    bill = bill_of(pattern, pieces, making, density=0.5)
    assert (bill.strips, bill.pieces, bill.crossings) == (len(pattern.strips), len(pieces), len(pattern.at))
    # every strip is as long as its pieces without what overlaps
    joins = sum(strip.closed for strip in pattern.strips) + len(pieces) - len(pattern.strips)
    assert bill.joins == joins
    whole = sum(strip.length for strip in pattern.strips) / 1000
    assert bill.metres == pytest.approx(whole + 0.010 * joins)
    volume = bill.metres * 1000 * pattern.width * pattern.thickness
    assert bill.grams == pytest.approx(0.5 * volume / 1000)
    assert bill.fasten <= bill.crossings
    assert bill_of(pattern, pieces, Making(holes=2.0)).fasten == bill.crossings


def test_the_model_of_hours_is_that_of_the_papers_bunny() -> None:
    """Section 5.4: 1,823 crossings on 108 ribbons, about fifty hours."""
    minutes = 1823 * MINUTES["crossing"] + 108 * MINUTES["strip"]
    assert minutes / 60 == pytest.approx(50, abs=2)


def test_it_is_harder_where_crossings_are_crowded_and_says_so() -> None:
    pattern, making = patterns()["flat"], Making()
    pieces = pieces_of(pattern, making)
    easy, hard = bill_of(pattern, pieces, making), bill_of(replace(pattern, width=40.0), pieces, making)
    assert easy.difficulty == "easy"
    assert not any(
        "nearer" in reason for reason in bill_of(replace(pattern, width=4.0), pieces, making).reasons
    )
    assert any("nearer than the strips are wide" in reason for reason in hard.reasons)
    narrow = bill_of(replace(pattern, width=2.0), pieces, making)
    assert any("only 2 mm wide" in reason for reason in narrow.reasons)
