"""Letters as strokes, and places where they overlap nothing else (the labels of Section 5.4, Fig. 20).

A laser can engrave strokes and a page can print them. No viewer can choose another font, so the box of a text
is that of its points, the same in every file. Letters are one line wide, capital letters and figures only.
"""

from __future__ import annotations

import math
from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geoweave.arrays import frozen
from geoweave.errors import FieldError

__all__ = ["PEN", "Board", "Box", "boxes_overlap", "text_box", "text_strokes"]

PEN = 0.11
"""Width of the pen in heights of a capital letter; boxes hold the pen."""

GAP = 0.24
"""Between letters, in heights."""

SPACE = 0.35
"""Width of a blank, in heights."""

SMOOTH = 0.1
"""How far a stroke may be from its curve, where a letter is 6 high: 0.03 mm in the smallest letters, about
a seventh of the pen."""

COLUMN = 8.0
"""Width of the columns by which boxes are found again, mm: about that of a label."""

Strokes = tuple[NDArray[np.float64], ...]

# Height 6. Strokes are "x,y x,y ...", separated by "|". A leading ~ rounds the corners of a stroke.
_GLYPHS = {
    "A": "0,0 2,6 4,0|0.67,2 3.33,2",
    "B": "0,0 0,6|~0,6 2.4,6 3.7,5.8 3.7,3.2 2.4,3.1 0,3.1|~0,3.1 2.6,3.1 4.1,2.9 4.1,0.1 2.6,0 0,0",
    "C": "~4,5 3.2,6 0,6.2 0,-0.2 3.2,0 4,1",
    "D": "0,0 0,6|~0,6 2,6 4.1,5.6 4.1,0.4 2,0 0,0",
    "E": "3.5,0 0,0 0,6 3.5,6|0,3.1 2.8,3.1",
    "F": "0,0 0,6 3.5,6|0,3 2.8,3",
    "G": "~4,5 3.2,6 0,6.2 0,-0.2 3.2,-0.1 4.1,0.5 4.1,2.8|2.4,2.8 4.1,2.8",
    "H": "0,0 0,6|4,0 4,6|0,3.1 4,3.1",
    "I": "0,0 0,6",
    "J": "~2.8,6 2.8,2 2.8,-0.1 0.4,-0.1 0,1.4",
    "K": "0,0 0,6|3.8,6 0,2.4|1.4,3.7 4,0",
    "L": "0,6 0,0 3.3,0",
    "M": "0,0 0,6 2.4,2 4.8,6 4.8,0",
    "N": "0,0 0,6 4,0 4,6",
    "O": "~@2.1,6 0,6 0,0 2.1,0 4.2,0 4.2,6",
    "P": "0,0 0,6|~0,6 2.4,6 3.9,5.8 3.9,2.9 2.4,2.7 0,2.7",
    "Q": "~@2.1,6 0,6 0,0 2.1,0 4.2,0 4.2,6|2.6,1.5 4.2,-0.3",
    "R": "0,0 0,6|~0,6 2.4,6 3.9,5.8 3.9,2.9 2.4,2.8 0,2.8|2,2.8 4,0",
    "S": "~3.7,5.1 3.1,6.1 0,6.2 0,3.3 2,3.1 4,2.9 4,-0.2 0.7,-0.1 0,0.9",
    "T": "0,6 4,6|2,6 2,0",
    "U": "~0,6 0,2 0,-0.1 4,-0.1 4,2 4,6",
    "V": "0,6 2,0 4,6",
    "W": "0,6 1.4,0 2.8,5 4.2,0 5.6,6",
    "X": "0,0 4,6|0,6 4,0",
    "Y": "0,6 2,3 4,6|2,3 2,0",
    "Z": "0,6 4,6 0,0 4,0",
    "0": "~@1.9,6 0,6.1 0,-0.1 1.9,0 3.8,-0.1 3.8,6.1",
    "1": "0,4.7 1.6,6 1.6,0",
    "2": "~0,4.7 0.3,6.1 3.8,6.2 3.8,3.8 1.6,2 0,0|0,0 3.8,0",
    "3": "0.1,6 3.5,6 1.6,3.6|~1.6,3.6 3.9,3.7 3.9,-0.1 0.8,-0.1 0,0.9",
    "4": "2.8,0 2.8,6 0,1.6 3.9,1.6",
    "5": "3.5,6 0.5,6 0.2,3.2|~0.2,3.2 1.4,3.9 3.9,3.8 3.9,-0.1 0.8,-0.1 0,0.8",
    "6": "~3.2,5.9 1,5.4 0,3 0,-0.1 3.9,-0.2 3.9,3.8 1.6,3.9 0.2,2.4",
    "7": "0,6 3.8,6 1.3,0",
    "8": "~@1.9,6 0.5,6.1 0.4,3.4 1.9,3.2 3.4,3.4 3.3,6.1|~@1.9,3.2 0,3.2 0,-0.1 1.9,0 3.8,-0.1 3.8,3.2",
    "9": "~0.7,0.1 2.9,0.6 3.9,3 3.9,6.1 0,6.2 0,2.2 2.3,2.1 3.7,3.6",
    "/": "0,-0.6 2.2,6.6",
    ">": "0,0.8 2.6,2.9 0,5",
    "=": "0,2 2.6,2|0,3.8 2.6,3.8",
}


