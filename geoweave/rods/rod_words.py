"""The words of a text file of numbers, taken one after another, with the lines they stand in."""

from __future__ import annotations

import re

import numpy as np

from geoweave.arrays import Scalars
from geoweave.documents import LARGEST
from geoweave.errors import RodError
from geoweave.wording import counted

__all__ = ["Words"]

_WHOLE = re.compile(r"[+-]?[0-9]{1,18}")
_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")


class Words:
    """The words of a file, one after another, and the lines they stand in."""

    def __init__(self, text: str) -> None:
        rows = [line.split() for line in text.split("\n")]
        self.words = [word for row in rows for word in row]
        self.lines = np.repeat(np.arange(1, len(rows) + 1), [len(row) for row in rows])
        self.at = 0

    def line(self, back: int = 1) -> int:
        """Number of the line of the word read last (or ``back`` words ago)."""
        place = min(max(self.at - back, 0), len(self.lines) - 1)
        return int(self.lines[place]) if len(self.lines) else 1

    def take(self, count: int, what: str) -> list[str]:
        """Return the next words, refusing before anything is allocated if there are not so many."""
        left = len(self.words) - self.at
        if count > left:
            raise RodError(
                f"line {self.line()}: {what} need {counted(count, 'more number')} but {left} follow; "
                f"the file is cut short or a count is wrong, export it again"
            )
        self.at += count
        return self.words[self.at - count : self.at]

    def whole(self, what: str, least: int = 0, most: int | None = None) -> int:
        """Return the next word, a whole number in a range."""
        (word,) = self.take(1, what)
        value = int(word) if _WHOLE.fullmatch(word) else None
        if value is None or value < least or (most is not None and value > most):
            span = f"from {least} on" if most is None else f"from {least} to {most}"
            raise RodError(f"line {self.line()}: {what} is '{word}', not a whole number {span}; correct it")
        return value

    def numbers(self, count: int, what: str) -> Scalars:
        """Return the next words as numbers."""
        words = self.take(count, what)
        for k, word in enumerate(words):
            if not _NUMBER.fullmatch(word):
                raise RodError(
                    f"line {self.line(count - k)}: '{word}' among {what} is not a finite number; correct it"
                )
        values = np.array(words, dtype=np.float64)
        beyond = np.flatnonzero(~(np.abs(values) <= LARGEST))
        if len(beyond):
            k = int(beyond[0])
            raise RodError(
                f"line {self.line(count - k)}: {words[k]} among {what} is beyond {LARGEST:g}; correct it"
            )
        return values
