"""Pages to print at true scale: strips, crosses in the corners, a ruler, a legend, a map of the pages."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from os import PathLike
from typing import TYPE_CHECKING

import numpy as np

from geoweave.errors import FieldError
from geoweave.fabrication.colours import INK, Colours, mixed
from geoweave.fabrication.marks import outline
from geoweave.fabrication.nesting import Sheet, Stock, nested
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.pdf_front import KEY_LETTERS, Line, draw_front, front_count, page_key
from geoweave.fabrication.pdf_marks import pdf_colour, strip_operators
from geoweave.fabrication.sheet_sizes import Paper
from geoweave.fabrication.strip_figures import Drawn
from geoweave.files import replacing

if TYPE_CHECKING:
    from reportlab.pdfgen.canvas import Canvas

__all__ = ["RULER", "laid_on_pages", "page_stock", "pdf_bytes", "write_pdf"]

MM = 72 / 25.4
"""Points in a millimetre."""

FAINT = "#6e747b"
MARGIN, FOOT, CROSS = 12.0, 21.0, 7.0
"""Margin of a page, height of what stands below the strips, and the crosses' distance from the edges, mm."""

RULER = (14.0, 20.0, 100.0)
"""Where the ruler begins and how long it is, mm."""

KEY_TOP, KEY_STEP, KEY_END = 30.4, 2.7, 188.0
"""Where the key of a page begins, the distance of its lines, and where the map of the pages begins, mm."""


def page_stock(paper: Paper) -> Stock:
    """Room for strips on a page."""
    return Stock(paper.width - 2 * MARGIN, paper.height - 2 * MARGIN - FOOT, margin=0.5, gap=1.5)


def laid_on_pages(drawings: Sequence[Drawn], paper: Paper) -> tuple[Sheet, ...]:
    """Lay pieces on pages."""
    return nested(drawings, page_stock(paper))


def write_pdf(
    path: str | PathLike[str],
    pattern: Pattern,
    pages: Sequence[Sheet],
    paper: Paper,
    colours: Colours,
    title: str,
    front: Sequence[Line] = (),
    mirror: bool = False,
    keyed: bool = True,
) -> None:
    """Write pages as PDF, whole or not at all.

    Parameters
    ----------
    path : of the file
    pattern : the strips
    pages : what lies on each page
    paper : that the pages were laid out for, one of `geoweave.fabrication.PAPERS`
    colours : of the families
    title : stands on each page
    front : lines of the first pages, which are numbered with the others
    mirror : whether the strips are drawn as seen from the inside
    keyed : whether the key of a page stands below its strips

    Examples
    --------
    >>> import pathlib, tempfile
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=100.0)
    >>> laid, fabrication = gw.fabrication.layout(weave), gw.fabrication
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = pathlib.Path(folder) / "cone.pdf"
    ...     pages, paper = laid.pages("a4"), fabrication.PAPERS["a4"]
    ...     fabrication.write_pdf(path, laid.pattern, pages, paper, fabrication.Colours("paper"), "cone")
    ...     path.read_bytes()[:5]
    b'%PDF-'
    """
    data = pdf_bytes(pattern, pages, paper, colours, title, front, mirror, keyed)
    with replacing(path) as temporary:
        temporary.write_bytes(data)


def pdf_bytes(
    pattern: Pattern,
    pages: Sequence[Sheet],
    paper: Paper,
    colours: Colours,
    title: str,
    front: Sequence[Line] = (),
    mirror: bool = False,
    keyed: bool = True,
) -> bytes:
    """The file, without a date: the same pages give the same bytes."""
    # The library is loaded by those who write pages only.
    from reportlab.pdfgen.canvas import Canvas
    from reportlab.pdfgen.pathobject import PDFPathObject

    out = io.BytesIO()
    before = front_count(front, paper)
    total = before + len(pages)
    with _binary():
        canvas = Canvas(out, pagesize=(paper.width * MM, paper.height * MM), invariant=1, pageCompression=1)
        canvas.setTitle(title)
        canvas.setCreator("geoweave")
        for number in range(total):
            canvas.saveState()
            canvas.scale(MM, MM)
            canvas.setLineCap(1)
            canvas.setLineJoin(1)
            if number < before:
                draw_front(canvas, front, paper, number)
            else:
                page = pages[number - before]
                code = strip_operators(page, colours, MARGIN, MARGIN + FOOT)
                canvas.drawPath(PDFPathObject(code=code), stroke=0, fill=0)
                _row_numbers(canvas, page)
                _crosses(canvas, paper)
                if keyed:
                    _key(canvas, page)
                _ruler(canvas)
                _legend(canvas, pattern, paper, colours, mirror)
                _map(canvas, pattern, pages, number - before, paper, colours)
            canvas.setFillColor(pdf_colour(INK))
            canvas.setFont("Helvetica-Bold", 2.6)
            right = paper.width - MARGIN - 2
            canvas.drawRightString(right, 13.2, f"{title}   {paper.name}   page {number + 1} of {total}")
            canvas.restoreState()
            canvas.showPage()
        canvas.save()
    return out.getvalue()


