"""A sheet as SVG in true millimetres, one group per layer, as Inkscape and laser cutters read it."""

from __future__ import annotations

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
from geoweave.fabrication.svg_paths import number, path_data, path_lines, place_data, text_data
from geoweave.files import replacing

__all__ = ["MarkSeen", "read_svg", "svg_text", "write_svg"]

LETTER, STEP, FINE = 0.05, 0.01, 0.001
"""Of the corners of letters, of marks, and of guides, whose direction is measured; mm."""

TOGETHER = ("heading", "fold")
"""Figures that nobody asks for one by one.

A machine works the parts of a path one after the other, as it would paths."""

FONT = ' font-family="Helvetica, Arial, sans-serif" text-anchor="middle"'
"""What all printed texts of a layer have in common."""

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
            f'{HEAD}version="1.1" width="{number(sheet.width)}mm" height="{number(sheet.height)}mm" '
            f'viewBox="0 0 {number(sheet.width)} {number(sheet.height)}" '
            f"{_made(pattern, making or Making())} "
            'fill="none" stroke-linecap="round" stroke-linejoin="round">'
        ),
        f"<title>{escape(title)}</title>",
    ]
    shown = [(piece, piece.figures) for piece in sheet.laid]
    for layer in LAYERS:
        drawn = [(piece, _inked(figures, layer, colours)) for piece, figures in shown]
        usual = _usual([each for _, looks in drawn for each in looks])
        if usual is None:
            continue
        shared = _stroke(usual.stroke, usual.width)
        if usual.letters:
            shared = f' stroke="none" fill="{usual.stroke}"{FONT} font-size="{usual.letters}"'
        lines.append(f'<g id="{layer}" inkscape:groupmode="layer" inkscape:label="{layer}"{shared}>')
        for piece, looks in drawn:
            if looks:
                said = _said(pattern, piece) if layer == "cut" else ""
                lines.append(f'<g id="{layer}-{_name(pattern, piece)}"{said}>')
                lines += [_element(each, look, usual, sheet.height) for each, look in _joined(looks)]
                lines.append("</g>")
        lines.append("</g>")
    return "\n".join([*lines, "</svg>"]) + "\n"


class Usual(NamedTuple):
    """What most figures of a layer have in common."""

    stroke: str | None
    width: float
    letters: str
    """Size of the font, empty where no text is in letters of a font."""


def _usual(looks: Iterable[tuple[Figure, Ink]]) -> Usual | None:
    """What is said once, of the layer; None of a layer without figures."""
    inks = Counter((look.stroke, look.width) for _, look in looks)
    sizes = Counter(_font(each.spot.size) for each, _ in looks if each.text and each.printed and each.spot)
    if not inks:
        return None
    return Usual(*inks.most_common(1)[0][0], sizes.most_common(1)[0][0] if sizes else "")


def _joined(looks: list[tuple[Figure, Ink]]) -> list[tuple[Figure, Ink]]:
    """The figures of a piece; arrows and folds that look the same are one path."""
    found: dict[object, tuple[Figure, Ink]] = {}
    for figure, look in looks:
        if figure.role not in TOGETHER:
            found[len(found)] = figure, look
            continue
        key = figure.role, figure.closed, look
        before = found[key][0].paths if key in found else ()
        found[key] = figure._replace(paths=before + figure.paths, crossing=-1), look
    return list(found.values())


def _font(size: float) -> str:
    """Size of the font whose capital letters are so high."""
    return number(size / CAPITAL)


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
    before, after = (number(each) for each in strip.trimmed)
    ends = "" if strip.openings is None else f' data-openings="{strip.openings[0]} {strip.openings[1]}"'
    return (
        f' data-strip="{piece.strip}" data-label={quoteattr(strip.label)} data-family="{strip.family}" '
        f'data-closed="{int(strip.closed)}" data-hoop="{int(strip.hoop)}" data-trimmed="{before} {after}" '
        f'data-piece="{piece.number}/{piece.total}" data-from="{number(piece.start)}"'
        f"{ends}"
    )


def _inked(figures: Iterable[Figure], layer: str, colours: Colours) -> list[tuple[Figure, Ink]]:
    """The figures of a layer that are drawn, and how."""
    looks = ((each, ink(each, colours)) for each in figures if ROLES[each.role] == layer)
    return [(each, look) for each, look in looks if look is not None]


def _stroke(colour: str | None, width: float) -> str:
    if colour is None:
        return ' stroke="none"'
    return f' stroke="{colour}" stroke-width="{number(width)}"'


def _element(figure: Figure, look: Ink, usual: Usual, height: float) -> str:
    """A figure as an element; of what all of its layer has nothing is said."""
    fields = [f'class="{figure.role}"']
    if (look.stroke, look.width) != usual[:2]:
        fields.append(_stroke(look.stroke, look.width).strip())
    if look.fill is not None:
        fields.append(f'fill="{look.fill}"')
    if figure.crossing >= 0 and not figure.text:
        fields.append(f'data-crossing="{figure.crossing}"')
    spot = figure.spot
    if figure.text and figure.printed and spot is not None:
        return _printed(figure, spot, look, usual, height)
    if figure.text:
        fields.append(f"data-text={quoteattr(figure.text)}")
    if spot is not None and (figure.role == "hole" or figure.mark == ROUND):
        size = spot.size if figure.role == "hole" else DISC * spot.size
        x, y, radius = (number(each) for each in (spot.x, height - spot.y, size))
        return f'<circle {" ".join(fields)} cx="{x}" cy="{y}" r="{radius}"/>'
    if figure.text and spot is not None:
        data = text_data(figure.text, spot.size, spot.turn, spot.x, height - spot.y, LETTER)
    elif ROLES[figure.role] == "guide":
        data = path_data(figure.paths, figure.closed, height, STEP if figure.mark >= 0 else FINE)
    else:
        data = place_data(figure.paths, figure.closed, height)
    return f'<path {" ".join(fields)} d="{data}"/>'


def _printed(figure: Figure, spot: Spot, look: Ink, usual: Usual, height: float) -> str:
    """A text in letters of a font, stretched to the width of its strokes."""
    x, y, low = (number(each) for each in (spot.x, height - spot.y, height - spot.y + 0.5 * spot.size))
    box, font = text_box(figure.text, spot.size), _font(spot.size)
    turn = f' transform="rotate({-spot.turn:g} {x} {y})"' if spot.turn else ""
    fill = "" if look.stroke == usual.stroke else f' fill="{look.stroke}"'
    size = "" if font == usual.letters else f' font-size="{font}"'
    long = number(box.right - box.left)
    return (
        f'<text class="{figure.role}" x="{x}" y="{low}"{turn}{fill}{size} textLength="{long}" '
        f'lengthAdjust="spacingAndGlyphs">{escape(figure.text)}</text>'
    )


def _name(pattern: Pattern, laid: Laid) -> str:
    piece = laid.drawn.piece
    label = pattern.strips[piece.strip].label
    return label if piece.total == 1 else f"{label}-{piece.number}"


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
