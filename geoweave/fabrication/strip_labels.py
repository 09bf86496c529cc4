"""What is written on a strip: its name, where pieces match, and a label for every mark (Section 5.4).

Everything stands inside the strip, as what stands beside it would be cut off. What finds no room stands in
the key: the mark alone is on the strip then, and the key says whose it is.
"""

from __future__ import annotations

import math

from geoweave.fabrication.pattern import Passage
from geoweave.fabrication.strip_canvas import StripCanvas, text_room, turned_room
from geoweave.fabrication.strip_figures import Spot
from geoweave.fabrication.strip_marks import Placed
from geoweave.fabrication.stroke_font import Box

__all__ = ["write_labels", "write_names"]

REACH = (8.0, 40.0)
"""A name stands at most so many widths, and so many mm more, from the place that it belongs to."""

UPRIGHT = 90.0
"""Degrees by which a name is turned that reads upwards."""


def write_names(canvas: StripCanvas) -> None:
    """Name and direction at both ends; what pieces there are; where pieces match."""
    if canvas.making.labels == "none":
        canvas.named = False
        return
    name = f"{canvas.strip.label} >"
    if canvas.piece.total > 1:
        name = f"{canvas.strip.label} {canvas.piece.number}/{canvas.piece.total} >"
    for join in canvas.piece.joins:
        middle = 0.5 * (join.low + join.high) - canvas.piece.start
        _sought(canvas, join.name, middle, -1.0 if join.ahead else 1.0)
    found = [_sought(canvas, name, 0.0, 1.0), _sought(canvas, name, canvas.length, -1.0)]
    canvas.named = any(found)


def _sought(canvas: StripCanvas, text: str, x: float, way: float) -> bool:
    """Write a name inside the strip, as near to x as it goes; whether there is room."""
    step = 0.1 * canvas.width
    reach = min(0.5 * canvas.length, REACH[0] * canvas.width + REACH[1])
    sizes = [(height, text_room(text, height)) for height in canvas.heights]
    found: tuple[int, Box, Spot] | None = None
    for height, box in sizes:
        aside = canvas.inside - box.top
        first = min(max(x, canvas.pad + box.right), canvas.length - canvas.pad - box.right)
        for y in (0.0, aside, -aside) if aside >= 0 else ():
            most = int(reach / step) if found is None else found[0]
            k = canvas.board.first_free(box, y, first, way * step, most)
            if k is not None:
                there = first + way * k * step
                found = k, box.moved(there, y), Spot(there, y, height)
    if found is None:
        return False
    canvas.take(found[1])
    canvas.write("name", text, found[2], canvas.strip.family)
    return True


def write_labels(canvas: StripCanvas, placed: list[Placed | None]) -> None:
    """Write the label of each mark next to it, or put it into the key where there is no room."""
    marks = [spot.box for spot in placed if spot is not None]
    plain = canvas.making.labels == "none"
    for each, spot in zip(canvas.passages, placed, strict=True):
        if plain or spot is None or not _label(canvas, each, spot, marks):
            canvas.unwritten(each, spot is not None)


def _label(canvas: StripCanvas, each: Passage, spot: Placed, marks: list[Box]) -> bool:
    """Write a label next to its mark; whether there is room."""
    family = canvas.pattern.strips[each.partner].family
    near = [box for box in marks if abs(box.left - spot.box.left) < 6 * canvas.width and box != spot.box]
    for height in canvas.heights:
        for turn, box in ((0.0, text_room(each.label, height)), (UPRIGHT, turned_room(each.label, height))):
            for x, y in _places(canvas, spot, box):
                there = box.moved(x, y)
                if not canvas.board.free(there):
                    continue
                own = _distance(there, spot.box)
                if any(_distance(there, other) < 1.25 * own for other in near):
                    continue
                canvas.take(there)
                canvas.write("label", each.label, Spot(x, y, height, turn), family, each.crossing)
                return True
    return False


def _places(canvas: StripCanvas, spot: Placed, box: Box) -> list[tuple[float, float]]:
    """Where a label may stand next to its mark, the best first; all inside the strip."""
    aside = canvas.inside - box.top
    if aside < 0:
        return []
    across, up = spot.radius + 1.3 * canvas.pad + box.right, spot.radius + 1.3 * canvas.pad + box.top
    drop = min(aside, spot.radius)
    places = [(spot.x + way * across, y) for y in (spot.y, 0.0) for way in (1, -1)]
    beside = [0.0, *(way * share * (box.right - spot.radius) for share in (0.5, 1.0) for way in (1, -1))]
    if canvas.raised:
        places = [(spot.x + slide, spot.y - up) for slide in beside] + places
    places += [(spot.x, spot.y - up), (spot.x, spot.y + up)]
    places += [(spot.x + way * across, spot.y + lift) for lift in (drop, -drop) for way in (1, -1)]
    slide = 0.5 * (box.right - spot.radius)
    places += [(spot.x + way * slide, spot.y + lift) for lift in (-up, up) for way in (1, -1)]
    places += [(spot.x + way * across, y) for y in (aside, -aside) for way in (1, -1)]
    return [(x, y) for x, y in places if abs(y) <= aside + 1e-9]


def _distance(one: Box, other: Box) -> float:
    """Between two boxes, 0 where they touch."""
    across = max(one.left - other.right, other.left - one.right, 0.0)
    return math.hypot(across, max(one.bottom - other.top, other.bottom - one.top, 0.0))
