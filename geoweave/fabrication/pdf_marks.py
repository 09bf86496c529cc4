"""Drawn strips as the operators of a PDF page, with texts that can be searched for.

Operators are written here: most of the time of a file would go into how the library writes them. A colour, a
width or a fill is said only where it changes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cache
from typing import Any

from geoweave.fabrication.colours import Colours, ink
from geoweave.fabrication.nesting import Sheet
from geoweave.fabrication.strip_figures import LAYERS, ROLES, Figure, Spot
from geoweave.fabrication.stroke_font import text_box

__all__ = ["FONT", "pdf_colour", "strip_operators"]

FONT = "/F1"
"""The name of Helvetica in a file: a canvas begins with it."""

CAPITAL = 0.718
"""Height of its capital letters in heights of the font (Adobe's metrics of the standard fonts)."""

ROUND_OFF = 0.5523
"""How far the handles of a Bezier curve that is a quarter of a circle are from its ends, in radii."""


def strip_operators(page: Sheet, colours: Colours, left: float, low: float) -> list[str]:
    """What draws the strips of a page, layer by layer, mm.

    Parameters
    ----------
    page : with the strips
    colours : of the families
    left, low : where the corner of the sheet is on the page
    """
    shown = [[figure.moved(left, low) for figure in laid.figures] for laid in page.laid]
    code: list[str] = []
    state = _State()
    for layer in LAYERS:
        for figures in shown:
            for figure in figures:
                if ROLES[figure.role] == layer:
                    code += _figure(figure, colours, state)
    # Whoever paints these operators ends them with a path, which is empty.
    return [*code, "0 0 m"]


class _State:
    """What has been said of colours and widths."""

    def __init__(self) -> None:
        self.said: dict[str, str] = {}

    def changes(self, **wanted: str) -> list[str]:
        """The operators for what is not as wanted."""
        changed = [text for name, text in wanted.items() if self.said.get(name) != text]
        self.said |= wanted
        return changed


def _figure(figure: Figure, colours: Colours, state: _State) -> list[str]:
    look = ink(figure, colours)
    if look is None:
        return []
    if figure.text and figure.spot is not None:
        colour = look.stroke or look.fill or "#000000"
        return [*state.changes(fill=f"{_rgb(colour)} rg"), _text(figure.text, figure.spot)]
    code = []
    if look.stroke is not None:
        code += state.changes(stroke=f"{_rgb(look.stroke)} RG", width=f"{look.width:g} w")
    if look.fill is not None:
        code += state.changes(fill=f"{_rgb(look.fill)} rg")
    if figure.role == "hole" and figure.spot is not None:
        code.append(_circle(figure.spot))
    else:
        for points in figure.paths:
            code += [f"{x:.3f} {y:.3f} {'l' if k else 'm'}" for k, (x, y) in enumerate(points.tolist())]
            code += ["h"] if figure.closed else []
    code.append("B" if look.stroke and look.fill else "f" if look.fill else "S")
    return code


def _circle(spot: Spot) -> str:
    """A circle of four curves."""
    x, y, r = spot.x, spot.y, spot.size
    k = ROUND_OFF * r
    quarter = [(r, k), (k, r), (0.0, r)]
    places: list[tuple[float, float]] = []
    for _ in range(4):
        places += quarter
        quarter = [(-v, u) for u, v in quarter]
    numbers = [f"{x + u:.3f} {y + v:.3f}" for u, v in places]
    curves = [" ".join(numbers[n : n + 3]) + " c" for n in range(0, 12, 3)]
    return f"{x + r:.3f} {y:.3f} m " + " ".join(curves) + " h"


def _text(text: str, spot: Spot) -> str:
    """A text in Helvetica, as high and as wide as its strokes would be."""
    box, size = text_box(text, spot.size), spot.size / CAPITAL
    wide = box.right - box.left
    turn = math.radians(spot.turn)
    c, s = math.cos(turn), math.sin(turn)
    x = spot.x - 0.5 * wide * c + 0.5 * spot.size * s
    y = spot.y - 0.5 * wide * s - 0.5 * spot.size * c
    stretch = 100 * wide / (size * _width(text))
    # Numbers of a PDF have no exponents (ISO 32000-1, 7.3.3): a text with one is not drawn.
    return (
        f"BT {FONT} {size:.4f} Tf {stretch:.2f} Tz "
        f"{c:.5f} {s:.5f} {-s:.5f} {c:.5f} {x:.3f} {y:.3f} Tm ({_escaped(text)}) Tj ET"
    )


@cache
def _width(text: str) -> float:
    """Width of a text in heights of the font."""
    from reportlab.pdfbase.pdfmetrics import stringWidth

    return float(stringWidth(text, "Helvetica", 1.0))


def _escaped(text: str) -> str:
    return text.replace("\\", "\\\\").replace("(", "\\(").replace(")", "\\)")


@cache
def _rgb(colour: str) -> str:
    parts: Iterable[int] = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return " ".join(f"{part / 255:.4g}" for part in parts)


@cache
def pdf_colour(colour: str) -> Any:
    """A colour of reportlab, which reads the name of a colour as slowly as a line of Python."""
    from reportlab.lib.colors import HexColor

    return HexColor(colour)
