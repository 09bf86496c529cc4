"""Words of messages that depend on a number."""

from __future__ import annotations

__all__ = ["counted", "plural"]

UNLIKE = {"vertex": "vertices", "axis": "axes"}
"""Nouns of which the plural has another stem."""


def plural(noun: str) -> str:
    """The plural of a noun; of several words the last one is the noun."""
    first, _, last = noun.rpartition(" ")
    many = UNLIKE.get(last) or f"{last}{'es' if last.endswith(('s', 'x', 'ch', 'sh')) else 's'}"
    return f"{first} {many}" if first else many


def counted(n: int, noun: str, verb: str = "") -> str:
    """A number and its noun, in the plural where that is due.

    Parameters
    ----------
    n : how many
    noun : in the singular
    verb : what follows, for one and for many: "is are", "has have"

    Examples
    --------
    >>> from geoweave.wording import counted
    >>> counted(1, "vertex"), counted(12_000, "open edge"), counted(1, "face", "has have")
    ('1 vertex', '12,000 open edges', '1 face has')
    """
    one, _, many = verb.partition(" ")
    said = f"{n:,} {noun if n == 1 else plural(noun)}"
    return f"{said} {one if n == 1 else many}" if verb else said
