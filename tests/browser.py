"""A real browser without a screen and without a network, for the tests of pages."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from PIL import Image

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "microsoft-edge", "msedge")
PLACES = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    "C:/Program Files/Google/Chrome/Application/chrome.exe",
    "C:/Program Files (x86)/Microsoft/Edge/Application/msedge.exe",
)
MISSING = "no Chromium, Chrome or Edge is installed, which the tests of pages need: apt-get install chromium"
FLAGS = (
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
PHONE, DESK = (390, 844), (1280, 900)
PATIENCE = 300.0
"""Seconds to wait for a page: far more than a busy machine needs, so that only a page that hangs ends it."""


def found() -> str:
    """The browser; without one a test is skipped, on continuous integration it fails."""
    place = next(filter(None, map(shutil.which, NAMES)), None)
    place = place or next((each for each in PLACES if Path(each).is_file()), None)
    if place is None:
        if os.environ.get("CI", "").lower() in ("1", "true"):
            pytest.fail(MISSING)
        pytest.skip(MISSING)
    return place


class Opened(NamedTuple):
    """A page and what went wrong on it."""

    page: Any
    errors: list[str]
    requests: list[str]

    def do(self, script: str) -> Any:
        return self.page.evaluate(script)

    def wait(self, script: str) -> None:
        """Until an expression holds; the page's own policy forbids the browser to do the waiting."""
        end = time.monotonic() + PATIENCE
        while not self.page.evaluate(script):
            assert time.monotonic() < end, f"still not: {script}"
            time.sleep(0.05)

    def picture(self, selector: str | None = None) -> np.ndarray:
        """(H, W, 3) what is to be seen."""
        import io

        shown = self.page.locator(selector) if selector else self.page
        return np.asarray(Image.open(io.BytesIO(shown.screenshot())).convert("RGB"))

    def fits(self) -> bool:
        """Whether nothing has to be scrolled sideways."""
        return bool(self.do("document.documentElement.scrollWidth <= window.innerWidth"))


@contextmanager
def browser() -> Iterator[Any]:
    """A browser with a profile of its own."""
    from playwright.sync_api import sync_playwright

    place = found()
    with sync_playwright() as play:
        chromium = play.chromium.launch(executable_path=place, args=list(FLAGS), timeout=PATIENCE * 1_000)
        try:
            yield chromium
        finally:
            chromium.close()


@contextmanager
def opened(
    chromium: Any, path: Path, size: tuple[int, int] = DESK, *, before: str = "", context: Any = None
) -> Iterator[Opened]:
    """Open a file without a network; ``before`` runs ahead of the scripts of the page."""
    phone = size[0] < 600
    own = context or chromium.new_context(
        viewport={"width": size[0], "height": size[1]},
        offline=True,
        is_mobile=phone,
        has_touch=phone,
        reduced_motion="reduce",
    )
    page = own.new_page()
    page.set_default_timeout(PATIENCE * 1_000)
    errors: list[str] = []
    requests: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda said: said.type == "error" and errors.append(said.text))
    page.on("request", lambda asked: requests.append(asked.url))
    if before:
        page.add_init_script(before)
    page.goto(path.resolve().as_uri())
    try:
        yield Opened(page, errors, requests)
    finally:
        page.close()
        if context is None:
            own.close()
