"""Every piece lies once on a sheet, inside its margins, and apart from the others."""

from __future__ import annotations

import math
from itertools import combinations

import pytest
from laidflat import NAMES, patterns

from geoweave.errors import FieldError
from geoweave.fabrication.nesting import Laid, Stock, nested, used_share
from geoweave.fabrication.pieces import Making, pieces_of
from geoweave.fabrication.strip_drawing import drawn
from geoweave.fabrication.stroke_font import Box, boxes_overlap


def extent(laid: Laid) -> Box:
    return laid.drawn.extent.moved(laid.x, laid.y)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    "stock", [Stock(), Stock(width=320.0), Stock(200.0, 70.0, margin=4.0, gap=1.5)], ids=str
)
def test_pieces_lie_apart_on_their_sheets(name: str, stock: Stock) -> None:
    pattern = patterns()[name]
    pieces = pieces_of(pattern, Making(), stock.room)
    sheets = nested([drawn(pattern, piece, Making()) for piece in pieces], stock)
    assert sorted(laid.drawn.piece for sheet in sheets for laid in sheet.laid) == sorted(pieces)
    assert math.isfinite(stock.height) or len(sheets) == 1
    for sheet in sheets:
        assert sheet.width == stock.width or stock.width == math.inf
        boxes = [extent(laid) for laid in sheet.laid]
        inner = Box(stock.margin, stock.margin, sheet.width - stock.margin, sheet.height - stock.margin)
        for box in boxes:
            assert box.left >= inner.left - 1e-6
            assert box.bottom >= inner.bottom - 1e-6
            assert box.right <= inner.right + 1e-6
            assert box.top <= inner.top + 1e-6
        assert not any(
            boxes_overlap(one.grown(0.5 * stock.gap - 1e-6), other.grown(0.5 * stock.gap - 1e-6))
            for one, other in combinations(boxes, 2)
        )


def test_refusals() -> None:
    pattern = patterns()["flat"]
    drawings = [drawn(pattern, piece, Making()) for piece in pieces_of(pattern, Making())]
    with pytest.raises(FieldError, match=r"150 mm does not fit .* take one of 160 mm"):
        nested(drawings, Stock(width=140.0))
    with pytest.raises(FieldError, match="take one of 18 mm or more"):
        nested(drawings, Stock(width=400.0, height=14.0))
    with pytest.raises(FieldError, match="no strip"):
        nested([], Stock())
    with pytest.raises(FieldError, match="no room between margins"):
        Stock(width=9.0)
    with pytest.raises(FieldError, match="gap"):
        Stock(gap=-1.0)


@pytest.mark.parametrize("name", NAMES)
def test_rows_come_as_a_person_looks_for_them(name: str) -> None:
    """Rows are in the order of the family and number of their first pieces, from the top down."""
    stock = Stock(230.0, 300.0)
    pattern = patterns()[name]
    pieces = pieces_of(pattern, Making(), stock.room)
    sheets = nested([drawn(pattern, piece, Making()) for piece in pieces], stock)
    first = {}
    for number, sheet in enumerate(sheets):
        for laid in sheet.laid:
            first.setdefault((number, laid.row), laid)
    found = [(one.drawn.family, one.drawn.number, one.drawn.piece.number) for _, one in sorted(first.items())]
    assert found == sorted(found)
    assert 0 < used_share(sheets) < 1
    # no row could be taken into another one of its family
    assert len(found) <= len(pieces)
