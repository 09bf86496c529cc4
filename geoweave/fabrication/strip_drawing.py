"""The drawing of one piece of a strip: outline, guides, marks, labels (Section 5.4, Fig. 20, Appendix F).

At each crossing the edges of the partner are drawn at the angle at which it crosses. A strip that goes under
has them doubled, its mark is solid and the partner's colour lies on it; a strip that goes over has them
dashed and a hollow mark. Guides leave room for text. Nothing stands beside the strip, where it would be cut
off: what finds no room inside is listed in `Drawn.key`.
"""

from __future__ import annotations

import math
import re

import numpy as np
from numpy.typing import NDArray

from geoweave.fabrication.clipping import clipped, dashes, outside, rectangle, within
from geoweave.fabrication.marks import circle
from geoweave.fabrication.pattern import Passage, Pattern
from geoweave.fabrication.pieces import Making, Piece
from geoweave.fabrication.strip_canvas import StripCanvas
from geoweave.fabrication.strip_figures import Drawn, Figure, Spot
from geoweave.fabrication.strip_labels import write_labels, write_names
from geoweave.fabrication.strip_marks import place_marks
from geoweave.fabrication.stroke_font import Box, boxes_overlap

__all__ = ["drawn", "inset_of", "number_of"]

NICK = (0.12, 1.2)
"""How deep a nick goes into the edge: a share of the width, and at most so many mm."""

CRUMB = 0.08
"""Pieces of guides shorter than this share of the width are left out."""

HOLE_POINTS = 32
"""Corners of a hole where a file knows no circles."""

SHALLOW = 0.3
"""Sine of the angle of a crossing below which no arrow shows where the partner leaves the strip."""


def drawn(pattern: Pattern, piece: Piece, making: Making) -> Drawn:
    """Draw a piece of a strip with everything that is marked on it.

    Parameters
    ----------
    pattern : the strips
    piece : which part of which strip, one of `pieces_of`
    making : how strips are cut

    Examples
    --------
    >>> cone = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=100.0)
    >>> pattern, making = gw.fabrication.pattern_of(cone), gw.fabrication.Making()
    >>> first = gw.fabrication.pieces_of(pattern, making)[0]
    >>> sheet = gw.fabrication.drawn(pattern, first, making)
    >>> names = {each.text for each in sheet.figures if each.role == "name"}
    >>> names == {f"{pattern.strips[0].label} >"}
    True
    """
    canvas = _written(pattern, piece, making, False)
    if canvas.key or not canvas.named:
        other = _written(pattern, piece, making, True)
        if (other.named, -len(other.key)) > (canvas.named, -len(canvas.key)):
            canvas = other
    # Writing takes its room first, but it is drawn above what lies under it.
    writing, canvas.figures = canvas.figures, []
    outline = _body(canvas)
    for each in canvas.passages:
        _guides(canvas, each)
    figures = (*canvas.figures, *writing)
    low, high = outline.min(axis=0), outline.max(axis=0)
    x, y = outline.T
    return Drawn(
        piece,
        figures,
        Box(float(low[0]), float(low[1]), float(high[0]), float(high[1])),
        canvas.strip.family,
        number_of(canvas.strip.label, piece.strip),
        0.5 * float(abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))),
        tuple(canvas.key),
        canvas.named,
        min((f.spot.size for f in writing if f.text and f.spot is not None), default=math.inf),
    )


def _written(pattern: Pattern, piece: Piece, making: Making, raised: bool) -> StripCanvas:
    """A piece with its marks and names, marks in the middle or at an edge."""
    canvas = StripCanvas(pattern, piece, making, raised)
    placed = place_marks(canvas)
    write_names(canvas)
    write_labels(canvas, placed)
    _headings(canvas)
    return canvas


def inset_of(width: float) -> float:
    """How far within the edges of the partner the second lines are, on a strip that goes under."""
    return min(0.07 * width, 0.6)


def number_of(label: str, otherwise: int) -> int:
    """The number in the name of a strip, such as 12 of A12."""
    found = re.search(r"\d+$", label)
    return int(found[0]) if found else otherwise


