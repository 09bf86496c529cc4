"""The PDF, read back with another library: true scale, ruler, crosses, lengths, pieces, same bytes."""

from __future__ import annotations

import ctypes
from functools import cache

import numpy as np
import pypdfium2 as pdfium
import pypdfium2.raw as raw
import pytest
from laidflat import patterns
from numpy.typing import NDArray

from geoweave.errors import FieldError
from geoweave.fabrication.colours import INK, Colours
from geoweave.fabrication.nesting import Sheet
from geoweave.fabrication.pdf import CROSS, RULER, laid_on_pages, page_stock, pdf_bytes
from geoweave.fabrication.pieces import Making, Piece, pieces_of
from geoweave.fabrication.sheet_sizes import PAPERS, Paper
from geoweave.fabrication.strip_drawing import drawn

MM = 72 / 25.4
OVERLAP = 15.0


@cache
def pages(name: str, paper: str) -> tuple[Sheet, ...]:
    pattern, how = patterns()[name], Making(overlap=OVERLAP)
    pieces = pieces_of(pattern, how, page_stock(PAPERS[paper]).room)
    return laid_on_pages([drawn(pattern, piece, how) for piece in pieces], PAPERS[paper])


@cache
def data(name: str, paper: str) -> bytes:
    return pdf_bytes(patterns()[name], pages(name, paper), PAPERS[paper], Colours("paper"), f"The {name}")


def outlines(page: pdfium.PdfPage) -> list[NDArray[np.float64]]:
    """(4, 2) corners in mm of the closed lines 0.2 mm wide in the ink of an outline, as they are drawn."""
    found = []
    for shape in page.get_objects(filter=[raw.FPDF_PAGEOBJ_PATH]):
        width, colour = ctypes.c_float(), [ctypes.c_uint() for _ in range(4)]
        raw.FPDFPageObj_GetStrokeWidth(shape, width)
        raw.FPDFPageObj_GetStrokeColor(shape, *colour)
        count = raw.FPDFPath_CountSegments(shape)
        ink = "#" + "".join(f"{each.value:02x}" for each in colour[:3])
        if abs(width.value - 0.2) > 1e-4 or ink != INK or count not in (4, 5):
            continue
        points = []
        for k in range(4):
            x, y = ctypes.c_float(), ctypes.c_float()
            raw.FPDFPathSegment_GetPoint(raw.FPDFPath_GetPathSegment(shape, k), x, y)
            points.append((x.value, y.value, 1.0))
        matrix = shape.get_matrix()
        turn = np.array([[matrix.a, matrix.b], [matrix.c, matrix.d], [matrix.e, matrix.f]])
        found.append(np.array(points) @ turn / MM)
    return found


@pytest.mark.parametrize("name", ["flat", "circles", "cone"])
@pytest.mark.parametrize("paper", list(PAPERS))
def test_drawn_pieces_add_up_to_their_ribbons(name: str, paper: str) -> None:
    pattern = patterns()[name]
    document = pdfium.PdfDocument(data(name, paper))
    assert len(document) == len(pages(name, paper))
    total: dict[int, float] = {}
    for page, sheet in zip(document, pages(name, paper), strict=True):
        assert page.get_size() == pytest.approx(
            (PAPERS[paper].width * MM, PAPERS[paper].height * MM), abs=0.01
        )
        cut = outlines(page)
        assert len(cut) == len(sheet.laid)
        for corners, laid in zip(cut, sheet.laid, strict=True):
            size, piece = np.ptp(corners, axis=0), laid.drawn.piece
            np.testing.assert_allclose(size, [piece.length, pattern.width], atol=0.02)
            assert corners.min() > CROSS + 3
            more = OVERLAP if any(join.ahead for join in piece.joins) else 0.0
            total[piece.strip] = total.get(piece.strip, 0.0) + float(size[0]) - more
    assert [total[r] for r in range(len(total))] == pytest.approx([s.length for s in pattern.strips], abs=0.1)


def test_long_strips_are_spliced() -> None:
    """A great circle of 377 mm needs two pieces on A4, and the text of a page names all that is on it."""
    pieces: list[Piece] = [laid.drawn.piece for page in pages("circles", "a4") for laid in page.laid]
    assert sorted((piece.strip, piece.number, piece.total) for piece in pieces) == [
        (strip, number, 2) for strip in range(3) for number in (1, 2)
    ]


