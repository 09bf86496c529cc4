"""Distances to curves, each on its side of a thin wall."""

from __future__ import annotations

import numpy as np
from surfaces import lines_on_square

from geoweave.curves.nearest_curve import nearest_curves

UP = np.array([[0.0, 0.0, 1.0]])


def test_distance_to_straight_lines_is_that_of_the_plane() -> None:
    lines = lines_on_square((-0.5, 0.0, 0.5, 0.0), (0.0, 0.4, 0.5, 0.4))
    height = lines.points[0, 2]
    points = np.array([[0.1, 0.1, height], [0.2, 0.35, height], [0.9, 0.3, height], [-0.8, 0.4, height]])
    distance, curve = nearest_curves(lines, points, np.repeat(UP, 4, axis=0))
    np.testing.assert_allclose(distance, [0.1, 0.05, np.hypot(0.4, 0.1), 0.5], atol=1e-9)
    assert curve.tolist() == [0, 1, 1, 0]


def test_a_curve_on_the_other_side_counts_only_if_there_is_no_other() -> None:
    line = lines_on_square((-0.5, 0.0, 0.5, 0.0))
    point = line.points[:1] + [0.0, 0.1, 0.0]
    assert nearest_curves(line, point, UP)[0] == nearest_curves(line, point, -UP)[0]
