"""The measures of a piece that is drawn, and what its parts leave for those that come later."""

from __future__ import annotations

import numpy as np
import pytest
from laidflat import patterns

from geoweave.fabrication.pieces import Making, pieces_of
from geoweave.fabrication.strip_canvas import LARGEST, SMALLEST, StripCanvas, text_room
from geoweave.fabrication.stroke_font import text_box


def canvas(name: str = "flat", which: int = 0) -> StripCanvas:
    pattern, making = patterns()[name], Making()
    return StripCanvas(pattern, pieces_of(pattern, making)[which], making)


def test_writing_fits_on_the_strip() -> None:
    for name in ("flat", "circles", "cone"):
        here = canvas(name)
        assert 0 < here.inside < here.edge == 0.5 * patterns()[name].width
        assert here.heights == sorted(here.heights, reverse=True)
        assert all(SMALLEST <= height <= LARGEST for height in here.heights)
        assert here.radius < here.inside


def test_places_of_crossings_are_counted_from_the_start_of_the_piece() -> None:
    pattern, making = patterns()["circles"], Making()
    for piece in pieces_of(pattern, making, 150.0):
        for each in StripCanvas(pattern, piece, making).passages:
            assert 0 <= each.at <= piece.length + 1e-9
            strip = pattern.strips[piece.strip]
            places = [
                passage.at for passage in pattern.passages[piece.strip] if passage.crossing == each.crossing
            ]
            assert any(
                (each.at + piece.start - at) % strip.length == pytest.approx(0.0, abs=1e-6)
                or (each.at + piece.start - at) % strip.length == pytest.approx(strip.length, abs=1e-6)
                for at in places
            )


def test_what_is_taken_is_free_for_nobody_else() -> None:
    here = canvas()
    box = text_room("A1", here.heights[0]).moved(0.5 * here.length, 0.0)
    assert here.board.free(box)
    here.take(box)
    assert not here.board.free(box)
    assert here.clear[-1].left < box.left
    assert here.clear[-1].right > box.right


def test_a_mark_is_hollow_on_the_upper_strip_and_solid_on_the_lower_one() -> None:
    here = canvas()
    for each in here.passages:
        here.mark(each, each.at, 0.0, here.radius)
        assert here.figures[-1].role == ("hollow" if each.over else "solid")
        assert here.figures[-1].family == here.pattern.strips[each.partner].family
        assert np.abs(here.figures[-1].paths[0] - [each.at, 0.0]).max() <= 1.2 * here.radius


def test_nothing_to_draw_leaves_no_figure() -> None:
    here = canvas()
    here.add("fold", [], False)
    assert here.figures == []


def test_a_text_has_half_a_gap_on_either_side() -> None:
    plain, room = text_box("C12", 3.0), text_room("C12", 3.0)
    assert plain.left - room.left == pytest.approx(0.36)
    assert room.right - plain.right == pytest.approx(0.36)
