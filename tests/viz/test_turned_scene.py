"""A scene in a cell: what the page holds, how large it is, and that a browser turns it."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import browser, opened
from matplotlib.colors import to_rgb

import geoweave as gw
from geoweave.errors import RenderError
from geoweave.viz import (
    Drop,
    Panel,
    Scene,
    Woven,
    drop_chart,
    streamline_gallery,
    style,
)
from geoweave.viz.turned_scene import FACES, POINTS, Turned, turn


@cache
def ball() -> Panel:
    field = gw.smoothest_field(gw.shapes.sphere(faces=320))
    return Panel("a <ball> & more", gw.streamlines(field, separation=0.4), indices=gw.vertex_indices(field))


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with browser() as running:
        yield running


def content(shown: Turned) -> dict[str, Any]:
    found = re.search(r'id="content">(.*?)</script>', shown.page, re.DOTALL)
    assert found
    return json.loads(found[1])


def numbers(text: str, kind: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), dtype=kind)


def test_the_page_holds_the_surface_its_lines_and_its_dots() -> None:
    held = content(turn(ball()))
    sphere, *dots = held["faces"]
    assert len(numbers(sphere["faces"], "<u2")) == 3 * 320
    assert dots, "singular vertices are marked"
    (lines,) = held["lines"]
    counts = numbers(lines["counts"], "<u4")
    assert len(counts) == len(ball().curves)
    assert counts.sum() == len(numbers(lines["points"], "<i2")) / 3
    # The points lie on one ball, in steps of the largest distance.
    points = numbers(sphere["points"], "<i2").reshape(-1, 3) / 32767
    radii = np.linalg.norm(points, axis=1)
    assert np.ptp(radii) < 0.01
    assert 0.9 < radii.max() <= 1.0
    colours = numbers(sphere["colours"], "u1").reshape(-1, 3)
    assert (colours == np.rint(255 * np.array(to_rgb(style.SURFACE)))).all()


def test_the_same_scene_gives_the_same_text() -> None:
    assert turn(ball()).page == turn(ball()).page
    assert turn(ball(), title="another").page != turn(ball()).page


def test_words_cannot_end_what_holds_them() -> None:
    bundle = turn(ball(), title='</script>"<b>')._repr_mimebundle_()
    assert set(bundle) == {"text/html", "text/plain"}
    outside = re.sub(r'srcdoc="[^"]*"', "", bundle["text/html"])
    assert "<b>" not in outside
    assert "<script" not in outside
    assert "<title>&lt;/script&gt;" in turn(ball(), title='</script>"<b>').page


def test_a_large_scene_is_thinned_out_and_keeps_its_colours_and_ends() -> None:
    mesh = gw.shapes.sphere(subdivisions=5)
    scene = Scene()
    scene.add_surface(mesh, values=mesh.vertices[:, 2], limit=1.0)
    lines = gw.streamlines(gw.smoothest_field(mesh), separation=0.03)
    scene.add_curves(lines, 0.003)
    shown = turn(scene)
    held = content(shown)
    assert len(shown._repr_mimebundle_()["text/html"]) < 400_000
    (surface,), (threads,) = held["faces"], held["lines"]
    assert 0.8 * FACES < len(numbers(surface["faces"], "<u2")) / 3 <= 1.01 * FACES
    counts = numbers(threads["counts"], "<u4")
    assert counts.sum() <= POINTS + 2 * len(counts)
    assert (counts >= 2).all()
    points = numbers(surface["points"], "<i2").reshape(-1, 3) / 32767
    colours = numbers(surface["colours"], "u1").reshape(-1, 3) / 255
    expected = style.diverging()(0.5 + 0.5 * points[:, 2])[:, :3]
    assert np.abs(colours - expected).max() < 0.1


def test_what_has_no_value_has_the_plain_colour() -> None:
    mesh = gw.shapes.sphere(faces=320)
    values = np.where(mesh.vertices[:, 2] > 0.5, np.nan, 10.0)
    scene = Scene()
    scene.add_surface(mesh, values=values, limits=(1.0, 100.0), log=True, colour="#102030")
    (surface,) = content(turn(scene))["faces"]
    seen = {tuple(each) for each in numbers(surface["colours"], "u1").reshape(-1, 3).tolist()}
    middle = tuple(np.rint(255 * np.array(style.diverging()(0.5)[:3])).astype(int).tolist())
    assert seen == {(0x10, 0x20, 0x30), middle}


def test_panels_of_a_picture_are_turned_one_by_one() -> None:
    picture = streamline_gallery([ball(), ball()], width=200, alt="two balls")
    assert len(picture.scenes) == 2
    assert turn(picture, 1).scene is picture.scenes[1]
    assert turn(picture).title == "two balls"
    with pytest.raises(RenderError, match="has 2 scenes, there is no scene 2"):
        turn(picture, 2)
    with pytest.raises(RenderError, match="has 0 scenes"):
        turn(drop_chart([Drop("Cow", 20.0, 7.0)]))
    with pytest.raises(RenderError, match="no surface"):
        turn(Scene()).page  # noqa: B018


def test_ribbons_have_the_colours_of_their_picture() -> None:
    woven = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)
    held = content(turn(Woven(woven, "a cone", view="cone")))
    seen = {
        tuple(each)
        for part in held["faces"]
        for each in numbers(part["colours"], "u1").reshape(-1, 3).tolist()
    }
    expected = [style.SURFACE, *style.FAMILIES[:3]]
    assert seen == {tuple(np.rint(255 * np.array(to_rgb(each))).astype(int).tolist()) for each in expected}


def test_a_veil_is_left_out_and_detail_thins() -> None:
    mesh = gw.shapes.sphere(faces=5120)
    scene = Scene()
    scene.add_surface(mesh, opacity=0.3)
    with pytest.raises(RenderError, match="no surface"):
        turn(scene).page  # noqa: B018
    scene.add_surface(mesh)
    assert len(content(turn(scene))["faces"]) == 1
    (thin,) = content(turn(scene, detail=0.1))["faces"]
    assert len(numbers(thin["faces"], "<u2")) / 3 <= 0.101 * FACES


def test_a_browser_turns_it(chromium: Any, tmp_path: Path) -> None:
    file = tmp_path / "cell.html"
    text = turn(ball())._repr_mimebundle_()["text/html"]
    file.write_text(f"<!DOCTYPE html><body style='margin:0;width:900px'>{text}</body>", encoding="utf-8")
    with opened(chromium, file) as it:
        (frame,) = it.page.frames[1:]
        for _ in range(200):
            if frame.evaluate("window.turned !== undefined && window.turned.drawn > 0"):
                break
            it.page.wait_for_timeout(50)
        assert it.page.get_attribute("iframe", "title") == "a <ball> & more"
        before = frame.evaluate("turned.axes()")
        assert it.picture("iframe").std() > 10
        box = it.page.locator("iframe").bounding_box()
        it.page.mouse.move(box["x"] + 400, box["y"] + 200)
        it.page.mouse.down()
        it.page.mouse.move(box["x"] + 500, box["y"] + 230, steps=3)
        it.page.mouse.up()
        after = np.array(frame.evaluate("turned.axes()"))
        assert np.abs(after - before).max() > 0.1
        assert np.allclose(after @ after.T, np.eye(3), atol=1e-6), "a turn, and nothing else"
        it.page.mouse.wheel(0, -300)
        it.page.wait_for_timeout(100)
        assert frame.evaluate("turned.zoom()") > 1
        it.page.mouse.dblclick(box["x"] + 400, box["y"] + 200)
        assert np.allclose(frame.evaluate("turned.axes()"), before)
        assert it.errors == []
        assert {url.split(":")[0] for url in it.requests} <= {"file", "data", "about"}
