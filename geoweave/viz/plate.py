"""Plates: a flat or gently curved mesh seen from one side, with arrows, lines and words (Figs. 6, 9, 10, 12).

Drawn as polygons in parallel projection, so that edges, arrows and labels stay sharp at any size. What faces
away from the eye is left out; parts of a surface that hide one another want `geoweave.viz.Scene`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colorbar import Colorbar
from matplotlib.colors import Colormap, ListedColormap, Normalize, to_rgb
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from geoweave.arrays import Flags, Scalars, Vectors
from geoweave.curves import Curves
from geoweave.errors import RenderError
from geoweave.fields import FaceField
from geoweave.surface import TriMesh, part_of
from geoweave.viz import style
from geoweave.viz.gallery import Scale
from geoweave.viz.picture import Picture, sheet
from geoweave.viz.scene import View

FROM_ABOVE = View(azimuth=-90.0, elevation=90.0, up="z")
"""Down on the plane z = 0: x to the right, y up."""

SIDE, GAP, TITLE, SUBTITLE, BAR = 40, 56, 56, 40, 190
"""Pixels of a figure of full width: border, between plates, for a title, for a subtitle, for a colour bar."""

MARGIN = 0.02
"""Air around the mesh on a plate, as a share of its longer side; more where arrows stick out."""


@dataclass(frozen=True, eq=False)
class Arrows:
    """Arrows of one colour, from ``points`` along ``vectors``.

    Attributes
    ----------
    points, vectors : (N, 3); the lengths are drawn as they are
    colour : of shaft and head
    width : of the shaft, a length
    label : words for the legend under the plate, none if empty
    """

    points: Vectors
    vectors: Vectors
    colour: str = style.INK
    width: float = 0.01
    label: str = ""

    def __post_init__(self) -> None:
        if self.points.shape != self.vectors.shape or self.points.ndim != 2 or self.points.shape[1] != 3:
            raise RenderError(
                "arrows need points and vectors of one shape (N, 3), not "
                f"{self.points.shape} and {self.vectors.shape}"
            )


def face_arrows(
    field: FaceField,
    *,
    length: float | None = None,
    faces: Flags | None = None,
    start: FaceField | None = None,
    colour: str = style.INK,
    width: float | None = None,
    label: str = "",
) -> Arrows:
    """Make one arrow per face from a field; a unit vector is drawn at ``length``.

    Parameters
    ----------
    field : what to draw
    length : of a unit vector; 0.6 mean edges by default
    faces : (F,) those to draw, all by default
    start : if given, arrows start where the centred arrows of this field end: ``delta`` at the tip of ``w``
    colour, width, label : as in `Arrows`; the width is a twelfth of the length by default
    """
    mesh = field.mesh
    unit = 0.6 * mesh.mean_edge if length is None else length
    base = field if start is None else start
    points = mesh.barycenters - 0.5 * unit * base.ambient
    if start is not None:
        points = points + unit * start.ambient
    keep = np.ones(mesh.n_faces, dtype=bool) if faces is None else faces
    thick = unit / 12.0 if width is None else width
    return Arrows(points[keep], unit * field.ambient[keep], colour, thick, label)


def mark(point: Sequence[float], vector: Sequence[float], colour: str) -> Arrows:
    """One bold arrow with its middle at a point: a handle (Fig. 10)."""
    along = np.array([vector], dtype=np.float64)
    return Arrows(np.array([point]) - 0.5 * along, along, colour, float(np.linalg.norm(along)) / 12.0)


def scattered(mesh: TriMesh, spacing: float, view: View | None = None) -> Flags:
    """Choose (F,) faces about so far apart, on a square grid seen from the eye: arrows that do not crowd."""
    flat = mesh.barycenters @ (view or FROM_ABOVE).axes[:2].T
    cell = np.floor((flat - flat.min(axis=0)) / spacing)
    middle = flat.min(axis=0) + (cell + 0.5) * spacing
    off = np.linalg.norm(flat - middle, axis=1)
    order = np.lexsort((off, cell[:, 1], cell[:, 0]))
    first = np.ones(len(order), dtype=bool)
    first[1:] = (np.diff(cell[order], axis=0) != 0).any(axis=1)
    chosen = np.zeros(mesh.n_faces, dtype=bool)
    # A cell at the rim may have its nearest face far from its middle, close to another cell's.
    chosen[order[first]] = off[order[first]] < 0.35 * spacing
    return chosen


@dataclass(frozen=True, eq=False)
class Lines:
    """Lines of one look: (N, 2, 3) straight pieces, or the curves of a foliation.

    Attributes
    ----------
    what : the lines
    colour, width : width in points of a figure of full width
    dashed : whether to draw dashes
    label : words for the legend under the plate, none if empty
    """

    what: Vectors | Curves
    colour: str = style.INK
    width: float = 0.6
    dashed: bool = False
    label: str = ""


@dataclass(frozen=True)
class Note:
    """A few words beside a point of the plate, ``offset`` in points to the right and up."""

    point: tuple[float, float, float]
    text: str
    colour: str = style.INK
    offset: tuple[float, float] = (0.0, 0.0)
    size: float = 10.0


@dataclass(frozen=True, eq=False)
class Plate:
    """One mesh and what lies on it.

    Attributes
    ----------
    mesh : what to draw
    title, subtitle : lines under the plate
    values : (F,) shown as colours of the faces
    scale : what the colours mean; needed with values
    edges : whether to draw the mesh's edges
    arrows, lines, notes : what lies on it, drawn in this order: lines, arrows, notes
    dots : (N, 3) points marked
    dot_colour : their colour
    view : where from; from above by default
    """

    mesh: TriMesh
    title: str = ""
    subtitle: str = ""
    values: Scalars | None = None
    scale: Scale | None = None
    edges: bool = False
    arrows: Sequence[Arrows] = ()
    lines: Sequence[Lines] = ()
    notes: Sequence[Note] = ()
    dots: Vectors | None = None
    dot_colour: str = style.SOURCE
    view: View = field(default=FROM_ABOVE)

    def __post_init__(self) -> None:
        if (self.values is None) != (self.scale is None):
            raise RenderError(f"plate '{self.title}': values and the scale of their colours go together")
        if self.values is not None and self.values.shape != (self.mesh.n_faces,):
            raise RenderError(
                f"plate '{self.title}': values of faces need shape ({self.mesh.n_faces},), "
                f"not {self.values.shape}"
            )

    @property
    def box(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Lower left and upper right of what is drawn, in the plane of the picture."""
        points = [self.mesh.vertices]
        for each in self.arrows:
            points += [each.points, each.points + each.vectors]
        flat = np.concatenate(points) @ self.view.axes[:2].T
        low, high = flat.min(axis=0), flat.max(axis=0)
        air = MARGIN * float((high - low).max())
        return low - air, high + air


