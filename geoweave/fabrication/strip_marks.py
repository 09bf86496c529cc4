"""Where the marks of the crossings go on a strip: each on the line of its partner (Section 5.4, Fig. 20)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from geoweave.fabrication.pattern import Passage
from geoweave.fabrication.strip_canvas import StripCanvas
from geoweave.fabrication.stroke_font import Box, boxes_overlap

__all__ = ["Placed", "place_marks"]

SHRUNK = (1.0, 0.8, 0.62)
"""Sizes of marks that are tried, as shares of the largest radius."""


SMALLEST = 0.5
"""The smallest size, for marks that would stand on others."""


class Placed(NamedTuple):
    """A mark that was put down."""

    x: float
    y: float
    radius: float
    box: Box


def place_marks(canvas: StripCanvas) -> list[Placed | None]:
    """Put down the marks, each on the line of its partner; nothing for those without room."""
    placed: list[Placed | None] = []
    for cluster in _clusters(canvas):
        placed += _cluster(canvas, cluster)
    for each, spot in zip(canvas.passages, placed, strict=True):
        if spot is not None:
            canvas.mark(each, spot.x, spot.y, spot.radius)
    return placed


def _clusters(canvas: StripCanvas) -> Iterator[list[Passage]]:
    """Runs of crossings so near each other that their marks would touch."""
    run: list[Passage] = []
    for each in canvas.passages:
        if run and each.at - run[-1].at > 2 * canvas.radius + canvas.pad:
            yield run
            run = []
        run.append(each)
    if run:
        yield run


def _cluster(canvas: StripCanvas, run: list[Passage]) -> list[Placed | None]:
    """The largest marks for which there is room on the lines of all partners of a run."""
    aside = canvas.inside - canvas.radius
    patterns: list[list[float]] = [[0.0] * len(run)] if len(run) == 1 and not canvas.raised else []
    patterns += [[1.0] * len(run)] if canvas.raised else []
    patterns += [[(-1.0) ** (k + first) for k in range(len(run))] for first in (0, 1)]
    patterns += [[float((k + first) % 3 - 1) for k in range(len(run))] for first in (0, 1, 2)]
    for share in SHRUNK:
        radius = share * canvas.radius
        for sides in patterns:
            spots = [
                _spot(canvas, each, side * (aside + canvas.radius - radius), radius)
                for each, side in zip(run, sides, strict=True)
            ]
            boxes = [spot.box for spot in spots]
            apart = not any(
                boxes_overlap(one.grown(canvas.pad), other)
                for k, one in enumerate(boxes)
                for other in boxes[:k]
            )
            if apart and all(canvas.board.free(box) for box in boxes):
                for box in boxes:
                    canvas.take(box)
                return list(spots)
    found: list[Placed | None] = []
    for each in run:
        free = None
        for share in (*SHRUNK, SMALLEST):
            radius = share * canvas.radius
            for side in (0.0, 1.0, -1.0, 0.5, -0.5):
                spot = _spot(canvas, each, side * (canvas.inside - radius), radius)
                if free is None and canvas.board.free(spot.box):
                    free = spot
        if free is not None:
            canvas.take(free.box)
        found.append(free)
    return found


def _spot(canvas: StripCanvas, each: Passage, y: float, radius: float) -> Placed:
    angle = np.radians(each.angle)
    # Along the partner's line, but not away from the crossing where it is shallow.
    x = each.at + float(np.clip(y * np.cos(angle) / (np.sin(angle) or 1e-12), -abs(y), abs(y)))
    return Placed(x, y, radius, Box(x - radius, y - radius, x + radius, y + radius))
