"""Finished figures as PNG: colours are kept, the size is limited, nothing is said of the making."""

from __future__ import annotations

import io
import platform
import tempfile
from types import SimpleNamespace

import click
import IPython.display
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
    assert image.mode == "RGB"
    assert (np.asarray(image) == picture.pixels).all()
    held = Image.open(io.BytesIO(picture.png(palette=True)))
    assert held.mode == "P"
    decoded = np.asarray(held.convert("RGB")).astype(float)
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


def test_shown_outside_a_notebook_it_is_a_file_and_no_viewer_starts_without_a_screen(
    monkeypatch, tmp_path, capsys
) -> None:
    opened: list[str] = []
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(click, "launch", opened.append)
    monkeypatch.setattr(platform, "system", lambda: "Linux")
    shown = viz.drop_chart([viz.Drop("Cow", 20.0, 7.0)])
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    shown.show()
    (path,) = tmp_path.iterdir()
    assert path.read_bytes() == shown.png()
    assert capsys.readouterr().out == f"the picture is in {path}\n"
    assert not opened
    monkeypatch.setenv("DISPLAY", ":0")
    shown.show()
    assert len(opened) == 1
    assert opened[0] != str(path)


def test_shown_in_a_notebook_it_stands_below_the_cell(monkeypatch, tmp_path) -> None:
    displayed: list[object] = []
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(IPython, "get_ipython", lambda: SimpleNamespace(kernel=object()))
    monkeypatch.setattr(IPython.display, "display", displayed.append)
    shown = viz.drop_chart([viz.Drop("Cow", 20.0, 7.0)])
    shown.show()
    assert displayed == [shown]
    assert not list(tmp_path.iterdir())