class Box(NamedTuple):
    """A rectangle along the axes."""

    left: float
    bottom: float
    right: float
    top: float

    def grown(self, by: float) -> Box:
        """The box with a border."""
        return Box(self.left - by, self.bottom - by, self.right + by, self.top + by)

    def wider(self, by: float) -> Box:
        """The box with a border to the left and to the right."""
        return Box(self.left - by, self.bottom, self.right + by, self.top)

    def moved(self, x: float, y: float) -> Box:
        """The box elsewhere."""
        return Box(self.left + x, self.bottom + y, self.right + x, self.top + y)


def boxes_overlap(one: Box, other: Box) -> bool:
    """Whether two boxes share more than their border."""
    return (
        one.left < other.right
        and other.left < one.right
        and one.bottom < other.top
        and other.bottom < one.top
    )


def text_strokes(text: str, height: float, x: float, y: float) -> tuple[Strokes, Box]:
    """Strokes of a text and the box that holds them and their pen.

    Parameters
    ----------
    text : capital letters, figures and ``/ > =``
    height : of a capital letter
    x, y : middle of the box

    Returns
    -------
    tuple
        The strokes, (P, 2) each, and the box.

    Raises
    ------
    FieldError
        If there is no such letter.
    """
    strokes, middle, _, _ = _whole(text)
    moved = tuple((stroke - middle) * height + [x, y] for stroke in strokes)
    return moved, text_box(text, height).moved(x, y)


def text_box(text: str, height: float) -> Box:
    """Box of a text about the origin, with its pen; see `text_strokes`."""
    _, _, low, high = _whole(text)
    by = 0.5 * PEN * height
    return Box(low[0] * height - by, low[1] * height - by, high[0] * height + by, high[1] * height + by)


class _Laid(NamedTuple):
    """A text of height 1."""

    strokes: Strokes
    middle: NDArray[np.float64]
    low: tuple[float, float]
    """Corners of what is drawn about the middle, without the pen."""
    high: tuple[float, float]


@lru_cache(maxsize=4096)
def _whole(text: str) -> _Laid:
    """Lay a text out, once for all the places that are tried for it."""
    strokes, _ = _laid(text)
    if not strokes:
        raise FieldError("there is nothing to write")
    points = np.concatenate(strokes)
    low, high = points.min(axis=0), points.max(axis=0)
    # Centred by its drawn extent across, but by the height of a capital letter up and down: lines of text
    # keep one height whether or not a stroke goes below the line.
    middle = np.array([0.5 * (low[0] + high[0]), 0.5])
    (left, bottom), (right, top) = (low - middle).tolist(), (high - middle).tolist()
    return _Laid(tuple(frozen(stroke) for stroke in strokes), frozen(middle), (left, bottom), (right, top))


def _laid(text: str) -> tuple[list[NDArray[np.float64]], float]:
    """Strokes of a text of height 1 from the origin, and its width."""
    strokes: list[NDArray[np.float64]] = []
    x = 0.0
    for number, letter in enumerate(text):
        x += GAP if number else 0.0
        if letter == " ":
            x += SPACE
            continue
        if letter not in _GLYPHS:
            raise FieldError(f"the letter {letter!r} of {text!r} cannot be written; use A-Z and 0-9")
        glyph = _glyph(_GLYPHS[letter])
        left = min(float(stroke[:, 0].min()) for stroke in glyph)
        right = max(float(stroke[:, 0].max()) for stroke in glyph)
        strokes += [stroke + [x - left, 0.0] for stroke in glyph]
        x += right - left
    return strokes, x


