"""Shaded surfaces: colours are those of the scale, curves and legend are drawn, bad panels are refused."""

import numpy as np
import pytest

from geoweave import viz
from geoweave.comparisons.integration_methods import geodesic_from, integrated
from geoweave.curves.tracing import streamlines
from geoweave.errors import RenderError
from geoweave.fields.face_field import FaceField
from geoweave.models import shapes
from geoweave.viz import style

BALL = shapes.sphere(faces=1280)
SCALE = viz.deviation_scale(30.0)


def near(pixels: np.ndarray, colour: str, reach: float = 60.0) -> np.ndarray:
    wanted = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)])
    return np.linalg.norm(pixels.astype(float) - wanted, axis=-1) < reach


@pytest.mark.parametrize("smooth", [True, False])
def test_aligned_is_dark_and_deviating_is_light(smooth: bool) -> None:
    values = np.where(BALL.barycenters[:, 2] > 0, 30.0, 0.0)
    scene = viz.Shaded(BALL, values, smooth, view=viz.View(azimuth=20, elevation=0)).scene(SCALE)
    pixels = scene.draw(120).astype(float).mean(axis=2)
    upper, lower = pixels[20:50, 40:80], pixels[-50:-20, 40:80]
    assert upper.mean() > 190
    assert lower.mean() < 70


def test_faces_without_a_value_are_plain() -> None:
    values = np.where(BALL.barycenters[:, 2] > 0, np.nan, 0.0)
    scene = viz.Shaded(BALL, values, view=viz.View(azimuth=20, elevation=0)).scene(SCALE)
    pixels = scene.draw(120)
    assert near(pixels[20:50, 40:80].reshape(-1, 3).mean(axis=0)[None], style.SURFACE).all()


def test_curves_legend_and_bar_are_drawn() -> None:
    circles = FaceField.from_ambient(BALL, np.cross([0.0, 0, 1], BALL.barycenters))
    lines = streamlines(circles, separation=0.2)
    family = viz.Family(lines, style.LEVEL_LINES, "level sets", 0.012)
    panel = viz.Shaded(BALL, np.zeros(BALL.n_faces), title="ball", subtitle="0 degrees", families=[family])
    picture = viz.shaded_gallery([panel, panel, panel], SCALE, columns=2, width=700)
    pixels = picture.pixels
    assert near(pixels, style.LEVEL_LINES).sum() > 500
    # The legend stands at the bottom right, below the models.
    assert near(pixels[-110:, 430:], style.LEVEL_LINES).sum() > 20
    # The bar runs from the first colour of the scale to the last.
    foot = pixels[-110:-30, :420].reshape(-1, 3)
    for end in (0.02, 0.98):
        colour = 255 * np.array(SCALE.colormap(end)[:3])
        assert (np.abs(foot - colour).max(axis=1) < 12).any()
    assert "ball" in picture.alt


def test_panel_of_a_method_shows_its_deviation_and_its_level_sets() -> None:
    field = geodesic_from(BALL, "smoothest")
    result = integrated(field, "mixed-integer", 15.0)
    panel = viz.deviation_panel(result, streamlines(field, separation=0.3), viz.View())
    assert panel.values is not None
    np.testing.assert_array_equal(np.isfinite(panel.values), result.part.kept)
    assert [family.curves.mesh is BALL for family in panel.families] == [True, True]
    assert f"{result.alignment.mean:.1f}° off" in panel.subtitle


def test_a_gallery_has_no_empty_panel_and_no_wrong_shape() -> None:
    with pytest.raises(RenderError, match="at least one panel"):
        viz.shaded_gallery([], SCALE)
    with pytest.raises(RenderError, match=r"values of faces need shape \(1280,\), not \(3,\)"):
        viz.Shaded(BALL, np.zeros(3))
    with pytest.raises(RenderError, match="no view is kept for 'nowhere'"):
        viz.Shaded(BALL, view="nowhere")
