"""Strips laid out on sheets, saved in the format that the ending of a name asks for (Section 5.4)."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

from geoweave.errors import FieldError
from geoweave.fabrication.assembly_order import Step
from geoweave.fabrication.assembly_zones import assembly_numbers, zoned_assembly
from geoweave.fabrication.bench import Bench, media_of
from geoweave.fabrication.bent_drawings import bent
from geoweave.fabrication.bill import Bill, bill_of
from geoweave.fabrication.crossing_order import order_sentence
from geoweave.fabrication.cut_list import cut_list
from geoweave.fabrication.dxf import write_dxf
from geoweave.fabrication.flattening import WeaveLike, free_end, pattern_of, trimmed, weave_document
from geoweave.fabrication.making_limits import check_made
from geoweave.fabrication.nesting import Sheet, nested
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.pdf import laid_on_pages, page_stock, write_pdf
from geoweave.fabrication.pdf_front import Line, front_count, front_lines, key_text
from geoweave.fabrication.pieces import Piece, pieces_of
from geoweave.fabrication.sheet_sizes import PAPERS, paper_of
from geoweave.fabrication.strip_drawing import drawn
from geoweave.fabrication.strip_figures import Drawn
from geoweave.fabrication.svg import write_svg
from geoweave.files import Job, OutputError, check_writable, written_together

__all__ = ["StripLayout", "layout"]

MOST_SHEETS = 400
"""Pages or sheets that are still written."""


@dataclass(frozen=True, eq=False)
class StripLayout:
    """Flat strips and how they are made: everything that a file for the bench is written from.

    Attributes
    ----------
    pattern : the strips
    bench : how they are made
    media : what is written, of "whole", "sheet", "stock" and the names of papers: each strip is cut into
        the same pieces in all files of a run, the longest that fit on all of them
    space : the weave as it will stand, as the contents of its ``weave.json`` or ``relaxed.json``; a pattern
        alone does not know where its ribbons are in space, and then there is no GLB and no guide. Of its
        ribbons the GLB and the guide show what the strips have of them

    See Also
    --------
    layout : makes one of a weave.
    """

    pattern: Pattern
    bench: Bench = field(default_factory=Bench)
    space: Mapping[str, Any] | None = None
    media: tuple[str, ...] = ("sheet",)

    @cached_property
    def order(self) -> tuple[Step, ...]:
        """In which order the strips are woven."""
        return zoned_assembly(self.pattern, self.space)

    @cached_property
    def assembly(self) -> dict[str, Any] | None:
        """What a report says of that order (`assembly_numbers`); None without a place in space."""
        return None if self.space is None else assembly_numbers(self.pattern, self.order, self.space)

    @cached_property
    def drawings(self) -> tuple[Drawn, ...]:
        """The pieces that are cut, drawn.

        Raises
        ------
        FieldError
            If they cannot be made; the text says which number would work.
        """
        making, stock = self.bench.making, self.bench.stock
        check_made(self.pattern, making, stock)
        rooms = {"whole": math.inf, "sheet": stock.room, "stock": self.bench.stock_length}
        rooms |= {name: page_stock(PAPERS[name]).room for name in PAPERS}
        across = {name: page_stock(PAPERS[name]).across for name in PAPERS} | {"sheet": stock.across}
        longest = min(rooms[medium] for medium in self.media)
        highest = min(across.get(medium, math.inf) for medium in self.media)
        pieces = pieces_of(self.pattern, making, longest, highest)
        return tuple(bent(drawn(self.pattern, piece, making), self.pattern, making) for piece in pieces)

    @cached_property
    def sheets(self) -> tuple[Sheet, ...]:
        """The strips nested on the sheets of the bench.

        Raises
        ------
        FieldError
            If strips do not fit on the sheets, or there are too many sheets.
        """
        return _few(nested(self.drawings, self.bench.stock))

    def pages(self, paper: str = "a4") -> tuple[Sheet, ...]:
        """The strips nested on pages to print, one of `PAPERS`.

        Raises
        ------
        FieldError
            As for `sheets`.
        """
        size = paper_of(paper)
        if paper not in self.media:
            return replace(self, media=(paper,)).pages(paper)
        return _few(laid_on_pages(self.drawings, size))

    def document(self) -> dict[str, Any]:
        """The contents of ``pattern.json``: the pattern, how it is made, and the order of assembly."""
        return {
            **self.pattern.document(),
            "making": vars(self.bench.making),
            "assembly": [
                {
                    "strip": step.strip,
                    "backbone": step.backbone,
                    "crossings": list(step.crossings),
                    "zone": step.zone,
                }
                for step in self.order
            ],
        }

    def save(self, path: str | PathLike[str], paper: str = "a4") -> tuple[Path, ...]:
        """Write a file in the format of its ending, whole or not at all.

        ``.svg`` and ``.dxf`` hold the sheets, ``.pdf`` pages to print, ``.csv`` the cut list, ``.json`` the
        pattern, ``.glb`` the woven object and ``.html`` the guide. Where an SVG or a DXF needs several
        sheets, each is a file of its own: ``torus-01.svg``, ``torus-02.svg`` and so on.

        Parameters
        ----------
        path : of the file, in a folder that is there
        paper : of a PDF, one of `PAPERS`

        Returns
        -------
        tuple
            The paths of what was written.

        Raises
        ------
        OutputError
            If there is no format of that ending, or the file cannot be written there.
        FieldError
            If strips do not fit on the sheets, or cannot be made as asked for.
        """
        target = Path(path)
        ending = target.suffix.lower()
        if ending not in _WRITERS:
            raise OutputError(
                f"{target}: strips are saved by the ending of the name, which is one of "
                f"{', '.join(_WRITERS)}, not '{target.suffix}'"
            )
        if paper not in PAPERS:
            raise OutputError(f"there is no paper '{paper}'; the papers are {', '.join(PAPERS)}")
        check_writable(target)
        alone = replace(self, media=media_of([_KINDS[ending]], (paper,)))
        jobs = alone.pdf_files(target.stem, paper) if ending == ".pdf" else alone.files(ending, target.stem)
        return tuple(written_together(jobs, target.parent).values())

    def files(self, ending: str, stem: str) -> dict[str, Job]:
        """What writes each file of a format, by its name; everything that may be refused is refused here.

        Parameters
        ----------
        ending : of the names, such as ``".svg"``
        stem : of the names; where there are several sheets their numbers follow it
        """
        self._check_order()
        return _WRITERS[ending](self, stem)

    def pdf_files(self, stem: str, paper: str = "a4") -> dict[str, Job]:
        """As `files`, for pages on a paper."""
        self._check_order()
        pages, size, bench = self.pages(paper), PAPERS[paper], self.bench
        front = self.front(paper)
        return {
            f"{stem}.pdf": lambda path: write_pdf(
                path,
                self.pattern,
                pages,
                size,
                bench.paper_colours,
                bench.title,
                front,
                bench.making.mirror,
                bench.making.labels != "none",
            )
        }

    @cached_property
    def bill(self) -> Bill:
        """What the object takes to make."""
        pieces = tuple(each.piece for each in self.drawings)
        return bill_of(self.pattern, pieces, self.bench.making, self.bench.density)

    def front(self, paper: str) -> list[Line]:
        """The lines of the first pages: index, signs and key."""
        drawings = sorted(self.drawings, key=lambda each: (each.family, each.number, each.piece.number))
        pages = self.pages(paper)

        def lines(before: int) -> list[Line]:
            places = _places(pages, before)
            making, title = self.bench.making, self.bench.title
            return front_lines(self.pattern, drawings, places, making, self.bill, title)

        return lines(front_count(lines(0), PAPERS[paper]))

    @cached_property
    def places(self) -> dict[str, dict[Piece, tuple[int, int]]]:
        """Page or sheet of each piece, and its row there, by medium: "sheet" or the name of a paper."""
        found = {}
        for medium in self.media:
            if medium == "sheet":
                found[medium] = _places(self.sheets, 0)
            elif medium in PAPERS:
                before = front_count(self.front(medium), PAPERS[medium])
                found[medium] = _places(self.pages(medium), before)
        return found

    @cached_property
    def whereabouts(self) -> tuple[str, ...]:
        """For each strip where its pieces are, in words; "" where nothing that is cut is written."""
        words: list[list[str]] = [[] for _ in self.pattern.strips]
        for medium, found in self.places.items():
            for piece, (page, row) in found.items():
                name = "" if piece.total == 1 else f"{piece.number}/{piece.total} "
                what = f"sheet {page}" if medium == "sheet" else f"{PAPERS[medium].name} page {page}"
                words[piece.strip].append(f"{name}{what}, row {row}")
        return tuple("; ".join(each) for each in words)

    def _check_order(self) -> None:
        """Refuse to write strips of another weave than the design."""
        if self.pattern.reordered:
            raise FieldError(
                f"these strips are not written, as they are those of another weave: "
                f"{order_sentence(self.pattern.reordered)}; cut the weave as it was designed (--no-relax)"
            )

    def _standing(self, what: str) -> Mapping[str, Any]:
        if self.space is None:
            raise OutputError(
                f"the {what} needs the weave itself, as a pattern has no places in space; make the layout of "
                f"the weave, or leave the {what} out"
            )
        return trimmed(self.space, [strip.trimmed for strip in self.pattern.strips])

    def _numbered(self, stem: str) -> list[tuple[str, str, Sheet]]:
        """Name of the file and title of each sheet."""
        title, count = self.bench.title, len(self.sheets)
        if count == 1:
            return [(stem, title, self.sheets[0])]
        return [
            (f"{stem}-{number:02d}", f"{title}, sheet {number} of {count}", sheet)
            for number, sheet in enumerate(self.sheets, 1)
        ]

    def _svg(self, stem: str) -> dict[str, Job]:
        def job(sheet: Sheet, title: str) -> Job:
            return lambda path: write_svg(
                path, self.pattern, sheet, self.bench.colours, title, self.bench.making
            )

        return {f"{name}.svg": job(sheet, title) for name, title, sheet in self._numbered(stem)}

    def _dxf(self, stem: str) -> dict[str, Job]:
        def job(sheet: Sheet) -> Job:
            return lambda path: write_dxf(path, self.pattern, sheet, self.bench.colours)

        return {f"{name}.dxf": job(sheet) for name, _, sheet in self._numbered(stem)}

    def _csv(self, stem: str) -> dict[str, Job]:
        pieces = [each.piece for each in self.drawings]
        found = cut_list(self.pattern, self.bench.making, self.bench.stock_length, pieces)
        keys = {each.piece: "; ".join(key_text(each)) for each in self.drawings}
        return {f"{stem}.csv": _text(found.text(self.pattern, self.order, self.places, keys))}

    def _json(self, stem: str) -> dict[str, Job]:
        return {f"{stem}.json": _text(json.dumps(self.document(), indent=1, allow_nan=False) + "\n")}

    def _glb(self, stem: str) -> dict[str, Job]:
        from geoweave.fabrication.glb import write_glb

        space, families = self._standing("GLB"), self.bench.paper_colours.families
        return {f"{stem}.glb": lambda path: write_glb(path, space, families, self.bench.up)}

    def _html(self, stem: str) -> dict[str, Job]:
        from geoweave.fabrication.guide_page import guide_html

        space, bench = self._standing("guide"), self.bench
        check_made(self.pattern, bench.making, bench.stock)
        making, colours, found = bench.making, bench.paper_colours, self.whereabouts
        text = guide_html(self.pattern, space, making, bench.title, colours, self.order, found, bench.up)
        return {f"{stem}.html": _text(text)}


_WRITERS: dict[str, Callable[[StripLayout, str], dict[str, Job]]] = {
    ".svg": StripLayout._svg,
    ".dxf": StripLayout._dxf,
    ".pdf": StripLayout.pdf_files,
    ".csv": StripLayout._csv,
    ".json": StripLayout._json,
    ".glb": StripLayout._glb,
    ".html": StripLayout._html,
}


_KINDS = {
    ".svg": "svg",
    ".dxf": "dxf",
    ".pdf": "pdf",
    ".csv": "csv",
    ".json": "pattern",
    ".glb": "glb",
    ".html": "guide",
}
"""Ending of the files of each format."""


def layout(
    weave: Pattern | WeaveLike, bench: Bench | None = None, *, end: float | None = None
) -> StripLayout:
    """Lay the strips of a weave out on sheets.

    Everything that is cut is in millimetres. A weave is in the unit of its mesh until it is given a size:
    ``weave.sized(size=200)`` makes its largest extent 200 mm, and what is relaxed from it then has that size
    too. Without a size there is nothing to cut, and the weave is refused.

    Parameters
    ----------
    weave : a weave in mm, as designed or at rest, the contents of its ``weave.json`` or ``relaxed.json``, or
        a pattern
    bench : how the strips are made; by default on one long sheet
    end : what an open strip keeps beyond its outermost crossings, mm; four widths if not given, and
        everything with ``math.inf``

    Raises
    ------
    FieldError
        If the weave is not in mm.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6)
    >>> sheets = gw.fabrication.layout(weave.sized(size=100.0))
    >>> sum(len(sheet.laid) for sheet in sheets.sheets) == len(weave.ribbons)
    True
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     [path.name for path in sheets.save(folder + "/cone.svg")]
    ['cone.svg']
    >>> gw.fabrication.layout(weave)
    Traceback (most recent call last):
    ...
    geoweave.errors.FieldError: ... a pattern needs lengths in mm; ...
    """
    how = bench or Bench()
    if isinstance(weave, Pattern):
        return StripLayout(weave, how)
    document = weave_document(weave)
    pattern = pattern_of(document, end=free_end(document) if end is None else end)
    return StripLayout(pattern, how, document)


def _places(sheets: Sequence[Sheet], before: int) -> dict[Piece, tuple[int, int]]:
    """Number of the sheet of each piece, from 1 after those before, and of its row."""
    return {
        laid.drawn.piece: (number, laid.row)
        for number, sheet in enumerate(sheets, before + 1)
        for laid in sheet.laid
    }


def _few(sheets: tuple[Sheet, ...]) -> tuple[Sheet, ...]:
    if len(sheets) > MOST_SHEETS:
        raise FieldError(
            f"the pattern needs {len(sheets)} sheets, more than {MOST_SHEETS}; "
            "make the object smaller or ask for fewer ribbons"
        )
    return sheets


def _text(text: str) -> Job:
    def job(path: Path) -> None:
        path.write_text(text, encoding="utf-8", newline="\n")

    return job
