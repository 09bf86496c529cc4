"""Paths of an SVG in few bytes, and the lines of such paths.

A path begins at a place; what follows are steps in whole hundredths or thousandths of a millimetre, which add
up without an error. Numbers stand together where their signs or points part them, as the grammar of SVG
allows (SVG 1.1, 8.3.9).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from geoweave.fabrication.stroke_font import text_strokes

__all__ = ["number", "path_data", "path_lines", "place_data", "text_data"]

PART, NUMBER = re.compile(r"([MmLlhvZz])([^MmLlhvZz]*)"), re.compile(r"-?\d*\.?\d+")
"""A command with its numbers, and a number."""

Paths = Sequence[NDArray[np.float64]]


def number(value: float) -> str:
    """Millimetres to a micrometre, without trailing zeros."""
    text = f"{value:.3f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def place_data(paths: Paths, closed: bool, height: float) -> str:
    """Lines by the places of their corners, y upwards; pairs that follow each other are lines."""
    return "".join(
        "M" + " ".join(f"{number(x)},{number(height - y)}" for x, y in path.tolist()) + "Z" * closed
        for path in paths
    )


def path_data(paths: Paths, closed: bool, height: float, step: float) -> str:
    """Lines by steps from the first place on, y upwards; ``step`` is what steps are whole numbers of, mm."""
    points = [_whole(path * [1.0, -1.0] / step + [0.0, height / step]) for path in paths]
    x, y = points[0][0].tolist()
    return f"M{_packed([x, y], step)}" + _steps(points, closed, step)


def text_data(text: str, size: float, turn: float, x: float, y: float, step: float) -> str:
    """A text about a place of the file, with letters of a height, turned to the left by degrees."""
    (across, down), rest = _text(text, size, turn, step)
    return f"M{_packed([round(x / step) + across, round(y / step) + down], step)}{rest}"


@lru_cache(maxsize=8192)
def _text(text: str, size: float, turn: float, step: float) -> tuple[tuple[int, int], str]:
    """Where a text begins about its middle, in steps, and what follows its first place."""
    strokes, _ = text_strokes(text, size, 0.0, 0.0)
    angle = np.radians(turn)
    turned = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    points = [_whole(stroke @ turned * [1.0, -1.0] / step) for stroke in strokes]
    across, down = points[0][0].tolist()
    return (across, down), _steps(points, False, step)


def _whole(places: NDArray[np.float64]) -> NDArray[np.int64]:
    return np.rint(places).astype(np.int64)


def _steps(points: Sequence[NDArray[np.int64]], closed: bool, step: float) -> str:
    """All that follows the first place. A line that begins elsewhere begins with a step from where the last
    one ended, which is its own beginning if it is closed."""
    found = []
    for k, line in enumerate(points):
        if k:
            move = (line[0] - points[k - 1][0 if closed else -1]).tolist()
            found.append("m" + _packed(move, step))
        found.append(_ahead(np.diff(line, axis=0).tolist(), step) + "z" * closed)
    return "".join(found)


def _ahead(steps: Sequence[Sequence[int]], step: float) -> str:
    """Steps of a line; those along an axis have one number."""
    found: list[str] = []
    run: list[int] = []
    for x, y in steps:
        if x and y:
            run += [x, y]
            continue
        if run:
            found.append("l" + _packed(run, step))
            run = []
        found.append("v" + _short(y, step) if y else "h" + _short(x, step))
    return "".join(found) + ("l" + _packed(run, step) if run else "")


def _packed(counts: Sequence[int], step: float) -> str:
    """Whole numbers of steps in mm, with blanks only where nothing else parts them."""
    found, pointed = [], True
    for k, count in enumerate(counts):
        text = _short(count, step)
        if k and not (text[0] == "-" or (text[0] == "." and pointed)):
            found.append(" ")
        found.append(text)
        pointed = "." in text
    return "".join(found)


@lru_cache(maxsize=65536)
def _short(count: int, step: float) -> str:
    """So many steps in mm, as short as it goes."""
    text = number(count * step)
    return text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) else text


def path_lines(data: str) -> list[NDArray[np.float64]]:
    """The lines of a path as it is written here, (P, 2) each, y as in the file.

    Examples
    --------
    >>> [line.tolist() for line in gw.fabrication.svg_paths.path_lines("M1 2l.5.5h-.5m2 0v1")]
    [[[1.0, 2.0], [1.5, 2.5], [1.0, 2.5]], [[3.0, 2.5], [3.0, 3.5]]]
    """
    found: list[NDArray[np.float64]] = []
    here = np.zeros(2)
    for command, text in PART.findall(data):
        numbers = np.array(NUMBER.findall(text), dtype=np.float64)
        if command in "Zz":
            # What follows begins where the closed line did.
            here = found[-1][0]
            continue
        if command in "hv":
            pairs = np.zeros((len(numbers), 2))
            pairs[:, "hv".index(command)] = numbers
        else:
            pairs = numbers.reshape(-1, 2)
        points = pairs if command in "ML" else here + np.cumsum(pairs, axis=0)
        if command in "Mm":
            found.append(points)
        else:
            found[-1] = np.concatenate([found[-1], points])
        here = points[-1]
    return found
