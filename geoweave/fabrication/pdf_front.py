"""The first pages of a PDF: where each strip is, what the signs mean, what is in the key, what it takes."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from geoweave.fabrication.bill import Bill
from geoweave.fabrication.marks import MARKS
from geoweave.fabrication.nesting import Sheet
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.pdf_marks import pdf_colour
from geoweave.fabrication.pieces import Making, Piece
from geoweave.fabrication.sheet_sizes import Paper
from geoweave.fabrication.strip_figures import Drawn
from geoweave.wording import counted

if TYPE_CHECKING:
    from reportlab.pdfgen.canvas import Canvas

__all__ = [
    "KEY_LETTERS",
    "Line",
    "draw_front",
    "front_count",
    "front_lines",
    "key_text",
    "page_key",
    "piece_name",
]

EDGE, COLUMN, STEP, LETTERS = 14.0, 66.0, 3.3, 2.3
"""Margin of a page, width of a column, distance of lines and height of the font, mm."""

WRAP = 58
"""Letters in a line."""

PER_LINE = 2
"""Entries of the key in a line."""


KEY_LETTERS, KEY_LINES = 2.1, 2
"""Height of the font of the key of a page, mm, and how many lines it may have."""


class Line(NamedTuple):
    """A line of a column."""

    text: str
    bold: bool = False


def front_lines(
    pattern: Pattern,
    drawings: Sequence[Drawn],
    places: dict[Piece, tuple[int, int]],
    making: Making,
    bill: Bill,
    title: str,
) -> list[Line]:
    """What stands on the first pages; how many lines it takes does not depend on the numbers of pages.

    Parameters
    ----------
    pattern, drawings, making, bill : the strips, as they are drawn, and what they take
    places : page and row of each piece
    title : of the drawings
    """
    lines = [Line(title, True), *_said(bill), Line(""), Line("How to read a strip", True)]
    side = "inwards, drawn as seen from the inside" if making.mirror else "outwards"
    lines += _wrapped(f"The printed side faces {side}. The arrow after a name points along the strip.")
    lines += _wrapped(
        "At each crossing stand the partner's name and a mark; the same mark stands on the partner. A solid "
        "mark under the partner's colour: this strip goes under. A hollow mark between dashed lines: over."
    )
    if any(each.joins for each in (drawing.piece for drawing in drawings)):
        lines += _wrapped(
            f"A8 1/2 is the first of two pieces of A8. Pieces overlap by {making.overlap:g} mm: where A8=1 "
            "stands on both, lay one on the other so that the end of each is at the line on the other, and "
            "glue. A closed strip is joined to its own start in the same way."
        )
    hoops = [strip.label for strip in pattern.strips if strip.hoop]
    if hoops:
        lines += _wrapped(
            f"Hoops: {', '.join(hoops)}, a closed strip round each opening, laid in last. Ribbons end "
            f"{making.hoops:g} mm beyond the middle of a hoop."
        )
    lines += [Line(""), Line("Strip: page, row", True)]
    for drawing in drawings:
        page, row = places[drawing.piece]
        lines.append(Line(f"{piece_name(pattern, drawing.piece)}: page {page}, row {row}"))
    listed = [each for each in drawings if each.key or not each.named]
    if listed and making.labels != "none":
        lines += [Line(""), Line("Key: partners without room for their names", True)]
        lines += _wrapped("Distances are in mm from the start of the piece, where its arrow comes from.")
    for drawing in listed if making.labels != "none" else ():
        name = piece_name(pattern, drawing.piece)
        page, row = places[drawing.piece]
        lines.append(Line(f"{name} (page {page}, row {row})"))
        texts = key_text(drawing)
        lines += [Line("   " + "; ".join(texts[k : k + PER_LINE])) for k in range(0, len(texts), PER_LINE)]
    return lines


def key_text(drawing: Drawn) -> list[str]:
    """The entries of the key for a piece: place, mark, partner, and which of the two lies above."""
    return [
        f"{line.at:.0f} {MARKS[line.mark] if line.marked else 'no mark'} {line.label} "
        f"{'over' if line.over else 'under'}"
        for line in drawing.key
    ]


def page_key(page: Sheet, wide: float) -> list[str]:
    """The lines below the strips of a page that say what its marks without names mean.

    Parameters
    ----------
    page : with its strips
    wide : what a line may take, mm
    """
    from reportlab.pdfbase.pdfmetrics import stringWidth

    entries = [f"row {laid.row} at {text}" for laid in page.laid for text in key_text(laid.drawn)]
    if not entries:
        return []
    lines, rest = ["Marks without a name (mm from the start of the piece): "], list(entries)
    while rest:
        # The last line keeps room for what says that there is more.
        more = "" if len(rest) == 1 or len(lines) < KEY_LINES else f"; {len(rest)} more in the key in front"
        fits = stringWidth(lines[-1] + rest[0] + more, "Helvetica", KEY_LETTERS) <= wide
        if fits:
            lines[-1] += rest.pop(0) + ("; " if rest else "")
        elif len(lines) < KEY_LINES:
            lines.append("")
        else:
            lines[-1] += f"{len(rest)} more in the key in front"
            break
    return lines


def piece_name(pattern: Pattern, piece: Piece) -> str:
    """The name of a piece, such as "A8 1/2"; of a strip in one piece that of the strip."""
    label = pattern.strips[piece.strip].label
    return label if piece.total == 1 else f"{label} {piece.number}/{piece.total}"


def front_count(lines: Sequence[Line], paper: Paper) -> int:
    """How many pages the lines take."""
    columns, rows = _grid(paper)
    return math.ceil(len(lines) / (columns * rows))


def draw_front(canvas: Canvas, lines: Sequence[Line], paper: Paper, number: int) -> None:
    """Draw the lines of one of the first pages, numbered from 0."""
    columns, rows = _grid(paper)
    canvas.setFillColor(pdf_colour("#22262b"))
    for k, line in enumerate(lines[number * columns * rows : (number + 1) * columns * rows]):
        column, row = divmod(k, rows)
        canvas.setFont("Helvetica-Bold" if line.bold else "Helvetica", LETTERS)
        canvas.drawString(EDGE + column * COLUMN, paper.height - EDGE - (row + 1) * STEP, line.text)


def _grid(paper: Paper) -> tuple[int, int]:
    """Columns of a page, and lines in a column; the lowest line is left to the number of the page."""
    return int((paper.width - 2 * EDGE) / COLUMN), int((paper.height - 2 * EDGE) / STEP) - 1


def _said(bill: Bill) -> list[Line]:
    return _wrapped(
        f"{counted(bill.strips, 'strip')} in {counted(bill.pieces, 'piece')}, "
        f"{counted(bill.crossings, 'crossing')}, {bill.metres:.1f} m, "
        f"{bill.grams:.0f} g. Fasten {counted(bill.fasten, 'crossing')} and {counted(bill.joins, 'join')}. "
        f"About {bill.hours:.0f} hours ({bill.difficulty})."
    )


def _wrapped(text: str) -> list[Line]:
    return [Line(part) for part in textwrap.wrap(text, WRAP)]
