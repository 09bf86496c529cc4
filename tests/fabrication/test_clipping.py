"""What is left of segments and polygons is what lies on the strip and outside of boxes."""

from __future__ import annotations

import numpy as np
import pytest

from geoweave.fabrication.clipping import clipped, dashes, outside, rectangle, span, within
from geoweave.fabrication.stroke_font import Box


def test_a_segment_lies_in_a_box_where_its_points_do() -> None:
    rng = np.random.default_rng(0)
    box, share = Box(-1.0, -0.5, 1.0, 0.5), np.linspace(0, 1, 2001)
    for start, end in rng.uniform(-2, 2, (60, 2, 2)):
        points = start + share[:, None] * (end - start)
        there = (np.abs(points) < [1.0, 0.5]).all(axis=1)
        found = span(start, end, box)
        if found is None:
            assert there.sum() <= 1
        else:
            assert found[1] - found[0] == pytest.approx(there.mean(), abs=2e-3)


def test_segments_along_the_axes() -> None:
    box = Box(0.0, -1.0, 10.0, 1.0)
    assert span(np.array([2.0, -3.0]), np.array([2.0, 3.0]), box) == pytest.approx((1 / 3, 2 / 3))
    assert span(np.array([-2.0, 2.0]), np.array([12.0, 2.0]), box) is None
    seen = within(np.array([-5.0, 0.0]), np.array([15.0, 0.0]), 10.0, 1.0)
    assert seen is not None
    np.testing.assert_allclose(seen, [[0, 0], [10, 0]])


def test_the_outside_and_the_inside_make_the_whole() -> None:
    line = np.array([[0.0, 0.0], [10.0, 0.0]])
    boxes = [Box(1, -1, 3, 1), Box(2, -1, 4, 1), Box(6, -1, 7, 1), Box(9, -1, 12, 1), Box(0, 1, 9, 2)]
    parts = outside(line, boxes)
    np.testing.assert_allclose([part[:, 0] for part in parts], [[0, 1], [4, 6], [7, 9]])
    assert outside(line, [Box(-1, -1, 11, 1)]) == []


def test_dashes_begin_and_end_whole() -> None:
    found = dashes(np.array([0.0, 0.0]), np.array([7.0, 0.0]), 0.5)
    sizes = [np.linalg.norm(each[1] - each[0]) for each in found]
    np.testing.assert_allclose(sizes, sizes[0])
    assert sizes[0] == pytest.approx(0.5, rel=0.2)
    np.testing.assert_allclose([found[0][0], found[-1][1]], [[0, 0], [7, 0]], atol=1e-12)


def test_a_polygon_keeps_the_area_that_lies_on_the_strip() -> None:
    whole = np.array([[-1.0, 0.0], [1.0, -2.0], [3.0, 0.0], [1.0, 2.0]])
    left = clipped(whole, 10.0, 1.0)
    assert _area(left) == pytest.approx(8.0 - 1.0 - 1.0 - 1.0)
    assert _area(clipped(rectangle(-5, 20, 3), 10.0, 1.0)) == pytest.approx(20.0)
    assert len(clipped(rectangle(11, 12, 0.5), 10.0, 1.0)) == 0


def _area(polygon: np.ndarray) -> float:
    x, y = polygon.T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
