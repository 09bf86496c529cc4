"""The guide in a real browser: without a network, step by step, and back where it was."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import PHONE, browser, opened
from laidflat import bow_tie, circles, cone, document, flat, patterns

from geoweave.errors import FieldError
from geoweave.fabrication.assembly_zones import zoned_assembly
from geoweave.fabrication.flattening import pattern_of
from geoweave.fabrication.guide_page import guide_html
from geoweave.fabrication.maker_files import write
from geoweave.files import OutputError

SOURCES = {"flat": flat, "circles": circles, "bow tie": bow_tie, "cone": lambda: cone().document()}
ACCENT = (216, 54, 28)


@cache
def text(name: str) -> str:
    return guide_html(patterns()[name], SOURCES[name](), title=name)


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("guides")
    for name in SOURCES:
        (folder / f"{name}.html").write_text(text(name), encoding="utf-8")
    return {name: folder / f"{name}.html" for name in SOURCES}


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with browser() as running:
        yield running


def content(name: str) -> dict[str, Any]:
    found = re.search(r'<script id="content" type="application/json">(.*?)</script>', text(name), re.S)
    assert found
    return json.loads(found[1])


# -- the file -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SOURCES)
def test_the_page_refers_to_nothing_outside(name: str) -> None:
    page = text(name)
    markup = re.sub(r"<script.*?</script>|<style>.*?</style>|<!--.*?-->", "", page, flags=re.S)
    assert "src=" not in markup
    assert "href=" not in markup
    assert "default-src 'none'" in page
    assert "@" not in re.sub(r"<script.*?</script>|<style>.*?</style>", "", page, flags=re.S)
    assert "url(" not in re.search(r"<style>(.*?)</style>", page, re.S)[1]
    for line in (
        "The MIT License",
        "Permission is hereby granted",
        "WITHOUT WARRANTY OF ANY KIND",
        "Three.js",
    ):
        assert line in page
    assert len(page) < 2_000_000


def test_the_page_is_the_same_each_time_and_knows_its_pattern() -> None:
    assert guide_html(patterns()["flat"], flat(), title="flat") == text("flat")
    assert content("flat")["key"] == content("flat")["key"]
    wider = flat(width=9.0)
    other = guide_html(pattern_of(wider), wider, title="flat")
    assert content("flat")["key"] not in other


def test_a_title_cannot_end_its_element(chromium: Any, tmp_path: Path) -> None:
    bad = '</script><script>document.title="taken"</script>'
    place = tmp_path / "guide.html"
    place.write_text(guide_html(patterns()["flat"], flat(), title=bad), encoding="utf-8")
    with opened(chromium, place) as it:
        assert it.page.inner_text("#title") == bad
        assert it.page.title() == f"{bad}: how to weave it"
        assert it.errors == []


def test_another_weave_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FieldError, match="other ribbons than the pattern"):
        guide_html(patterns()["flat"], circles())
    with pytest.raises(OutputError, match="guide needs the weave"):
        write(patterns()["flat"], tmp_path / "new", ["guide"])
    with pytest.raises(FieldError, match="is not a geoweave-weave"):
        write(patterns()["flat"], tmp_path / "new", ["guide"], weave={"format": "other"})
    assert not (tmp_path / "new").exists()
    assert document([], [])["units"] == "mm"


# -- in a browser -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", SOURCES)
def test_it_loads_from_a_file_without_a_network(chromium: Any, pages: dict[str, Path], name: str) -> None:
    with opened(chromium, pages[name]) as it:
        it.wait("guide.still()")
        assert it.errors == []
        assert {url.split(":")[0] for url in it.requests} <= {"file", "data", "blob"}
        assert sum(url.startswith("file:") for url in it.requests) == 1
        assert it.page.is_hidden("#trouble")
        # The whole weave is to be seen: ribbons cover a good part of the middle.
        shown = it.picture("#canvas").astype(int)
        middle = shown[shown.shape[0] // 4 : -shown.shape[0] // 4, shown.shape[1] // 4 : -shown.shape[1] // 4]
        coloured = np.ptp(middle, axis=2) > 30
        assert 0.02 < coloured.mean() < 0.9


def test_both_strips_stand_above_the_footer(chromium: Any, pages: dict[str, Path]) -> None:
    """On a screen of 1280 x 800, at the first crossing."""
    with opened(chromium, pages[next(iter(SOURCES))], (1280, 800)) as it:
        it.wait("guide.still()")
        while it.page.is_hidden("#other"):
            it.page.keyboard.press("ArrowRight")
        it.wait("guide.still()")
        low = it.do("document.querySelector('#other').getBoundingClientRect().bottom")
        assert low <= it.do("document.querySelector('footer').getBoundingClientRect().top")


@pytest.mark.parametrize("name", SOURCES)
def test_steps_are_those_of_the_assembly(chromium: Any, pages: dict[str, Path], name: str) -> None:
    """Every strip is taken once, every crossing laid once, when both its strips are there."""
    pattern = patterns()[name]
    with opened(chromium, pages[name]) as it:
        steps = it.do(
            "guide.plan.steps.map((s) => [s.kind, s.strip ?? -1, s.passage ? s.passage.crossing : -1,"
            " s.passage ? s.passage.over : null, s.passage ? s.passage.at : -1])"
        )
    order = zoned_assembly(pattern, SOURCES[name]())
    assert [each[1] for each in steps if each[0] == "take"] == [step.strip for step in order]
    laid = [each for each in steps if each[0] == "cross"]
    assert sorted(each[2] for each in laid) == list(range(len(pattern.at)))
    assert sorted(each[1] for each in steps if each[0] == "join") == [
        r for r, strip in enumerate(pattern.strips) if strip.closed
    ]
    placed: set[int] = set()
    last = -1.0
    for kind, strip, crossing, over, at in steps:
        if kind == "take":
            placed.add(strip)
            last = -1.0
        if kind == "cross":
            assert set(pattern.ribbons[crossing].tolist()) <= placed
            assert at >= last
            last = at
            passage = next(
                p
                for p in pattern.passages[strip]
                if p.crossing == crossing and p.at == pytest.approx(at, abs=1e-3)
            )
            assert passage.over == over


def test_the_crossing_that_is_named_is_marked_in_space_and_on_the_strips(
    chromium: Any, pages: dict[str, Path]
) -> None:
    weave, pattern = cone().document(), patterns()["cone"]
    with opened(chromium, pages["cone"]) as it:
        steps = it.do("guide.plan.steps.map((s) => s.passage ? [s.strip, s.passage.crossing] : null)")
        crossings = [k for k, each in enumerate(steps) if each]
        for k in crossings[:: max(len(crossings) // 6, 1)]:
            strip, crossing = steps[k]
            it.do(f"guide.go({k})")
            it.wait("guide.still()")
            passage = next(each for each in pattern.passages[strip] if each.crossing == crossing)
            own, other = pattern.strips[strip].label, pattern.strips[passage.partner].label
            sentence = it.page.inner_text("#sentence")
            assert sentence.split()[1:4] == [own, "OVER" if passage.over else "UNDER", other]
            # In space: the ring is where weave.json has this crossing, and is drawn there.
            marked = it.do("guide.marked()")
            assert (marked["crossing"], marked["shown"]) == (crossing, True)
            place = np.array(weave["crossings"][crossing]["point"])
            assert np.linalg.norm(np.array(marked["point"]) - place) < 0.15 * pattern.width
            shown = it.picture("#canvas").astype(int)
            x, y = round(marked["seen"]["x"]), round(marked["seen"]["y"])
            around = shown[max(y - 40, 0) : y + 40, max(x - 40, 0) : x + 40]
            assert (np.abs(around - ACCENT).max(axis=2) < 30).sum() > 20
            assert set(it.do("guide.shown()")) == {each[0] for each in steps[: k + 1] if each} | set(
                it.do(f"guide.plan.order.slice(0, guide.plan.steps[{k}].number + 1)")
            )
            # On both strips, in hand and in place, in view.
            for belt, far in (
                ("own", passage.at),
                (
                    "other",
                    next(
                        q.at
                        for q in pattern.passages[passage.partner]
                        if q.crossing == crossing and q.side != passage.side
                    ),
                ),
            ):
                spot = f"#{belt}-current [data-crossing]"
                assert it.page.get_attribute(spot, "data-crossing") == str(crossing)
                box, view = (
                    it.page.locator(spot).bounding_box(),
                    it.page.locator(f"#{belt} .belt").bounding_box(),
                )
                assert view["x"] <= box["x"] + box["width"] / 2 <= view["x"] + view["width"]
                where = it.do(
                    f"(() => {{ const b = document.querySelector('#{belt}-current polygon').getBBox();"
                    " return b.x + b.width / 2; })()"
                )
                assert where == pytest.approx(far, abs=0.05)
            texts = it.page.inner_text("#facts")
            for word in (own, other, "hollow", "solid"):
                assert word in texts
        assert it.errors == []


def test_what_is_left_on_a_strip_is_left_in_space(chromium: Any, pages: dict[str, Path]) -> None:
    """Angles on the strips are those at which the ribbons cross in space, seen from outside."""
    for name in ("flat", "circles", "bow tie", "cone"):
        pattern = patterns()[name]
        with opened(chromium, pages[name]) as it:
            found = it.do(
                "guide.plan.steps.map((s, k) => s.kind !== 'cross' ? null :"
                " (guide.go(k), [guide.marked().angle, s.passage.angle, s.passage.crossing, s.strip]))"
                ".filter(Boolean)"
            )
        assert len(found) == len(pattern.at)
        for seen, said, crossing, strip in found:
            # Sections lie a quarter of a width apart, and ribbons rise and bend between them.
            assert abs((seen - said + 180) % 360 - 180) < 6, (name, crossing)
            angles = [p.angle for p in pattern.passages[strip] if p.crossing == crossing]
            assert any(said == pytest.approx(angle, abs=0.01) for angle in angles)


def test_forward_back_keys_and_strips(chromium: Any, pages: dict[str, Path]) -> None:
    with opened(chromium, pages["flat"]) as it:
        press = it.page.keyboard.press
        index = lambda: it.do("guide.index")  # noqa: E731
        assert index() == 0
        assert it.page.is_disabled("#back")
        it.page.click("#next")
        assert (index(), it.do("guide.step.kind")) == (1, "take")
        press("ArrowRight")
        press("ArrowRight")
        assert index() == 3
        press("ArrowLeft")
        assert index() == 2
        it.page.click("#back")
        assert index() == 1
        press("ArrowDown")
        press("ArrowDown")
        assert (it.do("guide.step.kind"), it.do("guide.step.number")) == ("take", 2)
        press("ArrowRight")
        press("ArrowUp")
        assert (it.do("guide.step.kind"), it.do("guide.step.number")) == ("take", 2)
        press("ArrowUp")
        assert it.do("guide.step.number") == 1
        press("End")
        assert index() == it.do("guide.plan.steps.length - 1")
        assert it.page.is_disabled("#next")
        assert it.page.inner_text("#sentence") == "It is woven."
        assert len(it.do("guide.shown()")) == 12
        press("ArrowRight")
        assert index() == it.do("guide.plan.steps.length - 1")
        press("Home")
        assert index() == 0
        # Every control is to be reached and used by keys alone.
        it.page.focus("#next")
        press("Enter")
        assert index() == 1
        it.do("guide.go(guide.plan.steps.findIndex((s) => s.kind === 'cross' && s.k === 2))")
        first = it.page.inner_text("#where")
        it.page.locator("#chips button").first.click()
        assert it.page.inner_text("#where") != first
        assert it.errors == []


def test_strips_that_come_later_are_not_there_yet(chromium: Any, pages: dict[str, Path]) -> None:
    with opened(chromium, pages["flat"]) as it:
        it.page.click("#next")
        first = it.do("guide.plan.order[0]")
        assert it.do("guide.shown()") == [first]
        it.wait("guide.still()")
        few = (np.ptp(it.picture("#canvas").astype(int), axis=2) > 30).sum()
        it.page.keyboard.press("End")
        it.wait("guide.still()")
        assert (np.ptp(it.picture("#canvas").astype(int), axis=2) > 30).sum() > 4 * few


def test_it_remembers_where_the_maker_was(chromium: Any, pages: dict[str, Path]) -> None:
    context = chromium.new_context(viewport={"width": 1280, "height": 900}, offline=True)
    try:
        with opened(chromium, pages["flat"], context=context) as it:
            it.do("guide.go(17)")
            said = it.page.inner_text("#sentence")
            it.page.reload()
            assert it.do("guide.index") == 17
            assert it.page.inner_text("#sentence") == said
        # Another tab of the same file, and the page of another pattern.
        with opened(chromium, pages["flat"], context=context) as it:
            assert it.do("guide.index") == 17
            assert it.do("guide.memory") == "storage"
        with opened(chromium, pages["circles"], context=context) as it:
            assert it.do("guide.index") == 0
    finally:
        context.close()


def test_a_weave_that_was_tipped_over_stays_so(chromium: Any, pages: dict[str, Path]) -> None:
    context = chromium.new_context(
        viewport={"width": 1280, "height": 900}, offline=True, reduced_motion="reduce"
    )
    try:
        with opened(chromium, pages["cone"], context=context) as it:
            it.wait("guide.still()")
            lying = it.picture("#canvas").astype(int)
            it.page.click("#tip")
            it.wait("guide.still()")
            tipped = it.picture("#canvas").astype(int)
            assert (np.abs(tipped - lying).max(axis=2) > 40).mean() > 0.01
            it.page.reload()
            it.wait("guide.still()")
            again = it.picture("#canvas").astype(int)
            assert (np.abs(again - tipped).max(axis=2) > 40).mean() < 0.001
    finally:
        context.close()


@pytest.mark.parametrize("stored", ["{", '{"step": "x"}', '{"step": -5}', '{"step": 100000}', "[]", "null"])
def test_nonsense_in_the_memory_does_no_harm(chromium: Any, pages: dict[str, Path], stored: str) -> None:
    key = f"geoweave-guide-{content('flat')['key']}"
    before = f"try {{ localStorage.setItem({json.dumps(key)}, {json.dumps(stored)}); }} catch (e) {{}}"
    with opened(chromium, pages["flat"], before=before) as it:
        assert 0 <= it.do("guide.index") < it.do("guide.plan.steps.length")
        assert it.errors == []


def test_without_a_memory_the_address_keeps_the_place(chromium: Any, pages: dict[str, Path]) -> None:
    denied = "Object.defineProperty(window, 'localStorage', { get() { throw new Error('denied'); } });"
    with opened(chromium, pages["flat"], before=denied) as it:
        it.do("guide.go(9)")
        assert it.do("guide.memory") == "address"
        assert it.page.url.endswith("#step-9")
        assert "bookmark" in it.page.inner_text("#memory")
        it.page.reload()
        assert it.do("guide.index") == 9
        assert it.errors == []


def test_without_pictures_in_space_the_steps_still_work(chromium: Any, pages: dict[str, Path]) -> None:
    off = "HTMLCanvasElement.prototype.getContext = () => null;"
    with opened(chromium, pages["flat"], before=off) as it:
        assert "WebGL" in it.page.inner_text("#trouble")
        it.do("guide.go(guide.plan.steps.findIndex((s) => s.kind === 'cross') - 1)")
        it.page.click("#next")
        assert it.do("guide.step.kind") == "cross"
        assert it.page.is_visible("#own-current polygon")
        assert it.page.inner_text("#sentence")


@pytest.mark.parametrize("name", ["cone", "bow tie", "circles"])
def test_it_fits_a_phone(chromium: Any, pages: dict[str, Path], name: str) -> None:
    with opened(chromium, pages[name], PHONE) as it:
        last = it.do("guide.plan.steps.length - 1")
        for k in (0, 1, last // 2, last // 2 + 1, last - 1, last):
            it.do(f"guide.go({k})")
            it.wait("guide.still()")
            assert it.fits()
            for button in ("#next", "#back"):
                box = it.page.locator(button).bounding_box()
                assert box["height"] >= 44
                assert 0 <= box["y"] <= PHONE[1] - box["height"]
        it.do("guide.go(0)")
        it.page.tap("#next")
        assert it.do("guide.index") == 1
        # What is to be done and both strips are on one screen.
        it.do("guide.go(guide.plan.steps.findIndex((s) => s.kind === 'cross'))")
        for part in ("#sentence", "#own .belt svg"):
            box = it.page.locator(part).bounding_box()
            assert box["y"] + box["height"] < it.page.locator("footer").bounding_box()["y"]
        assert it.errors == []


def test_it_fits_a_phone_on_its_side(chromium: Any, pages: dict[str, Path]) -> None:
    with opened(chromium, pages["cone"], (844, 390)) as it:
        it.do("guide.go(guide.plan.steps.findIndex((s) => s.kind === 'cross'))")
        assert it.fits()
        foot = it.page.locator("footer").bounding_box()["y"]
        for part in ("#canvas", "#lens", "#sentence", "#facts"):
            box = it.page.locator(part).bounding_box()
            assert box["y"] + box["height"] <= foot + 1, part


def test_all_of_it_is_in_view(chromium: Any, pages: dict[str, Path]) -> None:
    """However wide the window is, nothing of the weave is cut off, and it fills what there is."""
    for size in ((1600, 800), (700, 1000), PHONE):
        with opened(chromium, pages["circles"], size) as it:
            it.page.keyboard.press("End")
            it.wait("guide.still()")
            drawn = np.ptp(it.picture("#canvas").astype(int), axis=2) > 30
            # Buttons stand in the lower left corner.
            drawn = drawn[: round(0.85 * len(drawn))]
            assert not drawn[:2].any()
            assert not drawn[:, :2].any()
            assert not drawn[:, -2:].any()
            rows, columns = (np.flatnonzero(drawn.any(axis=k)) for k in (1, 0))
            assert max(len(rows) / len(drawn), len(columns) / drawn.shape[1]) > 0.8


def test_all_steps_go_on_paper(chromium: Any, pages: dict[str, Path], tmp_path: Path) -> None:
    import pypdfium2

    pattern = patterns()["cone"]
    with opened(chromium, pages["cone"]) as it:
        it.do("guide.go(12)")
        it.wait("guide.still()")
        it.page.pdf(path=tmp_path / "steps.pdf", prefer_css_page_size=True)
        assert it.do("document.querySelector('#sheet img').naturalWidth") > 300
        assert it.do("document.querySelectorAll('#sheet tbody tr').length") == len(pattern.at)
        assert (it.do("guide.index"), it.do("guide.marked().shown")) == (12, True)
    paper = pypdfium2.PdfDocument(tmp_path / "steps.pdf")
    words = " ".join(page.get_textpage().get_text_bounded() for page in paper)
    for number, step in enumerate(zoned_assembly(pattern, cone().document()), 1):
        assert re.search(rf"{number}\.\s+Strip\s+{pattern.strips[step.strip].label}\b", words)
    paper.close()


def test_turning_and_nearing(chromium: Any, pages: dict[str, Path]) -> None:
    with opened(chromium, pages["cone"]) as it:
        it.wait("guide.still()")
        before = it.picture("#canvas")
        box = it.page.locator("#canvas").bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        it.page.mouse.move(x, y)
        it.page.mouse.down()
        it.page.mouse.move(x + 120, y + 30, steps=4)
        it.page.mouse.up()
        it.wait("guide.still()")
        turned = it.picture("#canvas")
        assert (np.abs(turned.astype(int) - before).max(axis=2) > 40).mean() > 0.01
        it.page.keyboard.press("+")
        it.wait("guide.still()")
        ground = lambda shown: (np.ptp(shown.astype(int), axis=2) > 30).mean()  # noqa: E731
        assert ground(it.picture("#canvas")) > ground(turned)
        assert it.errors == []


def test_a_crossing_that_friction_does_not_hold_is_to_be_glued(chromium: Any, tmp_path: Path) -> None:
    """The weave at rest marks it; the page says so at this crossing and at no other."""
    woven = flat()
    marked = dict(woven) | {
        "crossings": [dict(each) | {"fasten": x == 1} for x, each in enumerate(woven["crossings"])]
    }
    (tmp_path / "glued.html").write_text(guide_html(patterns()["flat"], marked), encoding="utf-8")
    with opened(chromium, tmp_path / "glued.html") as it:
        steps = it.do("guide.plan.steps.map((s) => s.passage ? s.passage.crossing : -1)")
        told = []
        for k, crossing in enumerate(steps):
            it.do(f"guide.go({k})")
            if "Glue or rivet it" in it.page.inner_text("body"):
                told.append(crossing)
    assert told == [1]


def test_the_map_shows_the_zone_in_hand(chromium: Any, tmp_path: Path) -> None:
    """Every strip is on both sides of the map once; where a strip is taken its zone stands out."""
    woven = flat(8)
    pattern = pattern_of(woven)
    order = zoned_assembly(pattern, woven)
    assert len({step.zone for step in order}) == 3
    (tmp_path / "zones.html").write_text(guide_html(pattern, woven), encoding="utf-8")
    for size in ((1280, 800), PHONE):
        with opened(chromium, tmp_path / "zones.html", size) as it:
            it.wait("guide.still()")
            seen = it.do("[...document.querySelectorAll('#zones path')].map((p) => Number(p.dataset.strip))")
            assert sorted(seen) == sorted(2 * list(range(len(pattern.strips))))
            space, shown = (it.page.locator(each).bounding_box() for each in ("#space", "#zones"))
            assert shown["y"] + shown["height"] <= space["y"] + space["height"]
            assert it.page.locator("#zones svg").first.bounding_box()["height"] > 40
            for step in (order[0], order[12], order[-1]):
                it.do(f"guide.go(guide.plan.firstOf[{step.strip}])")
                now = it.do(
                    "[...document.querySelectorAll('#zones g.now')].map((g) => Number(g.dataset.zone))"
                )
                own = it.do(
                    "[...document.querySelectorAll('#zones .own')].map((p) => Number(p.dataset.strip))"
                )
                assert (now, own) == (2 * [step.zone], 2 * [step.strip])
                assert f"zone {step.zone + 1} of 3" in it.page.inner_text("#where")
            it.do("guide.go(1e9)")
            assert it.page.is_hidden("#zones")
            assert it.errors == []
