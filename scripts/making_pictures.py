"""Draw the pictures of docs/making.md: a strip, a page, the guide, as the commands write them.

    python scripts/making_pictures.py

A tube of sixteen ribbons with a hoop at both ends is woven, cut for A4 and drawn from the files that a maker
gets. Needs pypdfium2, playwright and Chromium, Chrome or Edge, as the tests of pages do.
"""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from geoweave.fabrication import StripLayout
from geoweave.models import shapes
from geoweave.pipeline import CutRequest, cut_folder, write_weave
from geoweave.weave import weave_pattern

TARGET = Path(__file__).resolve().parent.parent / "docs" / "making"

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "microsoft-edge")

FLAGS = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")

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


def draw_guide(path: Path) -> None:
    """The guide after some steps, on a screen of 1280 x 800."""
    from playwright.sync_api import sync_playwright

    browser = next(filter(None, map(shutil.which, BROWSERS)))
    with sync_playwright() as play:
        running = play.chromium.launch(executable_path=browser, args=list(FLAGS))
        page = running.new_page(viewport={"width": 1280, "height": 800})
        page.goto(path.as_uri())
        page.wait_for_timeout(3_000)
        for _ in range(STEPS):
            page.keyboard.press("ArrowRight")
        page.wait_for_timeout(4_000)
        shot = path.with_suffix(".png")
        page.screenshot(path=str(shot))
        running.close()
    saved(Image.open(shot), "guide.png")


STEPS = 40
"""How far the guide is when its picture is taken."""


def main() -> None:
    """Write the three pictures."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "tube"
        made(folder)
        draw_pages(folder / "pattern-a4.pdf")
        draw_guide(folder / "guide.html")


if __name__ == "__main__":
    main()
