"""Finished figures as PNG: colours are kept, the size is limited, nothing is said of the making."""

from __future__ import annotations

import io

import numpy as np
import pytest
from pictures import circles
from PIL import Image

from geoweave import viz
from geoweave.errors import RenderError


def test_a_png_keeps_its_colours_and_says_nothing_of_its_making() -> None:
    picture = viz.streamline_gallery([viz.Panel("Circles", circles())], width=600)
    encoded = picture.png()
    image = Image.open(io.BytesIO(encoded))
    assert image.size == picture.pixels.shape[1::-1]
    assert image.info.keys() <= {"transparency", "gamma"}
    decoded = np.asarray(image.convert("RGB")).astype(float)
    assert np.abs(decoded - picture.pixels).mean() < 2.5
    ground = (picture.pixels == 255).all(axis=2)
    assert (decoded[ground] == 255).all()
    smaller = Image.open(io.BytesIO(picture.png(300)))
    assert smaller.width == 300
    limit = len(encoded) // 2
    assert len(picture.png_within(limit)) <= limit
    with pytest.raises(RenderError, match="does not fit"):
        picture.png_within(100)


def test_a_notebook_shows_a_small_png() -> None:
    picture = viz.streamline_gallery([viz.Panel("Circles", circles())], width=1400, alt="circles on a ball")
    bundle = picture._repr_mimebundle_()
    assert len(bundle["image/png"]) <= 300_000
    assert Image.open(io.BytesIO(bundle["image/png"])).width <= 1100
    assert bundle["text/plain"] == "Picture('circles on a ball')"
