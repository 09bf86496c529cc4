"""JSON documents are checked whole when they are read: numbers, lists and entries, before any work.

A shape is a function that takes a value and its place in the document, and raises ValueError with half a
sentence if the value is not what it should be. Shapes are put together: ``entries(points=points())``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from os import PathLike
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from geoweave.errors import GeoweaveError

__all__ = ["LARGEST", "Shape", "each", "entries", "flag", "number", "points", "read_json", "text", "whole"]

Shape: TypeAlias = Callable[[Any, str], None]

LARGEST = 1e50
"""Numbers beyond this are refused: squares and products of them would overflow."""

DIGITS = 15
"""Whole numbers of more digits are refused: floats no longer tell them apart."""


def read_json(path: str | PathLike[str], error: type[GeoweaveError], remedy: str) -> dict[str, Any]:
    """Read a JSON object in which every number is finite.

    Parameters
    ----------
    path : of the file
    error : what is raised if it cannot be read, with one sentence that begins with the file's name
    remedy : how the sentence ends, what to do about it
    """
    name = Path(path).name
    try:
        document = json.loads(
            Path(path).read_text(encoding="utf-8-sig"),
            parse_float=_finite,
            parse_int=_whole,
            parse_constant=_refused,
        )
    except OSError as problem:
        raise error(f"{name}: cannot be read ({problem.strerror}); check the path, or {remedy}") from problem
    except RecursionError as problem:
        raise error(f"{name}: lists are nested too deeply; {remedy}") from problem
    except UnicodeDecodeError as problem:
        raise error(f"{name}: is not text (byte {problem.start}); {remedy}") from problem
    except json.JSONDecodeError as problem:
        raise error(f"{name}: is not JSON ({problem}); {remedy}") from problem
    except ValueError as problem:
        raise error(f"{name}: {problem}; {remedy}") from problem
    if not isinstance(document, dict):
        raise error(f"{name}: is no JSON object; {remedy}")
    return document


def _finite(word: str) -> float:
    value = float(word)
    if not abs(value) <= LARGEST:
        return _refused(word)
    return value


def _whole(word: str) -> int:
    if len(word) > DIGITS:
        _refused(word)
    return int(word)


def _refused(word: str) -> Any:
    shown = word if len(word) <= 20 else f"{word[:17]}..."
    raise ValueError(f"the number {shown} is not finite or too large")


def number(*, above: float = -math.inf, least: float = -math.inf) -> Shape:
    """A number above a bound, or not below one."""

    def check(value: Any, place: str) -> None:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f"{place} is {_shown(value)}, not a number")
        if not (math.isfinite(value) and value > above and value >= least):
            bound = (
                f" above {above:g}"
                if above > -math.inf
                else f" from {least:g} on"
                if least > -math.inf
                else ""
            )
            raise ValueError(f"{place} is {value:g}, not a finite number{bound}")

    return check


def whole(least: int = 0, most: int = 10**9) -> Shape:
    """A whole number in a range."""

    def check(value: Any, place: str) -> None:
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
            raise ValueError(f"{place} is {_shown(value)}, not a whole number from {least} to {most}")

    return check


def text(*choices: str) -> Shape:
    """A text, one of some if they are given."""

    def check(value: Any, place: str) -> None:
        if not isinstance(value, str) or (choices and value not in choices):
            which = f"one of {', '.join(choices)}" if choices else "a text"
            raise ValueError(f"{place} is {_shown(value)}, not {which}")

    return check


def flag() -> Shape:
    """True or false."""

    def check(value: Any, place: str) -> None:
        if not isinstance(value, bool):
            raise ValueError(f"{place} is {_shown(value)}, not true or false")

    return check


def points(least: int = 1) -> Shape:
    """A list of points or directions, three finite numbers each."""

    def check(value: Any, place: str) -> None:
        try:
            array = np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError, OverflowError) as problem:
            raise ValueError(f"{place} is not a list of points of three numbers") from problem
        if array.ndim != 2 or array.shape[1] != 3 or len(array) < least:
            raise ValueError(f"{place} is not a list of {least} or more points of three numbers")
        if not (np.abs(array) <= LARGEST).all():
            raise ValueError(f"{place} holds a number that is not finite or too large")

    return check


def each(shape: Shape, count: int | None = None) -> Shape:
    """A list whose every item has a shape, of so many items if a count is given."""

    def check(value: Any, place: str) -> None:
        if not isinstance(value, list) or (count is not None and len(value) != count):
            raise ValueError(f"{place} is {_shown(value)}, not a list" + (f" of {count}" if count else ""))
        for k, item in enumerate(value):
            shape(item, f"{place}[{k}]")

    return check


def entries(optional: Mapping[str, Shape] | None = None, /, **shapes: Shape) -> Shape:
    """An object that has all these entries, and may have others; optional ones are checked where they are."""

    def check(value: Any, place: str) -> None:
        if not isinstance(value, Mapping):
            raise ValueError(f"{place or 'the document'} is {_shown(value)}, not an object")
        for name, shape in shapes.items():
            where = f"{place}.{name}" if place else name
            if name not in value:
                raise ValueError(f"{where} is missing")
            shape(value[name], where)
        for name, shape in (optional or {}).items():
            if name in value:
                shape(value[name], f"{place}.{name}" if place else name)

    return check


def _shown(value: Any) -> str:
    """A value as it stands in a sentence, however large it is."""
    if isinstance(value, list | dict):
        return f"{'a list' if isinstance(value, list) else 'an object'} of {len(value)}"
    words = json.dumps(value) if isinstance(value, str | int | float | bool) or value is None else repr(value)
    return words if len(words) <= 40 else f"{words[:37]}..."
