"""Panels of surfaces with streamlines, side by side, with one colour bar (the look of Figs. 3, 7 and 8)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from geoweave.arrays import Indices, Scalars
from geoweave.curves import Curves, geodesic_curvature
from geoweave.errors import RenderError
from geoweave.surface import TriMesh
from geoweave.viz import style
from geoweave.viz.layout import grid
from geoweave.viz.picture import Picture
from geoweave.viz.scales import FOOT, Scale, colour_bars, rounded_up
from geoweave.viz.scene import Scene
from geoweave.viz.smoothing import at_vertices
from geoweave.viz.views import View, view_of


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
    face_values : (F,) signed values shown on the surface, such as curl, averaged at the vertices
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
    def values(self) -> Scalars | None:
        """(V,) the values of the faces averaged at the vertices, as they are shown."""
        return None if self.face_values is None else at_vertices(self.surface, self.face_values)

    def scene(self) -> Scene:
        """Build the scene by itself, with scales of its own."""
        curl = None if self.face_values is None else curl_scale([self])
        return panel_scene(self, None if self.curves is None else curvature_scale([self]), curl)

    @property
    def eye(self) -> View:
        """The view, looked up if it was named."""
        return view_of(self.view)


def curvature_scale(panels: Sequence[Panel], percentile: float = 95.0) -> Scale:
    """One scale for the bending of all curves, ``|k_g|`` times bounding radius; clamped at a percentile.

    Examples
    --------
    >>> field = gw.smoothest_field(gw.shapes.sphere(faces=320))
    >>> scale = viz.curvature_scale([viz.Panel("a", gw.streamlines(field, separation=0.4))])
    >>> scale.low < scale.high
    True
    """
    values = [_bending(panel.curves) for panel in panels if panel.curves is not None]
    weights = [panel.curves.segment_lengths for panel in panels if panel.curves is not None]
    if not values:
        raise RenderError("no panel has curves, so there is no curvature to colour them by")
    value, weight = np.concatenate(values), np.concatenate(weights)
    order = np.argsort(value, kind="stable")
    share = np.cumsum(weight[order]) / weight.sum()
    high = value[order][min(int(np.searchsorted(share, percentile / 100.0)), len(order) - 1)]
    label = rf"geodesic curvature $|\kappa_g|$ × bounding radius (clamped at the {percentile:g}th percentile)"
    return Scale(style.sequential(), 0.0, rounded_up(float(high)), label)


def curl_scale(panels: Sequence[Panel], percentile: float = 98.0) -> Scale:
    """One scale for the signed values on all surfaces, centred at zero, clamped at a percentile.

    Examples
    --------
    >>> field = gw.smoothest_field(gw.shapes.sphere(faces=320))
    >>> panel = viz.Panel("curl", mesh=field.mesh, face_values=gw.signed_curl(field))
    >>> scale = viz.curl_scale([panel])
    >>> scale.low == -scale.high
    True
    """
    size = np.concatenate([np.abs(panel.values) for panel in panels if panel.values is not None])
    high = rounded_up(float(np.percentile(size, percentile)))
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
    percentile : share in percent of the curves' length below the end of the colour bar
    limit : end of the colour bar, in place of the percentile
    share : the separation of the streamlines as a share of the bounding radius, which sets their thickness
    columns, width, tallest, alt : as of `gallery`

    Raises
    ------
    RenderError
        If there is nothing to draw.

    Examples
    --------
    >>> field = gw.smoothest_field(gw.shapes.sphere(faces=320))
    >>> panel = viz.Panel("smooth", gw.streamlines(field, separation=0.4), view="sphere")
    >>> viz.streamline_gallery([panel], width=200).alt
    'Streamlines on smooth'
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
    figure = grid(
        scenes,
        [(panel.title, panel.subtitle) for panel in panels],
        columns=columns,
        width=width,
        tallest=tallest,
        foot=FOOT,
        equal_columns=False,
    )
    with style.applied():
        colour_bars(figure, scales)
    words = alt or "Streamlines on " + ", ".join(panel.title for panel in panels)
    return Picture(figure, words, tuple(each.colormap for each in scales), tuple(scenes))


def panel_scene(
    panel: Panel, scale: Scale | None = None, curl: Scale | None = None, share: float = 0.04
) -> Scene:
    """Build the scene of a panel; curves without a scale are drawn in ink, values without one not at all."""
    scene, mesh = Scene(panel.eye), panel.surface
    radius = mesh.bounding_radius
    if panel.face_values is not None and curl is not None:
        scene.add_surface(mesh, values=panel.values, limit=curl.high)
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
        scene.add_singularities(mesh.vertices, panel.indices, 3.2 * thickness)
    return scene


def _bending(curves: Curves) -> Scalars:
    return np.abs(geodesic_curvature(curves)) * curves.mesh.bounding_radius
