"""A piece of a strip that is being drawn: its measures, what lies on it, and what room is left.

The parts of a drawing are put down one after the other, in `strip_marks`, `strip_labels` and
`strip_drawing`. Each takes room, and what comes later keeps clear of it.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from geoweave.fabrication.marks import outline
from geoweave.fabrication.pattern import Passage, Pattern
from geoweave.fabrication.pieces import Making, Piece, holes_of, shown
from geoweave.fabrication.strip_figures import Figure, Role, Spot, Unwritten
from geoweave.fabrication.stroke_font import PEN, Board, Box, text_box, text_strokes

__all__ = ["StripCanvas", "text_room", "turned_room"]

SMALLEST, LARGEST = 1.8, 4.5
"""Height of capital letters, mm: smaller ones are not read at arm's length, nor engraved cleanly."""

LETTERS = (0.34, 0.29, 0.25, 0.21)
"""Heights of letters that are tried, in widths of the strip."""

LARGEST_MARK = 3.5
"""Largest radius of a mark, mm; on narrow strips it is a fifth of the width."""


class StripCanvas:
    """A piece of a strip that is being drawn; its start is at x = 0, its middle at y = 0.

    Attributes
    ----------
    pattern, piece, making : what is drawn
    raised : whether marks stand at an edge, with room for a line of names along the other one
    strip : the strip that the piece is of
    width, length : of the piece, mm
    edge : from the middle to the edge, mm
    inside : from the middle to where writing must end, mm
    pad : gap between neighbouring texts and marks, mm
    heights : of the letters that are tried, the largest first, mm
    radius : of the largest marks, mm
    board : the room that is left
    clear : boxes of writing, which guides leave free
    figures : what has been drawn
    passages : crossings on the piece, their places from its start
    holes : places of holes from its start, those that its end cuts through too
    key : crossings whose names find no room
    named : whether the name of the strip found room
    """

    def __init__(self, pattern: Pattern, piece: Piece, making: Making, raised: bool = False) -> None:
        self.pattern, self.piece, self.making, self.raised = pattern, piece, making, raised
        self.strip = pattern.strips[piece.strip]
        self.width, self.length = pattern.width, piece.length
        self.edge = 0.5 * pattern.width
        self.inside = self.edge - min(0.04 * pattern.width, 0.4)
        self.pad = min(max(0.07 * pattern.width, 0.25), 0.8)
        self.heights = sorted(
            {min(max(share * self.width, SMALLEST), LARGEST) for share in LETTERS},
            reverse=True,
        )
        self.radius = min(0.2 * self.width, LARGEST_MARK)
        self.board = Board(self.pad, self.length - self.pad, self.pad)
        self.clear: list[Box] = []
        self.figures: list[Figure] = []
        side = -1.0 if making.mirror else 1.0
        self.passages = [
            each._replace(at=each.at - piece.start, angle=side * each.angle)
            for each in shown(pattern, piece, self.radius + self.pad)
        ]
        self.key: list[Unwritten] = []
        self.named = True
        self.holes = [at - piece.start for at in holes_of(pattern, piece, making)]
        for at in self.holes:
            self.take(Box(at, 0.0, at, 0.0).grown(0.5 * making.holes))

    def add(
        self,
        role: Role,
        paths: Iterable[NDArray[np.float64]],
        closed: bool,
        family: int | None = None,
        text: str = "",
        crossing: int = -1,
    ) -> None:
        """Draw lines or areas, if there are any; in the colour of this strip unless another is named."""
        lines = tuple(paths)
        if lines:
            whose = self.strip.family if family is None else family
            self.figures.append(Figure(role, lines, closed, whose, text, crossing))

    def mark(self, each: Passage, x: float, y: float, radius: float) -> None:
        """Draw the mark of a crossing: hollow where this strip goes over, solid where it goes under."""
        family = self.pattern.strips[each.partner].family
        role: Role = "hollow" if each.over else "solid"
        self.figures.append(
            Figure(
                role,
                (radius * outline(each.mark) + [x, y],),
                True,
                family,
                crossing=each.crossing,
                spot=Spot(x, y, radius),
                mark=each.mark,
            )
        )

    def take(self, box: Box) -> None:
        """Keep others out of a box, and guides too."""
        self.board.take(box)
        self.clear.append(box.grown(0.5 * self.pad))

    def write(
        self,
        role: Role,
        text: str,
        spot: Spot,
        family: int,
        crossing: int = -1,
    ) -> None:
        """Write a text about a point, with letters of a height; a turned one reads upwards."""
        strokes, _ = text_strokes(text, spot.size, 0.0, 0.0)
        if spot.turn:
            strokes = tuple(np.stack([-each[:, 1], each[:, 0]], axis=1) for each in strokes)
        paths = tuple(each + [spot.x, spot.y] for each in strokes)
        printed = self.making.labels == "printed"
        pen = PEN * spot.size
        self.figures.append(Figure(role, paths, False, family, text, crossing, pen, spot, printed=printed))

    def unwritten(self, each: Passage, marked: bool) -> None:
        """Put a crossing into the key."""
        self.key.append(Unwritten(each.crossing, each.at, each.label, each.mark, each.over, marked))


def text_room(text: str, height: float) -> Box:
    """What a text about the origin takes up, with half a gap between letters on either side."""
    return text_box(text, height).wider(0.12 * height)


def turned_room(text: str, height: float) -> Box:
    """The same for a text that reads upwards."""
    left, bottom, right, top = text_room(text, height)
    return Box(-top, left, -bottom, right)
