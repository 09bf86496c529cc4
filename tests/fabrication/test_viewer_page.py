"""The viewer in a real browser, on a desk and on a phone: what is seen, named, coloured and changed."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import DESK, PHONE, Opened, browser, opened
from laidflat import cone, flat

from geoweave.errors import FieldError
from geoweave.fabrication.glb import ribbon_bodies, solid_ribbons
from geoweave.fabrication.viewer_page import viewer_html
from geoweave.rods import relaxed_weave
from geoweave.weave import inspected
from geoweave.weave.body import CLEAR

SIZES = {"desk": DESK, "phone": PHONE}
STILL = "viewer.still()"

CONTRAST = """
(() => {
  const part = (x) => x / 255 <= 0.04045 ? x / 255 / 12.92 : ((x / 255 + 0.055) / 1.055) ** 2.4;
  const light = ([r, g, b]) => 0.2126 * part(r) + 0.7152 * part(g) + 0.0722 * part(b);
  const pen = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const shown = (colour) => {
    pen.clearRect(0, 0, 1, 1);
    pen.fillStyle = colour;
    pen.fillRect(0, 0, 1, 1);
    return [...pen.getImageData(0, 0, 1, 1).data];
  };
  const said = (each) => [...each.childNodes].filter((node) => node.nodeType === 3)
    .map((node) => node.textContent.trim()).join("");
  const found = [];
  for (const each of document.querySelectorAll("body *:not(script, style, option, noscript, :disabled)")) {
    if (!said(each) || !each.checkVisibility({ visibilityProperty: true })) continue;
    let ground = each, colour = [0, 0, 0, 0];
    while (ground && colour[3] < 255) {
      colour = shown(getComputedStyle(ground).backgroundColor);
      ground = ground.parentElement;
    }
    const [a, b] = [light(shown(getComputedStyle(each).color)), light(colour)].sort((p, q) => q - p);
    found.push([(a + 0.05) / (b + 0.05), said(each).slice(0, 40)]);
  }
  return found;
})()
"""


@cache
def cone_text() -> str:
    weave = cone()
    return viewer_html(
        weave, relaxed_weave(weave), inspected(weave).document() | {"verdict": VERDICT}, "a cone"
    )


TOPS = """
(() => {
  const space = viewer.space, { strips, at } = space.now.crossings[@];
  return strips.map((r, k) => {
    const way = space.ways[r], places = space.meshes[r].geometry.attributes.position.array;
    let nearest = 0;
    way.at.forEach((s, n) => { if (Math.abs(s - at[k]) < Math.abs(way.at[nearest] - at[k])) nearest = n; });
    return places[3 * (4 * way.count + nearest) + 2];
  });
})()
"""
"""How high the outer faces of the two ribbons of a crossing are there."""

VERDICT = {"word": "make it, but", "reasons": ["two ends are loose, fasten them"], "remedy": ""}


def large() -> dict[str, Any]:
    """A weave in the plane of the size that the page is to be quick at."""
    return flat(37, spacing=11.0, reach=135.0, width=3.0)


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("viewers")
    made = {"cone": cone_text(), "flat": viewer_html(flat(), title="flat"), "large": viewer_html(large())}
    for name, text in made.items():
        (folder / f"{name}.html").write_text(text, encoding="utf-8")
    return {name: folder / f"{name}.html" for name in made}


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with browser() as running:
        yield running


def seen(it: Opened, what: str) -> tuple[float, float]:
    """Where something is in the window, and not behind something else."""
    box = it.page.locator("#canvas").bounding_box()
    at = it.do(f"viewer.seen({what})")
    return box["x"] + at["x"], box["y"] + at["y"]


def faced(it: Opened, what: str) -> tuple[float, float]:
    """Fly to something and say where it is then."""
    it.do(f"viewer.go({what})")
    it.wait(STILL)
    return seen(it, what)


def tap(it: Opened, where: tuple[float, float]) -> None:
    if it.do("navigator.maxTouchPoints > 0"):
        it.page.touchscreen.tap(*where)
    else:
        it.page.mouse.click(*where)
    it.wait(STILL)


# -- the file -----------------------------------------------------------------------------------------------


def test_the_page_refers_to_nothing_outside_and_is_the_same_each_time() -> None:
    page = cone_text()
    markup = re.sub(r"<script.*?</script>|<style>.*?</style>|<!--.*?-->", "", page, flags=re.S)
    assert "src=" not in markup
    assert "href=" not in markup
    assert "default-src 'none'" in page
    assert "The MIT License" in page
    assert viewer_html(flat(), title="flat") == viewer_html(flat(), title="flat")
    assert len(viewer_html(large())) < 3_000_000


def test_a_weave_at_rest_of_other_ribbons_is_refused() -> None:
    with pytest.raises(FieldError, match=r"other ribbons than weave\.json"):
        viewer_html(flat(), flat(5))
    with pytest.raises(FieldError, match=r"relaxed.json: is not a geoweave-weave"):
        viewer_html(flat(), {"format": "other"})


# -- what is seen -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("name", ["cone", "flat", "large"])
def test_it_loads_from_a_file_without_a_network(
    chromium: Any, pages: dict[str, Path], name: str, size: str
) -> None:
    with opened(chromium, pages[name], SIZES[size]) as it:
        it.wait(STILL)
        assert it.errors == []
        assert [url.split(":")[0] for url in it.requests] == ["file"]
        assert it.page.is_hidden("#trouble")
        assert it.fits()
        shown = it.picture("#canvas").astype(int)
        middle = shown[shown.shape[0] // 4 : -shown.shape[0] // 4, shown.shape[1] // 4 : -shown.shape[1] // 4]
        assert 0.02 < (np.ptp(middle, axis=2) > 30).mean() < 0.95


def test_ribbons_are_those_of_the_glb(chromium: Any, pages: dict[str, Path]) -> None:
    """Corner by corner, to the grain of the page."""
    with opened(chromium, pages["flat"]) as it:
        it.wait(STILL)
        drawn = it.do("viewer.space.meshes.map((mesh) => [...mesh.geometry.attributes.position.array])")
    grain = np.ptp(np.concatenate([r.vertices for r in solid_ribbons(flat())]), axis=0).max() / 65535
    for corners, body in zip(drawn, ribbon_bodies(flat()), strict=True):
        points = np.array(corners).reshape(8, -1, 3)[[0, 2, 4, 6]].swapaxes(0, 1)
        # Widths are told to 1/255.
        assert np.abs(points - body.corners).max() < 4 * grain + body.width / 510 + 1e-3


def test_where_ribbons_cross_the_upper_one_is_in_front(chromium: Any, pages: dict[str, Path]) -> None:
    weave = flat()
    with opened(chromium, pages["flat"]) as it:
        it.wait(STILL)
        for x in range(0, len(weave["crossings"]), 7):
            each = weave["crossings"][x]
            faced(it, f"{{ kind: 'crossing', crossing: {x} }}")
            hit = it.do(
                f"(() => {{ const at = viewer.seen({{ kind: 'crossing', crossing: {x} }}),"
                " box = document.getElementById('canvas').getBoundingClientRect();"
                " return viewer.space.hit(viewer.space.ray(box.left + at.x, box.top + at.y), 0).strip; })()"
            )
            assert hit == each["ribbons"][each["over_index"]]


def test_both_shapes_and_their_crossings(chromium: Any, pages: dict[str, Path]) -> None:
    with opened(chromium, pages["cone"]) as it:
        it.wait(STILL)
        assert it.page.inner_text("#states [aria-checked=true]") == "At rest"
        rest = it.picture("#canvas")
        it.page.click("#states [data-key='0']")
        it.wait(STILL)
        assert it.page.inner_text("#states [aria-checked=true]") == "As designed"
        assert np.abs(it.picture("#canvas").astype(int) - rest).max() > 60
        assert it.do("viewer.space.now.crossings.length") == len(cone().ribbons.crossings)
        assert it.page.inner_text("#verdict") == "Make it, but: two ends are loose, fasten them."


@pytest.mark.parametrize("size", SIZES)
def test_a_tap_names_ribbons_and_crossings(chromium: Any, pages: dict[str, Path], size: str) -> None:
    weave = flat()
    labels = [each["label"] for each in weave["ribbons"]]
    with opened(chromium, pages["flat"], SIZES[size]) as it:
        it.wait(STILL)
        tap(it, faced(it, "{ kind: 'crossing', crossing: 5 }"))
        upper, lower = (
            (weave["crossings"][5]["ribbons"][i] for i in (1, 0))
            if weave["crossings"][5]["over_index"]
            else weave["crossings"][5]["ribbons"]
        )
        said = f"{labels[upper]} over {labels[lower]}"
        assert it.page.inner_text("#named .name") == said
        assert it.page.inner_text("#tags .selected") == said
        tap(it, faced(it, "{ kind: 'ribbon', strip: 4, at: 3 }"))
        assert it.page.inner_text("#named .name") == labels[4]
        assert f"{weave['ribbons'][4]['length']:g} mm long" in it.page.inner_text("#named")
        met = sum(4 in each["ribbons"] for each in weave["crossings"])
        assert it.page.locator("#chips .chip").count() == met


def test_the_pointer_names_what_is_under_it(chromium: Any, pages: dict[str, Path]) -> None:
    with opened(chromium, pages["flat"]) as it:
        it.wait(STILL)
        it.page.mouse.move(*faced(it, "{ kind: 'ribbon', strip: 7, at: 3 }"))
        it.wait("document.querySelector('#tags .over') !== null")
        assert it.page.inner_text("#tags .over") == flat()["ribbons"][7]["label"]
        it.page.mouse.move(5, 5)
        it.wait("document.querySelector('#tags .over') === null")


def test_colours(chromium: Any, pages: dict[str, Path]) -> None:
    with opened(chromium, pages["cone"]) as it:
        it.wait(STILL)
        pictures = {}
        for name in ("family", "bend", "hard", "force"):
            it.page.select_option("#colour", name)
            it.wait(STILL)
            pictures[name] = it.picture("#canvas").astype(int)
            assert it.page.inner_text("#legend")
        assert np.abs(pictures["family"] - pictures["bend"]).max() > 60
        assert np.abs(pictures["bend"] - pictures["hard"]).max() > 60
        assert np.abs(pictures["hard"] - pictures["force"]).max() > 60
        # A design has no forces.
        it.page.click("#states [data-key='0']")
        assert it.page.locator("#colour option").count() == 3
        assert it.page.input_value("#colour") == "family"
        red = (pictures["hard"][..., 0] - pictures["hard"][..., 1] > 80).mean()
        assert 0.0005 < red < 0.5
    with opened(chromium, pages["flat"]) as it:  # nothing is hard there
        assert it.page.locator("#colour option").count() == 2
        assert it.page.is_hidden("#hard")


def test_a_click_flies_to_a_hard_place(chromium: Any, pages: dict[str, Path]) -> None:
    with opened(chromium, pages["cone"]) as it:
        it.wait(STILL)
        it.page.click("#hard summary")
        places = it.do("viewer.content.places.map((each) => each.at)")
        assert it.page.locator("[data-place]").count() == len(places)
        for k in range(0, len(places), max(len(places) // 3, 1)):
            it.page.click(f"[data-place='{k}']")
            it.wait(STILL)
            assert it.do("viewer.space.target.toArray()") == pytest.approx(places[k][1], abs=1e-3)
            assert it.page.get_attribute(f"[data-place='{k}']", "aria-current") == "true"
            assert it.page.locator("[data-place][aria-current]").count() == 1


# -- hands --------------------------------------------------------------------------------------------------


def test_mouse_and_wheel_turn_and_zoom(chromium: Any, pages: dict[str, Path]) -> None:
    with opened(chromium, pages["cone"]) as it:
        it.wait(STILL)
        way, far = it.do("viewer.space.direction.toArray()"), it.do("viewer.space.distance")
        it.page.mouse.move(400, 400)
        it.page.mouse.down()
        it.page.mouse.move(520, 430, steps=4)
        it.page.mouse.up()
        assert np.dot(it.do("viewer.space.direction.toArray()"), way) < 0.9
        it.page.mouse.wheel(0, -400)
        it.wait(f"viewer.space.distance < {0.8 * far}")
        it.page.click("#whole")
        it.wait(STILL)
        assert it.do("viewer.space.distance") == pytest.approx(far)


def test_two_fingers_zoom(chromium: Any, pages: dict[str, Path]) -> None:
    with opened(chromium, pages["cone"], PHONE) as it:
        it.wait(STILL)
        far = it.do("viewer.space.distance")
        hand = it.page.context.new_cdp_session(it.page)
        for reach in (30, 60, 90):
            kind = "touchStart" if reach == 30 else "touchMove"
            points = [{"x": 195 - reach, "y": 240, "id": 0}, {"x": 195 + reach, "y": 240, "id": 1}]
            hand.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        hand.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        it.wait(f"viewer.space.distance < {0.5 * far}")


def test_everything_can_be_done_with_keys(chromium: Any, pages: dict[str, Path]) -> None:
    with opened(chromium, pages["cone"]) as it:
        it.wait(STILL)
        way, far = it.do("viewer.space.direction.toArray()"), it.do("viewer.space.distance")
        it.page.focus("#canvas")
        it.page.keyboard.press("ArrowRight")
        assert it.do("viewer.space.direction.toArray()") != way
        it.page.keyboard.press("+")
        assert it.do("viewer.space.distance") < far
        it.page.keyboard.press("0")
        it.page.keyboard.press("s")
        it.page.keyboard.press("c")
        it.wait(STILL)
        assert it.page.inner_text("#states [aria-checked=true]") == "As designed"
        assert it.page.input_value("#colour") == "bend"
        faced(it, "{ kind: 'crossing', crossing: 3 }")
        it.page.keyboard.press("Enter")
        assert " over " in it.page.inner_text("#named .name")
        it.page.keyboard.press("Escape")
        assert it.page.locator("#named .name").count() == 0
        it.page.focus("#ribbon")
        it.page.keyboard.press("ArrowDown")
        it.wait(STILL)
        assert it.page.inner_text("#named .name") == it.do("viewer.content.strips[0][0]")
        it.page.focus("#chips .chip")
        it.page.keyboard.press("Enter")
        assert " over " in it.page.inner_text("#named .name")


@pytest.mark.parametrize("size", SIZES)
def test_text_can_be_read_and_buttons_can_be_hit(chromium: Any, pages: dict[str, Path], size: str) -> None:
    with opened(chromium, pages["cone"], SIZES[size]) as it:
        it.wait(STILL)
        it.do("viewer.select({ kind: 'ribbon', strip: 2 }, false)")
        it.page.click("#drop")
        it.do("document.querySelectorAll('details').forEach((each) => { each.open = true; })")
        it.do("viewer.mode('line')")
        it.page.click("#undo")
        it.wait(STILL)
        found = it.do(CONTRAST)
        assert len(found) > 25
        assert [each for each in found if each[0] < 4.5] == []
        if size == "phone":
            heights = it.do(
                "[...document.querySelectorAll('button, select, label:has(input), summary')]"
                ".filter((each) => each.checkVisibility())"
                ".map((each) => [each.getBoundingClientRect().height, each.textContent])"
            )
            assert [each for each in heights if each[0] < 40] == []
        assert it.fits()


# -- 110 ribbons and 1,700 crossings ------------------------------------------------------------------------


def test_a_large_weave_is_drawn_once_for_each_change(chromium: Any, pages: dict[str, Path]) -> None:
    """What makes it quick: a call for each ribbon, nothing drawn while nothing changes, no mesh made anew."""
    count = "viewer.space.renderer.info.render.frame"
    with opened(chromium, pages["large"]) as it:
        it.wait(STILL)
        ribbons = len(large()["ribbons"])
        assert ribbons >= 110
        assert len(large()["crossings"]) >= 1700
        before, made = it.do(count), it.do("viewer.space.renderer.info.memory.geometries")
        assert it.do("viewer.space.renderer.info.render.calls") == ribbons
        it.page.wait_for_timeout(300)
        assert it.do(count) == before
        tap(it, faced(it, "{ kind: 'crossing', crossing: 900 }"))
        assert " over " in it.page.inner_text("#named .name")
        it.page.select_option("#colour", "bend")
        it.wait(STILL)
        it.page.click("#flip")
        it.wait(STILL)
        # The ring that marks a crossing has two geometries in one.
        assert it.do("viewer.space.renderer.info.memory.geometries") <= made + 2


def test_without_webgl_the_page_says_so(chromium: Any, pages: dict[str, Path]) -> None:
    none = "HTMLCanvasElement.prototype.getContext = () => null;"
    with opened(chromium, pages["flat"], before=none) as it:
        assert "WebGL is off" in it.page.inner_text("#trouble")


# -- changes ------------------------------------------------------------------------------------------------


def saved(it: Opened, folder: Path) -> dict[str, Any]:
    with it.page.expect_download() as coming:
        it.page.click("#save")
    assert coming.value.suggested_filename == "edits.json"
    coming.value.save_as(folder / "edits.json")
    text = (folder / "edits.json").read_text(encoding="utf-8")
    assert json.loads(text) == json.loads(it.page.input_value("#written"))
    return json.loads(text)


@pytest.mark.parametrize("size", SIZES)
def test_drop_and_flip_are_shown_and_saved(
    chromium: Any, pages: dict[str, Path], size: str, tmp_path: Path
) -> None:
    weave = flat()
    with opened(chromium, pages["flat"], SIZES[size]) as it:
        it.wait(STILL)
        assert it.page.is_disabled("#save")
        it.do("viewer.select({ kind: 'ribbon', strip: 3 }, false)")
        it.page.click("#drop")
        assert it.do("viewer.space.meshes[3].visible") is False
        x = next(x for x, each in enumerate(weave["crossings"]) if 3 not in each["ribbons"])
        each = weave["crossings"][x]
        it.do(f"viewer.select({{ kind: 'crossing', crossing: {x} }}, false)")
        faced(it, f"{{ kind: 'crossing', crossing: {x} }}")
        before = it.do(TOPS.replace("@", str(x)))
        it.page.click("#flip")
        now = [each["ribbons"][1 - each["over_index"]], each["ribbons"][each["over_index"]]]
        names = [weave["ribbons"][r]["label"] for r in now]
        assert it.page.inner_text("#named .name") == " over ".join(names)
        faced(it, f"{{ kind: 'crossing', crossing: {x} }}")
        tops = it.do(TOPS.replace("@", str(x)))
        # The two have changed places: as far apart as before, the other one above.
        up = 1 - each["over_index"]
        assert before[1 - up] - before[up] > CLEAR * weave["thickness"] - 0.02
        assert tops[up] - tops[1 - up] == pytest.approx(before[1 - up] - before[up], abs=0.02)
        assert it.page.locator("#list li").all_inner_texts() == [
            f"{weave['ribbons'][3]['label']} is dropped",
            f"{names[0]} goes over {names[1]}",
        ]
        found = saved(it, tmp_path)
        assert (found["format"], found["version"]) == ("geoweave-edits", 1)
        assert found["drop"] == [weave["ribbons"][3]["label"]]
        assert found["flip"] == [
            {
                "crossing": x,
                "ribbons": [weave["ribbons"][r]["label"] for r in each["ribbons"]],
                "over": 1 - each["over_index"],
            }
        ]
        assert found["singularities"] is None
        assert found["align"] is None
        it.page.click("#undo")
        it.page.click("#undo")
        assert it.page.is_disabled("#save")
        assert it.do("viewer.space.meshes[3].visible") is True
        assert it.errors == []


def test_what_is_held_together_once_is_flipped_together(chromium: Any, pages: dict[str, Path]) -> None:
    with opened(chromium, pages["cone"]) as it:
        it.wait(STILL)
        designs = it.do("viewer.space.now.crossings.map((each) => each.designs)")
        assert sorted(x for each in designs for x in each) == list(range(len(cone().ribbons.crossings)))
        it.do("viewer.select({ kind: 'crossing', crossing: 4 }, false)")
        it.page.click("#flip")
        flipped = [each["crossing"] for each in it.do("viewer.edits.document()")["flip"]]
        assert flipped == sorted(designs[4])
