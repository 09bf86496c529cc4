"""A sheet as DXF R2010 in millimetres, one layer per purpose."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike
from typing import TYPE_CHECKING

from geoweave.fabrication.colours import Colours
from geoweave.fabrication.nesting import Sheet
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.strip_figures import LAYERS, ROLES, Figure
from geoweave.files import replacing

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.layouts.layout import Modelspace

__all__ = ["APPLICATION", "dxf_drawing", "write_dxf"]

APPLICATION = "GEOWEAVE"
"""Name under which entities carry their strip and their crossing as extended data."""


def write_dxf(path: str | PathLike[str], pattern: Pattern, sheet: Sheet, colours: Colours) -> None:
    """Write a sheet as DXF, whole or not at all; the same sheet gives the same bytes."""
    drawing = dxf_drawing(pattern, sheet, colours)
    with replacing(path) as temporary, _without_dates():
        drawing.saveas(temporary)


def dxf_drawing(pattern: Pattern, sheet: Sheet, colours: Colours) -> Drawing:
    """A drawing with the layers cut, score, guide and label, coloured by layer.

    Extended data under `APPLICATION` name the strip and, where there is one, the crossing.
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
    for laid in sheet.laid:
        piece = laid.drawn.piece
        name = pattern.strips[piece.strip].label
        for figure in laid.figures:
            layer = ROLES[figure.role]
            if layer == "colour":
                continue
            data = [(1000, name), (1070, piece.number), (1000, figure.role), (1071, figure.crossing)]
            for path in figure.paths:
                line = space.add_lwpolyline(path.tolist(), close=figure.closed, dxfattribs={"layer": layer})
                line.set_xdata(APPLICATION, data)
            if figure.role == "solid":
                _fill(space, figure, layer)
    return drawing


def _fill(space: Modelspace, figure: Figure, layer: str) -> None:
    from ezdxf import colors

    for path in figure.paths:
        hatch = space.add_hatch(dxfattribs={"layer": layer, "color": colors.BYLAYER})
        hatch.paths.add_polyline_path(path.tolist(), is_closed=True)


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
