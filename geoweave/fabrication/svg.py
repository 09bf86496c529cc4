"""A sheet as SVG in true millimetres, one group per layer, as Inkscape and laser cutters read it."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from os import PathLike
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree
from xml.sax.saxutils import escape, quoteattr

import numpy as np
from numpy.typing import NDArray

from geoweave.errors import FieldError
from geoweave.fabrication.colours import Colours, Ink, ink
from geoweave.fabrication.marks import DISC, MARKS
from geoweave.fabrication.nesting import Laid, Sheet
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.pieces import Making
from geoweave.fabrication.strip_figures import LAYERS, ROLES, Figure, Spot
from geoweave.fabrication.stroke_font import text_box
from geoweave.files import replacing

__all__ = ["MarkSeen", "path_lines", "read_svg", "svg_text", "write_svg"]

STEP, FINE = 0.01, 0.001
"""Of the corners of letters, and of those of guides and marks, mm."""

FONT = ' font-family="Helvetica, Arial, sans-serif" text-anchor="middle"'
"""What all printed texts of a layer have in common."""

LINES, NUMBER = re.compile(r"M([^MlZ]*)(?:l([^MZ]*))?"), re.compile(r"-?\d*\.?\d+")
"""A subpath: places, then steps from the last of them; and a number of it."""

ROUND = MARKS.index("disc")
"""The mark that is a circle."""

CAPITAL = 0.72
"""Height of a capital letter in heights of the font (Helvetica, Arial)."""

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '


def write_svg(
    path: str | PathLike[str],
    pattern: Pattern,
    sheet: Sheet,
    colours: Colours,
    title: str,
    making: Making | None = None,
) -> None:
    """Write a sheet as SVG, whole or not at all."""
    text = svg_text(pattern, sheet, colours, title, making)
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def svg_text(
    pattern: Pattern, sheet: Sheet, colours: Colours, title: str, making: Making | None = None
) -> str:
    """The text of the SVG: one user unit is one millimetre; ``data-`` attributes name strip and crossing.

    Layers come in the order in which a machine works. What most of a layer has in common is said once, of the
    layer. Holes and round marks are circles. Attributes of the sheet and of the outlines say how strips are
    made and which part of which strip a piece is, so that `pattern_of_svg` can measure the pattern.
    """
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        (
            f'{HEAD}version="1.1" width="{_number(sheet.width)}mm" height="{_number(sheet.height)}mm" '
            f'viewBox="0 0 {_number(sheet.width)} {_number(sheet.height)}" '
            f"{_made(pattern, making or Making())} "
            'fill="none" stroke-linecap="round" stroke-linejoin="round">'
        ),
        f"<title>{escape(title)}</title>",
    ]
    shown = [(piece, piece.figures) for piece in sheet.laid]
    for layer in LAYERS:
        drawn = [(piece, _inked(figures, layer, colours)) for piece, figures in shown]
        count = Counter((look.stroke, look.width) for _, looks in drawn for _, look in looks)
        if not count:
            continue
        usual = count.most_common(1)[0][0]
        printed = any(each.text and each.printed for _, looks in drawn for each, _ in looks)
        shared = _stroke(*usual) + FONT * printed
        lines.append(f'<g id="{layer}" inkscape:groupmode="layer" inkscape:label="{layer}"{shared}>')
        for piece, looks in drawn:
            if looks:
                said = _said(pattern, piece) if layer == "cut" else ""
                lines.append(f'<g id="{layer}-{_name(pattern, piece)}"{said}>')
                lines += [_element(each, look, usual, sheet.height) for each, look in looks]
                lines.append("</g>")
        lines.append("</g>")
    return "\n".join([*lines, "</svg>"]) + "\n"


def _made(pattern: Pattern, making: Making) -> str:
    """How strips are made, as attributes of a sheet."""
    numbers = {
        "thickness": pattern.thickness,
        "kerf": making.kerf,
        "overlap": making.overlap,
        "extra": making.extra,
        "hoops": making.hoops,
    }
    said = [f'data-{name}="{value:.6g}"' for name, value in numbers.items()]
    return " ".join([*said, f'data-mirror="{int(making.mirror)}"'])


def _said(pattern: Pattern, laid: Laid) -> str:
    """Which part of which strip a piece is, as attributes of its outline."""
    piece = laid.drawn.piece
    strip = pattern.strips[piece.strip]
    before, after = (_number(each) for each in strip.trimmed)
    ends = "" if strip.openings is None else f' data-openings="{strip.openings[0]} {strip.openings[1]}"'
    return (
        f' data-strip="{piece.strip}" data-label={quoteattr(strip.label)} data-family="{strip.family}" '
        f'data-closed="{int(strip.closed)}" data-hoop="{int(strip.hoop)}" data-trimmed="{before} {after}" '
        f'data-piece="{piece.number}/{piece.total}" data-from="{_number(piece.start)}"'
        f"{ends}"
    )


def _inked(figures: Iterable[Figure], layer: str, colours: Colours) -> list[tuple[Figure, Ink]]:
    """The figures of a layer that are drawn, and how."""
    looks = ((each, ink(each, colours)) for each in figures if ROLES[each.role] == layer)
    return [(each, look) for each, look in looks if look is not None]


def _stroke(colour: str | None, width: float) -> str:
    if colour is None:
        return ' stroke="none"'
    return f' stroke="{colour}" stroke-width="{_number(width)}"'


def _element(figure: Figure, look: Ink, usual: tuple[str | None, float], height: float) -> str:
    """A figure as an element; of what all of its layer has nothing is said."""
    fields = [f'class="{figure.role}"']
    if (look.stroke, look.width) != usual:
        fields.append(_stroke(look.stroke, look.width).strip())
    if look.fill is not None:
        fields.append(f'fill="{look.fill}"')
    if figure.crossing >= 0:
        fields.append(f'data-crossing="{figure.crossing}"')
    spot = figure.spot
    if figure.text and figure.printed and spot is not None:
        return _printed(figure, spot, look, height)
    if figure.text:
        fields.append(f"data-text={quoteattr(figure.text)}")
    if spot is not None and (figure.role == "hole" or figure.mark == ROUND):
        size = spot.size if figure.role == "hole" else DISC * spot.size
        x, y, radius = (_number(each) for each in (spot.x, height - spot.y, size))
        return f'<circle {" ".join(fields)} cx="{x}" cy="{y}" r="{radius}"/>'
    if figure.text:
        data = _relative(figure, height, STEP)
    else:
        short = ROLES[figure.role] == "guide"
        data = _relative(figure, height, FINE) if short else _absolute(figure, height)
    return f'<path {" ".join(fields)} d="{data}"/>'


def _absolute(figure: Figure, height: float) -> str:
    """Places of the corners; a pair that follows another one without a letter is a line to it."""
    return "".join(
        "M" + " ".join(f"{_number(x)},{_number(height - y)}" for x, y in path.tolist()) + "Z" * figure.closed
        for path in figure.paths
    )


def _relative(figure: Figure, height: float, step: float) -> str:
    """Lines, each from its first point on by differences in whole steps, which add up without an error."""
    found = []
    for path in figure.paths:
        points = np.rint(path * [1.0, -1.0] / step + [0.0, height / step]).astype(np.int64)
        ahead = np.diff(points, axis=0).tolist()
        x, y = points[0].tolist()
        rest = " ".join(f"{_steps(u, step)},{_steps(v, step)}" for u, v in ahead)
        found.append(f"M{_steps(x, step)},{_steps(y, step)}l{rest}" + "Z" * figure.closed)
    return "".join(found)


def _steps(count: int, step: float) -> str:
    """So many steps in mm, as short as it goes."""
    text = _number(count * step)
    return text.replace("0.", ".", 1) if text.startswith(("0.", "-0.")) else text


def path_lines(data: str) -> list[NDArray[np.float64]]:
    """The lines of a path as it is written here, (P, 2) each, y as in the file."""
    found = []
    for places, steps in LINES.findall(data):
        points = np.array(NUMBER.findall(places), dtype=np.float64).reshape(-1, 2)
        if steps:
            ahead = np.array(NUMBER.findall(steps), dtype=np.float64).reshape(-1, 2)
            points = np.concatenate([points, points[-1] + np.cumsum(ahead, axis=0)])
        found.append(points)
    return found


def _printed(figure: Figure, spot: Spot, look: Ink, height: float) -> str:
    """A text in letters of a font, stretched to the width of its strokes."""
    x, y = _number(spot.x), _number(height - spot.y)
    box = text_box(figure.text, spot.size)
    turn = f' transform="rotate({-spot.turn:g} {x} {y})"' if spot.turn else ""
    crossing = f' data-crossing="{figure.crossing}"' if figure.crossing >= 0 else ""
    return (
        f'<text class="{figure.role}" x="{x}" y="{y}" dy="{_number(0.5 * spot.size)}"{turn}{crossing} '
        f'font-size="{_number(spot.size / CAPITAL)}" textLength="{_number(box.right - box.left)}" '
        f'lengthAdjust="spacingAndGlyphs" stroke="none" fill="{look.stroke}">{escape(figure.text)}</text>'
    )


def _name(pattern: Pattern, laid: Laid) -> str:
    piece = laid.drawn.piece
    label = pattern.strips[piece.strip].label
    return label if piece.total == 1 else f"{label}-{piece.number}"


def _number(value: float) -> str:
    """Millimetres to a micrometre, without trailing zeros."""
    text = f"{value:.3f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def _strip_length(outline: NDArray[np.float64]) -> float:
    """Length L of a strip of constant width w, from its outline.

    Offset edges of a curve are together twice as long as it, so the perimeter is ``2 L + 2 w``, and the area
    is ``L w``: L is the larger root of ``x^2 - (perimeter / 2) x + area``.
    """
    ahead = np.roll(outline, -1, axis=0)
    half = 0.5 * float(np.linalg.norm(ahead - outline, axis=1).sum())
    area = 0.5 * abs(float((outline[:, 0] * ahead[:, 1] - outline[:, 1] * ahead[:, 0]).sum()))
    return 0.5 * half + float(np.sqrt(max(0.25 * half**2 - area, 0.0)))


class MarkSeen(NamedTuple):
    """A mark as it is found in a drawing."""

    crossing: int
    """The crossing that it belongs to."""
    strip: str
    """Label of the strip that it stands on."""
    role: str
    """"hollow" where the strip lies over, "solid" where it lies under."""
    outline: tuple[float, ...]
    """x and y of its corners about their mean, in heights of the mark: the same at any place and size.
    Nothing for a circle."""


def read_svg(path: str | PathLike[str]) -> tuple[dict[str, float], tuple[MarkSeen, ...]]:
    """Read back what a drawing says: how long each strip is that it cuts, and the marks.

    Returns
    -------
    tuple
        Length of the outlines of each strip in mm, by its label, and the marks; one that is repeated on the
        tab of a closed strip is listed once.

    Raises
    ------
    FieldError
        If the file is no SVG.

    Examples
    --------
    >>> import tempfile
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=100.0)
    >>> laid = gw.fabrication.layout(weave)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     lengths, marks = gw.fabrication.read_svg(laid.save(folder + "/cone.svg")[0])
    >>> bool(abs(lengths["A1"] - laid.pattern.strips[0].length) < 1e-3)  # mm
    True
    >>> len(marks) == 2 * len(laid.pattern.at)
    True
    """
    name = Path(path).name
    try:
        root = ElementTree.parse(path).getroot()
    except ElementTree.ParseError as error:
        raise FieldError(f"{name}: cannot be read as an SVG ({error}); write it anew") from error
    space = root.tag.removesuffix("svg")
    lengths: dict[str, float] = {}
    marks: dict[MarkSeen, None] = {}
    for group in root.iter(f"{space}g"):
        layer, _, strip = group.get("id", "").partition("-")
        for each in group.findall(f"{space}path"):
            role = each.get("class", "")
            if role not in ("outline", "hollow", "solid"):
                continue
            points = np.concatenate([*path_lines(each.get("d", "")), np.zeros((0, 2))])
            if layer == "cut":
                lengths[strip] = lengths.get(strip, 0.0) + _strip_length(points)
            else:
                shape = np.round((points - points.mean(axis=0)) / np.ptp(points[:, 1]), 1) + 0.0
                marks[MarkSeen(int(each.get("data-crossing", -1)), strip, role, tuple(shape.ravel()))] = None
        for each in group.findall(f"{space}circle"):
            role = each.get("class", "")
            if role in ("hollow", "solid"):
                marks[MarkSeen(int(each.get("data-crossing", -1)), strip, role, ())] = None
    return lengths, tuple(marks)
