"""Panels of surfaces with streamlines, side by side, with one colour bar (the look of Figs. 3, 7 and 8)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar
from matplotlib.colors import Colormap, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from geoweave.arrays import Indices, Scalars
from geoweave.curves import Curves, geodesic_curvature
from geoweave.errors import RenderError
from geoweave.surface import TriMesh
from geoweave.viz import style
from geoweave.viz.layout import caption, place
from geoweave.viz.picture import Picture, sheet
from geoweave.viz.scene import Scene, View

VIEWS = {
    "armadillo": View(azimuth=205, elevation=8, up="y"),
    "bunny": View(azimuth=-15, elevation=12, up="y"),
    "bumpy-box": View(azimuth=28, elevation=24, up="z"),
    "camel": View(azimuth=68, elevation=8, up="y"),
    "cone": View(azimuth=0, elevation=38, up="z"),
    "cow": View(azimuth=50, elevation=12, up="y"),
    "crown": View(azimuth=20, elevation=30, up="z"),
    "fertility": View(azimuth=0, elevation=10, up="y"),
    "genus-4": View(azimuth=20, elevation=35, up="z"),
    "icosahedron": View(azimuth=14, elevation=16, up="z"),
    "rocker-arm": View(azimuth=225, elevation=38, up="x"),
    "rocker-like": View(azimuth=25, elevation=28, up="y"),
    "saddle": View(azimuth=12, elevation=48, up="z"),
    "schwarz-p": View(azimuth=30, elevation=22, up="z"),
    "sphere": View(azimuth=20, elevation=25, up="z"),
    "spot": View(azimuth=128, elevation=12, up="y"),
    "torus": View(azimuth=-38, elevation=-34, up="z"),
    "vessel": View(azimuth=60, elevation=12, up="z"),
}
"""How each named model is looked at, standing upright."""


SIDE, GAP, CAPTION, FOOT = 34, 50, 98, 156
"""Pixels of a full-width figure: its border, between models, for the words under one, for the colour bars."""


@dataclass(frozen=True, eq=False)
class Panel:
    """One surface in a gallery.

    Attributes
    ----------
    title, subtitle : lines under the picture
    curves : streamlines; None to show the surface alone
    mesh : the surface, if not that of the curves
    indices : (V,) index of the field at each vertex; a dot marks where it is not zero (warm positive, blue
        negative)
    face_values : (F,) signed values shown on the surface, such as curl
    seams : (n,) edges of the mesh drawn as blue bars, such as singular lines
    view : where from, or the name of a model in `VIEWS`
    """

    title: str
    curves: Curves | None = None
    subtitle: str = ""
    mesh: TriMesh | None = None
    indices: Indices | None = None
    face_values: Scalars | None = None
    seams: Indices | None = None
    view: View | str = field(default_factory=View)

    @property
    def surface(self) -> TriMesh:
        """The mesh to draw."""
        if self.mesh is not None:
            return self.mesh
        if self.curves is None:
            raise RenderError(f"panel '{self.title}' has neither curves nor a mesh: give it one of them")
        return self.curves.mesh

    @property
    def eye(self) -> View:
        """The view, looked up if it was named."""
        if isinstance(self.view, View):
            return self.view
        if self.view not in VIEWS:
            raise RenderError(f"no view is kept for '{self.view}': give a View, or one of {', '.join(VIEWS)}")
        return VIEWS[self.view]


@dataclass(frozen=True)
class Scale:
    """What a colour means: the map, its limits and the words beside its bar."""

    colormap: Colormap
    low: float
    high: float
    label: str

    @property
    def ends(self) -> Literal["both", "max"]:
        """Which ends of the bar stand for everything beyond."""
        return "both" if self.low < 0 else "max"


def curvature_scale(panels: Sequence[Panel], percentile: float = 95.0) -> Scale:
    """One scale for the bending of all curves, ``|k_g|`` times bounding radius; clamped at a percentile."""
    values = [_bending(panel.curves) for panel in panels if panel.curves is not None]
    weights = [panel.curves.segment_lengths for panel in panels if panel.curves is not None]
    if not values:
        raise RenderError("no panel has curves, so there is no curvature to colour them by")
    value, weight = np.concatenate(values), np.concatenate(weights)
    order = np.argsort(value, kind="stable")
    share = np.cumsum(weight[order]) / weight.sum()
    high = value[order][min(int(np.searchsorted(share, percentile / 100.0)), len(order) - 1)]
    label = rf"geodesic curvature $|\kappa_g|$ × bounding radius (clamped at the {percentile:g}th percentile)"
    return Scale(style.sequential(), 0.0, _round_up(float(high)), label)


def curl_scale(panels: Sequence[Panel], percentile: float = 98.0) -> Scale:
    """One scale for the signed values on all surfaces, centred at zero, clamped at a percentile."""
    size = np.concatenate([np.abs(panel.face_values) for panel in panels if panel.face_values is not None])
    high = _round_up(float(np.percentile(size, percentile)))
    label = f"signed curl (clamped at the {percentile:g}th percentile)"
    return Scale(style.diverging(), -high, high, label)


def streamline_gallery(
    panels: Sequence[Panel],
    *,
    columns: int | None = None,
    percentile: float = 95.0,
    limit: float | None = None,
    share: float = 0.04,
    width: int = style.WIDTH,
    tallest: int = 900,
    alt: str = "",
) -> Picture:
    """Draw panels in rows, models in a row equally tall, streamlines coloured by geodesic curvature.

    Parameters
    ----------
    panels : what to draw; the order is kept
    columns : panels in a row; all in one row if not given
    percentile : share in percent of the curves' length below the end of the colour bar
    limit : end of the colour bar, in place of the percentile
    share : the separation of the streamlines as a share of the bounding radius, which sets their thickness
    width : pixels across the figure; a narrower one is the same figure, smaller
    tallest : height that no model exceeds, in pixels of a figure of full width
    alt : one sentence that says what is to be seen

    Raises
    ------
    RenderError
        If there is nothing to draw.
    """
    if not panels:
        raise RenderError("a gallery needs at least one panel")
    scale = curvature_scale(panels, percentile)
    if limit is not None:
        scale = Scale(scale.colormap, 0.0, limit, scale.label.split(" (")[0])
    scales = [scale]
    curl = None
    if any(panel.face_values is not None for panel in panels):
        curl = curl_scale(panels)
        scales.append(curl)
    scenes = [panel_scene(panel, scale, curl, share) for panel in panels]
    per_row = columns or len(panels)
    rows = [list(range(i, min(i + per_row, len(panels)))) for i in range(0, len(panels), per_row)]
    unit = width / style.WIDTH
    heights = []
    for row in rows:
        # A last row with fewer panels is no taller than a full one.
        room = width - unit * (2 * SIDE + GAP * (per_row - 1))
        wanted = sum(scenes[k].aspect for k in row) * per_row / len(row)
        heights.append(min(round(unit * tallest), int(room / wanted)))
    below = unit * (CAPTION if any(panel.subtitle for panel in panels) else CAPTION - 38)
    total = round(sum(heights) + (below + unit * SIDE) * len(rows) + unit * FOOT)
    figure = sheet(width, total)
    with style.applied():
        top = unit * SIDE
        for row, height in zip(rows, heights, strict=True):
            pictures = [scenes[k].draw(height) for k in row]
            spare = (width - sum(picture.shape[1] for picture in pictures)) / (len(row) + 1)
            left = spare
            for k, picture in zip(row, pictures, strict=True):
                place(figure, picture, left, top)
                middle = (left + 0.5 * picture.shape[1]) / width
                caption(figure, (panels[k].title, panels[k].subtitle), middle, top + height, unit, down=57)
                left += picture.shape[1] + spare
            top += height + below + unit * SIDE
        colour_bars(figure, scales)
    words = alt or "Streamlines on " + ", ".join(panel.title for panel in panels)
    return Picture(figure, words, tuple(each.colormap for each in scales))


def panel_scene(
    panel: Panel, scale: Scale | None = None, curl: Scale | None = None, share: float = 0.04
) -> Scene:
    """Build the scene of a panel; curves without a scale are drawn in ink, values without one not at all."""
    scene, mesh = Scene(panel.eye), panel.surface
    radius = mesh.bounding_radius
    if panel.face_values is not None and curl is not None:
        scene.add_surface(mesh, values=panel.face_values, limit=curl.high)
    else:
        scene.add_surface(mesh)
    thickness = 0.11 * share * radius
    if panel.curves is not None and scale is not None:
        limits = (scale.low, scale.high)
        scene.add_curves(panel.curves, thickness, values=_bending(panel.curves), limits=limits)
    elif panel.curves is not None:
        scene.add_curves(panel.curves, thickness)
    if panel.seams is not None and len(panel.seams):
        scene.add_segments(mesh.vertices[mesh.edges[panel.seams]], 2.2 * thickness, style.BLUE)
    if panel.indices is not None:
        marked = np.flatnonzero(panel.indices)
        colours = [style.SOURCE if panel.indices[v] > 0 else style.SADDLE for v in marked]
        scene.add_dots(mesh.vertices[marked], 3.2 * thickness, colours)
    return scene


def _bending(curves: Curves) -> Scalars:
    return np.abs(geodesic_curvature(curves)) * curves.mesh.bounding_radius


def _round_up(value: float) -> float:
    """Two leading digits, upwards."""
    if value <= 0:
        return 1.0
    step = 10.0 ** (np.floor(np.log10(value)) - 1)
    return float(np.ceil(value / step - 1e-9) * step)


def colour_bars(figure: Figure, scales: Sequence[Scale]) -> None:
    """Draw the colour bars at the bottom, side by side."""
    width, height = round(figure.bbox.width), round(figure.bbox.height)
    unit, long = width / style.WIDTH, 0.34
    for number, scale in enumerate(scales):
        centre = 0.5 if len(scales) == 1 else 0.27 + 0.46 * number
        axes = figure.add_axes((centre - 0.5 * long, unit * 108 / height, long, unit * 18 / height))
        bar = Colorbar(
            axes, ScalarMappable(Normalize(scale.low, scale.high), scale.colormap), orientation="horizontal",
            extend=scale.ends, extendfrac=0.03,
        )  # fmt: skip
        bar.outline.set_visible(False)
        axes.tick_params(length=unit * 3, width=unit * 0.7, pad=unit * 3, labelsize=unit * 8.5)
        bar.locator = MaxNLocator(6)
        bar.update_ticks()
        bar.set_label(scale.label, size=unit * 9, labelpad=unit * 4)
