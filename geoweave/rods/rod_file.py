"""Elastic rods and their crossings as text: the .rod files of RibbonSim, versions 0, 1 and 2.

Numbers apart by white space: the magic number -217 and the version (both absent in version 0); the
number of rods and of crossings, thickness, Young's modulus, density; for each rod its number of vertices n,
whether it is closed, [from version 1: visibility, colour], 3n coordinates of the centreline, 3m of the
directors, [from version 1: m angles], m widths, [in version 2: m colours of the segments], where m is n for
closed rods and n - 1 for open ones; for each crossing two rods, their segments, the places on these from 0
to 1, a stiffness.
Which rod lies above at a crossing is not in the file.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from geoweave.arrays import Indices, Scalars, Vectors, frozen
from geoweave.errors import RodError
from geoweave.files import replacing
from geoweave.rods.rod_repairs import DIRECTOR_TOLERANCE, squared
from geoweave.rods.rod_words import Words
from geoweave.weave import Passages
from geoweave.wording import counted

__all__ = [
    "MAGIC",
    "NEWEST",
    "Rod",
    "RodCrossing",
    "RodFile",
    "read_rods",
    "rod_text",
    "write_rods",
]

MAGIC = -217
"""The first number of a file of version 1 or later."""
NEWEST = 2
"""The version that is written."""


@dataclass(frozen=True, eq=False)
class Rod:
    """A ribbon as a chain of segments with a cross-section that may turn about it (Appendix E).

    Raises
    ------
    RodError
        If it has fewer than two vertices (three when closed), an array does not fit, a number is not
        finite, a segment has no length, a width is not positive, a director is no unit vector square to
        its segment, or a colour is no whole number, that of the rod from 0 on.
    """

    centerline: Vectors
    """(n, 3) vertices, length."""
    directors: Vectors
    """(m, 3) unit vectors d square to the segments, m = n if closed and n - 1 if not."""
    widths: Scalars
    """(m,) length, positive."""
    closed: bool = False
    """Whether a last segment joins the last vertex to the first."""
    angles: Scalars | None = None
    """(m,) radians from d to the thickness direction, about the segment; None stands for zeros."""
    visible: bool = True
    """Whether RibbonSim shows the rod."""
    color: int = 0
    """Number of a colour in RibbonSim's palette."""
    segment_colors: Indices | None = None
    """(m,) number of a colour for each segment; None stands for zeros."""

    def __post_init__(self) -> None:
        points = np.array(self.centerline, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 3:
            raise RodError(f"a centreline is (n, 3) vertices, not {points.shape}")
        least = 3 if self.closed else 2
        if len(points) < least:
            raise RodError(f"it has {counted(len(points), 'vertex')} but needs {least}; leave the rod out")
        count = len(points) if self.closed else len(points) - 1
        angles = np.zeros(count) if self.angles is None else np.array(self.angles, dtype=np.float64)
        colors = np.zeros(count) if self.segment_colors is None else np.array(self.segment_colors)
        directors = np.array(self.directors, dtype=np.float64)
        widths = np.array(self.widths, dtype=np.float64)
        for name, array, shape in (
            ("directors", directors, (count, 3)),
            ("angles", angles, (count,)),
            ("widths", widths, (count,)),
            ("segment colours", colors, (count,)),
        ):
            if array.shape != shape:
                raise RodError(
                    f"its {name} are of shape {array.shape} but it has {counted(count, 'segment')}"
                )
        for name, array in (
            ("vertex", points), ("director", directors), ("angle", angles), ("width", widths)
        ):  # fmt: skip
            strange = ~np.isfinite(array.reshape(len(array), -1)).all(axis=1, keepdims=True)
            if strange.any():
                raise RodError(f"{name} {_first(strange)} is not finite; correct it or leave the rod out")
        steps = np.roll(points, -1, axis=0)[:count] - points[:count]
        lengths = np.linalg.norm(steps, axis=1)
        if not (lengths > 0).all():
            raise RodError(f"segment {_first(~(lengths > 0))} has no length; merge its two vertices")
        if not (widths > 0).all():
            bad = _first(~(widths > 0))
            raise RodError(f"segment {bad} has the width {widths[bad]:g}; make it positive")
        norms = np.linalg.norm(directors, axis=1)
        leaning = np.abs((directors * steps).sum(axis=1)) / lengths
        askew = (np.abs(norms - 1) > DIRECTOR_TOLERANCE) | (leaning > DIRECTOR_TOLERANCE)
        if askew.any():
            bad = _first(askew)
            raise RodError(
                f"director {bad} has length {norms[bad]:.4g} and {leaning[bad]:.4g} of it along its segment; "
                f"make it a unit vector square to the segment"
            )
        if (colors != np.floor(colors)).any():
            raise RodError("its segment colours are not whole numbers")
        if self.color != int(self.color) or not 0 <= self.color < 10**18:
            raise RodError(f"its colour is {self.color}; give a whole number from 0 on")
        object.__setattr__(self, "color", int(self.color))
        object.__setattr__(self, "centerline", frozen(points))
        object.__setattr__(self, "directors", frozen(directors))
        object.__setattr__(self, "angles", frozen(angles))
        object.__setattr__(self, "widths", frozen(widths))
        object.__setattr__(self, "segment_colors", frozen(colors.astype(np.int64)))

    @property
    def segments(self) -> int:
        """Number of segments, m."""
        return len(self.directors)

    @property
    def lengths(self) -> Scalars:
        """(m,) length of each segment."""
        ahead = np.roll(self.centerline, -1, axis=0)[: self.segments]
        lengths: Scalars = np.linalg.norm(ahead - self.centerline[: self.segments], axis=1)
        return lengths


@dataclass(frozen=True)
class RodCrossing:
    """Two places that are held together, each on a segment of a rod."""

    rods: tuple[int, int]
    """The two rods; they may be one rod twice."""
    segments: tuple[int, int]
    """The segment of each of them."""
    places: tuple[float, float]
    """How far along these, from 0 at the first vertex of a segment to 1 at its second."""
    stiffness: float = 1000.0
    """Of the contact; RibbonSim's default."""


@dataclass(frozen=True, eq=False)
class RodFile:
    """Rods, their crossings, and the material.

    Raises
    ------
    RodError
        If a crossing names a rod or a segment that is not there, a place outside its segment or one segment
        twice, or a number is out of range.
    """

    rods: tuple[Rod, ...]
    crossings: tuple[RodCrossing, ...]
    thickness: float
    """Length, positive."""
    young: float
    """Young's modulus, force per area, positive."""
    density: float
    """Mass per volume, not negative."""
    repairs: tuple[str, ...] = ()
    """What was put right when the file was read, a sentence each."""

    def __post_init__(self) -> None:
        for name, value, ok in (
            ("thickness", self.thickness, self.thickness > 0),
            ("Young's modulus", self.young, self.young > 0),
            ("density", self.density, self.density >= 0),
        ):
            if not (np.isfinite(value) and ok):
                raise RodError(f"the {name} is {value:g}; give a positive number")
        for number, crossing in enumerate(self.crossings):
            problem = _problem(crossing, self.rods)
            if problem:
                raise RodError(f"crossing {number} {problem}; correct or remove it")

    def placed(self) -> Passages:
        """Return the crossings by rod and arclength, as over and under need them."""
        ends = [np.concatenate([[0.0], np.cumsum(rod.lengths)]) for rod in self.rods]
        arclengths = [
            [
                (1 - place) * ends[rod][segment] + place * ends[rod][segment + 1]
                for rod, segment, place in zip(one.rods, one.segments, one.places, strict=True)
            ]
            for one in self.crossings
        ]
        ribbons = np.array([one.rods for one in self.crossings], dtype=np.int64).reshape(-1, 2)
        closed = np.array([rod.closed for rod in self.rods], dtype=bool)
        return Passages(ribbons, np.array(arclengths, dtype=np.float64).reshape(-1, 2), closed)


def _first(flags: ArrayLike) -> int:
    return int(np.flatnonzero(flags)[0])


def _problem(crossing: RodCrossing, rods: tuple[Rod, ...]) -> str:
    """Say what is wrong with a crossing; an empty text if it is fine."""
    for rod, segment, place in zip(crossing.rods, crossing.segments, crossing.places, strict=True):
        if not 0 <= rod < len(rods):
            return f"names rod {rod} of {len(rods)}"
        if not 0 <= segment < rods[rod].segments:
            return f"names segment {segment} of rod {rod}, which has {rods[rod].segments}"
        if not 0.0 <= place <= 1.0:
            return f"lies at {place:g} of a segment, which runs from 0 to 1"
    if len({(rod, segment) for rod, segment in zip(crossing.rods, crossing.segments, strict=True)}) < 2:
        return "joins a segment to itself"
    if not (np.isfinite(crossing.stiffness) and crossing.stiffness >= 0):
        return f"has the stiffness {crossing.stiffness:g}"
    return ""


def read_rods(path: str | PathLike[str]) -> RodFile:
    """Read a .rod file of version 0, 1 or 2; what the older ones lack is zero, and visible.

    What RibbonSim reads with a warning is put right, and `RodFile.repairs` says so: directors that lean, rods
    with too few vertices, numbers after the last crossing.

    Raises
    ------
    RodError
        If it cannot be read or holds anything that `Rod` or `RodFile` refuses, words that are no numbers or
        too few of them; the sentence names the file, the line and the remedy.

    Examples
    --------
    >>> gw.rods.read_rods("no such.rod")
    Traceback (most recent call last):
    ...
    geoweave.errors.RodError: no such.rod: cannot be read (No such file or directory); check the name
    """
    source = Path(path)
    try:
        text = source.read_bytes().decode("ascii")
    except OSError as error:
        raise RodError(f"{source}: cannot be read ({error.strerror}); check the name") from error
    except UnicodeDecodeError as error:
        raise RodError(f"{source}: byte {error.start} is no text; a .rod file holds numbers only") from error
    try:
        return _parsed(Words(text))
    except RodError as error:
        raise RodError(f"{source}: {error}") from error


def _parsed(words: Words) -> RodFile:
    version = 0
    if words.words[:1] == [str(MAGIC)]:
        words.take(1, "the file")
        version = words.whole("the version", 1, NEWEST)
    count = words.whole("the number of rods")
    crossing_count = words.whole("the number of crossings")
    thickness, young, density = words.numbers(3, "thickness, Young's modulus and density").tolist()
    rods: list[Rod] = []
    numbers: list[int] = []  # of the rods that are kept, -1 for those that are left out
    short, leaning = 0, 0
    for number in range(count):
        start = words.at
        try:
            rod, changed = _parsed_rod(words, version, f"rod {number}")
        except RodError as error:
            if str(error).startswith("line "):
                raise
            raise RodError(f"line {words.line(words.at - start)}: rod {number}: {error}") from error
        numbers.append(-1 if rod is None else len(rods))
        rods += [] if rod is None else [rod]
        short, leaning = short + (rod is None), leaning + changed
    crossings = []
    for number in range(crossing_count):
        crossing = _parsed_crossing(words, number, numbers)
        if crossing is None:
            continue
        problem = _problem(crossing, tuple(rods))
        if problem:
            raise RodError(f"line {words.line(7)}: crossing {number} {problem}; correct or remove it")
        crossings.append(crossing)
    lost, left = crossing_count - len(crossings), len(words.words) - words.at
    repairs = (
        (leaning, f"directors made unit vectors square to their segments: {leaning}"),
        (short, f"rods with too few vertices, left out: {short}, with {lost} of the crossings"),
        (left, f"numbers after the last crossing, left out: {left}"),
    )
    said = tuple(sentence for number, sentence in repairs if number)
    return RodFile(tuple(rods), tuple(crossings), thickness, young, density, said)


def _parsed_crossing(words: Words, number: int, numbers: list[int]) -> RodCrossing | None:
    """Read a crossing; None if a rod of it was left out."""
    (one, other), segments = (
        (words.whole(f"{what} of crossing {number}"), words.whole(f"{what} of crossing {number}"))
        for what in ("a rod", "a segment")
    )
    first, second, stiffness = words.numbers(3, f"the places and the stiffness of crossing {number}").tolist()
    for rod in (one, other):
        if rod >= len(numbers):
            raise RodError(
                f"line {words.line(7)}: crossing {number} names rod {rod} of {len(numbers)}; "
                "correct or remove it"
            )
    pair = (numbers[one], numbers[other])
    return None if min(pair) < 0 else RodCrossing(pair, segments, (first, second), stiffness)


def _parsed_rod(words: Words, version: int, name: str) -> tuple[Rod | None, int]:
    """Read a rod, None if it is too short for one, and count the directors that were put right."""
    vertices = words.whole(f"the number of vertices of {name}")
    closed = words.whole(f"the closed flag of {name}", 0, 1) == 1
    visible, color = True, 0
    if version >= 1:
        visible = words.whole(f"the visibility of {name}", 0, 1) == 1
        color = words.whole(f"the colour of {name}")
    count = vertices if closed else max(vertices - 1, 0)
    centerline = words.numbers(3 * vertices, f"the vertices of {name}").reshape(-1, 3)
    directors = words.numbers(3 * count, f"the directors of {name}").reshape(-1, 3)
    angles = words.numbers(count, f"the angles of {name}") if version >= 1 else None
    widths = words.numbers(count, f"the widths of {name}")
    colors = words.numbers(count, f"the segment colours of {name}") if version >= 2 else np.zeros(count)
    if (colors != np.floor(colors)).any() or (np.abs(colors) > 2.0**53).any():
        raise RodError("its segment colours are not whole numbers; correct them")
    if vertices < (3 if closed else 2):
        return None, 0
    directors, changed = squared(centerline, directors, closed)
    return Rod(
        centerline, directors, widths, closed, angles, visible, color, colors.astype(np.int64)
    ), changed


def rod_text(content: RodFile) -> str:
    """Return the text of a .rod file of the newest version, with every digit.

    >>> rods = gw.elastic_rods(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)).rods
    >>> gw.rods.rod_text(gw.rods.file_of_rods(rods)).splitlines()[:2]
    ['-217', '2']
    """
    lines = [str(MAGIC), str(NEWEST), str(len(content.rods)), str(len(content.crossings))]
    lines += [_joined([value]) for value in (content.thickness, content.young, content.density)]
    for rod in content.rods:
        lines += ["", str(len(rod.centerline)), str(int(rod.closed)), str(int(rod.visible)), str(rod.color)]
        for array in (rod.centerline, rod.directors, rod.angles, rod.widths):
            lines.append(_joined(np.asarray(array).ravel()))
        lines.append(" ".join(str(int(color)) for color in np.asarray(rod.segment_colors)))
    lines.append("")
    for one in content.crossings:
        indices = (*one.rods, *one.segments)
        lines.append(" ".join([*map(str, indices), _joined([*one.places, one.stiffness])]))
    return "\n".join(lines) + "\n"


def write_rods(path: str | PathLike[str], content: RodFile) -> None:
    """Write a .rod file of the newest version, whole or not at all.

    Raises
    ------
    OutputError
        If it cannot be written there.
    """
    with replacing(path) as temporary:
        temporary.write_text(rod_text(content), encoding="ascii", newline="\n")


def _joined(values: Iterable[float]) -> str:
    return " ".join(f"{value:.17g}" for value in values)
