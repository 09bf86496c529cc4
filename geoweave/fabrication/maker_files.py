"""Everything a maker takes to the bench, written together or not at all (Section 5.4)."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geoweave.errors import FieldError
from geoweave.fabrication.assembly_order import Step, assembly
from geoweave.fabrication.colours import Colours
from geoweave.fabrication.cut_list import cut_list
from geoweave.fabrication.dxf import write_dxf
from geoweave.fabrication.glb import write_glb
from geoweave.fabrication.guide_page import guide_html
from geoweave.fabrication.nesting import Sheet, Stock, nested
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.pdf import PAPERS, laid_on_pages, page_stock, write_pdf
from geoweave.fabrication.pieces import Making, pieces_of
from geoweave.fabrication.strip_drawing import drawn
from geoweave.fabrication.strip_figures import Drawn
from geoweave.fabrication.svg import write_svg
from geoweave.files import Job, OutputError, chosen, written_together

if TYPE_CHECKING:
    from geoweave.weave import Weave

__all__ = ["FORMATS", "Bench", "check_formats", "pattern_document", "write"]

FORMATS = {
    "pattern": "pattern.json, flat strips, crossings and the order of assembly",
    "csv": "cutlist.csv, lengths and stock",
    "svg": "pattern.svg, sheets in true millimetres with the layers of a laser cutter",
    "dxf": "pattern.dxf, the same as DXF R2010",
    "pdf": "pattern-a4.pdf and pattern-letter.pdf, pages at true scale",
    "glb": "weave.glb, the woven object",
    "guide": "guide.html, a page that shows how to put it together",
}
"""What a pattern can be written as."""

MOST_SHEETS = 400
"""Pages or sheets that are still written."""


@dataclass(frozen=True)
class Bench:
    """How a pattern is made.

    Attributes
    ----------
    making : overlap, extra and kerf
    stock : sheets of the SVG and of the DXF; by default one long sheet
    stock_length : of the strips that the cut list counts, mm
    colours : of SVG and DXF
    paper_colours : of the pages
    title : what the drawings are called
    """

    making: Making = field(default_factory=Making)
    stock: Stock = field(default_factory=Stock)
    stock_length: float = 1000.0
    colours: Colours = field(default_factory=Colours)
    paper_colours: Colours = field(default_factory=lambda: Colours("paper"))
    title: str = "weave"


def check_formats(names: Iterable[str]) -> tuple[str, ...]:
    """Return the formats of these names, each once, in the order of `FORMATS`.

    Raises
    ------
    OutputError
        If there is no such format.
    """
    return chosen(names, FORMATS, "pattern")


def pattern_document(pattern: Pattern, bench: Bench, order: tuple[Step, ...] | None = None) -> dict[str, Any]:
    """The contents of ``pattern.json``: the pattern, how it is made, and the order of assembly."""
    steps = assembly(pattern) if order is None else order
    return {
        **pattern.document(),
        "making": vars(bench.making),
        "assembly": [
            {"strip": step.strip, "backbone": step.backbone, "crossings": list(step.crossings)}
            for step in steps
        ],
    }


def write(
    pattern: Pattern,
    folder: str | PathLike[str],
    formats: Iterable[str] = tuple(FORMATS),
    *,
    bench: Bench | None = None,
    weave: Weave | Mapping[str, Any] | None = None,
    rest: Mapping[str, Any] | None = None,
) -> dict[str, Path]:
    """Write a pattern, all files together or none.

    Parameters
    ----------
    pattern : the pattern
    folder : where to; it is made if it is not there, in a folder that is
    formats : names from `FORMATS`
    bench : how it is made
    weave : the weave the pattern is of, or the contents of its ``weave.json``; needed for the GLB and the
        guide only, as a pattern does not know where its ribbons are
    rest : the contents of ``relaxed.json`` if the pattern is of the weave at rest; GLB and guide then show it

    Returns
    -------
    dict
        Path of each file by its name.

    Raises
    ------
    OutputError
        If a format is unknown, GLB or guide are asked for without a weave, or a file cannot be written there.
    FieldError
        If strips do not fit on the sheets, their crossings are too dense to be labelled, or the weave is not
        that of the pattern.
    """
    if not (wanted := check_formats(formats)):
        raise OutputError(f"no format is asked for; the formats are {', '.join(FORMATS)}")
    return written_together(jobs_of(pattern, wanted, bench=bench, weave=weave, rest=rest), folder)


def jobs_of(
    pattern: Pattern,
    formats: Iterable[str],
    *,
    bench: Bench | None = None,
    weave: Weave | Mapping[str, Any] | None = None,
    rest: Mapping[str, Any] | None = None,
) -> dict[str, Job]:
    """What writes each file of a pattern; everything that may be refused is refused here. As `write`."""
    wanted, how = check_formats(formats), bench or Bench()
    for name, what in (("glb", "GLB"), ("guide", "guide")):
        if name in wanted and weave is None:
            raise OutputError(
                f"the {what} needs the weave itself, as a pattern has no places in space; leave '{name}' out"
            )
    jobs: dict[str, Job] = {}
    order = assembly(pattern)
    if "pattern" in wanted:
        text = json.dumps(pattern_document(pattern, how, order), indent=1, allow_nan=False) + "\n"
        jobs["pattern.json"] = _text(text)
    if "csv" in wanted:
        jobs["cutlist.csv"] = _text(cut_list(pattern, how.making, how.stock_length).text(pattern, order))
    if "svg" in wanted or "dxf" in wanted:
        sheets = nested(_drawings(pattern, how, how.stock.room), how.stock)
        _few(sheets)
        for number, sheet in enumerate(sheets, 1):
            name = "pattern" if len(sheets) == 1 else f"pattern-{number:02d}"
            title = how.title if len(sheets) == 1 else f"{how.title}, sheet {number} of {len(sheets)}"
            if "svg" in wanted:
                jobs[f"{name}.svg"] = _svg(pattern, sheet, how.colours, title)
            if "dxf" in wanted:
                jobs[f"{name}.dxf"] = _dxf(pattern, sheet, how.colours)
    if "pdf" in wanted:
        for key, paper in PAPERS.items():
            pages = laid_on_pages(_drawings(pattern, how, page_stock(paper).room), paper)
            _few(pages)
            jobs[f"pattern-{key}.pdf"] = _pdf(pattern, pages, key, how)
    stands = rest or weave
    if "glb" in wanted:
        assert stands is not None  # or it would have been refused
        jobs["weave.glb"] = _glb(stands, how.paper_colours)
    if "guide" in wanted:
        assert stands is not None
        jobs["guide.html"] = _text(
            guide_html(pattern, stands, how.making, how.title, how.paper_colours, order)
        )
    return jobs


def _drawings(pattern: Pattern, how: Bench, longest: float) -> list[Drawn]:
    return [drawn(pattern, piece, how.making) for piece in pieces_of(pattern, how.making, longest)]


def _few(sheets: tuple[Sheet, ...]) -> None:
    if len(sheets) > MOST_SHEETS:
        raise FieldError(
            f"the pattern needs {len(sheets)} sheets, more than {MOST_SHEETS}; "
            "make the object smaller or ask for fewer ribbons"
        )


def _text(text: str) -> Job:
    def job(path: Path) -> None:
        path.write_text(text, encoding="utf-8", newline="\n")

    return job


def _svg(pattern: Pattern, sheet: Sheet, colours: Colours, title: str) -> Job:
    return lambda path: write_svg(path, pattern, sheet, colours, title)


def _dxf(pattern: Pattern, sheet: Sheet, colours: Colours) -> Job:
    return lambda path: write_dxf(path, pattern, sheet, colours)


def _pdf(pattern: Pattern, pages: tuple[Sheet, ...], key: str, how: Bench) -> Job:
    return lambda path: write_pdf(path, pattern, pages, PAPERS[key], how.paper_colours, how.title)


def _glb(weave: Weave | Mapping[str, Any], colours: Colours) -> Job:
    return lambda path: write_glb(path, weave, colours.families)
