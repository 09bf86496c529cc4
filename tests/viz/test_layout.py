"""Where panels and their words go: rows of equal columns, or rows packed by width."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from pictures import blank_frame

from geoweave.errors import RenderError
from geoweave.viz.layout import GAP, SIDE, gallery, grid
from geoweave.viz.picture import Picture


@dataclass(frozen=True)
class Block:
    """Something to draw that is one flat grey."""

    aspect: float
    grey: int = 100

    def draw(self, height: int) -> np.ndarray:
        return np.full((height, round(height * self.aspect), 3), self.grey, dtype=np.uint8)


def boxes(pixels: np.ndarray, greys: list[int]) -> list[tuple[int, int, int, int]]:
    """Left, right, top and bottom of each grey."""
    found = []
    for grey in greys:
        rows, columns = np.nonzero((pixels == grey).all(axis=2))
        found.append((columns.min(), columns.max() + 1, rows.min(), rows.max() + 1))
    return found


def test_scenes_that_fill_their_cells_are_as_large_as_a_square_of_the_column() -> None:
    greys = [60, 90, 120]
    blocks = [Block(aspect, grey) for aspect, grey in zip((0.5, 2.0, 1.0), greys, strict=True)]
    figure = grid(blocks, [("", "")] * 3, columns=None, width=1100, tallest=900, foot=0, filling=True)
    found = boxes(Picture(figure).pixels, greys)
    longest = [max(right - left, bottom - top) for left, right, top, bottom in found]
    assert np.ptp(longest) <= 2
    assert len({top + bottom for _, _, top, bottom in found}) <= 2, "in the middle of the row"


@pytest.mark.parametrize("equal", [True, False])
def test_models_of_a_row_are_equally_tall_and_apart(equal: bool) -> None:
    greys = [60, 90, 120]
    blocks = [Block(aspect, grey) for aspect, grey in zip((0.5, 1.5, 1.0), greys, strict=True)]
    figure = grid(blocks, [("", "")] * 3, columns=None, width=1100, tallest=900, foot=0, equal_columns=equal)
    pixels = Picture(figure).pixels
    first, second, third = boxes(pixels, greys)
    assert len({each[2:] for each in (first, second, third)}) == 1
    assert blank_frame(pixels, 10)
    middles = [0.5 * (each[0] + each[1]) for each in (first, second, third)]
    gaps = [second[0] - first[1], third[0] - second[1]]
    if equal:
        assert middles[1] - middles[0] == pytest.approx(middles[2] - middles[1], abs=1)
    else:
        assert gaps[0] == pytest.approx(gaps[1], abs=1)
        assert first[0] == pytest.approx(gaps[0], abs=1)


def test_packed_rows_use_the_width_that_equal_columns_leave_empty() -> None:
    blocks = [Block(0.5, 60), Block(1.5, 90)]
    heights = []
    for equal in (True, False):
        figure = grid(
            blocks, [("", "")] * 2, columns=None, width=1100, tallest=5000, foot=0, equal_columns=equal
        )
        box = boxes(Picture(figure).pixels, [60])[0]
        heights.append(box[3] - box[2])
    inside = 1100 - 0.5 * (2 * SIDE + GAP)
    assert heights == [int(inside / 2 / 1.5), int(inside / 2)]


def test_no_model_is_taller_than_allowed_and_a_last_row_stands_in_the_middle() -> None:
    figure = grid(
        [Block(1.0, 60), Block(1.0, 90), Block(1.0, 120)],
        [("a", "b")] * 3,
        columns=2,
        width=1100,
        tallest=300,
        foot=100,
    )
    first, _, last = boxes(Picture(figure).pixels, [60, 90, 120])
    assert first[3] - first[2] == 150
    assert 0.5 * (last[0] + last[1]) == pytest.approx(550, abs=1)


def test_words_stand_below_and_accents_keep_their_colour() -> None:
    plain = gallery([Block(1.0)], [("", "")], width=400).pixels
    worded = gallery([Block(1.0)], [("title", "subtitle")], width=400)
    assert len(worded.pixels) > len(plain)
    assert (worded.pixels[len(plain) - 5 :] < 128).any()
    assert worded.alt == "title"
    accented = gallery([Block(1.0)], [("", "")], width=400, accents=["#ff0000"])
    assert tuple(accented.colormaps[0](3)[:3]) == (1.0, 0.0, 0.0)


def test_an_empty_gallery_is_refused() -> None:
    with pytest.raises(RenderError, match="at least one panel"):
        gallery([], [])
