"""Paths of an SVG: what is written is what is read, and little is written."""

from __future__ import annotations

import numpy as np
import pytest

from geoweave.fabrication.stroke_font import text_strokes
from geoweave.fabrication.svg_paths import path_data, path_lines, place_data, text_data


@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("step", [0.05, 0.01, 0.001])
def test_lines_come_back_to_half_a_step(closed: bool, step: float) -> None:
    """However many steps there are, their errors do not add up."""
    rng = np.random.default_rng(3)
    paths = [
        np.cumsum(rng.normal(0.0, size, (count, 2)), axis=0) + 40.0
        for count, size in ((2, 5.0), (300, 0.4), (5, 90.0), (3, 0.02))
    ]
    found = path_lines(path_data(paths, closed, 200.0, step))
    assert [len(each) for each in found] == [len(each) for each in paths]
    for one, other in zip(found, paths, strict=True):
        # to the micrometre that is written of places
        assert np.abs(one * [1, -1] + [0, 200.0] - other).max() <= 0.5 * step + 5e-4


def test_steps_along_an_axis_have_one_number() -> None:
    corner = np.array([[1.0, 9.0], [3.0, 9.0], [3.0, 8.5], [2.5, 8.0], [2.5, 8.25]])
    data = path_data([corner, corner - [0.0, 2.0]], False, 10.0, 0.01)
    assert data == "M1 1h2v.5l-.5.5v-.25m-1.5 1.25h2v.5l-.5.5v-.25"
    found = path_lines(data)
    np.testing.assert_allclose(found[1] * [1, -1] + [0, 10.0], corner - [0.0, 2.0], atol=1e-12)


def test_a_line_after_a_closed_one_begins_at_the_beginning_of_that() -> None:
    square = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    data = path_data([square, square + [10.0, 1.0]], True, 0.0, 0.01)
    assert data.count("z") == 2
    np.testing.assert_allclose(path_lines(data)[1] * [1, -1], square + [10.0, 1.0], atol=1e-12)


def test_places_are_read_as_they_were_before() -> None:
    corners = np.array([[0.125, 9.0], [30.0, 9.0], [30.0, -8.5]])
    data = place_data([corners], True, 10.0)
    assert data == "M0.125,1 30,1 30,18.5Z"
    np.testing.assert_allclose(path_lines(data)[0], corners * [1, -1] + [0, 10.0])


@pytest.mark.parametrize("turn", [0.0, 90.0, 37.0])
def test_a_text_stands_where_its_strokes_do(turn: float) -> None:
    strokes, _ = text_strokes("B12/3", 2.4, 0.0, 0.0)
    angle = np.radians(turn)
    turned = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    found = path_lines(text_data("B12/3", 2.4, turn, 17.31, 42.18, 0.05))
    assert len(found) == len(strokes)
    for one, stroke in zip(found, strokes, strict=True):
        wanted = stroke @ turned * [1, -1] + [17.31, 42.18]
        assert np.abs(one - wanted).max() <= 0.05 + 1e-9


def test_numbers_stand_apart_where_nothing_parts_them() -> None:
    """``1.5.25`` is two numbers, ``15`` and ``1 5`` are not the same."""
    line = np.array([[0.0, 0.0], [1.5, 0.25], [2.5, 5.25], [2.75, 6.25], [12.75, 5.75]])
    data = path_data([line], False, 0.0, 0.01)
    assert data == "M0 0l1.5-.25 1-5 .25-1 10 .5"
    np.testing.assert_allclose(path_lines(data)[0] * [1, -1], line, atol=1e-12)
