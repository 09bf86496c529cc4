"""Galleries of streamlines: colours mean what they should, nothing is cut off, bytes repeat."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import pytest
from pictures import ball, blank_frame, circles, lightness, meridians, near, north

from geoweave import viz
from geoweave.errors import RenderError
from geoweave.fields.face_field import FaceField, signed_curl
from geoweave.viz import style
from geoweave.viz.streamline_panels import panel_scene


def test_singularities_are_dots_of_their_sign() -> None:
    def red_and_blue(indices):
        scene = panel_scene(viz.Panel("one", mesh=ball(), indices=indices, view=viz.View(elevation=70)))
        pixels = scene.draw(300)
        return near(pixels, style.SOURCE, 60).sum(), near(pixels, style.SADDLE, 60).sum()

    assert red_and_blue(0 * north()) == (0, 0)
    plus, minus = red_and_blue(north()), red_and_blue(-north())
    assert plus[0] > 5
    assert plus[1] == 0
    assert minus[0] == 0
    assert minus[1] > 5


def test_seams_are_blue_bars() -> None:
    def blue(seams):
        scene = panel_scene(viz.Panel("one", mesh=ball(), seams=seams, view="sphere"))
        return near(scene.draw(300), style.BLUE, 40).sum()

    assert blue(np.arange(0)) == 0
    assert blue(np.arange(ball().n_edges)) > blue(np.arange(ball().n_edges // 2)) > 20


def test_a_gallery_keeps_a_margin_and_one_scale() -> None:
    panels = [
        viz.Panel("Circles", circles(), "1,280 faces"),
        viz.Panel("Meridians", meridians(), "1,280 faces"),
    ]
    picture = viz.streamline_gallery(panels, width=800)
    assert blank_frame(picture.pixels, 6)
    # both halves hold a model, and below there are words
    drawn = lightness(picture.pixels) < 245
    assert drawn[20:300, :400].mean() > 0.3
    assert drawn[20:300, 400:].mean() > 0.3
    assert picture.alt == "Streamlines on Circles, Meridians"
    high = viz.curvature_scale(panels).high
    assert viz.curvature_scale(panels[:1]).high >= high > viz.curvature_scale(panels[1:]).high


def test_curl_on_the_surface_gets_a_bar_of_its_own() -> None:
    field = FaceField.from_ambient(ball(), np.cross([0.0, 0.0, 1.0], ball().barycenters)).normalized()
    panel = viz.Panel("Curl", meridians(), face_values=signed_curl(field), view="sphere")
    scale = viz.curl_scale([panel])
    assert scale.low == -scale.high
    picture = viz.streamline_gallery([panel], width=900)
    pixels = picture.pixels
    bar = np.flatnonzero(near(pixels[:, 450:], style.diverging()(0.02)[:3], 25).any(axis=1))
    assert bar.size > 0
    assert bar.max() > len(pixels) - 130


def test_pictures_repeat_to_the_byte_and_ignore_the_users_settings() -> None:
    def draw() -> bytes:
        panels = [viz.Panel("Circles", circles(), indices=north(), view="sphere")]
        return viz.streamline_gallery(panels, width=500).png()

    once = draw()
    with mpl.rc_context({"font.size": 30, "axes.facecolor": "black", "savefig.dpi": 30}):
        assert draw() == once
        assert mpl.rcParams["font.size"] == 30


def test_what_cannot_be_drawn_is_refused() -> None:
    with pytest.raises(RenderError, match="at least one panel"):
        viz.streamline_gallery([])
    with pytest.raises(RenderError, match="no panel has curves"):
        viz.curvature_scale([viz.Panel("Bare", mesh=ball())])
    with pytest.raises(RenderError, match="no view is kept for 'nessie'"):
        viz.streamline_gallery([viz.Panel("Nessie", circles(), view="nessie")])
    with pytest.raises(RenderError, match="neither curves nor a mesh"):
        _ = viz.Panel("Empty").surface
