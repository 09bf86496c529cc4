"""Pieces cover their strip, overlap as they should, and fit on the sheet."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from laidflat import NAMES, patterns

from geoweave.errors import FieldError
from geoweave.fabrication.pieces import Making, cut_length, pieces_of, shown


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("longest", [math.inf, 110.0])
def test_pieces_make_the_strip(name: str, longest: float) -> None:
    pattern, making = patterns()[name], Making(overlap=12.0, extra=3.0, kerf=0.2)
    pieces = pieces_of(pattern, making, longest)
    for r, strip in enumerate(pattern.strips):
        own = [piece for piece in pieces if piece.strip == r]
        assert [piece.number for piece in own] == list(range(1, len(own) + 1))
        assert {piece.total for piece in own} == {len(own)}
        added = 12.0 if strip.closed else 6.0
        assert own[-1].end - own[0].start == pytest.approx(strip.length + added)
        assert cut_length(pattern, making, r) == pytest.approx(strip.length + added)
        assert own[0].start == (0.0 if strip.closed else -3.0)
        assert all(piece.length + 0.2 <= longest + 1e-9 for piece in own)
        if len(own) > 1:  # one piece less would not do
            assert (strip.length + added - 12) / (len(own) - 1) + 12 > longest - 0.2
        for one, other in pairwise(own):
            assert one.end - other.start == pytest.approx(12.0)
            assert one.joins[-1].name == other.joins[0].name
            assert one.joins[-1][:2] == pytest.approx(other.joins[0][:2])
        joins = [join.name for piece in own for join in piece.joins]
        assert len(joins) == 2 * len(set(joins)) == 2 * (len(own) - 1 + strip.closed)


@pytest.mark.parametrize("name", NAMES)
def test_every_crossing_is_shown_on_every_strip(name: str) -> None:
    pattern, making = patterns()[name], Making(overlap=12.0)
    for longest in (math.inf, 90.0):
        seen = [
            (piece.strip, each.crossing, each.side)
            for piece in pieces_of(pattern, making, longest)
            for each in shown(pattern, piece, 2.0)
        ]
        wanted = {(r, x, side) for x, pair in enumerate(pattern.ribbons) for side, r in enumerate(pair)}
        assert set(seen) == wanted
        doubles = len(seen) - len(wanted)
        overlaps = sum(len(piece.joins) for piece in pieces_of(pattern, making, longest)) / 2
        assert doubles <= 3 * overlaps


def test_a_closed_strip_shows_its_start_on_its_tab() -> None:
    pattern = patterns()["circles"]
    (piece, *_) = pieces_of(pattern, Making(overlap=20.0))
    lengths = pattern.strips[piece.strip].length
    at = [each.at for each in shown(pattern, piece, 2.0)]
    assert min(at) == pytest.approx(0.0)
    assert any(np.isclose(at, lengths))


def test_refusals() -> None:
    pattern = patterns()["circles"]
    with pytest.raises(FieldError, match="longer sheet or a smaller overlap"):
        pieces_of(pattern, Making(overlap=40.0), 100.0)
    with pytest.raises(FieldError, match="too short for a tab"):
        pieces_of(pattern, Making(overlap=300.0))
    with pytest.raises(FieldError, match="kerf"):
        Making(kerf=-0.1)
    with pytest.raises(FieldError, match="extra"):
        Making(extra=math.nan)
    with pytest.raises(FieldError, match="cannot be joined"):
        Making(overlap=0.0)
