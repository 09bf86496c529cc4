"""Figures of plates: arrows point where they should, colours stand where they belong, nothing is cut off."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from pictures import along, near

from geoweave import viz
from geoweave.curves.tracing import streamlines
from geoweave.errors import RenderError
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh
from geoweave.viz import style


@cache
def square() -> TriMesh:
    return shapes.square(faces=200)


@pytest.mark.parametrize("direction", [(1, 0), (-1, 0), (0, 1), (0, -1)])
def test_an_arrow_points_where_its_vector_points(direction) -> None:
    vector = np.array([[*direction, 0.0]])
    arrows = viz.Arrows(np.zeros((1, 3)), vector, "#0000ff", 0.1)
    pixels = viz.plates([viz.Plate(square(), arrows=[arrows])], width=400).pixels
    down, right = np.nonzero(near(pixels, "#0000ff"))
    middle = 0.5 * np.array(pixels.shape[:2])
    offset = np.array([right.mean() - middle[1], middle[0] - down.mean()]) / pixels.shape[1]
    # The head is heavier than the shaft: its centre lies beyond half of the way, a fifth of the width.
    assert offset @ direction > 0.15
    assert abs(offset @ np.array([-direction[1], direction[0]])) < 0.03


def test_values_stand_where_their_faces_are() -> None:
    scale = viz.Scale(style.diverging(), -1.0, 1.0, "x")
    plate = viz.Plate(square(), values=np.sign(square().barycenters[:, 0]), scale=scale)
    pixels = viz.plates([plate], width=600).pixels.astype(int)
    warm = pixels[..., 0] - pixels[..., 2]
    # The colour bar takes less than a tenth at the right, the border less than that at the left.
    assert warm[250:350, 100:200].max() < 0
    assert warm[250:350, 350:450].min() > 0


def test_nothing_is_cut_off() -> None:
    """A white frame stays, also where arrows stick out of the mesh."""
    out = viz.Arrows(np.array([[0.9, 0.9, 0.0]]), np.array([[0.8, 0.5, 0.0]]), "#ff0000", 0.05)
    for view in (viz.FROM_ABOVE, viz.View(azimuth=30, elevation=40)):
        plate = viz.Plate(square(), arrows=[out], edges=True, view=view)
        pixels = viz.plates([plate, viz.Plate(square())], width=600).pixels
        assert near(pixels, "#ff0000").any()
        frame = np.concatenate(
            [pixels[:4].reshape(-1, 3), pixels[-4:].reshape(-1, 3), pixels[:, :4].reshape(-1, 3)]
        )
        assert (frame == 255).all()


def test_what_looks_away_is_left_out() -> None:
    ball = shapes.sphere(faces=500)
    side = viz.View(azimuth=0, elevation=0)
    # The eye is on the x axis: hidden curves would cover as much as seen ones.
    curves = streamlines(along(ball, [0, 0, 1.0]), share=0.1)
    lines = viz.Lines(curves, "#00ff00", 2.0)
    seen = viz.plates([viz.Plate(ball, lines=[lines], view=side)], width=500).pixels
    assert near(seen, "#00ff00").any()
    with pytest.raises(RenderError, match="looks away"):
        viz.plates([viz.Plate(shapes.disk(faces=50), view=viz.View(elevation=-90))])


def test_a_curved_mesh_is_shaded_and_a_flat_one_is_not() -> None:
    for mesh, varied in ((square(), False), (shapes.sphere(faces=500), True)):
        pixels = viz.plates([viz.Plate(mesh)], width=400).pixels
        drawn = pixels[(pixels < 250).any(axis=2)]
        assert (np.ptp(drawn[:, 0].astype(int)) > 20) == varied


def test_words_are_written_below() -> None:
    plain = viz.plates([viz.Plate(square())], width=600).pixels
    arrows = viz.face_arrows(along(square(), [1.0, 0, 0]), label="field", colour="#aa00aa")
    worded = viz.plates([viz.Plate(square(), "title", "subtitle", arrows=[arrows])], width=600).pixels
    below = worded[len(plain) - 20 :]
    assert len(worded) > len(plain)
    assert near(below, style.INK, 80).any()
    assert near(below, "#aa00aa", 80).any()


def test_notes_and_dots_are_drawn() -> None:
    note = viz.Note((0.0, 0.5, 0.0), "here", "#0000ff", size=30)
    plate = viz.Plate(square(), notes=[note], dots=np.array([[0.5, -0.5, 0.0]]), dot_colour="#ff0000")
    pixels = viz.plates([plate], width=600).pixels
    half = len(pixels) // 2
    assert near(pixels[:half], "#0000ff").any()
    assert not near(pixels[half:], "#0000ff").any()
    assert near(pixels[half:, 300:], "#ff0000").any()


def test_the_same_arguments_give_the_same_bytes() -> None:
    def draw():
        arrows = viz.face_arrows(along(square(), [1.0, 0.5, 0]))
        return viz.plates([viz.Plate(square(), edges=True, arrows=[arrows])], width=500).png()

    assert draw() == draw()


def test_rows_that_cannot_be_drawn_are_refused() -> None:
    scales = [viz.heat_scale(np.ones(3), name) for name in "ab"]
    values = np.ones(square().n_faces)
    with pytest.raises(RenderError, match="at least one"):
        viz.plates([])
    with pytest.raises(RenderError, match="one scale"):
        viz.plates([viz.Plate(square(), values=values, scale=scale) for scale in scales])
