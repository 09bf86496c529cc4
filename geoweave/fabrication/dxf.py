"""A sheet as DXF R2010 in millimetres, one layer per purpose."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from geoweave.fabrication.colours import Colours
from geoweave.fabrication.marks import DISC, MARKS, outline
from geoweave.fabrication.nesting import Sheet
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.strip_figures import LAYERS, ROLES, Figure
from geoweave.fabrication.stroke_font import text_strokes
from geoweave.files import replacing

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.entities.dxfgfx import DXFGraphic
    from ezdxf.graphicsfactory import CreatorInterface as GenericLayout
    from ezdxf.layouts.layout import Modelspace

PLACES = 3
"""Of the numbers in a file: a micrometre."""

__all__ = ["APPLICATION", "dxf_drawing", "write_dxf"]

APPLICATION = "GEOWEAVE"
"""Name under which entities carry their strip and their crossing as extended data."""


def write_dxf(path: str | PathLike[str], pattern: Pattern, sheet: Sheet, colours: Colours) -> None:
    """Write a sheet as DXF, whole or not at all; the same sheet gives the same bytes."""
    drawing = dxf_drawing(pattern, sheet, colours)
    with replacing(path) as temporary, _without_dates():
        drawing.saveas(temporary)


def dxf_drawing(pattern: Pattern, sheet: Sheet, colours: Colours) -> Drawing:
    """A drawing with one layer per purpose, in the order in which a machine works, coloured by layer.

    Holes and round marks are circles. Each mark and each text is drawn once, as a block of lines, and put
    down where it belongs; printed texts are TEXT. Extended data under `APPLICATION` name the strip, the
    piece, the role and the crossing of outlines, holes and marks.
    """
    # The library is loaded by those who write DXF only.
    from ezdxf import colors, units as dxf_units
    from ezdxf.filemanagement import new

    with _without_dates():
        drawing = new("R2010")
    drawing.units = dxf_units.MM
    drawing.header["$MEASUREMENT"] = 1
    drawing.appids.add(APPLICATION)
    for layer in LAYERS:
        if layer != "colour":
            rgb = getattr(colours, layer)
            drawing.layers.add(layer, true_color=colors.rgb2int(_rgb(rgb)))
    space = drawing.modelspace()
    pieces = [(laid.drawn.piece, laid.figures) for laid in sheet.laid]
    for layer in LAYERS:
        for piece, figures in pieces:
            name = pattern.strips[piece.strip].label
            for figure in figures:
                if ROLES[figure.role] != layer or layer == "colour":
                    continue
                drawn = _drawn(drawing, space, figure, layer)
                if figure.role in ("outline", "hole", "hollow", "solid"):
                    data = [(1000, name), (1070, piece.number), (1000, figure.role), (1071, figure.crossing)]
                    for each in drawn:
                        each.set_xdata(APPLICATION, data)
    return drawing


def _drawn(drawing: Drawing, space: Modelspace, figure: Figure, layer: str) -> list[DXFGraphic]:
    """Put a figure down, as what a program for drawing knows it as."""
    spot, look = figure.spot, {"layer": layer}
    if spot is None:
        return [_line(space, path, figure.closed, look) for path in figure.paths]
    middle = (round(spot.x, PLACES), round(spot.y, PLACES))
    if figure.role == "hole":
        return [space.add_circle(middle, round(spot.size, PLACES), dxfattribs=look)]
    if figure.text and figure.printed:
        from ezdxf.enums import TextEntityAlignment

        text = space.add_text(figure.text, height=spot.size, rotation=spot.turn, dxfattribs=look)
        text.set_placement(middle, align=TextEntityAlignment.MIDDLE_CENTER)
        return [text]
    if figure.text:
        block = "TEXT_" + re.sub("[^A-Z0-9]", lambda found: f"_{ord(found[0]):X}", figure.text)
        if block not in drawing.blocks:
            _glyphs(drawing, block, figure.text)
    else:
        block = f"{MARKS[figure.mark]}_{figure.role}".upper()
        if block not in drawing.blocks:
            _mark(drawing, block, figure)
    size = round(spot.size, PLACES)
    scale = {"xscale": size, "yscale": size, "zscale": size, "rotation": spot.turn}
    return [space.add_blockref(block, middle, dxfattribs=look | scale)]


def _line(space: GenericLayout, path: NDArray[np.float64], closed: bool, look: dict[str, str]) -> DXFGraphic:
    """A line of two points, or of more."""
    path = path.round(PLACES)
    if len(path) == 2 and not closed:
        start, end = path.tolist()
        return space.add_line(start, end, dxfattribs=look)
    return space.add_lwpolyline(path.tolist(), close=closed, dxfattribs=look)


def _glyphs(drawing: Drawing, name: str, text: str) -> None:
    """A block with the strokes of a text with capital letters of height 1 about the origin."""
    block = drawing.blocks.new(name)
    for stroke in text_strokes(text, 1.0, 0.0, 0.0)[0]:
        _line(block, stroke, False, {"layer": "0"})


def _mark(drawing: Drawing, name: str, figure: Figure) -> None:
    """A block with a mark of radius 1 about the origin, filled where it is solid."""
    from ezdxf import colors

    block = drawing.blocks.new(name)
    look = {"layer": "0"}
    round_one = MARKS[figure.mark] == "disc"
    if round_one:
        block.add_circle((0.0, 0.0), DISC, dxfattribs=look)
    else:
        _line(block, outline(figure.mark), True, look)
    if figure.role == "solid":
        hatch = block.add_hatch(dxfattribs=look | {"color": colors.BYLAYER})
        if round_one:
            hatch.paths.add_edge_path().add_arc((0.0, 0.0), DISC, 0.0, 360.0)
        else:
            hatch.paths.add_polyline_path(outline(figure.mark).tolist(), is_closed=True)


@contextmanager
def _without_dates() -> Iterator[None]:
    """No time and no new identifier in the file; the switch of the library goes back to what it was."""
    from ezdxf._options import options

    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


def _rgb(colour: str) -> tuple[int, int, int]:
    red, green, blue = (int(colour[k : k + 2], 16) for k in (1, 3, 5))
    return red, green, blue
