"""Operators of a page: every text is there in letters, as high and as wide as its strokes."""

from __future__ import annotations

import re

import numpy as np
import pypdfium2 as pdfium
import pytest
from laidflat import NAMES, patterns, sheet

from geoweave.fabrication.colours import Colours
from geoweave.fabrication.pdf import FOOT, MARGIN, pdf_bytes
from geoweave.fabrication.pdf_marks import CAPITAL, strip_operators
from geoweave.fabrication.pieces import Making
from geoweave.fabrication.sheet_sizes import Paper

OPERATOR = r"BT /F1 (\S+) Tf \S+ Tz (\S+) (\S+) \S+ \S+ (\S+) (\S+) Tm \(([^)]*)\) Tj"


@pytest.mark.parametrize("name", NAMES)
def test_every_text_is_written_where_it_stands(name: str) -> None:
    page = sheet(name)
    found = re.findall(OPERATOR, "\n".join(strip_operators(page, Colours("paper"), 12.0, 33.0)))
    wanted = [f for laid in page.laid for f in laid.figures if f.text]
    assert sorted(each[-1] for each in found) == sorted(f.text for f in wanted)
    for size, c, s, x, y, text in found:
        high = CAPITAL * float(size)
        assert high >= 1.8 - 1e-3
        # Half a letter above the corner where the text begins is the left end of its strokes.
        start = [float(x) - 12 - 0.5 * high * float(s), float(y) - 33 + 0.5 * high * float(c)]
        off = []
        for figure in wanted:
            if figure.text == text and figure.spot is not None:
                points = np.concatenate(figure.paths)
                if figure.spot.turn:
                    off.append(np.hypot(figure.spot.x - start[0], points[:, 1].min() - start[1]))
                else:
                    off.append(np.hypot(points[:, 0].min() - start[0], figure.spot.y - start[1]))
        assert min(off) < 0.35 * high


def test_holes_are_closed_curves_of_their_size() -> None:
    page = sheet("flat", Making(holes=2.0))
    code = strip_operators(page, Colours("paper"), 0.0, 0.0)
    rings = [each for each in code if each.count(" c") == 4]
    assert len(rings) == sum(figure.role == "hole" for laid in page.laid for figure in laid.figures)
    for ring in rings:
        numbers = np.array(re.findall(r"-?[\d.]+", ring), dtype=np.float64).reshape(-1, 2)
        assert np.ptp(numbers, axis=0) == pytest.approx([2.0, 2.0], abs=2e-3)
        np.testing.assert_allclose(numbers[0], numbers[-1], atol=1e-9)


def test_numbers_have_no_exponents() -> None:
    """A page knows none: the cosine of a right angle, as 6e-17, made names that read upwards vanish."""
    turned = 0
    for name in NAMES:
        page = sheet(name)
        turned += sum(bool(f.spot and f.spot.turn) for laid in page.laid for f in laid.figures if f.text)
        for line in strip_operators(page, Colours("paper"), 0.0, 0.0):
            numbers = re.sub(r"\([^)]*\) Tj", "", line)
            assert not re.search(r"[\d.]e[-+]?\d", numbers), line
    assert turned


def test_a_name_that_reads_upwards_is_seen() -> None:
    """Drawn by a program that knows nothing of ours: ink where its strokes are."""
    name, piece, plain = next(
        (name, laid, f)
        for name in NAMES
        for laid in sheet(name).laid
        for f in laid.drawn.figures
        if f.role == "label" and f.spot is not None and f.spot.turn
    )
    figure = plain.moved(piece.x, piece.y)
    page, paper, out = sheet(name), Paper("test", 400.0, 300.0), 10
    alone = page._replace(laid=(piece._replace(drawn=piece.drawn._replace(figures=(plain,))),))
    data = pdf_bytes(patterns()[name], [alone], paper, Colours("paper"), "test")
    with pdfium.PdfDocument(data) as document:
        picture = np.asarray(document[0].render(scale=out * 25.4 / 72).to_pil().convert("L"), dtype=float)
    points = np.concatenate(figure.paths) + [MARGIN, MARGIN + FOOT]
    (left, low), (right, high) = points.min(axis=0), points.max(axis=0)
    rows = slice(int(out * (paper.height - high)), int(out * (paper.height - low)))
    assert (picture[rows, int(out * left) : int(out * right)] < 160).mean() > 0.1
