"""Films: frames of one size and palette as an animated PNG."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from geoweave import viz
from geoweave.errors import RenderError
from geoweave.models import shapes
from geoweave.rods.weave_at_rest import relaxed_weave
from geoweave.weave.design import weave_pattern


def scene(stretch: float) -> viz.Scene:
    mesh = shapes.sphere(320)
    found = viz.Scene()
    found.add_surface(mesh)
    found.add_dots(stretch * np.eye(3), 0.1, ["#b8402f"] * 3)
    return found


def test_a_film_shows_its_frames_in_turn() -> None:
    film = viz.Film([scene(1 + 0.1 * k) for k in range(3)], "dots that move", height=90)
    data = film.apng()
    image = Image.open(io.BytesIO(data))
    assert image.n_frames == 3
    assert image.height == 90
    shown = []
    for k in range(3):
        image.seek(k)
        shown.append(np.array(image.convert("RGB")))
        assert image.info["duration"] == (film.rest if k in (0, 2) else film.step)
        assert (shown[k][0, 0] == 255).all(), "the ground is white"
    assert (shown[0] != shown[1]).any()
    assert (shown[1] != shown[2]).any()
    assert film.apng() == data
    assert set(film._repr_mimebundle_()) == {"image/png", "text/plain"}


def test_one_frame_is_no_film() -> None:
    with pytest.raises(RenderError, match="two frames or more"):
        viz.Film([scene(1.0)], "still").apng()


def test_relaxing_draws_its_states_further_apart() -> None:
    designed = relaxed_weave(weave_pattern(shapes.cone(faces=1000), ribbons=9), rounds=1).designed
    moved = replace(designed, points=designed.points + [0, 0, 0.05])
    steps = []
    for times in (1.0, 3.0):
        film = viz.relaxing([designed, moved], shapes.cone(faces=1000), "cone", frames=4, times=times)
        first, last = (np.concatenate(scene._points[1:]).mean(axis=0) for scene in film.scenes)
        steps.append(last - first)
        assert len(film.scenes) == 2
        assert film.scenes[0].focus == film.scenes[1].focus
    assert steps[0][2] > 0.04
    np.testing.assert_allclose(steps[1], 3 * steps[0], atol=1e-6)
    with pytest.raises(RenderError, match="two states or more"):
        viz.relaxing([designed], shapes.cone(faces=1000), "cone")
