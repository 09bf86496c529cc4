"""The drawing of one piece of a strip: outline, guides, marks, labels (Section 5.4, Fig. 20, Appendix F).

At each crossing the edges of the partner are drawn at the angle at which it crosses. A strip that goes under
has them doubled, its mark is solid and the partner's colour lies on it; a strip that goes over has them
dashed and a hollow mark. Guides leave room for text. What finds no room inside stands beside the strip, with
a line to its place.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from geoweave.errors import FieldError
from geoweave.fabrication.clipping import clipped, dashes, outside, rectangle, within
from geoweave.fabrication.marks import outline
from geoweave.fabrication.pattern import Passage, Pattern
from geoweave.fabrication.pieces import Making, Piece, shown
from geoweave.fabrication.stroke_font import PEN, Board, Box, boxes_overlap, text_box, text_strokes

__all__ = ["LAYERS", "ROLES", "Drawn", "Figure", "Role", "drawn"]

Role: TypeAlias = Literal[
    "ground",
    "band",
    "outline",
    "fold",
    "under",
    "over",
    "heading",
    "leader",
    "hollow",
    "solid",
    "label",
    "name",
]
Paths: TypeAlias = tuple[NDArray[np.float64], ...]

LAYERS = ("colour", "cut", "score", "guide", "label")
"""From the bottom up."""

ROLES: dict[Role, str] = {
    "ground": "colour",
    "band": "colour",
    "outline": "cut",
    "fold": "score",
    "under": "guide",
    "over": "guide",
    "heading": "guide",
    "leader": "guide",
    "hollow": "guide",
    "solid": "guide",
    "label": "label",
    "name": "label",
}
"""Layer of each kind of figure."""

SMALLEST, LARGEST = 1.3, 4.5
"""Height of letters, mm."""

ROWS = 24
"""Rows of text beside a strip before it is given up."""


class Figure(NamedTuple):
    """Lines or an area that are drawn together."""

    role: Role
    paths: Paths
    """(P, 2) each, mm."""
    closed: bool
    family: int
    """Whose colour it has."""
    text: str = ""
    """What its letters say."""
    crossing: int = -1
    """The crossing it belongs to."""
    pen: float = 0.0
    """Width of the lines of letters, mm."""

    def moved(self, x: float, y: float) -> Figure:
        """The same figure elsewhere."""
        return self._replace(paths=tuple(path + [x, y] for path in self.paths))


class Drawn(NamedTuple):
    """The drawing of a piece; its start is at x = 0, its middle at y = 0."""

    piece: Piece
    figures: tuple[Figure, ...]
    extent: Box
    """With what stands beside the strip."""


def drawn(pattern: Pattern, piece: Piece, making: Making) -> Drawn:
    """Draw a piece of a strip with everything that is marked on it.

    Raises
    ------
    FieldError
        If crossings are so dense that their labels find no place even beside the strip.
    """
    return _Drawing(pattern, piece, making).finished()


class _Placed(NamedTuple):
    """A mark that was put down."""

    x: float
    y: float
    radius: float
    box: Box


class _Drawing:
    """A piece that is being drawn."""

    def __init__(self, pattern: Pattern, piece: Piece, making: Making) -> None:
        self.pattern, self.piece, self.making = pattern, piece, making
        self.strip = pattern.strips[piece.strip]
        self.width, self.length = pattern.width, piece.length
        self.edge = 0.5 * pattern.width
        self.inside = self.edge - min(0.04 * pattern.width, 0.4)
        self.pad = min(max(0.07 * pattern.width, 0.25), 0.8)
        self.heights = sorted(
            {min(max(share * self.width, SMALLEST), LARGEST) for share in (0.34, 0.29, 0.25, 0.21)},
            reverse=True,
        )
        self.radius = min(0.2 * self.width, 3.5)
        self.board = Board(self.pad, self.length - self.pad, self.pad)
        self.clear: list[Box] = []
        """What guides leave free."""
        self.figures: list[Figure] = []
        self.passages = [
            each._replace(at=each.at - piece.start) for each in shown(pattern, piece, self.radius + self.pad)
        ]

    def finished(self) -> Drawn:
        placed = self._marks()
        self._names()
        self._headings()
        self._labels(placed)
        writing = self.figures
        self.figures = []
        self._body()
        for each in self.passages:
            self._guides(each)
        self.figures += writing
        points = np.concatenate([path for figure in self.figures for path in figure.paths])
        low, high = points.min(axis=0), points.max(axis=0)
        return Drawn(
            self.piece,
            tuple(self.figures),
            Box(float(low[0]), float(low[1]), float(high[0]), float(high[1])),
        )

    def _add(
        self,
        role: Role,
        paths: Iterable[NDArray[np.float64]],
        closed: bool,
        family: int | None = None,
        text: str = "",
        crossing: int = -1,
    ) -> None:
        lines = tuple(paths)
        if lines:
            whose = self.strip.family if family is None else family
            self.figures.append(Figure(role, lines, closed, whose, text, crossing))

    def _body(self) -> None:
        """Colour, outline, and where strips end and overlap."""
        out, half = 0.5 * self.making.kerf, self.edge + 0.5 * self.making.kerf
        whole = rectangle(0.0, self.length, self.edge)
        self._add("ground", [whole], True)
        self._add("outline", [rectangle(-out, self.length + out, half)], True)
        folds = [each.low if each.ahead else each.high for each in self.piece.joins]
        if not self.strip.closed and self.making.extra:
            folds += [0.0, self.strip.length]
        lines = [np.array([[x, -self.edge], [x, self.edge]]) for x in np.array(folds) - self.piece.start]
        inner = [each for each in lines if 1e-9 < each[0, 0] < self.length - 1e-9]
        self._add("fold", [part for each in inner for part in outside(each, self.clear)], False)

    # ---- marks

    def _marks(self) -> list[_Placed | None]:
        """Put down the marks, each on the line of its partner; nothing for those without room."""
        placed: list[_Placed | None] = []
        for cluster in self._clusters():
            placed += self._cluster(cluster)
        for each, spot in zip(self.passages, placed, strict=True):
            if spot is not None:
                self._mark(each, spot.x, spot.y, spot.radius)
        return placed

    def _clusters(self) -> Iterator[list[Passage]]:
        """Runs of crossings so near each other that their marks would touch."""
        run: list[Passage] = []
        for each in self.passages:
            if run and each.at - run[-1].at > 2 * self.radius + self.pad:
                yield run
                run = []
            run.append(each)
        if run:
            yield run

    def _cluster(self, run: list[Passage]) -> list[_Placed | None]:
        """The largest marks for which there is room on the lines of all partners of a run."""
        aside = self.inside - self.radius
        patterns: list[list[float]] = [[0.0] * len(run)] if len(run) == 1 else []
        patterns += [[(-1.0) ** (k + first) for k in range(len(run))] for first in (0, 1)]
        patterns += [[float((k + first) % 3 - 1) for k in range(len(run))] for first in (0, 1, 2)]
        for share in (1.0, 0.8, 0.62):
            radius = share * self.radius
            for sides in patterns:
                spots = [
                    self._spot(each, side * (aside + self.radius - radius), radius)
                    for each, side in zip(run, sides, strict=True)
                ]
                boxes = [spot.box for spot in spots]
                apart = not any(
                    boxes_overlap(one.grown(self.pad), other)
                    for k, one in enumerate(boxes)
                    for other in boxes[:k]
                )
                if apart and all(self.board.free(box) for box in boxes):
                    for box in boxes:
                        self._take(box)
                    return list(spots)
        found: list[_Placed | None] = []
        for each in run:
            free = None
            for share in (0.8, 0.62):
                for side in (0.0, 1.0, -1.0):
                    spot = self._spot(each, side * (self.inside - share * self.radius), share * self.radius)
                    if free is None and self.board.free(spot.box):
                        free = spot
            if free is not None:
                self._take(free.box)
            found.append(free)
        return found

    def _spot(self, each: Passage, y: float, radius: float) -> _Placed:
        angle = np.radians(each.angle)
        # Along the partner's line, but not away from the crossing where it is shallow.
        x = each.at + float(np.clip(y * np.cos(angle) / (np.sin(angle) or 1e-12), -abs(y), abs(y)))
        return _Placed(x, y, radius, Box(x - radius, y - radius, x + radius, y + radius))

    def _mark(self, each: Passage, x: float, y: float, radius: float) -> None:
        family = self.pattern.strips[each.partner].family
        role: Role = "hollow" if each.over else "solid"
        self._add(role, [radius * outline(each.mark) + [x, y]], True, family, crossing=each.crossing)

    def _take(self, box: Box) -> None:
        self.board.take(box)
        self.clear.append(box.grown(0.5 * self.pad))

    # ---- writing

    def _names(self) -> None:
        """Name and direction at both ends; what pieces there are; where pieces match."""
        name = f"{self.strip.label} >"
        if self.piece.total > 1:
            name = f"{self.strip.label} {self.piece.number}/{self.piece.total} >"
        for ahead in (False, True):
            self._sought(name, self.length if ahead else 0.0, -1.0 if ahead else 1.0)
        for join in self.piece.joins:
            middle = 0.5 * (join.low + join.high) - self.piece.start
            self._sought(join.name, middle, -1.0 if join.ahead else 1.0)

    def _sought(self, text: str, x: float, way: float) -> None:
        """Write a name inside the strip, as near to x as it goes; beside it where it does not."""
        step = 0.1 * self.width
        reach = min(0.5 * self.length, 8 * self.width + 40)
        sizes = [(height, self._box(text, height)) for height in self.heights]
        for k in range(int(reach / step)):
            for height, box in sizes:
                aside = self.inside - box.top
                first = min(max(x, self.pad + box.right), self.length - self.pad - box.right)
                for y in (0.0, aside, -aside) if aside >= 0 else ():
                    spot = box.moved(first + way * k * step, y)
                    if self.board.free(spot):
                        self._take(spot)
                        self._write("name", text, height, first + way * k * step, y, self.strip.family)
                        return
        self._beside(text, x, None)

    def _headings(self) -> None:
        """A small arrow where the partner leaves the strip, so that it is not laid the wrong way round."""
        size = 0.09 * self.width
        for each in self.passages:
            angle = np.radians(each.angle)
            if abs(np.sin(angle)) < 0.3:
                continue
            way = np.array([np.cos(angle), np.sin(angle)])
            tip = np.array([each.at, 0.0]) + way * (self.edge - 0.3 * self.pad) / abs(way[1])
            side = np.array([-way[1], way[0]])
            arrow = np.array([tip - size * (way + 0.7 * side), tip, tip - size * (way - 0.7 * side)])
            low, high = arrow.min(axis=0), arrow.max(axis=0)
            box = Box(float(low[0]), float(low[1]), float(high[0]), float(high[1]))
            on_strip = box.left > 0 and box.right < self.length
            if on_strip and not any(boxes_overlap(box, other) for other in self.clear):
                # At the edge: it may touch other arrows, but no writing may lie on it.
                self.board.take(box)
                self._add(
                    "heading", [arrow], False, self.pattern.strips[each.partner].family, "", each.crossing
                )

    def _labels(self, placed: list[_Placed | None]) -> None:
        marks = [spot.box for spot in placed if spot is not None]
        for each, spot in zip(self.passages, placed, strict=True):
            if spot is None or not self._label(each, spot, marks):
                self._beside(each.label, each.at, each, spot)

    def _label(self, each: Passage, spot: _Placed, marks: list[Box]) -> bool:
        """Write a label next to its mark; whether there is room."""
        family = self.pattern.strips[each.partner].family
        near = [box for box in marks if abs(box.left - spot.box.left) < 6 * self.width and box != spot.box]
        for height in self.heights:
            box = self._box(each.label, height)
            across, up = spot.radius + 1.3 * self.pad + box.right, spot.radius + 1.3 * self.pad + box.top
            aside = self.inside - box.top
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
                if abs(y) > aside + 1e-9 or not self.board.free(there):
                    continue
                own = _distance(there, spot.box)
                if any(_distance(there, other) < 1.25 * own for other in near):
                    continue
                self._take(there)
                self._write("label", each.label, height, x, y, family, each.crossing)
                return True
        return False

    def _beside(self, text: str, x: float, each: Passage | None, spot: _Placed | None = None) -> None:
        """Write beside the strip, with a line to the place; with the mark where that has no room inside."""
        height = max(self.heights[-1], 1.8)
        radius = 0.6 * height if each is not None and spot is None else 0.0
        box = self._box(text, height)
        gap = self.pad if radius else 0.0
        wide, tall = box.right - box.left + 2 * radius + gap, max(box.top - box.bottom, 2 * radius)
        lead, row = 0.35 * height + 2 * self.pad + 0.5 * self.making.kerf, tall + 1.6 * self.pad
        shifts = [0.0] + [sign * k * 0.5 * height for k in range(1, 30) for sign in (1, -1)]
        for number in range(ROWS):
            for shift in shifts[: 5 + 4 * number]:
                stem = min(max(x + shift, self.pad), self.length - self.pad)
                for side in (1.0, -1.0):
                    low = self.edge + lead + number * row
                    middle = side * (low + 0.5 * tall)
                    foot, top = sorted((side * (self.edge + self.pad), side * low))
                    line = Box(stem - 0.05, foot, stem + 0.05, top)
                    for left in (stem - 0.3 * self.pad, stem + 0.3 * self.pad - wide, stem - 0.5 * wide):
                        whole = Box(left, middle - 0.5 * tall, left + wide, middle + 0.5 * tall)
                        if not self.board.free(whole) or (number and not self.board.free(line)):
                            continue
                        self.board.take(whole)
                        self.board.take(line)
                        family = self.strip.family
                        if each is not None:
                            family = self.pattern.strips[each.partner].family
                            origin = (each.at, 0.0 if spot is None else side * self.edge)
                            bend = [origin, (stem, side * (self.edge + 0.8 * lead)), (stem, side * low)]
                            self._add("leader", [np.array(bend)], False, family, "", each.crossing)
                            if radius:
                                self._mark(each, left + radius, middle, radius)
                        centre = left + wide - 0.5 * (box.right - box.left)
                        role: Role = "name" if each is None else "label"
                        crossing = -1 if each is None else each.crossing
                        self._write(role, text, height, centre, middle, family, crossing)
                        return
        raise FieldError(
            f"the crossings of strip {self.strip.label} are too dense to be labelled near {x:.4g} mm; "
            "make the object larger or ask for fewer ribbons"
        )

    @staticmethod
    def _box(text: str, height: float) -> Box:
        """What a text about the origin takes up, with half a gap between letters on either side."""
        return text_box(text, height).wider(0.12 * height)

    def _write(
        self, role: Role, text: str, height: float, x: float, y: float, family: int, crossing: int = -1
    ) -> None:
        strokes, _ = text_strokes(text, height, x, y)
        self.figures.append(Figure(role, strokes, False, family, text, crossing, PEN * height))

    # ---- guides

    def _guides(self, each: Passage) -> None:
        """The edges of the partner at its angle, and its colour where it lies on top."""
        angle = np.radians(each.angle)
        way = np.array([np.cos(angle), np.sin(angle)])
        left = np.array([-way[1], way[0]])
        middle, far = np.array([each.at, 0.0]), way * (self.length + 4 * self.width)
        family = self.pattern.strips[each.partner].family
        if not each.over:
            corners = np.array(
                [s * self.edge * left + t * far for s, t in ((1, -1), (1, 1), (-1, 1), (-1, -1))]
            )
            band = clipped(middle + corners, self.length, self.edge)
            self._add("band", [band] if len(band) > 2 else [], True, family, "", each.crossing)
        inset = min(0.07 * self.width, 0.6)
        offsets = (self.edge,) if each.over else (self.edge, self.edge - inset)
        lines: list[NDArray[np.float64]] = []
        for offset in offsets:
            for sign in (1.0, -1.0):
                base = middle + sign * offset * left
                seen = within(base - far, base + far, self.length, self.edge)
                if seen is not None:
                    parts = dashes(*seen, min(0.1 * self.width, 1.2)) if each.over else [np.array(seen)]
                    lines += [part for dash in parts for part in outside(dash, self.clear)]
        self._add("over" if each.over else "under", lines, False, family, "", each.crossing)


def _distance(one: Box, other: Box) -> float:
    """Between two boxes, 0 where they touch."""
    across = max(one.left - other.right, other.left - one.right, 0.0)
    return float(np.hypot(across, max(one.bottom - other.top, other.bottom - one.top, 0.0)))
