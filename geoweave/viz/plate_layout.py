"""Figures of plates: rows with titles, legends and colour bars, and the drawing of each plate."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Colormap, ListedColormap, to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray

from geoweave.arrays import Vectors
from geoweave.curves import Curves
from geoweave.errors import RenderError
from geoweave.viz import style
from geoweave.viz.arrows import Arrows
from geoweave.viz.picture import Picture, sheet
from geoweave.viz.plate import Lines, Plate
from geoweave.viz.scales import Scale, colour_bar
from geoweave.viz.views import View

SIDE, GAP, TITLE, SUBTITLE, BAR = 40, 56, 56, 40, 190
"""Pixels of a figure of full width: border, between plates, for a title, for a subtitle, for a colour bar."""


def plates(
    panels: Sequence[Plate],
    *,
    columns: int | None = None,
    width: int = style.WIDTH,
    alt: str = "",
) -> Picture:
    """Draw plates in rows of equal columns; one colour bar for each row that shows values.

    Parameters
    ----------
    panels : what to draw; the order is kept
    columns : plates in a row; all in one row if not given
    width : pixels across the figure; a narrower one is the same figure, smaller
    alt : one sentence that says what is to be seen

    Raises
    ------
    RenderError
        If there is nothing to draw, or the plates of a row have different scales.

    Examples
    --------
    >>> plate = viz.Plate(gw.shapes.disk(faces=100), "a disk", edges=True)
    >>> viz.plates([plate, plate], width=400).pixels.shape[1]
    400
    """
    if not panels:
        raise RenderError("a figure of plates needs at least one plate")
    per_row = columns or len(panels)
    rows = [list(panels[i : i + per_row]) for i in range(0, len(panels), per_row)]
    scales = [_scale_of(row) for row in rows]
    unit = width / style.WIDTH
    room = width - unit * (2 * SIDE + GAP * (per_row - 1) + (BAR if any(scales) else 0))
    across = room / per_row
    tall = [across / min(_aspect(each) for each in row) for row in rows]
    words = [_words(row, unit) for row in rows]
    height = round(sum(tall) + sum(words) + unit * (SIDE + GAP * (len(rows) - 1)) + unit * SIDE)
    figure = sheet(width, height)
    with style.applied():
        top = unit * SIDE
        for row, scale, high, below in zip(rows, scales, tall, words, strict=True):
            # A row that is not full stands in the middle.
            left = unit * SIDE + 0.5 * (per_row - len(row)) * (across + unit * GAP)
            for plate in row:
                axes = figure.add_axes(
                    (left / width, 1 - (top + high) / height, across / width, high / height)
                )
                _draw(axes, plate, across / high, unit)
                _caption(figure, plate, (left + 0.5 * across) / width, top + high, height, unit)
                left += across + unit * GAP
            if scale is not None:
                _bar(figure, scale, (top + 0.1 * high, 0.8 * high), width, height, unit)
            top += high + below + unit * GAP
    maps: dict[int, Colormap] = {id(each.colormap): each.colormap for each in scales if each is not None}
    words_of_all = alt or ", ".join(plate.title for plate in panels)
    return Picture(figure, words_of_all, (*maps.values(), ListedColormap(sorted(_accents(panels)))))


def _accents(panels: Sequence[Plate]) -> set[str]:
    """Colours of thin things, for which the palette of a published picture must keep a place."""
    accents = {style.INK}
    for plate in panels:
        accents |= {each.colour for each in plate.arrows} | {each.colour for each in plate.lines}
        accents |= {plate.dot_colour} if plate.dots is not None else set()
    return accents


def _scale_of(row: Sequence[Plate]) -> Scale | None:
    scales = {id(plate.scale): plate.scale for plate in row if plate.scale is not None}
    if len(scales) > 1:
        raise RenderError("the plates of a row share one scale: put the others in a row of their own")
    return next(iter(scales.values()), None)


def _aspect(plate: Plate) -> float:
    low, high = plate.box
    return float((high - low)[0] / (high - low)[1])


def _words(row: Sequence[Plate], unit: float) -> float:
    """Pixels for what is written under a row."""
    title = TITLE if any(plate.title for plate in row) else 0
    subtitle = SUBTITLE if any(plate.subtitle for plate in row) else 0
    return unit * (title + subtitle + (SUBTITLE if any(_labelled(plate) for plate in row) else 0))


def _labelled(plate: Plate) -> list[tuple[str, str]]:
    """Legend of a plate: words and colour of each thing that has words."""
    things: list[Arrows | Lines] = [*plate.arrows, *plate.lines]
    return [(each.label, each.colour) for each in things if each.label]


def _draw(axes: Axes, plate: Plate, aspect: float, unit: float) -> None:
    low, high = plate.box
    middle, size = 0.5 * (low + high), high - low
    half = 0.5 * np.array([max(size[0], aspect * size[1]), max(size[1], size[0] / aspect)])
    axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
    axes.set_ylim(middle[1] - half[1], middle[1] + half[1])
    axes.set_axis_off()
    _faces(axes, plate, unit)
    project = plate.view.axes[:2].T
    for lines in plate.lines:
        look: dict[str, Any] = {"colors": lines.colour, "linewidths": unit * lines.width, "zorder": 2}
        if lines.dashed:
            look["linestyles"] = [(0, (2.5, 2.0))]
        axes.add_collection(LineCollection(list(_pieces(lines.what, plate.view) @ project), **look))
    for arrows in plate.arrows:
        points, vectors = arrows.points @ project, arrows.vectors @ project
        axes.quiver(
            points[:, 0], points[:, 1], vectors[:, 0], vectors[:, 1], color=arrows.colour,
            angles="xy", scale_units="xy", scale=1.0, units="xy", width=arrows.width,
            headwidth=3.6, headlength=4.2, headaxislength=3.8, minlength=0.0, minshaft=1.4, zorder=3,
        )  # fmt: skip
    if plate.dots is not None:
        dots = plate.dots @ project
        axes.scatter(dots[:, 0], dots[:, 1], s=unit**2 * 46, color=plate.dot_colour, linewidths=0, zorder=4)
    for note in plate.notes:
        x, y = np.asarray(note.point) @ project
        axes.annotate(
            note.text, (x, y), xytext=tuple(unit * np.asarray(note.offset)),
            textcoords="offset points", ha="center", va="center", color=note.colour,
            size=unit * note.size, zorder=5,
        )  # fmt: skip


def _faces(axes: Axes, plate: Plate, unit: float) -> None:
    """Fill the faces that look to the eye, far ones first; shade them where the mesh is not flat."""
    mesh, (right, up, eye) = plate.mesh, plate.view.axes
    facing = mesh.face_normals @ eye
    seen = np.flatnonzero(facing > 0)
    if not len(seen):
        raise RenderError(f"plate '{plate.title}': every face looks away from the eye; turn the view")
    seen = seen[np.argsort(mesh.barycenters[seen] @ eye, kind="stable")]
    corners = mesh.vertices[mesh.faces[seen]] @ np.stack([right, up]).T
    if plate.values is None or plate.scale is None:
        colours = np.tile(to_rgb(style.SURFACE), (len(seen), 1))
    else:
        colours = np.asarray(plate.scale.colormap(plate.scale.norm(plate.values[seen])))[:, :3]
    light = mesh.face_normals[seen] @ (eye - 0.45 * right + 0.6 * up) / np.linalg.norm([1.0, 0.45, 0.6])
    if np.ptp(light) > 1e-6:
        colours = colours * (0.72 + 0.28 * np.clip(light, 0.0, 1.0))[:, None]
    # Antialiased neighbours would let the ground shine through between them.
    axes.add_collection(
        PolyCollection(corners, facecolors=colours, linewidths=0, antialiaseds=False, zorder=1)
    )
    if plate.edges:
        shown = np.zeros(mesh.n_edges, dtype=bool)
        shown[mesh.face_edges[seen]] = True
        ends = mesh.vertices[mesh.edges[shown]] @ np.stack([right, up]).T
        axes.add_collection(LineCollection(list(ends), colors="#a39c8e", linewidths=unit * 0.7, zorder=1.5))


def _pieces(what: Vectors | Curves, view: View) -> NDArray[np.float64]:
    """(N, 2, 3) straight pieces; those of curves only where the surface looks to the eye."""
    if not isinstance(what, Curves):
        return what
    kept = (what.following != np.arange(len(what.points))) & (what.normals @ view.axes[2] > 0)
    return np.stack([what.points, what.points[what.following]], axis=1)[kept]


def _caption(figure: Figure, plate: Plate, middle: float, top: float, height: int, unit: float) -> None:
    """Write title, subtitle and legend under a plate that ends ``top`` pixels down."""
    down = 12.0
    for text, size, colour, room in (
        (plate.title, 11.5, style.INK, TITLE),
        (plate.subtitle, 9.0, style.FAINT, SUBTITLE),
    ):
        if text:
            where = 1.0 - (top + unit * down) / height
            figure.text(middle, where, text, ha="center", va="top", size=unit * size, color=colour)
            down += room
    legend = _labelled(plate)
    if legend:
        # Words in the colour of what they name, spread by their length.
        lengths = np.array([len(text) + 4.0 for text, _ in legend])
        starts = np.cumsum(lengths) - 0.5 * lengths - 0.5 * lengths.sum()
        pixel = unit * 12.5 / figure.bbox.width
        for (text, colour), at in zip(legend, starts, strict=True):
            where = 1.0 - (top + unit * down) / height
            figure.text(
                middle + pixel * at, where, text, ha="center", va="top", size=unit * 9.0, color=colour
            )


def _bar(
    figure: Figure, scale: Scale, span: tuple[float, float], width: int, height: int, unit: float
) -> None:
    """Draw a colour bar at the right of a row, from ``span[0]`` pixels down and ``span[1]`` long."""
    down, long = span
    box = (1 - unit * (BAR - 24) / width, 1 - (down + long) / height, unit * 20 / width, long / height)
    colour_bar(figure, scale, box, unit, upright=True)
