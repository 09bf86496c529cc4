"""Texts are as wide as they say, stay in their boxes, and boxes that are free meet nothing."""

from __future__ import annotations

import string
from itertools import combinations

import numpy as np
import pytest

from geoweave.errors import FieldError
from geoweave.fabrication.stroke_font import PEN, Board, Box, boxes_overlap, text_box, text_strokes


def test_the_box_holds_the_strokes_and_the_pen() -> None:
    for text in ("A1", "B12/2", "C3=1", "Q >", *string.ascii_uppercase, *string.digits):
        strokes, box = text_strokes(text, 3.0, 10.0, -2.0)
        points = np.concatenate(strokes)
        assert box.right - box.left == pytest.approx(np.ptp(points[:, 0]) + 3 * PEN)
        np.testing.assert_allclose(points.min(axis=0) - 1.5 * PEN, box[:2])
        np.testing.assert_allclose(points.max(axis=0) + 1.5 * PEN, box[2:])
        assert 0.5 * (box.left + box.right) == pytest.approx(10.0)


def test_the_box_is_the_same_wherever_the_text_stands() -> None:
    for text, height in (("A1", 3.0), ("B12/2", 1.3), ("Q >", 4.5)):
        box = text_box(text, height)
        _, there = text_strokes(text, height, 7.0, -3.0)
        np.testing.assert_allclose(there, box.moved(7.0, -3.0))
    with pytest.raises(FieldError, match="nothing to write"):
        text_box(" ", 3.0)


def test_letters_are_of_one_height_and_differ() -> None:
    seen = []
    for letter in string.ascii_uppercase + string.digits:
        strokes, _ = text_strokes(letter, 1.0, 0.0, 0.0)
        points = np.concatenate(strokes)
        assert -0.56 < points[:, 1].min() < -0.4
        assert 0.4 < points[:, 1].max() < 0.56
        dots = {(round(15 * x), round(15 * y)) for stroke in strokes for x, y in _dense(stroke)}
        seen.append((letter, dots))
    for (one, a), (other, b) in combinations(seen, 2):
        assert len(a & b) < 0.9 * len(a | b), (one, other)


def test_boxes_are_found_over_any_distance() -> None:
    """A box as long as a strip, one as thin as a line, and what lies on either side of zero."""
    board = Board(-1000.0, 1000.0, 0.5)
    board.take(Box(-900.0, 0.0, 900.0, 1.0))
    board.take(Box(950.0, -5.0, 950.0, 5.0))
    for x in (-899.0, -8.0, -0.1, 0.0, 7.9, 8.0, 899.0):
        assert not board.free(Box(x, 0.9, x + 0.1, 2.0))
        assert not board.free(Box(x, 1.4, x + 0.1, 2.0))
        assert board.free(Box(x, 1.5, x + 0.1, 2.0))
    assert not board.free(Box(940.0, 0.0, 949.6, 1.0))
    assert board.free(Box(940.0, 0.0, 949.5, 1.0))


def _dense(stroke: np.ndarray) -> np.ndarray:
    share = np.linspace(0, 1, 12)[:, None, None]
    return (stroke[:-1] + share * np.diff(stroke, axis=0)).reshape(-1, 2)


def test_letters_that_are_not_there_are_refused() -> None:
    with pytest.raises(FieldError, match="'é'"):
        text_strokes("Aé", 3.0, 0.0, 0.0)
    with pytest.raises(FieldError, match="nothing to write"):
        text_strokes(" ", 3.0, 0.0, 0.0)


def test_free_boxes_meet_nothing() -> None:
    board, put = Board(0.0, 100.0, 0.5), []
    rng = np.random.default_rng(1)
    for x, y, w, h in rng.uniform([-5, -20, 1, 1], [105, 20, 9, 4], (800, 4)):
        box = Box(x, y, x + w, y + h)
        free = box.left >= 0 and box.right <= 100 and not any(boxes_overlap(box.grown(0.5), b) for b in put)
        assert board.free(box) == free
        if free:
            board.take(box)
            put.append(box)
    assert len(put) > 64
    assert not any(boxes_overlap(one, other) for one, other in combinations(put, 2))


def test_the_first_free_place_is_that_of_a_walk_step_by_step() -> None:
    """Leaping over what is in the way finds what trying every step finds, to the right and to the left."""
    random = np.random.default_rng(5)
    found = []
    for _ in range(60):
        board = Board(0.0, 100.0, 0.5)
        for x in random.uniform(5, 95, 9):
            board.take(Box(x - 3.0, -1.0, x + 3.0, 1.0).moved(0.0, float(random.uniform(-2, 2))))
        box, start = Box(-4.0, -1.0, 4.0, 1.0), float(random.uniform(0, 100))
        for step in (0.3, -0.3, 7.0):
            walk = (k for k in range(150) if board.free(box.moved(start + k * step, 0.5)))
            found.append(next(walk, None))
            assert board.first_free(box, 0.5, start, step, 150) == found[-1]
    assert None in found
    assert len(set(found)) > 20
