"""The pages of the notebooks: complete, without a network, and fit for a phone."""

from __future__ import annotations

import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import nbformat
import numpy as np
import pytest
from browser import DESK, PHONE, browser, opened
from PIL import Image

from geoweave.artifact import claims, notebooks, site
from geoweave.artifact.notebooks import NotebookError
from geoweave.artifact.site_docs import DOCUMENTS
from geoweave.artifact.site_text import plain
from geoweave.checkout import repository
from geoweave.files import OutputError

ROOT = repository()
VOID = {"meta", "link", "img", "br", "hr", "col", "input"}


class Reader(HTMLParser):
    """Elements in order, what they refer to, and whether they are closed as they are opened."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.open: list[str] = []
        self.links: list[str] = []
        self.loads: list[str] = []
        self.ids: set[str] = set()
        self.seen: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen.append(tag)
        for key, value in attrs:
            if key == "href" and tag == "a":
                self.links.append(value or "")
            elif key in ("src", "href", "srcset", "data", "poster", "action"):
                self.loads.append(value or "")
            elif key == "id":
                self.ids.add(value or "")
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    target = tmp_path_factory.mktemp("pages") / "site"
    site.build(ROOT, target)
    return target


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    with browser() as running:
        yield running


def pages(built: Path) -> dict[str, Reader]:
    return {path.name: Reader(path.read_text(encoding="utf-8")) for path in sorted(built.glob("*.html"))}


def test_there_is_a_page_for_every_notebook(built: Path) -> None:
    assert {path.stem for path in built.glob("*.html")} == {"index", *DOCUMENTS, *notebooks.names(ROOT)}
    for name in notebooks.names(ROOT):
        text = (built / f"{name}.html").read_text(encoding="utf-8")
        notebook = notebooks.read(notebooks.path_of(ROOT, name))
        # Every stored picture is there as it is stored, every text, every line of code.
        stored = [
            o.data["image/png"]
            for c in notebooks.code_cells(notebook)
            for o in c.outputs
            if "image/png" in o.get("data", {})
        ]
        assert text.count("<img ") == len(stored) == len(list((built / "images").glob(f"{name}-[0-9]*.png")))
        shown = plain(text)
        for cell in notebooks.code_cells(notebook):
            for line in cell.source.splitlines():
                assert line.strip() in shown
            for output in cell.outputs:
                if output.output_type == "stream":
                    assert output.text.strip().splitlines()[0].strip() in shown


def test_nothing_is_loaded_from_elsewhere(built: Path) -> None:
    all_pages = pages(built)
    for name, page in all_pages.items():
        assert page.open == []
        for address in page.loads:
            assert (built / address).is_file(), f"{name} loads {address}"
        for address in page.links:
            file, _, place = address.partition("#")
            if address.startswith("https://"):
                continue
            assert "://" not in address
            assert not file or (built / file).is_file(), f"{name} leads to {address}"
            assert not place or place in all_pages[file or name].ids, f"{name} leads to {address}"
        assert not {"object", "embed", "video"} & set(page.seen)
        assert page.seen.count("script") == (name == "index.html"), "the search alone is a script"
    for view in (built / "images").glob("*.html"):
        text = view.read_text(encoding="utf-8")
        assert "default-src 'none'" in text, "a view asks for nothing"
        assert not re.search(r"\b(?:src|href)=", text)
    style = (built / "site.css").read_text(encoding="utf-8")
    assert re.findall(r"url\((.*?)\)", style) == ['"math.woff"']
    assert "@import" not in style
    assert "http" not in style


def test_no_tex_is_left(built: Path) -> None:
    for path in built.glob("*.html"):
        text = re.sub(r"<pre.*?</pre>|<code.*?</code>", "", path.read_text(encoding="utf-8"), flags=re.S)
        assert "$" not in plain(text), path.name
        assert not re.search(r"\\[a-zA-Z]", plain(text)), path.name


def test_the_index_shows_every_figure_and_every_claim(built: Path) -> None:
    text = (built / "index.html").read_text(encoding="utf-8")
    for name in notebooks.names(ROOT):
        assert f'<a href="{name}.html"><div class="picture">' in text
    for claim in claims.read(ROOT):
        assert claim.says in plain(text)
    rows = re.findall(r'<td data-label="here">(.*?)</td>', text, re.S)
    assert len(rows) == len(claims.read(ROOT))
    numbered = [claim for claim in claims.read(ROOT) if claim.figure]
    assert sum(bool(row) for row in rows) == len(numbered)
    for claim in numbered[:5]:
        assert claims.ours(ROOT, claim) in plain(text)
    for picture in (built / "images").glob("*-small.jpg"):
        with Image.open(picture) as image:
            assert max(image.size) <= site.THUMBNAIL
            assert np.asarray(image.convert("L")).std() > 3
    assert sum(path.stat().st_size for path in built.rglob("*")) < 30e6


def test_it_is_the_same_each_time_and_replaces_itself_only(built: Path, tmp_path: Path) -> None:
    before = {path.relative_to(built): path.read_bytes() for path in built.rglob("*") if path.is_file()}
    (built / "old.html").write_text("left over")
    site.build(ROOT, built)
    after = {path.relative_to(built): path.read_bytes() for path in built.rglob("*") if path.is_file()}
    assert after == before
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear")
    with pytest.raises(OutputError, match="no earlier site"):
        site.build(ROOT, tmp_path / "mine")
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["letter.txt"]


def test_the_search_finds_pages_and_claims(chromium: Any, built: Path) -> None:
    shown = "[...document.querySelectorAll('{}')].filter((e) => e.getClientRects().length).length"
    with opened(chromium, built / "index.html", DESK) as it:
        cards, rows = it.do(shown.format(".cards li")), it.do(shown.format(".claims tbody tr"))
        assert (cards, rows) == (len(notebooks.names(ROOT)), len(claims.read(ROOT)))
        it.page.fill("#search", "Integrating  FACTOR")
        found = it.do("[...document.querySelectorAll('#found a')].map((e) => e.getAttribute('href'))")
        assert "fig13_rescaling.html" in found
        assert "making.html" not in found
        assert len(found) < len(notebooks.names(ROOT))
        assert it.do(shown.format(".cards li")) == sum(each[:-5] not in DOCUMENTS for each in found)
        assert 0 < it.do(shown.format(".claims tbody tr")) < rows
        assert it.do("document.getElementById('said').textContent").startswith(f"{len(found)} pages, ")
        it.page.fill("#search", "veneer-laser")
        assert it.do("document.querySelector('#found a').getAttribute('href')") == "making.html"
        it.page.fill("#search", "qqqq")
        assert it.do("document.getElementById('said').textContent") == "0 pages, 0 claims"
        it.page.fill("#search", "")
        assert it.do(shown.format(".cards li")) == cards
        assert it.do("document.querySelectorAll('#found li').length") == 0


def test_what_a_notebook_may_hold() -> None:
    v4 = nbformat.v4
    code = v4.new_code_cell("1 / 0", metadata={"tags": ["parameters"]})
    code.outputs = [
        v4.new_output("stream", name="stdout", text="<b>bold</b>\n"),
        v4.new_output("error", ename="E", evalue="x", traceback=["\x1b[31mTraceback\x1b[0m", "E: <x>"]),
        v4.new_output("display_data", data={"text/plain": "<Axes>", "text/html": "<script>1</script>"}),
        v4.new_output("stream", name="stdout", text="\n"),
    ]
    notebook = v4.new_notebook(
        cells=[v4.new_markdown_cell("# On $s$ & more\n\n**The question.** Why $s$?"), code]
    )
    page = site.page_of(notebook, "probe")
    assert (page.title, plain(page.question)) == ("On s & more", "Why s?")
    assert "<summary>parameters, 1 line</summary>" in page.body
    boxes = re.findall(r'<pre class="out" tabindex="0">(.*?)</pre>', page.body, re.S)
    assert boxes == ["&lt;b&gt;bold&lt;/b&gt;", "Traceback\nE: &lt;x&gt;", "&lt;Axes&gt;"]
    assert Reader(page.body).open == []
    said = "<title>a &amp; b</title>"
    view = f'<iframe srcdoc="{said.replace("&", "&amp;")}" title="a" style="x"></iframe>\n<p>words</p>'
    code.outputs = [v4.new_output("execute_result", data={"text/plain": "Turned('a')", "text/html": view})]
    page = site.page_of(notebook, "probe")
    assert page.pictures == {"probe-view-1.html": said.encode()}
    assert 'src="images/probe-view-1.html" title="a"' in page.body
    assert "Turned" not in page.body
    with pytest.raises(NotebookError, match="lacks a part"):
        site.page_of(v4.new_notebook(cells=[v4.new_markdown_cell(r"$\frac{1}$")]), "probe")


def test_the_command_says_where_it_is(
    built: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert site.main(["-o", str(tmp_path / "there")]) == 0
    assert f"{tmp_path / 'there' / 'index.html'}: " in capsys.readouterr().out
    (tmp_path / "file").write_text("")
    assert site.main(["-o", str(tmp_path / "file")]) == 2
    assert "no earlier site" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["index", "fig12_recover", "table1", "making", "deviations"])
@pytest.mark.parametrize("size", [PHONE, DESK], ids=["phone", "desk"])
def test_it_reads_well(chromium: Any, built: Path, name: str, size: tuple[int, int]) -> None:
    with opened(chromium, built / f"{name}.html", size) as it:
        it.do("document.querySelectorAll('details').forEach((each) => { each.open = true; })")
        it.do("document.querySelectorAll('img').forEach((each) => { each.loading = 'eager'; })")
        it.wait("[...document.images].every((each) => each.complete && each.naturalWidth > 0)")
        assert it.errors == []
        assert {url.split(":")[0] for url in it.requests} <= {"file", "data"}
        assert it.fits()
        # Wide things scroll in boxes of their own; everything else is inside the page.
        wide = it.do(
            "[...document.querySelectorAll('body *')].filter((e) =>"
            " !e.closest('pre, .equation, .claims, .text table, math') &&"
            " e.getBoundingClientRect().right > window.innerWidth + 1).map((e) => e.outerHTML.slice(0, 80))"
        )
        assert wide == []
        assert it.do("!document.querySelector('math') || document.fonts.check('16px \"site math\"')")
        assert it.do("[...document.images].every((each) => each.clientWidth <= window.innerWidth)")
        sizes = it.do(
            "[...document.querySelectorAll('p')].map((e) => parseFloat(getComputedStyle(e).fontSize))"
        )
        assert min(sizes) >= 14
        # Equations have a size and are no text in a row: exponents stand higher than what they belong to.
        places = it.do(
            "[...document.querySelectorAll('msup')].map((e) => [e.children[0].getBoundingClientRect().bottom,"
            " e.children[1].getBoundingClientRect().bottom])"
        )
        assert all(above < below for below, above in places)
        if name == "fig12_recover":
            assert len(places) > 5
