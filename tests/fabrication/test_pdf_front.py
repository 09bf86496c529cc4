"""The first pages say where each strip is, and it is there; what has no room on a strip is in the key."""

from __future__ import annotations

import re
from pathlib import Path

import pypdfium2 as pdfium
import pytest
from laidflat import NAMES, patterns
from reportlab.pdfbase.pdfmetrics import stringWidth

from geoweave.fabrication.bench import Bench
from geoweave.fabrication.pdf_front import (
    COLUMN,
    KEY_LETTERS,
    LETTERS,
    front_count,
    key_text,
    page_key,
    piece_name,
)
from geoweave.fabrication.pieces import Making
from geoweave.fabrication.sheet_sizes import PAPERS
from geoweave.fabrication.strip_layout import StripLayout

ENTRY = re.compile(r"^([A-Z]+\d+(?: \d+/\d+)?): page (\d+), row (\d+)", re.MULTILINE)


def laid(name: str, making: Making | None = None) -> StripLayout:
    return StripLayout(patterns()[name], Bench(making or Making(), papers=("a4",)), media=("a4",))


@pytest.mark.parametrize("name", NAMES)
def test_the_index_is_true(name: str, tmp_path: Path) -> None:
    layout = laid(name)
    (path,) = layout.save(tmp_path / "pattern.pdf")
    texts = [page.get_textpage().get_text_range() for page in pdfium.PdfDocument(path)]
    index = {label: (page, row) for label, page, row in ENTRY.findall(texts[0].replace("\r", ""))}
    assert set(index) == {piece_name(layout.pattern, each.piece) for each in layout.drawings}
    pages = layout.pages("a4")
    for number, page in enumerate(pages, len(texts) - len(pages) + 1):
        tops = sorted({round(each.y, 6) for each in page.laid}, reverse=True)
        for each in page.laid:
            label = piece_name(layout.pattern, each.drawn.piece)
            assert index[label] == (str(number), str(tops.index(round(each.y, 6)) + 1))
            if each.drawn.named:
                assert f"{label} >" in texts[number - 1]


def test_the_key_holds_what_is_not_on_the_strips() -> None:
    layout = laid("often")
    lines = "\n".join(line.text for line in layout.front("a4"))
    assert any(drawing.key for drawing in layout.drawings)
    for drawing in layout.drawings:
        for line in drawing.key:
            assert re.search(rf"{line.at:.0f} .*{line.label} {'over' if line.over else 'under'}", lines)
    bare = "\n".join(line.text for line in laid("often", Making(labels="none")).front("a4"))
    assert "Key" not in bare


def test_a_page_has_the_key_of_its_own_marks(tmp_path: Path) -> None:
    """Nobody turns back to the first page for what three marks mean; if there are many, the page says so."""
    layout = laid("often")
    (path,) = layout.save(tmp_path / "pattern.pdf")
    texts = [page.get_textpage().get_text_range() for page in pdfium.PdfDocument(path)]
    pages = layout.pages("a4")
    assert any(piece.drawn.key for page in pages for piece in page.laid)
    for page, text in zip(pages, texts[len(texts) - len(pages) :], strict=True):
        own = [f"row {each.row} at {line}" for each in page.laid for line in key_text(each.drawn)]
        flat = " ".join(text.split())
        shown = [line for line in own if line in flat]
        more = re.search(r"(\d+) more in the key in front", flat)
        assert len(own) - len(shown) == (int(more[1]) if more else 0)
        assert shown or not own
        assert ("Marks without a name" in flat) == bool(own)


@pytest.mark.parametrize("wide", [90.0, 172.0, 400.0])
def test_the_key_of_a_page_keeps_to_its_lines(wide: float) -> None:
    for page in laid("often").pages("a4"):
        lines = page_key(page, wide)
        assert len(lines) <= 2
        for line in lines:
            assert stringWidth(line, "Helvetica", KEY_LETTERS) <= wide


def test_splices_are_explained_where_there_are_any() -> None:
    spliced = " ".join(line.text for line in laid("circles").front("a4"))
    assert "is the first of two pieces" in spliced
    whole = " ".join(line.text for line in laid("flat").front("a4"))
    assert "is the first of two pieces" not in whole


@pytest.mark.parametrize("name", NAMES)
def test_lines_stay_in_their_columns(name: str) -> None:
    front = laid(name).front("a4")
    for line in front:
        font = "Helvetica-Bold" if line.bold else "Helvetica"
        assert stringWidth(line.text, font, LETTERS) < COLUMN
    assert front_count(front, PAPERS["a4"]) == 1
