"""What cannot be made is refused, and the number that is named works."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from laidflat import patterns

from geoweave.errors import FieldError
from geoweave.fabrication.making_limits import check_made
from geoweave.fabrication.nesting import Stock
from geoweave.fabrication.pieces import Making
from geoweave.fabrication.sheet_sizes import stock_of


def refusal(making: Making, stock: Stock, width: float = 8.0) -> str:
    pattern = replace(patterns()["flat"], width=width)
    with pytest.raises(FieldError) as found:
        check_made(pattern, making, stock)
    return str(found.value)


def number(text: str, before: str) -> float:
    found = re.search(before + r" ([\d.]+) mm", text)
    assert found, text
    return float(found[1])


def test_holes_wider_than_a_strip() -> None:
    text = refusal(Making(holes=7.5), Stock())
    pattern = patterns()["flat"]
    check_made(pattern, Making(holes=number(text, "holes of [^;]*; take holes of")), Stock())
    check_made(replace(pattern, width=number(text, "strips of")), Making(holes=7.5), Stock())
    assert "make them 4 mm wide or more" in refusal(Making(holes=3.0), Stock(), width=0.9)
    check_made(replace(pattern, width=4.0), Making(holes=3.0), Stock())
    assert "take one of 0.4 mm or more" in refusal(Making(holes=0.2, kerf=0.3), Stock())


def test_strips_too_narrow_to_cut() -> None:
    text = refusal(Making(), Stock(), width=0.13)
    assert "make the object 4 times as large" in text
    check_made(replace(patterns()["flat"], width=4 * 0.13), Making(), Stock())


def test_a_sheet_narrower_than_a_strip() -> None:
    text = refusal(Making(kerf=0.2), Stock(300.0, 15.0))
    pattern = patterns()["flat"]
    check_made(pattern, Making(kerf=0.2), Stock(300.0, number(text, "take a sheet of")))
    narrow = replace(pattern, width=number(text, "or strips of"))
    check_made(narrow, Making(kerf=0.2), Stock(300.0, 15.0))


def test_a_strip_longer_than_the_roll() -> None:
    text = refusal(Making(), stock_of("roll:22x120", margin=2.0))
    assert "strip A1 is 150 mm long and the roll leaves 116 mm" in text
    long = number(text, "take a roll of")
    check_made(patterns()["flat"], Making(), stock_of(f"roll:22x{long:g}", margin=2.0))
    # on a sheet it is made of pieces
    check_made(patterns()["flat"], Making(), Stock(120.0, 60.0))
