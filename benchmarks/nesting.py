"""How full sheets and pages are, beside a packer of rectangles and what no packing can pass.

    python -m benchmarks.nesting [DIR...]

Each DIR holds a weave in mm, as ``geoweave weave --size`` writes it; without one, ten weaves of about
300 mm are made and kept in build/bench/nesting. Their strips are cut for A4 pages and for sheets of 600 x
400 mm. The share of strip in them is set beside what rectpack gives for the same pieces (``pip install
rectpack``; Apache-2.0; the best of its algorithms, free to turn pieces and to mix families), and the rows
beside those that no laying in rows can do without, with about the share that these would have. Where most
strips are longer than half a row, as on the cylinder, nothing but more joins fills the sheets. Of the last
sheet counts what lies above its lowest strip, by both. The exit status is 1 if a goal is missed that
rectpack reaches. The table is written to build/bench/nesting.md.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from geoweave.checkout import PACKAGE
from geoweave.fabrication import Stock, layout_for
from geoweave.fabrication.nesting import Sheet, used_share
from geoweave.fabrication.pdf import FOOT, MARGIN, page_stock
from geoweave.fabrication.sheet_sizes import PAPERS
from geoweave.fabrication.strip_layout import StripLayout
from geoweave.meshing import isotropic_remesh
from geoweave.models import datasets, shapes
from geoweave.pipeline import CutRequest, write_weave
from geoweave.pipeline.strips import strips_of
from geoweave.surface import TriMesh
from geoweave.weave import weave_pattern

LEAST = {"a4": 0.45, "sheet": 0.70}
"""Goals: share of strip in pages and sheets."""

FOLDER = PACKAGE.parent / "build" / "bench"

SIZE = 300.0
"""Longest side of every object, mm."""


def scan(name: str) -> Callable[[], TriMesh]:
    return lambda: isotropic_remesh(datasets.load(name), 2_500)


MODELS: dict[str, tuple[Callable[[], TriMesh], int]] = {
    "cone": (lambda: shapes.cone(faces=1_500), 20),
    "cylinder": (lambda: shapes.cylinder(faces=1_500), 24),
    "torus": (lambda: shapes.torus(faces=1_500), 24),
    "sphere": (lambda: shapes.sphere(1_280), 30),
    "saddle": (lambda: shapes.saddle(faces=1_500), 40),
    "vessel": (lambda: shapes.vessel(faces=2_500), 40),
    "bunny": (scan("bunny"), 40),
    "spot": (scan("spot"), 50),
    "armadillo": (scan("armadillo"), 60),
    "camel": (scan("camel"), 60),
}
"""The ten weaves: surface, and number of ribbons."""


def made(name: str) -> Path:
    """The folder of one of the ten weaves."""
    folder = FOLDER / "nesting" / name
    folder.parent.mkdir(parents=True, exist_ok=True)
    if not (folder / "weave.json").exists():
        build, ribbons = MODELS[name]
        write_weave(weave_pattern(build(), ribbons=ribbons).sized(size=SIZE), folder)
    return folder


def rows_of(sheets: tuple[Sheet, ...]) -> int:
    """How many rows there are."""
    return sum(max(each.row for each in sheet.laid) for sheet in sheets)


def least_rows(lengths: Sequence[float], room: float) -> int:
    """Rows that no laying in rows can do without (the bound L2 of Martello and Toth, 1990).

    Pieces longer than half a row have a row each. What is left of those rows takes the shorter ones; for each
    length a, only pieces of at least a are counted: none of them fits beside one longer than ``room - a``.
    """
    best = 0
    for a in {0.0, *(each for each in lengths if each <= room / 2)}:
        long = [each for each in lengths if each > room - a]
        half = [each for each in lengths if room / 2 < each <= room - a]
        short = sum(each for each in lengths if a <= each <= room / 2)
        more = short - (len(half) * room - sum(half))
        best = max(best, len(long) + len(half) + max(math.ceil(more / room - 1e-9), 0))
    return best


def packed_share(laid: StripLayout, stock: Stock, around: tuple[float, float]) -> float | None:
    """The share of strip in the sheets that rectpack lays, None without rectpack."""
    try:
        import rectpack
    except ImportError:
        return None
    grain = 100  # rectpack is exact in whole numbers: hundredths of a millimetre, rounded up
    pieces = [each.extent for each in laid.drawings]
    sizes = [
        tuple(math.ceil(grain * (side + stock.gap) - 1e-6) for side in (e.right - e.left, e.top - e.bottom))
        for e in pieces
    ]
    bins = tuple(math.floor(grain * (side + stock.gap) + 1e-6) for side in (stock.room, stock.across))
    area = sum(each.area for each in laid.drawings)
    best = 0.0
    for algorithm in (
        rectpack.MaxRectsBl,
        rectpack.MaxRectsBssf,
        rectpack.GuillotineBssfSas,
        rectpack.SkylineBlWm,
    ):
        packer = rectpack.newPacker(pack_algo=algorithm, rotation=True)
        packer.add_bin(*bins, count=float("inf"))
        for number, (wide, tall) in enumerate(sizes):
            packer.add_rect(wide, tall, number)
        packer.pack()
        rectangles = packer.rect_list()
        assert len(rectangles) == len(sizes)
        last = max(each[0] for each in rectangles)
        used = max(each[2] + each[4] for each in rectangles if each[0] == last) / grain + stock.margin
        wide, tall = stock.width + around[0], stock.height + around[1]
        best = max(best, area / (wide * tall * (last + min(used / stock.height, 1.0))))
    return best


def measured(folder: Path) -> tuple[list[str], int]:
    """Two lines of the table, and how many goals are missed that rectpack reaches."""

    def read(name: str) -> Any:
        path = folder / name
        return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None

    weave = read("weave.json")
    cut = strips_of(weave, read("relaxed.json"))
    lines, missed = [], 0
    for medium, formats in (("a4", ("pdf",)), ("sheet", ("svg",))):
        bench = CutRequest(sheet="600x400", papers=("a4",)).bench(folder.name)
        laid = layout_for(cut.pattern, formats, bench=bench, weave=weave, rest=cut.space)
        page = medium == "a4"
        stock = page_stock(PAPERS["a4"]) if page else bench.stock
        around = (2 * MARGIN, 2 * MARGIN + FOOT) if page else (0.0, 0.0)
        sheets = laid.pages("a4") if page else laid.sheets
        lengths = [each.extent.right - each.extent.left + stock.gap for each in laid.drawings]
        least, share = least_rows(lengths, stock.room + stock.gap), used_share(sheets, around)
        # Strips of a weave that are cut straight are equally wide: fewer rows mean less paper in proportion.
        bound = share * rows_of(sheets) / least
        packer = packed_share(laid, stock, around)
        met = share >= LEAST[medium]
        missed += not met and packer is not None and packer >= LEAST[medium]
        lines.append(
            f"| {folder.name} | {medium} | {len(laid.drawings)} | {cut.pattern.width:.1f} | {share:.1%} | "
            f"{'-' if packer is None else f'{packer:.1%}'} | {LEAST[medium]:.0%} | "
            f"{'yes' if met else 'no'} | "
            f"{len(sheets)} | {rows_of(sheets)} | {least} | {bound:.0%} |"
        )
    return lines, missed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folders", metavar="DIR", nargs="*", type=Path)
    folders = parser.parse_args().folders or [made(name) for name in MODELS]
    head = (
        "| weave | on | pieces | width mm | strip | rectpack | goal | met | sheets | rows | least | at most |"
    )
    lines = [head, "|---|---|---:|---:|---:|---:|---:|---|---:|---:|---:|---:|"]
    missed = 0
    for folder in folders:
        more, wrong = measured(folder)
        lines, missed = lines + more, missed + wrong
    table = "\n".join(lines)
    print(table)
    target = FOLDER / "nesting.md"
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(table + "\n", encoding="utf-8")
    raise SystemExit(int(missed > 0))


if __name__ == "__main__":
    main()
