"""Figures have a role, a role has a layer, and a figure that is moved keeps all but its place."""

import numpy as np

from geoweave.fabrication.strip_figures import LAYERS, ROLES, Figure


def test_every_role_lies_on_a_layer_and_every_layer_is_used() -> None:
    assert set(ROLES.values()) == set(LAYERS)


def test_a_figure_is_moved_as_a_whole() -> None:
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    figure = Figure("solid", (square, 2 * square), True, 1, "A1", 3, 0.2)
    moved = figure.moved(5.0, -2.0)
    for before, after in zip(figure.paths, moved.paths, strict=True):
        np.testing.assert_array_equal(after - before, np.tile([5.0, -2.0], (4, 1)))
    assert moved._replace(paths=figure.paths) == figure
