"""The surface under ribbons: one looks at its other side only where it is open."""

from __future__ import annotations

import numpy as np

from geoweave import viz
from geoweave.models import shapes
from geoweave.viz import style
from geoweave.viz.ground import add_ground

DEPTH = 0.02


def test_an_open_surface_gets_a_far_side_that_lies_deeper() -> None:
    cone, ball = shapes.cone(faces=400), shapes.sphere(faces=320)
    for mesh, sides in ((cone, 2), (ball, 1)):
        scene = viz.Scene()
        add_ground(scene, mesh, DEPTH)
        assert len(scene.actors()) == sides
    scene = viz.Scene()
    add_ground(scene, cone, DEPTH)
    near, far = (actor.data.points for actor in scene.actors())
    away = [np.linalg.norm(each - scene.placed(cone.vertices), axis=1).max() for each in (near, far)]
    assert away[1] > 2 * away[0]


def test_what_sticks_out_of_the_far_side_is_hidden() -> None:
    # bars a little deeper than the near side: who looks under the cone does not see them
    tube = shapes.cone(faces=800)
    below = viz.View(azimuth=0.0, elevation=-80.0)
    middle = tube.barycenters - 1.5 * DEPTH * tube.face_normals
    bars = np.stack([middle, middle + 0.01], axis=1)
    seen = []
    for lined in (False, True):
        scene = viz.Scene(below)
        if lined:
            add_ground(scene, tube, DEPTH)
        else:
            scene.add_surface(tube)
        scene.add_segments(bars, 0.004, style.RED)
        red = scene.draw(160).astype(int)
        seen.append(int((red[..., 0] - red[..., 1] > 60).sum()))
    assert seen[0] > 50
    assert seen[1] < 0.1 * seen[0]
