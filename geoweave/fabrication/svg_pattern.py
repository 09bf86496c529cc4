"""The pattern that a drawing holds, measured on its lines: what a maker cuts is what is put together.

Lengths come from the outlines. Place and angle of a crossing come from the edges of the partner, which
are drawn on the strip in the direction of the partner, half a width on either side of its middle; on a strip
that goes under there are two more, further in. Over and under are the two kinds of these lines.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from geoweave.errors import FieldError
from geoweave.fabrication.marks import MARKS, assigned, outline
from geoweave.fabrication.pattern import Pattern, Strip
from geoweave.fabrication.strip_drawing import inset_of
from geoweave.fabrication.svg_paths import path_lines

__all__ = ["SvgPattern", "pattern_of_svg"]

MADE = "'geoweave cut --formats svg'"

NEAR = 0.05
"""Two places on a strip no farther apart than this are one, mm."""

ASKEW = 1.0
"""By how much the two strips of a crossing may differ about its angle, degrees."""


class SvgPattern(NamedTuple):
    """A pattern, and what its drawing says of how it is made."""

    pattern: Pattern
    hoops: float
    """What strips keep beyond the middle of a hoop, mm; 0 without hoops."""


class Seen(NamedTuple):
    """A crossing as it is drawn on a piece."""

    strip: int
    crossing: int
    at: float
    """Along the strip, mm."""
    angle: float
    """From this strip to the partner, radians, left is positive."""
    over: bool
    aside: float = 0.0
    """Of a crossing that is known by its mark alone, and has no angle: by how much the mark stands to the
    left of the middle of the strip, mm. It stands on the line of the partner, beside the crossing."""

    def moved(self, angle: float) -> Seen:
        """A crossing known by its mark, once its angle is known from the other strip."""
        return self._replace(at=self.at - _beside(self.aside, angle), angle=angle, aside=0.0)


class Part(NamedTuple):
    """The outline of a piece and what its group says."""

    strip: Strip
    number: int
    of: int
    start: float
    """Where it begins on the strip, mm."""
    box: tuple[float, float, float, float]
    """Left, right, lower and upper edge on the sheet, y upwards."""


class Sheet(NamedTuple):
    """What all of a sheet has in common, mm."""

    thickness: float
    kerf: float
    overlap: float
    extra: float
    hoops: float
    mirror: bool


def pattern_of_svg(paths: Sequence[str | PathLike[str]]) -> SvgPattern:
    """Measure the pattern that is drawn on the sheets of an SVG.

    Parameters
    ----------
    paths : all sheets of one pattern, as ``geoweave cut --formats svg`` writes them, of straight strips

    Raises
    ------
    FieldError
        If a file is no such SVG, a piece or a crossing is missing, or two strips say different things of
        a crossing.

    Examples
    --------
    >>> import tempfile
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=100.0)
    >>> laid = gw.fabrication.layout(weave)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = gw.fabrication.pattern_of_svg(laid.save(folder + "/cone.svg")).pattern
    >>> bool(np.abs(found.at - laid.pattern.at).max() < 0.02)  # mm
    True
    """
    parts: dict[tuple[int, int], Part] = {}
    seen: list[Seen] = []
    width, sheet = math.nan, None
    for path in paths:
        root = _root(path)
        sheet = _sheet(root, Path(path).name)
        groups = {each.get("id", ""): each for each in root.iter() if _tag(each) == "g"}
        for name, group in groups.items():
            if not name.startswith("cut-"):
                continue
            index, part, width = _part(group, sheet, Path(path).name)
            parts[index, part.number] = part
            guides = groups.get(name.replace("cut-", "guide-", 1))
            if guides is not None:
                seen += _seen(guides, index, part, sheet, width)
    if sheet is None or not parts:
        raise FieldError(f"{_names(paths)}: no strip is drawn; write it with {MADE}")
    strips = _strips(parts, sheet)
    return SvgPattern(_pattern(strips, seen, width, sheet.thickness), sheet.hoops)


def _names(paths: Sequence[str | PathLike[str]]) -> str:
    return ", ".join(Path(path).name for path in paths) or "the drawing"


def _tag(element: ElementTree.Element) -> str:
    return element.tag.rpartition("}")[2]


def _root(path: str | PathLike[str]) -> ElementTree.Element:
    try:
        return ElementTree.parse(path).getroot()
    except (ElementTree.ParseError, OSError) as error:
        raise FieldError(
            f"{Path(path).name}: cannot be read as an SVG ({error}); write it with {MADE}"
        ) from error


def _sheet(root: ElementTree.Element, name: str) -> Sheet:
    try:
        thickness, kerf, overlap, extra, hoops = (
            _finite(root.attrib[f"data-{key}"]) for key in ("thickness", "kerf", "overlap", "extra", "hoops")
        )
        return Sheet(thickness, kerf, overlap, extra, hoops, root.attrib["data-mirror"] == "1")
    except (KeyError, ValueError) as error:
        raise FieldError(
            f"{name}: does not say how its strips are made ({error}); write it with {MADE}"
        ) from error


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text} is not a number of mm")
    return value


def _lines(element: ElementTree.Element) -> Iterator[NDArray[np.float64]]:
    """The lines of a path, y upwards."""
    for points in path_lines(element.get("d", "")):
        yield points * [1.0, -1.0]


def _part(group: ElementTree.Element, sheet: Sheet, name: str) -> tuple[int, Part, float]:
    """Number of the strip, the piece, and how wide it is without the kerf."""
    label = group.get("data-label", "?")
    try:
        number, of = (int(each) for each in group.attrib["data-piece"].split("/"))
        one, other = (_finite(each) for each in group.attrib["data-trimmed"].split())
        outline = next(points for each in group if each.get("class") == "outline" for points in _lines(each))
        start, index = _finite(group.attrib["data-from"]), int(group.attrib["data-strip"])
        family, closed = int(group.attrib["data-family"]), group.attrib["data-closed"] == "1"
        ends = _openings(group.get("data-openings"))
    except (KeyError, ValueError, StopIteration) as error:
        raise FieldError(
            f"{name}: an entry of strip {label} is missing or wrong ({error!r}); write the drawing anew"
        ) from error
    if len(outline) != 4:
        raise FieldError(
            f"{name}: strip {label} is cut curved, and only straight ones are measured; read pattern.json"
        )
    (left, low), (right, high) = outline.min(axis=0).tolist(), outline.max(axis=0).tolist()
    half = 0.5 * sheet.kerf
    box = (left + half, right - half, low + half, high - half)
    hoop = group.get("data-hoop") == "1"
    strip = Strip(label, family, closed, 0.0, 0.0, 0.0, (one, other), (), ends, hoop)
    return index, Part(strip, number, of, start, box), box[3] - box[2]


def _openings(text: str | None) -> tuple[int, int] | None:
    """At which openings a strip ends, if the drawing says so."""
    if text is None:
        return None
    one, other = text.split()
    return int(one), int(other)


def _seen(guides: ElementTree.Element, index: int, part: Part, sheet: Sheet, width: float) -> Iterator[Seen]:
    """The crossings that are drawn on a piece."""
    left, right, low, high = part.box
    origin = np.array([left, 0.5 * (low + high)])
    marks: dict[int, list[tuple[float, float, bool]]] = {}
    for each in guides:
        if each.get("class") in ("hollow", "solid"):
            x, y = _spot(each) - origin
            whose = int(each.get("data-crossing", "-1"))
            marks.setdefault(whose, []).append((float(x), float(y), each.get("class") == "hollow"))
    side = -1.0 if sheet.mirror else 1.0
    lined: dict[int, list[float]] = {}
    for each in guides:
        kind = each.get("class")
        crossing = int(each.get("data-crossing", "-1"))
        if kind not in ("over", "under") or crossing < 0:
            continue
        lines = [points - origin for points in _lines(each)]
        near = [(x, y) for x, y, _ in marks.get(crossing, [])]
        angle, at = _measured(lines, width, right - left, kind == "under", near)
        lined.setdefault(crossing, []).append(at)
        yield Seen(index, crossing, part.start + at, side * angle, kind == "over")
    for crossing, spots in marks.items():
        for x, y, over in spots:
            # Where writing leaves no room for lines, the mark alone stands on the line of the partner.
            if all(abs(at - x) > width for at in lined.get(crossing, [])):
                yield Seen(index, crossing, part.start + x, math.nan, over, side * y)


def _spot(mark: ElementTree.Element) -> NDArray[np.float64]:
    """Where a mark stands on the sheet: its middle, not that of its box."""
    if _tag(mark) == "circle":
        return np.array([float(mark.get("cx", "nan")), -float(mark.get("cy", "nan"))])
    points = np.concatenate(list(_lines(mark)))
    best, found = math.inf, points.mean(axis=0)
    for number in range(len(MARKS)):
        shape = outline(number)
        if len(shape) == len(points):
            size = float(np.ptp(points, axis=0).sum() / np.ptp(shape, axis=0).sum())
            middle = (points - size * shape).mean(axis=0)
            off = float(np.abs(points - size * shape - middle).max())
            if off < best:
                best, found = off, middle
    return np.asarray(found)


def _beside(aside: float, angle: float) -> float:
    """By how much a mark is farther along the strip than its crossing, as `place_marks` puts it down."""
    reach = abs(aside)
    return min(max(aside * math.cos(angle) / (math.sin(angle) or 1e-12), -reach), reach)


def _measured(
    lines: Sequence[NDArray[np.float64]],
    width: float,
    length: float,
    under: bool,
    marks: Sequence[tuple[float, float]],
) -> tuple[float, float]:
    """Angle and place of a crossing, from parts of the edges of the partner.

    With n the normal of the partner and a the place of the crossing, a part of an edge has
    ``n . p = n_x a + o``, where the offset o is one of the few that are drawn.
    """
    ends = np.array([[points[0], points[-1]] for points in lines])
    steps = ends[:, 1] - ends[:, 0]
    way = steps.sum(axis=0)
    angle = math.atan2(way[1], way[0])
    normal = np.array([-math.sin(angle), math.cos(angle)])
    found = ends.mean(axis=1) @ normal
    size = np.linalg.norm(steps, axis=1)
    half = 0.5 * width
    offsets = [half, -half] + ([half - inset_of(width), inset_of(width) - half] if under else [])
    best: list[tuple[float, float, float]] = []
    # The larger the lever, the less exactly the direction tells where a line is.
    slack = 0.02 + 0.002 * float(np.abs(ends).max() / max(size.sum(), 1e-9))
    for guess in {round(float(value - offset), 3) for value in found for offset in offsets}:
        off = np.abs(found[:, None] - guess - np.array(offsets)[None])
        nearest = off.argmin(axis=1)
        fits = off.min(axis=1) <= slack
        values = (found - np.array(offsets)[nearest])[fits]
        at = float(np.average(values, weights=size[fits]) / normal[0]) if fits.any() else math.nan
        best.append((float(size[fits].sum()), at, guess))
    most = max(each[0] for each in best)
    likely = [at for covered, at, _ in best if covered >= most - 1e-6]

    def doubt(at: float) -> tuple[bool, float]:
        # Where only one edge of the partner is seen, the mark says on which side of it the middle is. Without
        # a mark the other edge lies beyond the end of the piece.
        near = [off for x, y in marks if (off := abs(at - x + _beside(y, angle))) < width]
        return not near, min(near, default=min(abs(at), abs(length - at)))

    return angle, min(likely, key=doubt)


def _strips(parts: Mapping[tuple[int, int], Part], sheet: Sheet) -> list[Strip]:
    """The strips that the pieces make."""
    count = 1 + max(index for index, _ in parts)
    strips = []
    for index in range(count):
        own = sorted(
            (part for (strip, _), part in parts.items() if strip == index), key=lambda part: part.number
        )
        if not own or [part.number for part in own] != list(range(1, own[0].of + 1)):
            label = own[0].strip.label if own else f"number {index}"
            raise FieldError(f"strip {label} is not whole on these sheets; give all of them")
        last = own[-1]
        end = last.start + last.box[1] - last.box[0]
        strip = last.strip
        strips.append(strip._replace(length=end - (sheet.overlap if strip.closed else sheet.extra)))
    return strips


def _pattern(strips: Sequence[Strip], seen: Sequence[Seen], width: float, thickness: float) -> Pattern:
    """Put together what the strips say of each crossing."""
    of: dict[int, list[Seen]] = {}
    # What is known by its mark alone comes last, when the other strip is known.
    for drawn in sorted(seen, key=lambda each: math.isnan(each.angle)):
        each, strip, others = drawn, strips[drawn.strip], of.setdefault(drawn.crossing, [])
        if math.isnan(drawn.angle):
            if len(others) != 1 or (others[0].strip == drawn.strip and abs(others[0].at - drawn.at) < width):
                continue
            each = drawn.moved(-others[0].angle)
        place = each.at % strip.length if strip.closed else each.at
        # In an overlap, and on the tab of a closed strip, a crossing is drawn twice.
        if not any(_same(place, other, strip) for other in others if other.strip == each.strip):
            others.append(each._replace(at=place))
    count = 1 + max(of, default=-1)
    ribbons, at = np.zeros((count, 2), dtype=np.int64), np.zeros((count, 2))
    angle, over = np.zeros(count), np.zeros(count, dtype=np.int64)
    for x in range(count):
        both = sorted(of.get(x, []))
        if len(both) != 2:
            where = " and ".join(strips[each.strip].label for each in both) or "no strip"
            raise FieldError(f"crossing {x} is drawn on {where}, and it must be on two places of strips")
        one, other = both
        turn = math.remainder(one.angle + other.angle, 2 * math.pi)
        if one.over == other.over or abs(turn) > math.radians(ASKEW):
            raise FieldError(
                f"strips {strips[one.strip].label} and {strips[other.strip].label} do not agree about "
                f"crossing {x}; write the drawing anew"
            )
        ribbons[x], at[x] = (one.strip, other.strip), (one.at, other.at)
        angle[x] = math.degrees(math.remainder(one.angle - 0.5 * turn, 2 * math.pi))
        over[x] = int(other.over)
    mark, again = assigned(ribbons, at, np.array([strip.closed for strip in strips], dtype=bool))
    return Pattern(tuple(strips), width, thickness, ribbons, at, angle, over, mark, again)


def _same(at: float, other: Seen, strip: Strip) -> bool:
    """Whether two places on a strip are one."""
    off = at - other.at
    return abs(math.remainder(off, strip.length) if strip.closed else off) <= NEAR