def projections(
    field: FaceField, vertex: int, title: str = "", subtitle: str = "", *, view: View | None = None
) -> Plate:
    """Show around a vertex what the discrete curl compares: projections on the common edges (Fig. 6, left).

    Beside each edge lie the projections of the vectors on its two sides (teal and ochre), each from the foot
    of the vector's tail to the foot of its tip. They are equally long where the curl vanishes (Eq. 3).
    Without a view one looks along the normal of the vertex.
    """
    if view is None:
        x, y, z = field.mesh.vertex_normals[vertex]
        view = View(float(np.degrees(np.arctan2(y, x))), float(np.degrees(np.arcsin(np.clip(z, -1, 1)))))
    fan = part_of(field.mesh, (field.mesh.faces == vertex).any(axis=1))
    mesh, vectors = fan.mesh, 0.4 * fan.mesh.mean_edge * field.ambient[fan.faces]
    size = mesh.mean_edge
    spokes = mesh.interior_edges
    along = mesh.edge_vectors[spokes] / mesh.edge_lengths[spokes, None]
    base = mesh.vertices[mesh.edges[spokes, 0]]
    tails = mesh.barycenters - 0.5 * vectors
    arrows, feet = [Arrows(tails, vectors, width=0.028 * size)], []
    for side, colour in ((0, style.FAMILIES[0]), (1, style.FAMILIES[1])):
        face = mesh.edge_faces[spokes, side]
        tail, vector = tails[face], vectors[face]
        foot = base + np.einsum("ex,ex->e", tail - base, along)[:, None] * along
        shadow = np.einsum("ex,ex->e", vector, along)[:, None] * along
        # Face i lies to the left of its edge.
        aside = (1 - 2 * side) * 0.03 * size * np.cross(mesh.face_normals[face], along)
        arrows.append(Arrows(foot + aside, shadow, colour, 0.022 * size))
        feet += [np.stack([tail, foot], axis=1), np.stack([tail + vector, foot + shadow], axis=1)]
    dashes, dots = Lines(np.concatenate(feet), style.FAINT, dashed=True), field.mesh.vertices[[vertex]]
    return Plate(mesh, title, subtitle, edges=True, arrows=arrows, lines=[dashes], dots=dots, view=view)


def heat_scale(values: Scalars, label: str, percentile: float = 98.0) -> Scale:
    """Scale of magnitudes on a pale surface, from zero to a percentile of the given values."""
    high = float(np.percentile(values, percentile))
    return Scale(style.heat(), 0.0, high if high > 0 else 1.0, label)


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
        share = (plate.values[seen] - plate.scale.low) / (plate.scale.high - plate.scale.low)
        colours = np.asarray(plate.scale.colormap(share))[:, :3]
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
    axes = figure.add_axes(
        (1 - unit * (BAR - 24) / width, 1 - (down + long) / height, unit * 20 / width, long / height)
    )
    bar = Colorbar(
        axes, ScalarMappable(Normalize(scale.low, scale.high), scale.colormap), extend=scale.ends,
        extendfrac=0.03,
    )  # fmt: skip
    bar.outline.set_visible(False)
    axes.tick_params(length=unit * 3, width=unit * 0.7, pad=unit * 3, labelsize=unit * 8.5)
    bar.locator = MaxNLocator(6)
    bar.update_ticks()
    bar.set_label(scale.label, size=unit * 9, labelpad=unit * 4)