@contextmanager
def _binary() -> Iterator[None]:
    """Streams as they are, not written as letters; the switch of the library goes back to what it was."""
    from reportlab import rl_config

    before = rl_config.useA85
    rl_config.useA85 = 0
    try:
        yield
    finally:
        rl_config.useA85 = before


def _row_numbers(canvas: Canvas, page: Sheet) -> None:
    """The number of each row, left of it, as the index says it."""
    canvas.setFillColor(pdf_colour(FAINT))
    canvas.setFont("Helvetica", 2.3)
    rows = {laid.row: laid.y for laid in reversed(page.laid)}
    for row, y in rows.items():
        canvas.drawRightString(MARGIN - 1.0, MARGIN + FOOT + y - 0.8, str(row))


def _key(canvas: Canvas, page: Sheet) -> None:
    """What the marks of this page mean that have no name beside them."""
    canvas.setFillColor(pdf_colour(INK))
    canvas.setFont("Helvetica", KEY_LETTERS)
    for k, line in enumerate(page_key(page, KEY_END - RULER[0])):
        canvas.drawString(RULER[0], KEY_TOP - k * KEY_STEP, line)


def _crosses(canvas: Canvas, paper: Paper) -> None:
    """Registration marks in the corners."""
    canvas.setStrokeColor(pdf_colour(INK))
    canvas.setLineWidth(0.12)
    for x in (CROSS, paper.width - CROSS):
        for y in (CROSS, paper.height - CROSS):
            canvas.circle(x, y, 1.2, stroke=1, fill=0)
            canvas.line(x - 2, y, x + 2, y)
            canvas.line(x, y - 2, x, y + 2)


def _ruler(canvas: Canvas) -> None:
    """A hundred millimetres, to be measured after printing; the black bar is as long as it says."""
    x, y, length = RULER
    canvas.setFillColor(pdf_colour(INK))
    canvas.setStrokeColor(pdf_colour(INK))
    canvas.rect(x, y - 0.3, length, 0.6, stroke=0, fill=1)
    canvas.setLineWidth(0.12)
    canvas.setLineCap(0)
    for tick in range(101):
        if 0 < tick < 100:
            tall = 2.6 if tick % 10 == 0 else 1.8 if tick % 5 == 0 else 1.1
            canvas.line(x + tick, y, x + tick, y + tall)
    canvas.setLineCap(1)
    canvas.setFont("Helvetica", 2.3)
    for tick in range(10, 100, 10):
        canvas.drawCentredString(x + tick, y + 3.2, str(tick))
    canvas.setFillColor(pdf_colour(FAINT))
    canvas.drawString(x, y - 3.4, "The bar is 100 mm long. Print at 100 %, without fitting to the page.")


