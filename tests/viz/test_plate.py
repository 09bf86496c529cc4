"""Plates: the arrows point where the field points, colours stand where they belong, nothing is cut off."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import ImageColor

from geoweave import viz
from geoweave.curves.tracing import streamlines
from geoweave.errors import RenderError
from geoweave.fields.face_field import FaceField, random_field
from geoweave.fields.operators import ClosedFields, as_complex
from geoweave.models import shapes
from geoweave.viz import style


@pytest.fixture(scope="module")
def square():
    return shapes.square(faces=200)


def constant(mesh, vector):
    return FaceField.from_ambient(mesh, np.tile(np.asarray(vector, dtype=float), (mesh.n_faces, 1)))


def near(pixels, colour, reach=40.0):
    return np.linalg.norm(pixels.astype(float) - np.array(ImageColor.getrgb(colour)), axis=-1) < reach


def test_arrows_of_a_field_are_centred_and_as_long_as_asked(square):
    field = constant(square, [0.0, 1.0, 0.0])
    arrows = viz.face_arrows(field, length=0.05)
    np.testing.assert_allclose(arrows.vectors, np.tile([0, 0.05, 0], (square.n_faces, 1)), atol=1e-15)
    np.testing.assert_allclose(arrows.points + 0.5 * arrows.vectors, square.barycenters, atol=1e-15)


def test_scattered_faces_are_apart_and_everywhere():
    disk = shapes.disk(faces=4000)
    points = disk.barycenters[viz.scattered(disk, 0.2)]
    gaps = np.linalg.norm(points[:, None] - points, axis=2) + np.eye(len(points))
    assert gaps.min() > 0.05
    # 79 squares of that side have the area of the disk; some at its rim have no face near their middle
    assert 60 < len(points) < 90


def test_arrows_of_a_second_field_start_at_the_tips_of_the_first(square):
    first, second = constant(square, [1.0, 0, 0]), constant(square, [0, 0.5, 0])
    some = np.arange(square.n_faces) % 3 == 0
    w = viz.face_arrows(first, length=0.1, faces=some)
    delta = viz.face_arrows(second, length=0.1, faces=some, start=first)
    assert len(w.points) == some.sum()
    np.testing.assert_allclose(delta.points, w.points + w.vectors, atol=1e-15)
    np.testing.assert_allclose(delta.vectors, 0.1 * second.ambient[some], atol=1e-15)


@pytest.mark.parametrize("direction", [(1, 0), (-1, 0), (0, 1), (0, -1)])
def test_an_arrow_points_where_its_vector_points(square, direction):
    vector = np.array([[*direction, 0.0]])
    arrows = viz.Arrows(np.zeros((1, 3)), vector, "#0000ff", 0.1)
    pixels = viz.plates([viz.Plate(square, arrows=[arrows])], width=400).pixels
    down, right = np.nonzero(near(pixels, "#0000ff"))
    middle = 0.5 * np.array(pixels.shape[:2])
    offset = np.array([right.mean() - middle[1], middle[0] - down.mean()]) / pixels.shape[1]
    # The head is heavier than the shaft: its centre lies beyond half of the way, a fifth of the width.
    assert offset @ direction > 0.15
    assert abs(offset @ np.array([-direction[1], direction[0]])) < 0.03


def test_values_stand_where_their_faces_are(square):
    scale = viz.Scale(style.diverging(), -1.0, 1.0, "x")
    plate = viz.Plate(square, values=np.sign(square.barycenters[:, 0]), scale=scale)
    pixels = viz.plates([plate], width=600).pixels.astype(int)
    warm = pixels[..., 0] - pixels[..., 2]
    # The colour bar takes less than a tenth at the right, the border less than that at the left.
    assert warm[250:350, 100:200].max() < 0
    assert warm[250:350, 350:450].min() > 0


def test_nothing_is_cut_off(square):
    """A white frame stays, also where arrows stick out of the mesh."""
    out = viz.Arrows(np.array([[0.9, 0.9, 0.0]]), np.array([[0.8, 0.5, 0.0]]), "#ff0000", 0.05)
    for view in (viz.FROM_ABOVE, viz.View(azimuth=30, elevation=40)):
        plate = viz.Plate(square, arrows=[out], edges=True, view=view)
        pixels = viz.plates([plate, viz.Plate(square)], width=600).pixels
        assert near(pixels, "#ff0000").any()
        frame = np.concatenate(
            [pixels[:4].reshape(-1, 3), pixels[-4:].reshape(-1, 3), pixels[:, :4].reshape(-1, 3)]
        )
        assert (frame == 255).all()


def test_what_looks_away_is_left_out():
    ball = shapes.sphere(faces=500)
    side = viz.View(azimuth=0, elevation=0)
    # The eye is on the x axis: hidden curves would cover as much as seen ones.
    curves = streamlines(constant(ball, [0, 0, 1.0]), share=0.1)
    lines = viz.Lines(curves, "#00ff00", 2.0)
    seen = viz.plates([viz.Plate(ball, lines=[lines], view=side)], width=500).pixels
    assert near(seen, "#00ff00").any()
    with pytest.raises(RenderError, match="looks away"):
        viz.plates([viz.Plate(shapes.disk(faces=50), view=viz.View(elevation=-90))])


def test_a_curved_mesh_is_shaded_and_a_flat_one_is_not(square):
    for mesh, varied in ((square, False), (shapes.sphere(faces=500), True)):
        pixels = viz.plates([viz.Plate(mesh)], width=400).pixels
        drawn = pixels[(pixels < 250).any(axis=2)]
        assert (np.ptp(drawn[:, 0].astype(int)) > 20) == varied


def test_words_are_written_below(square):
    plain = viz.plates([viz.Plate(square)], width=600).pixels
    arrows = viz.face_arrows(constant(square, [1.0, 0, 0]), label="field", colour="#aa00aa")
    worded = viz.plates([viz.Plate(square, "title", "subtitle", arrows=[arrows])], width=600).pixels
    below = worded[len(plain) - 20 :]
    assert len(worded) > len(plain)
    assert near(below, style.INK, 80).any()
    assert near(below, "#aa00aa", 80).any()


def test_notes_and_dots_are_drawn(square):
    note = viz.Note((0.0, 0.5, 0.0), "here", "#0000ff", size=30)
    plate = viz.Plate(square, notes=[note], dots=np.array([[0.5, -0.5, 0.0]]), dot_colour="#ff0000")
    pixels = viz.plates([plate], width=600).pixels
    half = len(pixels) // 2
    assert near(pixels[:half], "#0000ff").any()
    assert not near(pixels[half:], "#0000ff").any()
    assert near(pixels[half:, 300:], "#ff0000").any()


def test_a_mark_is_centred():
    arrow = viz.mark([0.5, 0, 0], [0, 0.2, 0], "#ff0000")
    np.testing.assert_allclose(arrow.points + 0.5 * arrow.vectors, [[0.5, 0, 0]])


def test_projections_are_equally_long_where_the_curl_vanishes():
    ball = shapes.sphere(faces=500)
    fields = ClosedFields(ball)
    rng = np.random.default_rng(0)
    closed = FaceField(ball, as_complex(fields.basis @ rng.normal(size=fields.basis.shape[1])))
    vertex = int(ball.faces[0, 0])
    for field, equal in ((closed, True), (random_field(ball, 0), False)):
        plate = viz.projections(field, vertex)
        vectors, left, right = plate.arrows
        assert len(vectors.points) == (ball.faces == vertex).sum()
        assert len(left.points) == len(right.points) == len(vectors.points)
        assert (np.abs(left.vectors - right.vectors).max() < 1e-12) == equal
        # Each lies on its own side of the edge, and dashes lead from tail and tip square to the edge.
        tail_foot = plate.lines[0].what[: len(left.points)]
        drop = tail_foot[:, 1] - tail_foot[:, 0]
        assert np.abs(np.einsum("ex,ex->e", drop, left.vectors)).max() < 1e-12
        side = np.einsum("ex,ex->e", left.points - tail_foot[:, 1], drop)
        assert (side < 0).all()
        viz.plates([plate], width=300)


def test_the_same_arguments_give_the_same_bytes(square):
    def draw():
        arrows = viz.face_arrows(constant(square, [1.0, 0.5, 0]))
        return viz.plates([viz.Plate(square, edges=True, arrows=[arrows])], width=500).png()

    assert draw() == draw()


def test_nonsense_is_refused(square):
    scales = [viz.heat_scale(np.ones(3), name) for name in "ab"]
    values = np.ones(square.n_faces)
    with pytest.raises(RenderError, match="at least one"):
        viz.plates([])
    with pytest.raises(RenderError, match="go together"):
        viz.Plate(square, values=values)
    with pytest.raises(RenderError, match="values of faces"):
        viz.Plate(square, values=values[1:], scale=scales[0])
    with pytest.raises(RenderError, match="one scale"):
        viz.plates([viz.Plate(square, values=values, scale=scale) for scale in scales])
    with pytest.raises(RenderError, match="one shape"):
        viz.Arrows(np.zeros((2, 3)), np.zeros((3, 3)))
