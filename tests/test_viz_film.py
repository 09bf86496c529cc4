"""Films: frames of one size and palette, there and back, as an animated PNG."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from geoweave import shapes, viz
from geoweave.errors import RenderError


def scene(stretch: float) -> viz.Scene:
    mesh = shapes.sphere(320)
    found = viz.Scene()
    found.add_surface(mesh)
    found.add_dots(stretch * np.eye(3), 0.1, ["#b8402f"] * 3)
    return found


def test_a_film_goes_there_and_back() -> None:
    film = viz.Film([scene(1 + 0.1 * k) for k in range(3)], "dots that move", height=90)
    data = film.apng()
    image = Image.open(io.BytesIO(data))
    assert image.n_frames == 4
    assert image.height == 90
    shown = []
    for k in range(4):
        image.seek(k)
        shown.append(np.array(image.convert("RGB")))
        assert image.info["duration"] == (film.rest if k in (0, 2) else film.step)
        assert (shown[k][0, 0] == 255).all(), "the ground is white"
    assert (shown[0] != shown[1]).any()
    np.testing.assert_array_equal(shown[1], shown[3])
    assert film.apng() == data
    assert set(film._repr_mimebundle_()) == {"image/png", "text/plain"}


def test_one_frame_is_no_film() -> None:
    with pytest.raises(RenderError, match="two frames or more"):
        viz.Film([scene(1.0)], "still").apng()
