"""The numbers of a layout say what lies on sheets and pages."""

from __future__ import annotations

import pytest
from laidflat import NAMES, patterns

from geoweave.fabrication.bench import Bench
from geoweave.fabrication.nesting import Stock
from geoweave.fabrication.numbers_of_layout import layout_numbers
from geoweave.fabrication.pieces import Making
from geoweave.fabrication.strip_layout import StripLayout


@pytest.mark.parametrize("name", NAMES)
def test_they_are_those_of_the_drawings(name: str) -> None:
    bench = Bench(Making(overlap=10.0), Stock(200.0, 80.0, 4.0, 1.0), papers=("a4",))
    laid = StripLayout(patterns()[name], bench, media=("sheet", "a4"))
    numbers = layout_numbers(laid)
    assert numbers["sheets"] == len(laid.sheets)
    assert numbers["sheet_size"] == [200.0, 80.0]
    assert numbers["pages"] == {"a4": len(laid.pages("a4"))}
    assert numbers["pieces"] == sum(len(sheet.laid) for sheet in laid.sheets)
    assert numbers["pieces"] == sum(len(page.laid) for page in laid.pages("a4"))
    assert all(0 < share < 1 for share in numbers["used_share"].values())
    sizes = [f.spot.size for d in laid.drawings for f in d.figures if f.text and f.spot is not None]
    assert numbers["smallest_text_mm"] == pytest.approx(min(sizes), abs=1e-4)
    assert numbers["in_key"] == sum(len(each.key) for each in laid.drawings)
    assert numbers["bill"]["crossings"] == len(patterns()[name].at)


def test_where_nothing_is_written_there_is_no_smallest_text() -> None:
    laid = StripLayout(patterns()["flat"], Bench(Making(labels="none")))
    assert layout_numbers(laid)["smallest_text_mm"] is None