@pytest.mark.parametrize("paper", list(PAPERS))
def test_the_ruler_is_a_hundred_millimetres_at_100_dpi(paper: str) -> None:
    document = pdfium.PdfDocument(data("cone", paper))
    for page in document:
        image = np.asarray(page.render(scale=100 / 72).to_pil().convert("L"), dtype=float)
        row = round((PAPERS[paper].height - RULER[1]) / 25.4 * 100)
        left = round(RULER[0] / 25.4 * 100)
        bar = image[row - 1 : row + 2, left - 20 : left + 430].min(axis=0)
        dark = np.flatnonzero(bar < 128)
        assert dark[-1] - dark[0] + 1 == pytest.approx(394, abs=1)
        assert (np.diff(dark) == 1).all()


@pytest.mark.parametrize("paper", list(PAPERS))
def test_crosses_are_in_the_corners_of_every_page(paper: str) -> None:
    width, height, _ = PAPERS[paper].width, PAPERS[paper].height, None
    for page in pdfium.PdfDocument(data("circles", paper)):
        image = np.asarray(page.render(scale=200 / 72).to_pil().convert("L"), dtype=float)
        for x in (CROSS, width - CROSS):
            for y in (CROSS, height - CROSS):
                column, row = (round(each / 25.4 * 200) for each in (x, height - y))
                window = image[row - 20 : row + 21, column - 20 : column + 21]
                dark_row, dark_column = window.mean(axis=1).argmin(), window.mean(axis=0).argmin()
                assert abs(dark_row - 20) <= 1
                assert abs(dark_column - 20) <= 1
                assert window.min() < 160


def test_pages_say_what_they_are() -> None:
    document = pdfium.PdfDocument(data("circles", "letter"))
    for number, page in enumerate(document, 1):
        text = page.get_textpage().get_text_bounded()
        assert f"page {number} of {len(document)}" in text
        assert "US Letter" in text
        assert "100 mm" in text
        assert "265.4 x 201.9 mm" in text
    assert document.get_metadata_dict()["Title"] == "The circles"


def test_the_page_map_shows_every_page_and_frames_this_one() -> None:
    """In the map the drawn frames are one per page, and one of them is heavier."""
    document = pdfium.PdfDocument(data("circles", "a4"))
    assert len(document) >= 1
    for page in document:
        frames = []
        for shape in page.get_objects(filter=[raw.FPDF_PAGEOBJ_PATH]):
            width = ctypes.c_float()
            raw.FPDFPageObj_GetStrokeWidth(shape, width)
            left, bottom, right, top = (each / MM for each in shape.get_bounds())
            ratio = (right - left) / max(top - bottom, 1e-9)
            if left > 185 and top < 34 and abs(ratio - 297 / 210) < 0.05 and right - left > 3:
                frames.append(round(width.value, 3))
        assert sorted(frames) == [0.12] * (len(document) - 1) + [0.35]


def test_over_and_under_differ_at_a_glance() -> None:
    """The marks of a strip that goes under are dark inside, those of one that goes over are white."""
    pattern = patterns()["flat"]
    scale = 200 / 25.4
    for page, sheet in zip(pdfium.PdfDocument(data("flat", "a4")), pages("flat", "a4"), strict=True):
        image = np.asarray(page.render(scale=200 / 72).to_pil().convert("L"), dtype=float)
        for laid in sheet.laid:
            for figure in laid.figures:
                if figure.role in ("hollow", "solid") and int(pattern.mark[figure.crossing]) in (0, 2):
                    x, y = figure.paths[0].mean(axis=0) + [12.0, 33.0]
                    shade = image[round((210 - y) * scale), round(x * scale)]
                    assert (shade < 140) == (figure.role == "solid")


def test_the_same_weave_gives_the_same_bytes() -> None:
    again = pdf_bytes(patterns()["flat"], pages("flat", "a4"), PAPERS["a4"], Colours("paper"), "The flat")
    assert again == data("flat", "a4")


def test_a_page_without_room_for_its_foot_is_refused() -> None:
    paper = Paper("a strip of paper", 120.0, 200.0)
    with pytest.raises(FieldError, match=r"a page 120 mm wide has no room .* take one of 217 mm or more"):
        pdf_bytes(patterns()["flat"], pages("flat", "a4"), paper, Colours("paper"), "narrow")
