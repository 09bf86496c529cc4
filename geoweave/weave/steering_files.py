"""Read what a user says of the RoSy from files of text: singularities, and what a family is to follow."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator

import numpy as np

from geoweave.errors import FieldError
from geoweave.weave.steering import Point, Singularity
from geoweave.wording import counted

__all__ = ["read_guide", "read_singularities"]


def read_singularities(path: str | os.PathLike[str]) -> tuple[Singularity, ...]:
    """Read prescribed singularities from a file of text.

    One line each: three coordinates and the index, a whole number of N-ths of a turn, separated by blanks or
    commas. Empty lines, what follows a ``#``, and a first line of names (``x,y,z,index``) are passed over.

    Raises
    ------
    FieldError
        If the file cannot be read, or a line is none; the text names the file and the line.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from geoweave.weave import read_singularities
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(f"{folder}/poles.csv").write_text("x,y,z,index\\n0,0,1,6\\n0,0,-1,6\\n")
    ...     [each.numerator for each in read_singularities(f"{folder}/poles.csv")]
    [6, 6]
    """
    name = os.fspath(path)
    found: list[Singularity] = []
    for place, (x, y, z, index) in _rows(name, "the four of a singularity: x y z index"):
        if index != round(index):
            raise FieldError(
                f"{place}: the index is {index:g}; give a whole number of N-ths (sixths) of a turn"
            )
        found.append(Singularity((x, y, z), round(index)))
    if not found:
        raise FieldError(f"{name} holds no singularity; give a line x y z index for each")
    return tuple(found)


def read_guide(path: str | os.PathLike[str]) -> tuple[Point, ...]:
    """Read what one family is to follow from a file of text.

    One line of three coordinates is a direction, several are the corners of a curve on the surface or near
    it, in the coordinates of the mesh file. The rest of the form is that of `read_singularities`.

    Raises
    ------
    FieldError
        If the file cannot be read, or a line is none; the text names the file and the line.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from geoweave.weave import read_guide
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = Path(f"{folder}/up.txt").write_text("0 0 1  # a direction\\n")
    ...     read_guide(f"{folder}/up.txt")
    ((0.0, 0.0, 1.0),)
    """
    name = os.fspath(path)
    found = [(x, y, z) for _, (x, y, z) in _rows(name, "the three of a point: x y z")]
    if not found:
        raise FieldError(f"{name} holds no point; give one line x y z for a direction, several for a curve")
    if not np.any(found if len(found) == 1 else np.diff(found, axis=0)):
        raise FieldError(f"{name}: what a family is to follow has no length; give points that are apart")
    return tuple(found)


def _rows(name: str, what: str) -> Iterator[tuple[str, list[float]]]:
    """Place and numbers of each line of a file of text; empty lines, comments and names are passed over.

    ``what`` says what the numbers of a line are; after the colon it names them.
    """
    try:
        with open(name, encoding="utf-8-sig") as file:
            lines = file.read().splitlines()
    except OSError as error:
        raise FieldError(f"{name} cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise FieldError(f"{name} is no file of text; give one line of numbers for each point") from error
    count, first = len(what.split(": ")[1].split()), True
    for number, line in enumerate(lines, 1):
        words, place = line.split("#")[0].replace(",", " ").split(), f"{name}: line {number}"
        if not words:
            continue
        if len(words) != count:
            raise FieldError(f"{place} has {counted(len(words), 'number')}, not {what}")
        if not (first and all(word.isalpha() for word in words)):
            yield place, [_number(word, place) for word in words]
        first = False


def _number(word: str, place: str) -> float:
    """A word as a finite number."""
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise FieldError(f"{place}: '{word}' is not a finite number")
    return value
