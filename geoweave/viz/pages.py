"""Pages of a pattern as pictures: what comes out of the printer (Figs. 20 and 25)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import to_rgb
from PIL import Image

from geoweave.errors import RenderError
from geoweave.fabrication import (
    FOOT,
    MARGIN,
    PAPERS,
    Colours,
    Laid,
    Making,
    Paper,
    Pattern,
    Sheet,
    drawn,
    pieces_of,
    write_pdf,
)
from geoweave.viz import style
from geoweave.viz.shot import Pixels
from geoweave.wording import counted

POINT = 25.4 / 72
"""Millimetres of a point, the unit of a PDF."""

OVERSIZE = 3
"""Pixels of the page for each of the picture, along either side, before they are averaged."""


@dataclass(frozen=True)
class Page:
    """One page of a PDF, or a part of it, that a gallery draws like a scene.

    Attributes
    ----------
    path : the PDF
    number : of the page, from 1
    crop : left, top, right and bottom of the part that is drawn, mm from the upper left corner; all if None
    frame : whether a thin line surrounds it; without one the edge of white paper is invisible on white ground
    """

    path: str | PathLike[str]
    number: int = 1
    crop: tuple[float, float, float, float] | None = None
    frame: bool = True

    @cached_property
    def size(self) -> tuple[float, float]:
        """Width and height of the whole page, mm."""
        with _opened(self) as page:
            width, height = page.get_size()
        return width * POINT, height * POINT

    @cached_property
    def part(self) -> tuple[float, float, float, float]:
        """What is drawn: left, top, right and bottom, mm from the upper left corner of the page.

        Raises
        ------
        RenderError
            If it does not lie on the page.
        """
        width, height = self.size
        left, top, right, bottom = self.crop or (0.0, 0.0, width, height)
        if not (0 <= left < right <= width + 1e-6 and 0 <= top < bottom <= height + 1e-6):
            raise RenderError(
                f"{Path(self.path).name}: the part {self.crop} mm does not lie on page {self.number}, "
                f"which is {width:.1f} x {height:.1f} mm"
            )
        return left, top, right, bottom

    @property
    def aspect(self) -> float:
        """Width over height."""
        left, top, right, bottom = self.part
        return (right - left) / (bottom - top)

    def draw(self, height: int) -> Pixels:
        """Rasterise to a height in pixels.

        Returns
        -------
        (height, width, 3) uint8

        Raises
        ------
        RenderError
            If the file is no PDF or has no such page.
        """
        left, top, right, bottom = self.part
        wide, tall = self.size
        width = max(8, round(height * self.aspect))
        scale = OVERSIZE * height / (bottom - top)  # pixels for a millimetre
        away = tuple(each / POINT for each in (left, tall - bottom, wide - right, top))
        with _opened(self) as page:
            image = page.render(scale=scale * POINT, crop=away).to_pil().convert("RGB")
        small = np.array(image.resize((width, height), Image.Resampling.BOX))
        if self.frame:
            line = np.array([round(255 * each) for each in to_rgb(style.LINE)], dtype=np.uint8)
            small[[0, 1, -2, -1]] = line
            small[:, [0, 1, -2, -1]] = line
        return small


@contextmanager
def _opened(what: Page) -> Iterator[Any]:
    try:
        import pypdfium2 as pdfium
    except ImportError as error:
        raise RenderError(
            "showing a page of a PDF needs pypdfium2: pip install 'geoweave[notebooks]'"
        ) from error
    path = Path(what.path)
    try:
        document = pdfium.PdfDocument(path)
    except (pdfium.PdfiumError, OSError) as error:
        raise RenderError(f"{path.name}: cannot be read as a PDF ({error})") from error
    try:
        if not 1 <= what.number <= len(document):
            raise RenderError(
                f"{path.name}: has {counted(len(document), 'page')}, there is no page {what.number}"
            )
        yield document[what.number - 1]
    finally:
        document.close()


def strips_page(
    path: str | PathLike[str],
    pattern: Pattern,
    which: Sequence[int],
    middles: Sequence[float],
    reach: float,
    gap: float = 1.0,
) -> Page:
    """Draw parts of some strips under each other, as they are printed, and return the page that shows them.

    Parameters
    ----------
    path : the PDF that is written
    pattern : whose strips
    which : numbers of the strips, from the top down
    middles : the place on each that lies in the middle of the picture, mm from its start
    reach : mm of strip on either side of it
    gap : between two strips, in widths of a strip

    Raises
    ------
    RenderError
        If there is no strip, or not one middle for each.

    Examples
    --------
    >>> import tempfile
    >>> woven = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)
    >>> pattern = gw.fabrication.pattern_of(woven.sized(size=200.0))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     page = viz.strips_page(f"{folder}/two.pdf", pattern, [0, 1], [40.0, 60.0], reach=30.0)
    ...     round(60.0 / page.aspect / pattern.width, 6)  # two strips and three gaps, and the gap at the foot
    ...
    6.0
    """
    if not len(which) or len(which) != len(middles):
        raise RenderError(
            f"{counted(len(which), 'strip')} cannot be drawn about {counted(len(middles), 'middle')}"
        )
    making, pitch = Making(), (1.0 + gap) * pattern.width
    pieces = pieces_of(pattern, making)
    tall = (len(which) + gap) * pitch
    laid = tuple(
        Laid(drawn(pattern, pieces[r], making), reach - middle, tall - (row + 0.5 + 0.5 * gap) * pitch)
        for row, (r, middle) in enumerate(zip(which, middles, strict=True))
    )
    paper = Paper("", max(2 * (reach + MARGIN), PAPERS["a4"].width), tall + 2 * MARGIN + FOOT)
    sheet = Sheet(paper.width, paper.height, laid)
    write_pdf(path, pattern, [sheet], paper, Colours("paper"), "strips")
    crop = (MARGIN, paper.height - MARGIN - FOOT - tall, MARGIN + 2 * reach, paper.height - MARGIN - FOOT)
    return Page(path, crop=crop, frame=False)
