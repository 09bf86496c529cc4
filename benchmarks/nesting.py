"""How full sheets and pages are, beside what no packing can pass.

    python -m benchmarks.nesting DIR...

Each DIR holds a weave in mm, as ``geoweave weave --size`` writes it. Its strips are cut for A4 pages and for
sheets of 600 x 400 mm, and the share of strip in the sheets is set beside two numbers: that of rows filled to
the last tenth of a millimetre (which no packing of strips in rows can pass), and that of rows filled by first
fit of the longest first, all strips alike, as a packer for rods does. The table is written to
build/bench/nesting.md.
"""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path

from geoweave.checkout import PACKAGE
from geoweave.fabrication import Stock, layout_for, layout_numbers
from geoweave.fabrication.nesting import Sheet
from geoweave.fabrication.pdf import page_stock
from geoweave.fabrication.sheet_sizes import PAPERS
from geoweave.fabrication.strip_layout import StripLayout
from geoweave.pipeline import CutRequest
from geoweave.pipeline.strips import strips_of

LEAST = {"a4": 0.45, "sheet": 0.70}


def rows_of(sheets: tuple[Sheet, ...]) -> int:
    """How many rows there are."""
    return sum(max(each.row for each in sheet.laid) for sheet in sheets)


def first_fit(laid: StripLayout, stock: Stock) -> int:
    """Rows by first fit of the longest first, whatever their family."""
    left: list[float] = []
    for length in sorted((each.piece.length for each in laid.drawings), reverse=True):
        k = next((k for k, room in enumerate(left) if room >= length + stock.gap - 1e-9), None)
        if k is None:
            left.append(stock.room - length)
        else:
            left[k] -= length + stock.gap
    return len(left)


def measured(folder: Path) -> list[str]:
    weave = json.loads((folder / "weave.json").read_text(encoding="utf-8"))
    rest = folder / "relaxed.json"
    relaxed = json.loads(rest.read_text(encoding="utf-8")) if rest.exists() else None
    cut = strips_of(weave, relaxed)
    lines = []
    for medium, formats in (("a4", ("pdf",)), ("sheet", ("svg",))):
        bench = CutRequest(sheet="600x400", papers=("a4",)).bench(folder.name)
        laid = layout_for(cut.pattern, formats, bench=bench, weave=weave, rest=cut.space)
        stock = page_stock(PAPERS["a4"]) if medium == "a4" else bench.stock
        sheets = laid.pages("a4") if medium == "a4" else laid.sheets
        total = sum(each.piece.length + stock.gap for each in laid.drawings)
        least, ours = math.ceil(total / (stock.room + stock.gap) - 1e-9), rows_of(sheets)
        share = layout_numbers(laid)["used_share"][medium]
        said = "yes" if share >= LEAST[medium] else "no"
        lines.append(
            f"| {folder.name} | {medium} | {len(laid.drawings)} | {cut.pattern.width:.2f} | {share:.1%} | "
            f"{LEAST[medium]:.0%} | {said} | {ours} | {first_fit(laid, stock)} | {least} |"
        )
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folders", metavar="DIR", nargs="+", type=Path)
    folders = parser.parse_args().folders
    head = "| weave | on | pieces | width | strip | goal | met | rows | rows of first fit | least rows |"
    lines = [head, "|---|---|---:|---:|---:|---:|---|---:|---:|---:|"]
    for folder in folders:
        lines += measured(folder)
    table = "\n".join(lines)
    print(table)
    target = PACKAGE.parent / "build" / "bench" / "nesting.md"
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(table + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
