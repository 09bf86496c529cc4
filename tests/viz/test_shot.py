"""A rendering of actors: what is framed, and how shade falls."""

from __future__ import annotations

import numpy as np
import pyvista as pv

from geoweave.viz.shot import Actor, Camera, shot

CAMERA = Camera(np.eye(3), np.zeros(3), 10.0, 2.0)


def test_a_ball_of_radius_one_fills_half_of_a_picture_four_high() -> None:
    ball = Actor(pv.Sphere(radius=1.0), {"color": "red"})
    drawn = (shot([ball], CAMERA, 4.0, (80, 80)) != 255).any(axis=2)
    assert abs(drawn.any(axis=1).sum() - 40) <= 2
    assert abs(drawn.any(axis=0).sum() - 40) <= 2


def test_what_is_for_pages_and_for_shade_is_not_told_to_the_renderer() -> None:
    look = {"color": "red"}
    plain = shot([Actor(pv.Sphere(), look)], CAMERA, 4.0, (40, 40))
    more = shot([Actor(pv.Sphere(), look | {"occludes": True}, pv.Cube(), 1.0)], CAMERA, 4.0, (40, 40))
    np.testing.assert_array_equal(plain, more)


def test_shade_falls_where_another_body_is_near() -> None:
    white = {"color": "white", "ambient": 0.98, "diffuse": 0.02}
    floor = Actor(pv.Plane(direction=(0, 0, 1), i_size=4.0, j_size=4.0), white)
    ball = Actor(pv.Sphere(radius=0.5, center=(0.0, 0.0, 0.4)), white)
    lit = shot([floor, ball], CAMERA, 6.0, (80, 80), occlusion=0.5).astype(int)
    # The ball's edge stands 11 pixels from the middle.
    assert lit[40, 53].mean() < lit[40, 75].mean() - 3
