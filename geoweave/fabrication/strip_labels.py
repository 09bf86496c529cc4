"""What is written on a strip: its name, where pieces match, and a label for every mark (Section 5.4).

What finds no room inside the strip stands beside it, with a line to its place.
"""

from __future__ import annotations

import numpy as np

from geoweave.errors import FieldError
from geoweave.fabrication.pattern import Passage
from geoweave.fabrication.strip_canvas import StripCanvas, text_room
from geoweave.fabrication.strip_figures import Role
from geoweave.fabrication.strip_marks import Placed
from geoweave.fabrication.stroke_font import Box

__all__ = ["write_labels", "write_names"]

ROWS = 24
"""Rows of text beside a strip before it is given up."""

STEMS = 30
"""Half heights of a letter within which the line to a text beside the strip may leave it."""

SMALLEST_BESIDE = 1.8
"""Smallest height of letters beside a strip, mm."""

REACH = (8.0, 40.0)
"""A name stands at most so many widths, and so many mm more, from the place that it belongs to."""


def write_names(canvas: StripCanvas) -> None:
    """Name and direction at both ends; what pieces there are; where pieces match."""
    name = f"{canvas.strip.label} >"
    if canvas.piece.total > 1:
        name = f"{canvas.strip.label} {canvas.piece.number}/{canvas.piece.total} >"
    for ahead in (False, True):
        _sought(canvas, name, canvas.length if ahead else 0.0, -1.0 if ahead else 1.0)
    for join in canvas.piece.joins:
        middle = 0.5 * (join.low + join.high) - canvas.piece.start
        _sought(canvas, join.name, middle, -1.0 if join.ahead else 1.0)


def _sought(canvas: StripCanvas, text: str, x: float, way: float) -> None:
    """Write a name inside the strip, as near to x as it goes; beside it where it does not."""
    step = 0.1 * canvas.width
    reach = min(0.5 * canvas.length, REACH[0] * canvas.width + REACH[1])
    sizes = [(height, text_room(text, height)) for height in canvas.heights]
    for k in range(int(reach / step)):
        for height, box in sizes:
            aside = canvas.inside - box.top
            first = min(max(x, canvas.pad + box.right), canvas.length - canvas.pad - box.right)
            for y in (0.0, aside, -aside) if aside >= 0 else ():
                spot = box.moved(first + way * k * step, y)
                if canvas.board.free(spot):
                    canvas.take(spot)
                    canvas.write("name", text, height, first + way * k * step, y, canvas.strip.family)
                    return
    _beside(canvas, text, x, None)


def write_labels(canvas: StripCanvas, placed: list[Placed | None]) -> None:
    """Write the label of each mark next to it, and beside the strip where there is no room."""
    marks = [spot.box for spot in placed if spot is not None]
    for each, spot in zip(canvas.passages, placed, strict=True):
        if spot is None or not _label(canvas, each, spot, marks):
            _beside(canvas, each.label, each.at, each, spot)


def _label(canvas: StripCanvas, each: Passage, spot: Placed, marks: list[Box]) -> bool:
    """Write a label next to its mark; whether there is room."""
    family = canvas.pattern.strips[each.partner].family
    near = [box for box in marks if abs(box.left - spot.box.left) < 6 * canvas.width and box != spot.box]
    for height in canvas.heights:
        box = text_room(each.label, height)
        across, up = spot.radius + 1.3 * canvas.pad + box.right, spot.radius + 1.3 * canvas.pad + box.top
        aside = canvas.inside - box.top
        if aside < 0:
            continue
        drop = min(aside, spot.radius)
        places = [(spot.x + way * across, y) for y in (spot.y, 0.0) for way in (1, -1)]
        places += [(spot.x, spot.y - up), (spot.x, spot.y + up)]
        places += [(spot.x + way * across, spot.y + lift) for lift in (drop, -drop) for way in (1, -1)]
        slide = 0.5 * (box.right - spot.radius)
        places += [(spot.x + way * slide, spot.y + lift) for lift in (-up, up) for way in (1, -1)]
        for x, y in places:
            there = box.moved(x, y)
            if abs(y) > aside + 1e-9 or not canvas.board.free(there):
                continue
            own = _distance(there, spot.box)
            if any(_distance(there, other) < 1.25 * own for other in near):
                continue
            canvas.take(there)
            canvas.write("label", each.label, height, x, y, family, each.crossing)
            return True
    return False


def _beside(
    canvas: StripCanvas, text: str, x: float, each: Passage | None, spot: Placed | None = None
) -> None:
    """Write beside the strip, with a line to the place.

    Parameters
    ----------
    canvas : the piece
    text : what is written
    x : the place along the piece
    each : the crossing that the text belongs to, if any
    spot : where its mark is; without one the mark stands beside the strip too
    """
    height = max(canvas.heights[-1], SMALLEST_BESIDE)
    radius = 0.6 * height if each is not None and spot is None else 0.0
    box = text_room(text, height)
    gap = canvas.pad if radius else 0.0
    wide, tall = box.right - box.left + 2 * radius + gap, max(box.top - box.bottom, 2 * radius)
    lead = 0.35 * height + 2 * canvas.pad + 0.5 * canvas.making.kerf
    row = tall + 1.6 * canvas.pad
    stems = _stems(canvas, x, 0.5 * height)
    for number in range(ROWS):
        low = canvas.edge + lead + number * row
        for stem in stems[: 5 + 4 * number]:
            for side in (1.0, -1.0):
                middle = side * (low + 0.5 * tall)
                foot, top = sorted((side * (canvas.edge + canvas.pad), side * low))
                line = Box(stem - 0.05, foot, stem + 0.05, top)
                for left in (stem - 0.3 * canvas.pad, stem + 0.3 * canvas.pad - wide, stem - 0.5 * wide):
                    whole = Box(left, middle - 0.5 * tall, left + wide, middle + 0.5 * tall)
                    if not canvas.board.free(whole) or (number and not canvas.board.free(line)):
                        continue
                    canvas.board.take(whole)
                    canvas.board.take(line)
                    family = canvas.strip.family
                    if each is not None:
                        family = canvas.pattern.strips[each.partner].family
                        origin = (each.at, 0.0 if spot is None else side * canvas.edge)
                        bend = [origin, (stem, side * (canvas.edge + 0.8 * lead)), (stem, side * low)]
                        canvas.add("leader", [np.array(bend)], False, family, "", each.crossing)
                        if radius:
                            canvas.mark(each, left + radius, middle, radius)
                    centre = left + wide - 0.5 * (box.right - box.left)
                    role: Role = "name" if each is None else "label"
                    crossing = -1 if each is None else each.crossing
                    canvas.write(role, text, height, centre, middle, family, crossing)
                    return
    raise FieldError(
        f"the crossings of strip {canvas.strip.label} are too dense to be labelled near {x:.4g} mm; "
        "make the object larger or ask for fewer ribbons"
    )


def _stems(canvas: StripCanvas, x: float, step: float) -> list[float]:
    """Where the line to a text beside the strip may leave it: the place itself, then ever further away."""
    shifts = [0.0] + [sign * k * step for k in range(1, STEMS) for sign in (1, -1)]
    return [min(max(x + shift, canvas.pad), canvas.length - canvas.pad) for shift in shifts]


def _distance(one: Box, other: Box) -> float:
    """Between two boxes, 0 where they touch."""
    across = max(one.left - other.right, other.left - one.right, 0.0)
    return float(np.hypot(across, max(one.bottom - other.top, other.bottom - one.top, 0.0)))
