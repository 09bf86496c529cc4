"""The cut list, read back: lengths, totals, and stock that holds what is cut from it."""

from __future__ import annotations

import csv
import io

import pytest
from laidflat import NAMES, patterns

from geoweave.errors import FieldError
from geoweave.fabrication.assembly_order import assembly
from geoweave.fabrication.cut_list import COLUMNS, cut_list
from geoweave.fabrication.pieces import Making


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("stock", [150.5, 400.0, 5000.0])
def test_stock_holds_what_is_cut_from_it(name: str, stock: float) -> None:
    pattern, making = patterns()[name], Making(overlap=12.0, kerf=0.2)
    found = cut_list(pattern, making, stock)
    taken = [0.0] * found.used
    for piece, number in zip(found.pieces, found.stock, strict=True):
        taken[number - 1] += piece.length + 0.2
    assert max(taken) <= stock + 1e-9
    assert min(taken) > 0
    assert sum(found.per_stock) == len(found.pieces)
    assert found.used >= found.cut / stock - 1e-9
    # of first fit, at most one stock length is less than half full
    assert sum(each < 0.5 * stock for each in taken) <= 1


@pytest.mark.parametrize("name", NAMES)
def test_the_file_says_the_same(name: str) -> None:
    pattern, making = patterns()[name], Making()
    found = cut_list(pattern, making, 1000.0)
    text = found.text(pattern, assembly(pattern))
    rows, totals = (list(csv.reader(io.StringIO(part))) for part in text.split("\n\n"))
    assert tuple(rows[0]) == COLUMNS
    table = [dict(zip(COLUMNS, row, strict=True)) for row in rows[1:]]
    assert [float(row["length_mm"]) for row in table] == pytest.approx(
        [strip.length for strip in pattern.strips], abs=0.01
    )
    assert {row["strip"]: int(row["crossings"]) for row in table} == {
        strip.label: len(passages) for strip, passages in zip(pattern.strips, pattern.passages, strict=True)
    }
    assert sorted(int(row["order"]) for row in table) == list(range(1, len(pattern.strips) + 1))
    numbers = dict(totals)
    metres = sum(strip.length for strip in pattern.strips) / 1000
    assert float(numbers["total_m"]) == pytest.approx(metres, abs=1e-3)
    assert float(numbers["cut_m"]) == pytest.approx(
        sum(float(row["cut_mm"]) for row in table) / 1000, abs=1e-3
    )
    assert int(numbers["stock_lengths"]) == max(int(row["stock"]) for row in table)
    assert sum(int(each) for each in numbers["pieces_per_stock_length"].split()) == len(table)


def test_refusals() -> None:
    with pytest.raises(FieldError, match="stock length"):
        cut_list(patterns()["flat"], Making(), 0.0)
    with pytest.raises(FieldError, match="too short for pieces"):
        cut_list(patterns()["flat"], Making(), 20.0)
