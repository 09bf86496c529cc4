"""Ribbons as solids: as wide as asked, closed surfaces, above where they pass over."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from geoweave import viz
from geoweave.errors import RenderError
from geoweave.models import catalogue, shapes
from geoweave.surface.mesh import TriMesh
from geoweave.viz import style, weaves
from geoweave.viz.weaves import facing
from geoweave.weave.design import Weave, weave_pattern


@cache
def pattern() -> Weave:
    return weave_pattern(shapes.torus(faces=2500), scale=0.6)


def test_a_picture_has_all_three_hues() -> None:
    picture = viz.weave_gallery(
        [viz.Woven(pattern(), "Torus", "three families", viz.View(elevation=40), dots=True)], width=700
    )
    pixels = picture.pixels.reshape(-1, 3).astype(float)
    colourful = pixels[np.ptp(pixels, axis=1) > 60]
    assert len(colourful) > 0.1 * len(pixels)
    with pytest.raises(RenderError, match="at least one"):
        viz.weave_gallery([])


def test_places_are_marked_in_white_with_a_dark_rim() -> None:
    weave = pattern()
    plain, marked = (
        viz.weave_gallery([viz.Woven(weave, view=viz.View(elevation=40), marked=places)], width=500)
        for places in (None, weave.mesh.vertices[::20])
    )
    changed = (plain.pixels != marked.pixels).any(axis=2)
    assert 0.002 < changed.mean() < 0.2
    seen = marked.pixels[changed].astype(int)
    assert (seen.min(axis=1) > 215).mean() > 0.05
    assert (seen.max(axis=1) < 90).mean() > 0.05


def test_only_bright_ribbons_have_a_colour() -> None:
    weave = pattern()
    looks = (None, np.arange(2), np.zeros(0, dtype=np.int64))
    shares = []
    for bright in looks:
        picture = viz.weave_gallery([viz.Woven(weave, view=viz.View(elevation=40), bright=bright)], width=400)
        shares.append((np.ptp(picture.pixels.astype(int), axis=2) > 60).mean())
    assert shares[0] > 3 * shares[1] > 0
    assert shares[2] < 0.001


def test_a_close_up_is_in_front_and_away_from_what_would_spoil_it() -> None:
    ball = shapes.sphere(faces=1280)
    view = viz.View(azimuth=20.0, elevation=10.0)
    eye = view.axes[2]
    place = viz.clear_place(ball.vertices, -eye[None], ball, view)
    assert place @ eye > 0.99, "opposite to what is behind"
    ahead = viz.clear_place(ball.vertices, eye[None], ball, view)
    assert 0.74 < ahead @ eye < 0.85, "as far from it as still turns to the eye"
    behind = viz.clear_place(-eye[None], eye[None], ball, view)
    np.testing.assert_array_equal(behind, -eye)


def test_crossing_ribbons_differ_in_colour_where_that_can_be() -> None:
    # no branch point on the cylinder: families are colours, and each crosses only the others
    tube = weave_pattern(shapes.cylinder(faces=1000))
    assert not len(tube.branch_points)
    np.testing.assert_array_equal(weaves.colouring(tube), tube.families)
    # on the sphere families are permuted twelve times over, and a ribbon passes through several
    ball = weave_pattern(shapes.sphere(faces=1280), scale=0.8)
    pairs = ball.ribbons.crossings.curves
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    chosen = weaves.colouring(ball)
    clashes = [np.sum(each[pairs[:, 0]] == each[pairs[:, 1]]) for each in (ball.families, chosen)]
    assert clashes[1] < clashes[0]
    # no ribbon would have fewer crossings of its own colour in another one
    for ribbon in range(len(chosen)):
        met = np.concatenate([pairs[pairs[:, k] == ribbon, 1 - k] for k in range(2)])
        counts = np.bincount(chosen[met], minlength=3)
        assert counts[chosen[ribbon]] == counts.min()
    assert set(weaves.colouring(ball, 5)) == set(range(5))


def test_a_close_up_shows_what_it_is_asked_to() -> None:
    weave = pattern()
    view = viz.View(elevation=40)
    nearest = weave.mesh.vertices[np.argmax(weave.mesh.vertices @ view.axes[2])]
    scene = viz.Woven(weave, view=view, focus=(nearest, 0.15)).scene()
    assert scene.aspect == 1.0
    whole = viz.Woven(weave, view=view).scene().draw(300)
    near = scene.draw(300)
    assert near.shape == (300, 300, 3)
    # the ground is seen round the whole torus, hardly in the close-up
    assert (near == 255).all(axis=2).mean() < 0.5 * (whole == 255).all(axis=2).mean()


def test_a_surface_turned_inside_out_lies_behind_its_ribbons() -> None:
    sphere, saddle = shapes.sphere(320), shapes.saddle(faces=400)
    assert facing(sphere) == 1
    assert facing(TriMesh(sphere.vertices, sphere.faces[:, ::-1])) == -1
    assert facing(saddle) == facing(TriMesh(saddle.vertices, saddle.faces[:, ::-1])) == 1  # it has no inside
    assert facing(catalogue.load("schwarz-p")) == -1


def test_ribbons_have_edges_that_show_where_two_of_one_colour_cross() -> None:
    weave = pattern()
    alike = np.zeros(len(weave.ribbons), dtype=np.int64)
    scene = viz.weave_scene(weave, viz.View(elevation=40), alike)
    pixels = scene.draw(500)
    dark = np.array(to_rgb(style.darker(style.FAMILIES[0]))) * 255
    near = np.abs(pixels.astype(float) - dark).max(axis=-1) < 25
    assert near.mean() > 0.005
