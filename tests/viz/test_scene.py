"""Scenes: something is drawn, nothing is cut off, up is up."""

from __future__ import annotations

import numpy as np
import pytest
from pictures import ball, blank_frame, circles, lightness, meridians, near

from geoweave import viz
from geoweave.curves.curves import geodesic_curvature
from geoweave.errors import RenderError
from geoweave.surface.mesh import TriMesh
from geoweave.viz import style


@pytest.mark.parametrize("elevation", [-40.0, 10.0, 80.0])
@pytest.mark.parametrize("stretch", [(1, 1, 1), (4, 1, 1), (1, 1, 4)])
def test_a_scene_fills_the_picture_and_is_not_cut_off(elevation, stretch) -> None:
    scene = viz.Scene(viz.View(azimuth=25, elevation=elevation))
    scene.add_surface(TriMesh(ball().vertices * stretch + [7.0, -3.0, 2.0], ball().faces))
    pixels = scene.draw(160)
    assert blank_frame(pixels, 1)
    drawn = (pixels < 250).any(axis=2)
    rows, columns = np.flatnonzero(drawn.any(axis=1)), np.flatnonzero(drawn.any(axis=0))
    # a margin of 3 % of the longer side, and nothing more, is left on every side
    most = 0.04 * max(drawn.shape) + 2
    assert rows[0] < most
    assert len(drawn) - 1 - rows[-1] < most
    assert columns[0] < most
    assert drawn.shape[1] - 1 - columns[-1] < most
    light = lightness(pixels)[drawn]
    assert np.median(light) > 110  # an off-white surface, most of it in the light
    assert np.ptp(light) > 40  # and yet shaded


def test_a_surface_of_any_size_looks_the_same() -> None:
    pictures = []
    for scale in (1e-6, 1.0, 1e6):
        scene = viz.Scene()
        scene.add_surface(TriMesh(ball().vertices * scale, ball().faces))
        pictures.append(scene.draw(80).astype(int))
    assert np.abs(pictures[0] - pictures[1]).mean() < 1.0
    assert np.abs(pictures[2] - pictures[1]).mean() < 1.0


def test_up_is_up() -> None:
    for up, sign in (("z", 1), ("-z", -1), ("y", 1), ("x", 1)):
        axis = "xyz".index(up[-1])
        values = sign * ball().barycenters[:, axis]
        scene = viz.Scene(viz.View(azimuth=40, elevation=0, up=up))
        scene.add_surface(ball(), values=values)
        pixels = scene.draw(100).astype(int)
        warm = pixels[..., 0] - pixels[..., 2]
        assert warm[15:35, 40:60].mean() > 30  # the positive, red end
        assert warm[-35:-15, 40:60].mean() < -10  # the negative, blue end


def test_occlusion_darkens_a_groove() -> None:
    rings = np.stack([np.linspace(-1, 1, 161)] * 40, axis=1)
    angle = np.linspace(0, 2 * np.pi, 41)[:-1]
    radius = 1 - 0.75 * np.exp(-((rings / 0.12) ** 2))
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), rings], axis=2).reshape(-1, 3)
    a = (np.arange(160)[:, None] * 40 + np.arange(40)).ravel()
    b = (np.arange(160)[:, None] * 40 + (np.arange(40) + 1) % 40).ravel()
    faces = np.concatenate([np.stack([a, b, b + 40], 1), np.stack([a, b + 40, a + 40], 1)])
    scene = viz.Scene(viz.View(azimuth=0, elevation=0))
    scene.add_surface(TriMesh(points, faces))
    light = lightness(scene.draw(200))
    column = light[:, light.shape[1] // 2]
    assert column[95:105].min() < 0.75 * np.median(column[30:70])


def test_curved_lines_are_warm_and_straight_lines_are_dark() -> None:
    amber, slate = style.sequential()(1.0)[:3], style.sequential()(0.0)[:3]

    def shares(curves):
        scene = viz.Scene(viz.View(elevation=30))
        scene.add_surface(ball())
        scene.add_curves(curves, 0.015, values=np.abs(geodesic_curvature(curves)), limits=(0.0, 1.0))
        pixels = scene.draw(300)
        return near(pixels, amber, 45).mean(), near(pixels, slate, 45).mean()

    circle, meridian = shares(circles()), shares(meridians())
    assert circle[0] > 5 * meridian[0]
    assert meridian[1] > 2 * circle[1]


def test_an_empty_scene_is_refused() -> None:
    with pytest.raises(RenderError, match="holds no surface"):
        viz.Scene().draw(50)
    with pytest.raises(RenderError, match="holds no surface"):
        viz.Scene().add_dots(np.zeros((1, 3)), 0.1, ["#000000"])