def _body(canvas: StripCanvas) -> NDArray[np.float64]:
    """Colour, folds, nicks, holes, and the outline, which is returned."""
    out, half = 0.5 * canvas.making.kerf, canvas.edge + 0.5 * canvas.making.kerf
    whole = rectangle(0.0, canvas.length, canvas.edge)
    canvas.add("ground", [whole], True)
    outline = rectangle(-out, canvas.length + out, half)
    canvas.add("outline", [outline], True)
    folds = [each.low if each.ahead else each.high for each in canvas.piece.joins]
    if not canvas.strip.closed and canvas.making.extra:
        folds += [0.0, canvas.strip.length]
    lines = [np.array([[x, -canvas.edge], [x, canvas.edge]]) for x in np.array(folds) - canvas.piece.start]
    inner = [each for each in lines if 1e-9 < each[0, 0] < canvas.length - 1e-9]
    canvas.add("fold", [part for each in inner for part in outside(each, canvas.clear)], False)
    if canvas.making.score:
        deep = canvas.edge - min(NICK[0] * canvas.width, NICK[1])
        for each in canvas.passages:
            nicks = [np.array([[each.at, s * canvas.edge], [each.at, s * deep]]) for s in (1, -1)]
            canvas.add("nick", nicks, False, crossing=each.crossing)
    radius = 0.5 * (canvas.making.holes - canvas.making.kerf)
    ring = radius * circle(HOLE_POINTS)
    for at in canvas.holes:
        hole = Figure("hole", (ring + [at, 0.0],), True, canvas.strip.family, spot=Spot(at, 0.0, radius))
        canvas.figures.append(hole)
    return outline


def _headings(canvas: StripCanvas) -> None:
    """A small arrow where the partner leaves the strip, so that it is not laid the wrong way round."""
    size = 0.09 * canvas.width
    for each in canvas.passages:
        angle = np.radians(each.angle)
        if abs(np.sin(angle)) < SHALLOW:
            continue
        way = np.array([np.cos(angle), np.sin(angle)])
        tip = np.array([each.at, 0.0]) + way * (canvas.edge - 0.3 * canvas.pad) / abs(way[1])
        side = np.array([-way[1], way[0]])
        arrow = np.array([tip - size * (way + 0.7 * side), tip, tip - size * (way - 0.7 * side)])
        low, high = arrow.min(axis=0), arrow.max(axis=0)
        box = Box(float(low[0]), float(low[1]), float(high[0]), float(high[1]))
        on_strip = box.left > 0 and box.right < canvas.length
        if on_strip and not any(boxes_overlap(box, other) for other in canvas.clear):
            # At the edge: it may touch other arrows, but no writing may lie on it.
            canvas.board.take(box)
            canvas.add(
                "heading", [arrow], False, canvas.pattern.strips[each.partner].family, "", each.crossing
            )


def _long(line: NDArray[np.float64]) -> float:
    return float(np.hypot(*(line[1] - line[0])))


def _guides(canvas: StripCanvas, each: Passage) -> None:
    """The edges of the partner at its angle, and its colour where it lies on top."""
    angle = np.radians(each.angle)
    way = np.array([np.cos(angle), np.sin(angle)])
    left = np.array([-way[1], way[0]])
    middle, far = np.array([each.at, 0.0]), way * (canvas.length + 4 * canvas.width)
    family = canvas.pattern.strips[each.partner].family
    if not each.over:
        corners = np.array(
            [s * canvas.edge * left + t * far for s, t in ((1, -1), (1, 1), (-1, 1), (-1, -1))]
        )
        band = clipped(middle + corners, canvas.length, canvas.edge)
        canvas.add("band", [band] if len(band) > 2 else [], True, family, "", each.crossing)
    offsets = (canvas.edge,) if each.over else (canvas.edge, canvas.edge - inset_of(canvas.width))
    lines: list[NDArray[np.float64]] = []
    whole: list[NDArray[np.float64]] = []
    for offset in offsets:
        for sign in (1.0, -1.0):
            base = middle + sign * offset * left
            seen = within(base - far, base + far, canvas.length, canvas.edge)
            if seen is not None:
                whole.append(np.array(seen))
                parts = dashes(*seen, min(0.3 * canvas.width, 3.0)) if each.over else [np.array(seen)]
                lines += [part for dash in parts for part in outside(dash, canvas.clear)]
    # What is left of a line between two letters says nothing.
    lines = [each for each in lines if _long(each) > CRUMB * canvas.width]
    # Without any line nobody would know how the partner lies, so one of them crosses the letters.
    lines = lines or sorted(whole, key=_long)[-1:]
    canvas.add("over" if each.over else "under", lines, False, family, "", each.crossing)
