"""A weave in a cell: it can be turned where frames are allowed, and is a picture where they are not."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import browser, opened
from laidflat import cone
from PIL import Image

from geoweave.files import OutputError
from geoweave.rods import relaxed_weave
from geoweave.viz.turnable import Turnable, show

HOST = "<!DOCTYPE html><html><body style='margin:0;width:{}px'><div class='output'>{}</div></body></html>"


@cache
def turned() -> Turnable:
    return show(relaxed_weave(cone()), title='a "cone" & more')


@cache
def bundle() -> dict[str, Any]:
    return turned()._repr_mimebundle_()


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with browser() as running:
        yield running


def test_what_a_notebook_is_given() -> None:
    found = bundle()
    assert set(found) == {"text/html", "image/png", "text/plain"}
    image = np.asarray(Image.open(io.BytesIO(found["image/png"])).convert("RGB"))
    assert image.std() > 10
    assert len(found["image/png"]) <= 300_000
    assert found["text/plain"] == "Turnable('A weave of 10 ribbons at rest')"
    assert len(found["text/html"]) < 2_500_000
    assert "<script" not in re.sub(r'srcdoc="[^"]*"', "", found["text/html"])


def test_design_alone() -> None:
    assert show(cone()).rest is None
    assert '"says":"At rest"' not in show(cone()).page
    assert '"says":"At rest"' in turned().page


@pytest.mark.parametrize("width", [1000, 700])
def test_it_can_be_turned_in_a_cell(chromium: Any, tmp_path: Path, width: int) -> None:
    file = tmp_path / "cell.html"
    file.write_text(HOST.format(width, bundle()["text/html"]), encoding="utf-8")
    with opened(chromium, file) as it:
        (frame,) = it.page.frames[1:]
        for _ in range(200):
            if frame.evaluate("window.viewer !== undefined && viewer.still()"):
                break
            it.page.wait_for_timeout(50)
        assert frame.evaluate("document.title") == 'a "cone" & more: the weave'
        before = frame.evaluate("viewer.space.direction.toArray()")
        # The controls stand beside the weave, and both are within the cell.
        space, panel = (frame.locator(each).bounding_box() for each in ("#space", "#panel"))
        assert panel["x"] >= space["x"] + space["width"]
        assert panel["y"] + panel["height"] <= 560
        it.page.mouse.move(space["x"] + 150, space["y"] + 250)
        it.page.mouse.down()
        it.page.mouse.move(space["x"] + 260, space["y"] + 260, steps=3)
        it.page.mouse.up()
        assert frame.evaluate("viewer.space.direction.toArray()") != before
        assert it.errors == []
        assert {url.split(":")[0] for url in it.requests} <= {"file", "data", "about"}


def test_where_frames_are_taken_out_the_picture_is_seen(chromium: Any, tmp_path: Path) -> None:
    file = tmp_path / "cell.html"
    bare = re.sub(r"<iframe.*?</iframe>", "", bundle()["text/html"], flags=re.DOTALL)
    file.write_text(HOST.format(900, bare), encoding="utf-8")
    with opened(chromium, file) as it:
        assert it.page.get_attribute("img", "alt") == "A weave of 10 ribbons at rest"
        assert it.do("document.querySelector('img').naturalWidth") > 300
        assert it.picture("img").std() > 10


def test_the_page_is_written_to_a_file(tmp_path: Path) -> None:
    turned().save(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == turned().page
    with pytest.raises(OutputError, match="there is no folder"):
        turned().save(tmp_path / "no" / "page.html")