@cache
def _glyph(text: str) -> Strokes:
    """Strokes of one letter, height 1."""
    strokes = []
    for stroke in text.split("|"):
        soft, ring = stroke.startswith("~"), "@" in stroke
        points = np.array([[float(each) for each in pair.split(",")] for pair in stroke.lstrip("~@").split()])
        if ring:
            points = np.concatenate([points, points[:1]])
        for _ in range(3 if soft else 0):
            points = _softer(points)
        points = _fewer(_bends(points))
        strokes.append(frozen(points / 6.0))
    return tuple(strokes)


def _softer(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cut the corners of a stroke at a quarter of its sides; the ends stay."""
    first, second = 0.75 * points[:-1] + 0.25 * points[1:], 0.25 * points[:-1] + 0.75 * points[1:]
    inner = np.stack([first, second], axis=1).reshape(-1, 2)[1:-1]
    return np.concatenate([points[:1], inner, points[-1:]])


def _bends(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The points of a stroke at which it bends."""
    way = np.diff(points, axis=0)
    turn = way[:-1, 0] * way[1:, 1] - way[:-1, 1] * way[1:, 0]
    bent = np.abs(turn) > 0.02 * np.hypot(*way[:-1].T) * np.hypot(*way[1:].T)
    return points[np.concatenate([[True], bent, [True]])]


def _fewer(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Leave out points that are nearer than `SMOOTH` to the line without them (Douglas and Peucker 1973)."""
    if len(points) < 3:
        return points
    start, way = points[0], points[-1] - points[0]
    length = float(np.hypot(*way))
    off = points - start
    far = np.abs(off[:, 0] * way[1] - off[:, 1] * way[0]) / length if length > 0 else np.hypot(*off.T)
    k = int(far.argmax())
    if far[k] < SMOOTH:
        return points[[0, -1]]
    return np.concatenate([_fewer(points[: k + 1])[:-1], _fewer(points[k:])])


class Board:
    """Boxes that are taken, in the order in which they were put down.

    Parameters
    ----------
    left, right : nothing may reach beyond these
    pad : least distance between two boxes
    """

    def __init__(self, left: float, right: float, pad: float) -> None:
        self.left, self.right, self.pad = left, right, pad
        self._columns: dict[int, list[Box]] = {}

    def free(self, box: Box) -> bool:
        """Whether a box lies between left and right and keeps its distance from all that is there."""
        return self.left <= box.left and box.right <= self.right and self._blocker(box) is None

    def first_free(self, box: Box, y: float, start: float, step: float, count: int) -> int | None:
        """The least k below a number for which a box at ``start + k step`` and ``y`` is free, or None.

        Steps lead to the right or, if they are negative, to the left. What is in the way is leapt over.
        """
        k = 0
        while k < count:
            there = box.moved(start + k * step, y)
            if (there.right > self.right) if step > 0 else (there.left < self.left):
                return None
            other = self._blocker(there)
            if other is None and self.left <= there.left and there.right <= self.right:
                return k
            k += 1
            if other is not None:
                beyond = other.right + self.pad - box.left if step > 0 else other.left - self.pad - box.right
                k = max(k, math.floor((beyond - start) / step - 1e-6))
        return None

    def _blocker(self, box: Box) -> Box | None:
        """A box that is there and nearer than it may be, None if there is none."""
        left, bottom, right, top = box.grown(self.pad)
        # Boxes that overlap share a column, so no others need to be checked.
        for column in range(int(left // COLUMN), int(right // COLUMN) + 1):
            for other in self._columns.get(column, ()):
                if other[0] < right and left < other[2] and other[1] < top and bottom < other[3]:
                    return other
        return None

    def take(self, box: Box) -> None:
        """Put a box down."""
        for column in range(int(box.left // COLUMN), int(box.right // COLUMN) + 1):
            self._columns.setdefault(column, []).append(box)
