"""Draw the pictures of docs/making.md: a strip, a page, the guide, the viewer, as the commands write them.

    python scripts/making_pictures.py

A tube of sixteen ribbons with a hoop at both ends is woven, cut for A4 and drawn from the files that a maker
gets; the viewer shows a bunny of eighty ribbons at rest. Needs pypdfium2, playwright and Chromium, Chrome or
Edge, and finds and starts them as the tests of pages do (tests/browser.py).
"""

from __future__ import annotations

import importlib
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from geoweave.checkout import repository
from geoweave.fabrication import StripLayout
from geoweave.models import shapes
from geoweave.pipeline import (
    CutRequest,
    MeshSource,
    WeaveRequest,
    cut_folder,
    show_folder,
    weave_file,
    write_weave,
)
from geoweave.weave import weave_pattern

TARGET = Path(__file__).resolve().parent.parent / "docs" / "making"

SCREEN = (1280, 800)
"""Of the pages, pixels."""

MM = 72 / 25.4
"""Points in a millimetre."""


def made(folder: Path) -> StripLayout:
    """A tube, cut for A4."""
    weave = weave_pattern(shapes.cylinder(radius=1.0, height=1.6, faces=1_500), ribbons=16)
    write_weave(weave.sized(size=200.0, width=12.0), folder)
    wish = CutRequest(preset="bristol-a4", hoops=12.0, formats=("pdf", "guide"), title="tube")
    return cut_folder(folder, request=wish).layout


def saved(picture: Image.Image, name: str) -> None:
    """Keep a picture, small: few colours say all that lines need."""
    TARGET.mkdir(parents=True, exist_ok=True)
    picture.convert("RGB").quantize(128).save(TARGET / name, optimize=True)


def draw_pages(path: Path) -> None:
    """A page of strips, and its first strip at twice its size."""
    import pypdfium2 as pdfium

    page = pdfium.PdfDocument(path)[1]
    saved(page.render(scale=1.5).to_pil(), "page.png")
    close = page.render(scale=3.2).to_pil()
    rows = np.asarray(close.convert("L")).min(axis=1) < 250
    # The first run of rows with ink below the crosses in the corners.
    start = int(3.2 * MM * 10)
    first = start + int(np.argmax(rows[start:]))
    last = first + int(np.argmin(rows[first:]))
    saved(close.crop((int(3.2 * MM * 8), first - 12, int(3.2 * MM * 155), last + 12)), "strip.png")


def shot(path: Path, name: str, still: str, *acts: str) -> None:
    """A picture of a page after some acts, each of them when the page stands still."""
    pages = importlib.import_module("browser")
    with pages.browser() as running, pages.opened(running, path, SCREEN) as page:
        page.wait(still)
        for act in acts:
            page.do(act)
            page.wait(still)
        saved(Image.fromarray(page.picture()), name)


def draw_guide(path: Path) -> None:
    """The guide after some steps."""
    shot(path, "guide.png", "guide.still()", f"guide.go({STEPS})")


def draw_viewer(folder: Path) -> None:
    """The viewer with a crossing of a bunny at rest, and the list of hard places open."""
    request = WeaveRequest(ribbons=80, size=300.0, formats=("json",))
    weave_file(MeshSource("bunny"), folder, request)
    page = show_folder(folder).path
    pick = f"viewer.select({{ kind: 'crossing', crossing: {CROSSING} }}, false)"
    still = "window.viewer !== undefined && viewer.still()"
    shot(page, "viewer.png", still, pick, "document.querySelector('#hard').open = true")


CROSSING = 40
"""That is picked in the viewer."""

STEPS = 40
"""How far the guide is when its picture is taken."""


def main() -> None:
    """Write the four pictures."""
    sys.path.insert(0, str(repository() / "tests"))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "tube"
        made(folder)
        draw_pages(folder / "pattern-a4.pdf")
        draw_guide(folder / "guide.html")
        draw_viewer(Path(name) / "bunny")


if __name__ == "__main__":
    main()
