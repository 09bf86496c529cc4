"""A sheet as SVG in true millimetres, one group per layer, as Inkscape and laser cutters read it."""

from __future__ import annotations

import re
from os import PathLike
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from geoweave.errors import FieldError
from geoweave.fabrication.colours import Colours, ink
from geoweave.fabrication.nesting import Laid, Sheet
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.strip_figures import LAYERS, ROLES, Figure
from geoweave.files import replacing

__all__ = ["MarkSeen", "read_svg", "svg_text", "write_svg"]

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '


def write_svg(
    path: str | PathLike[str], pattern: Pattern, sheet: Sheet, colours: Colours, title: str
) -> None:
    """Write a sheet as SVG, whole or not at all."""
    text = svg_text(pattern, sheet, colours, title)
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")


def svg_text(pattern: Pattern, sheet: Sheet, colours: Colours, title: str) -> str:
    """The text of the SVG: one user unit is one millimetre; ``data-`` attributes name strip and crossing."""
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        (
            f'{HEAD}version="1.1" width="{_number(sheet.width)}mm" height="{_number(sheet.height)}mm" '
            f'viewBox="0 0 {_number(sheet.width)} {_number(sheet.height)}" '
            'fill="none" stroke-linecap="round" stroke-linejoin="round">'
        ),
        f"<title>{escape(title)}</title>",
    ]
    shown = [(piece, piece.figures) for piece in sheet.laid]
    for layer in LAYERS:
        inner: list[str] = []
        for piece, figures in shown:
            paths = [
                line
                for figure in figures
                if ROLES[figure.role] == layer and (line := _path(figure, colours, sheet.height))
            ]
            if paths:
                inner += [f'<g id="{layer}-{_name(pattern, piece)}">', *paths, "</g>"]
        if inner:
            lines += [
                f'<g id="{layer}" inkscape:groupmode="layer" inkscape:label="{layer}">',
                *inner,
                "</g>",
            ]
    return "\n".join([*lines, "</svg>"]) + "\n"


def _path(figure: Figure, colours: Colours, height: float) -> str:
    look = ink(figure, colours)
    if look is None:
        return ""
    data = " ".join(
        "M"
        + " L".join(f"{_number(x)},{_number(height - y)}" for x, y in path)
        + (" Z" if figure.closed else "")
        for path in figure.paths
    )
    fields = [f'class="{figure.role}"', f'd="{data}"']
    if look.stroke is not None:
        fields.append(f'stroke="{look.stroke}" stroke-width="{_number(look.width)}"')
    if look.fill is not None:
        fields.append(f'fill="{look.fill}"')
    if figure.crossing >= 0:
        fields.append(f'data-crossing="{figure.crossing}"')
    if figure.text:
        fields.append(f"data-text={quoteattr(figure.text)}")
    return f"<path {' '.join(fields)}/>"


def _name(pattern: Pattern, laid: Laid) -> str:
    piece = laid.drawn.piece
    label = pattern.strips[piece.strip].label
    return label if piece.total == 1 else f"{label}-{piece.number}"


def _number(value: float) -> str:
    """Millimetres to a tenth of a micrometre, without trailing zeros."""
    text = f"{value:.4f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


class MarkSeen(NamedTuple):
    """A mark as it is found in a drawing."""

    crossing: int
    """The crossing that it belongs to."""
    strip: str
    """Label of the strip that it stands on."""
    role: str
    """"hollow" where the strip lies over, "solid" where it lies under."""
    outline: tuple[float, ...]
    """x and y of its corners about their mean, in heights of the mark: the same at any place and size."""


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
            points = np.array(re.findall(r"-?[0-9.]+", each.get("d", "")), dtype=np.float64).reshape(-1, 2)
            role = each.get("class", "")
            if layer == "cut":
                lengths[strip] = lengths.get(strip, 0.0) + float(np.ptp(points[:, 0]))
            if role in ("hollow", "solid"):
                shape = np.round((points - points.mean(axis=0)) / np.ptp(points[:, 1]), 1) + 0.0
                marks[MarkSeen(int(each.get("data-crossing", -1)), strip, role, tuple(shape.ravel()))] = None
    return lengths, tuple(marks)