def _legend(canvas: Canvas, pattern: Pattern, paper: Paper, colours: Colours, mirror: bool) -> None:
    """What over and under look like."""
    families = sorted({strip.family for strip in pattern.strips})
    own, other = (colours.of_family(families[k % len(families)]) for k in (0, 1))
    x, y, half = 122.0, 20.6, 2.6
    lean = half / math.tan(math.radians(60))
    dark = mixed(other, INK, 0.62)
    for over, left in ((False, x), (True, x + 31)):
        canvas.setFillColor(pdf_colour(mixed(own, "#ffffff", 0.16)))
        canvas.rect(left, y - half, 11, 2 * half, stroke=0, fill=1)
        if not over:
            _polygon(
                canvas,
                [(left + 5.5 + s * 3 + t * lean, y + t * half) for s, t in _CORNERS],
                mixed(other, "#ffffff", 0.42),
                None,
            )
        canvas.setStrokeColor(pdf_colour(dark))
        canvas.setLineWidth(0.16)
        if over:
            canvas.setDash([0.6, 0.5])
        for shift in (-3.0, 3.0) if over else (-3.0, -2.6, 2.6, 3.0):
            canvas.line(left + 5.5 + shift - lean, y - half, left + 5.5 + shift + lean, y + half)
        canvas.setDash()
        canvas.setStrokeColor(pdf_colour(INK))
        canvas.line(left, y - half, left + 11, y - half)
        canvas.line(left, y + half, left + 11, y + half)
        star = 1.3 * outline(3) + [left + 5.5, y]
        _polygon(canvas, star.tolist(), "#ffffff" if over else dark, dark)
        canvas.setFillColor(pdf_colour(INK))
        canvas.setFont("Helvetica", 2.3)
        canvas.drawString(left + 12.2, y + 0.4, "this strip goes")
        canvas.setFont("Helvetica-Bold", 2.3)
        canvas.drawString(left + 12.2, y - 2.4, "over" if over else "under")
    canvas.setFillColor(pdf_colour(FAINT))
    canvas.setFont("Helvetica", 2.3)
    apart = (paper.width - 2 * CROSS, paper.height - 2 * CROSS)
    side = "inwards" if mirror else "outwards"
    canvas.drawString(
        x, 16.6 - 3.2, f"Printed side {side}. Corner crosses are {apart[0]:g} x {apart[1]:g} mm apart."
    )


_CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def _polygon(canvas: Canvas, points: Sequence[Sequence[float]], fill: str, stroke: str | None) -> None:
    path = canvas.beginPath()
    path.moveTo(*points[0])
    for point in points[1:]:
        path.lineTo(*point)
    path.close()
    canvas.setFillColor(pdf_colour(fill))
    if stroke is not None:
        canvas.setStrokeColor(pdf_colour(stroke))
    canvas.drawPath(path, stroke=int(stroke is not None), fill=1)


def _map(
    canvas: Canvas,
    pattern: Pattern,
    pages: Sequence[Sheet],
    number: int,
    paper: Paper,
    colours: Colours,
) -> None:
    """All pages, small, with their strips; this one in a frame."""
    right, top, high = paper.width - MARGIN - 2, MARGIN + FOOT - 2.6, 13.0
    left = 190.0
    if right - left < high:
        raise FieldError(
            f"a page {paper.width:g} mm wide has no room for the map of pages beside the ruler; "
            f"take one of {left + high + MARGIN + 2:g} mm or more"
        )
    ratio = paper.width / paper.height
    rows = 1
    while math.ceil(len(pages) / rows) * (high / rows) * ratio > right - left:
        rows += 1
    tall = high / rows
    wide, columns = tall * ratio, math.ceil(len(pages) / rows)
    start = right - columns * wide
    for k, page in enumerate(pages):
        x, y = start + (k % columns) * wide, top - (k // columns + 1) * tall
        scale = 0.88 * tall / paper.height
        here = k == number
        canvas.setFillColor(pdf_colour("#ffffff"))
        canvas.setStrokeColor(pdf_colour(INK if here else "#b9bec4"))
        canvas.setLineWidth(0.35 if here else 0.12)
        canvas.rect(x, y, 0.88 * wide, 0.88 * tall, stroke=1, fill=1)
        canvas.setLineCap(0)
        for laid in page.laid:
            family = colours.of_family(pattern.strips[laid.drawn.piece.strip].family)
            canvas.setStrokeColor(pdf_colour(family if here else mixed(family, "#ffffff", 0.6)))
            canvas.setLineWidth(max(0.7 * pattern.width * scale, 0.08))
            line = np.array([[0.0, 0.0], [laid.drawn.piece.length, 0.0]])
            line = line if laid.drawn.spine is None else laid.drawn.spine
            places = [x, y] + scale * (line + [laid.x + MARGIN, laid.y + MARGIN + FOOT])
            for (a, b), (c, d) in pairwise(places.tolist()):
                canvas.line(a, b, c, d)
        canvas.setLineCap(1)
