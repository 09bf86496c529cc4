"""Pages of a PDF in a gallery: size, crop, frame, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from laidflat import patterns
from reportlab.pdfgen.canvas import Canvas

from geoweave import viz
from geoweave.errors import RenderError
from geoweave.viz import style

MM = 72 / 25.4


@pytest.fixture
def sheet(tmp_path: Path) -> Path:
    """Two pages of 200 x 100 mm; on the second a red square of 20 mm, 30 mm from its left."""
    path = tmp_path / "sheet.pdf"
    canvas = Canvas(str(path), pagesize=(200 * MM, 100 * MM))
    canvas.showPage()
    canvas.setFillColorRGB(1, 0, 0)
    canvas.rect(30 * MM, 70 * MM, 20 * MM, 20 * MM, stroke=0, fill=1)
    canvas.showPage()
    canvas.save()
    return path


def red(pixels: np.ndarray) -> np.ndarray:
    return (pixels[..., 0] > 200) & (pixels[..., 1] < 60)


def test_a_page_is_drawn_where_its_ink_is(sheet: Path) -> None:
    page = viz.Page(sheet, 2)
    assert page.size == pytest.approx((200, 100), abs=0.01)
    pixels = page.draw(200)  # two pixels a millimetre
    assert pixels.shape == (200, 400, 3)
    rows, columns = np.nonzero(red(pixels))
    assert (rows.min(), rows.max() + 1) == pytest.approx((20, 60), abs=1)
    assert (columns.min(), columns.max() + 1) == pytest.approx((60, 100), abs=1)
    assert not red(viz.Page(sheet, 1).draw(200)).any()


def test_a_part_of_a_page_fills_the_picture(sheet: Path) -> None:
    page = viz.Page(sheet, 2, crop=(30, 10, 50, 20), frame=False)
    assert page.aspect == pytest.approx(2)
    assert red(page.draw(100))[2:-2, 2:-2].all()


def test_a_frame_shows_where_the_paper_ends(sheet: Path) -> None:
    pixels = viz.Page(sheet, 1).draw(50)
    edge = tuple(int(style.LINE[k : k + 2], 16) for k in (1, 3, 5))
    assert tuple(pixels[0, 7]) == tuple(pixels[7, -1]) == edge
    assert tuple(pixels[25, 50]) == (255, 255, 255)


def test_what_is_no_page_is_refused(sheet: Path, tmp_path: Path) -> None:
    with pytest.raises(RenderError, match=r"sheet.pdf: has 2 pages, there is no page 3"):
        viz.Page(sheet, 3).draw(10)
    with pytest.raises(RenderError, match=r"does not lie on page 1, which is 200.0 x 100.0 mm"):
        _ = viz.Page(sheet, 1, crop=(0, 0, 300, 10)).part
    text = tmp_path / "text.pdf"
    text.write_text("no PDF")
    with pytest.raises(RenderError, match=r"text.pdf: cannot be read as a PDF"):
        viz.Page(text).draw(10)


def test_pages_and_scenes_share_a_gallery(sheet: Path) -> None:
    picture = viz.gallery([viz.Page(sheet, 1), viz.Page(sheet, 2)], [("one", ""), ("two", "")], alt="Pages")
    assert picture.alt == "Pages"


def test_parts_of_strips_lie_under_each_other(tmp_path: Path) -> None:
    pattern = patterns()["flat"]
    page = viz.strips_page(tmp_path / "near.pdf", pattern, [0, 4], [75.0, 60.0], 30.0)
    assert page.aspect == pytest.approx(60.0 / (3 * 2 * pattern.width))
    pixels = page.draw(480).astype(int)
    dark = (pixels.sum(axis=2) < 150).mean(axis=1) > 0.9  # the edges of two strips, right across
    edges = np.flatnonzero(np.diff(dark.astype(int)) == 1) * 6 * pattern.width / 480
    assert edges[1] - edges[0] == pytest.approx(pattern.width, abs=0.2)
    assert edges[2] - edges[0] == pytest.approx(2 * pattern.width, abs=0.2)
    assert len(edges) == 4
    with pytest.raises(RenderError, match=r"2 strips cannot be drawn about 1 middle"):
        viz.strips_page(tmp_path / "near.pdf", pattern, [0, 4], [75.0], 30.0)
