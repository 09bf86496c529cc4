"""How quick the page of ``geoweave show`` is at 110 ribbons and 1,700 crossings.

    python -m benchmarks.viewer [DIR]

DIR holds a weave; without one it is a weave in the plane of that size. The page is opened in a browser
without a screen, on a desk and on a phone. What is measured is the time that the main thread of the page
computes, by the clock of that thread, so that a busy machine does not count: loading until the first picture
stands still, and after that how long each of the usual acts blocks the page. Drawing itself is done by the
graphics card, which is software here; its time is not counted, and the wall clock stands beside.
"""

from __future__ import annotations

import argparse
import importlib
import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from geoweave.checkout import repository
from geoweave.fabrication import viewer_html

LOAD, BLOCK = 2.0, 0.1
"""Seconds that loading may take, and an act may block the page."""

ACTS = {
    "point at a ribbon": "viewer.space.hover(viewer.space.at(400, 300, 2))",
    "select a crossing": "viewer.select({ kind: 'crossing', crossing: 40 }, false)",
    "select a ribbon": "viewer.select({ kind: 'ribbon', strip: 3 }, false)",
    "colour by curvature": "viewer.colour('bend')",
    "turn": "viewer.space.turn(0.3, 0.1)",
    "zoom": "viewer.space.zoom(0.7)",
    "drop a ribbon": "viewer.edits.drop(5); viewer.space.refresh()",
    "flip a crossing": "viewer.edits.flip([60]); viewer.space.refresh()",
}


def page_of(folder: Path | None) -> str:
    """The page of a folder, or of a weave in the plane."""
    if folder is None:
        return viewer_html(importlib.import_module("laidflat").flat(37, spacing=11.0, reach=135.0, width=3.0))
    read = {
        name: json.loads((folder / name).read_text(encoding="utf-8")) if (folder / name).is_file() else None
        for name in ("weave.json", "relaxed.json", "report.json")
    }
    return viewer_html(read["weave.json"], read["relaxed.json"], read["report.json"], folder.name)


def measured(chromium: Any, file: Path, size: tuple[int, int]) -> dict[str, Any]:
    """Seconds of loading and of each act."""
    phone = size[0] < 600
    context = chromium.new_context(
        viewport={"width": size[0], "height": size[1]},
        is_mobile=phone,
        has_touch=phone,
        reduced_motion="reduce",
    )
    page = context.new_page()
    hand = context.new_cdp_session(page)
    hand.send("Performance.enable", {"timeDomain": "threadTicks"})

    def spent() -> float:
        found = {each["name"]: each["value"] for each in hand.send("Performance.getMetrics")["metrics"]}
        return float(found["TaskDuration"])

    def still() -> None:
        while not page.evaluate("window.viewer !== undefined && viewer.still()"):
            time.sleep(0.02)

    clock, start = time.perf_counter(), spent()
    page.goto(file.as_uri())
    still()
    load = {"computing": spent() - start, "wall": time.perf_counter() - clock}
    page.wait_for_timeout(1500)  # the other shape is made ready meanwhile
    acts = {}
    for name, script in ACTS.items():
        before = spent()
        page.evaluate(script)
        still()
        acts[name] = spent() - before
    count = page.evaluate("[viewer.content.strips.length, viewer.content.crossings.length]")
    context.close()
    return {"ribbons": count[0], "crossings": count[1], "load": load, "acts": acts}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", nargs="?", type=Path)
    folder = parser.parse_args().folder
    sys.path.insert(0, str(repository() / "tests"))
    headless = importlib.import_module("browser")
    with tempfile.TemporaryDirectory() as temporary, headless.browser() as chromium:
        file = Path(temporary) / "viewer.html"
        text = page_of(folder)
        file.write_text(text, encoding="utf-8")
        print(f"{len(text) / 1e6:.2f} MB")
        for name, size in (("desk", headless.DESK), ("phone", headless.PHONE)):
            found = measured(chromium, file, size)
            load, worst = found["load"], max(found["acts"], key=found["acts"].get)
            print(
                f"{name}: {found['ribbons']} ribbons, {found['crossings']:,} crossings; loading computes "
                f"{load['computing']:.2f} s (at most {LOAD:g}; wall clock {load['wall']:.2f})"
            )
            for act, seconds in found["acts"].items():
                mark = "" if seconds <= BLOCK else f"  more than {BLOCK:g}"
                print(f"  {act:20} {1000 * seconds:6.0f} ms{mark}")
            print(f"  the longest: {worst}")


if __name__ == "__main__":
    main()
