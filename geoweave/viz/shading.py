"""Surfaces shaded by a number per face, with several families of curves on them (Figs. 13 and 15)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from geoweave.arrays import Indices, Scalars
from geoweave.comparisons import TITLES, Integration
from geoweave.curves import Curves, lifted
from geoweave.errors import RenderError
from geoweave.foliation import deviation, isolines
from geoweave.surface import TriMesh
from geoweave.viz import style
from geoweave.viz.layout import grid
from geoweave.viz.picture import Picture
from geoweave.viz.scales import Scale, colour_bar
from geoweave.viz.scene import Scene
from geoweave.viz.smoothing import at_vertices
from geoweave.viz.views import View, view_of

GAP, FOOT = 46, 160
"""Pixels of a full-width figure: between panels, for bar and legend."""


@dataclass(frozen=True, eq=False)
class Family:
    """Curves of one look.

    Attributes
    ----------
    curves : the curves; they may lie on another mesh than the surface shown, such as a part of it
    colour : of the tubes
    label : text in the legend; families with the same label share one entry
    thickness : radius of the tubes in bounding radii
    """

    curves: Curves
    colour: str = style.INK
    label: str = ""
    thickness: float = 0.004


@dataclass(frozen=True, eq=False)
class Shaded:
    """One surface with a number per face and curves on it.

    Attributes
    ----------
    mesh : the surface
    values : (F,) shown as colours; not a number where a face has none; None for a plain surface
    smooth : whether to join the colours over the faces, by averages at the vertices
    title, subtitle : lines under the picture
    families : curves on the surface
    indices : (V,) a dot marks where this is not zero, warm positive, blue negative
    view : where from, or the name of a model in `VIEWS`
    """

    mesh: TriMesh
    values: Scalars | None = None
    smooth: bool = True
    title: str = ""
    subtitle: str = ""
    families: Sequence[Family] = ()
    indices: Indices | None = None
    view: View | str = field(default_factory=View)

    def __post_init__(self) -> None:
        if self.values is not None and self.values.shape != (self.mesh.n_faces,):
            raise RenderError(
                f"panel '{self.title}': values of faces need shape ({self.mesh.n_faces},), "
                f"not {self.values.shape}"
            )
        view_of(self.view)

    def scene(self, scale: Scale) -> Scene:
        """Build the scene, values in the colours of a scale."""
        scene = Scene(view_of(self.view))
        values = self.values
        if values is not None and self.smooth:
            values = at_vertices(self.mesh, values)
        scene.add_surface(
            self.mesh, values=values, limits=scale.limits, log=scale.log, colormap=scale.colormap
        )
        radius = self.mesh.bounding_radius
        for family in self.families:
            if len(family.curves):
                scene.add_curves(family.curves, family.thickness * radius, colour=family.colour)
        if self.indices is not None:
            scene.add_singularities(self.mesh.vertices, self.indices, 0.022 * radius)
        return scene


def deviation_panel(result: Integration, lines: Curves, view: View | str) -> Shaded:
    """Panel of one method of Fig. 15: streamlines blue, level sets purple, shaded by their deviation.

    Parameters
    ----------
    result : the method's theta
    lines : streamlines of the field
    view : where from

    Examples
    --------
    >>> from geoweave import comparisons
    >>> field = gw.smoothest_field(gw.shapes.torus(faces=400))
    >>> result = comparisons.integrated(field, "ours", 2.0)
    >>> panel = viz.deviation_panel(result, gw.streamlines(field, separation=0.3), "torus")
    >>> [family.label for family in panel.families]
    ['streamlines of the field', 'level sets of θ']
    """
    fit, mesh = result.alignment, result.part.whole
    angle = np.full(mesh.n_faces, np.nan)
    angle[result.part.faces] = deviation(result.field, result.circle)
    leaves = lifted(isolines(result.circle), result.part)
    return Shaded(
        mesh,
        angle,
        title=TITLES[result.method],
        subtitle=f"{fit.mean:.1f}° off, spread {fit.spacing_spread:.2f}, {fit.dislocations} dislocations",
        families=[
            Family(lines, style.FIELD_LINES, "streamlines of the field", 0.003),
            Family(leaves, style.LEVEL_LINES, "level sets of θ", 0.0045),
        ],
        view=view,
    )


def shaded_gallery(
    panels: Sequence[Shaded],
    scale: Scale,
    *,
    columns: int | None = None,
    width: int = style.WIDTH,
    tallest: int = 900,
    alt: str = "",
) -> Picture:
    """Draw panels in rows of equal columns, with one colour bar for all and a legend of the curves.

    Parameters
    ----------
    panels : what to draw; the order is kept
    scale : what the colours of all panels mean
    columns, width, tallest, alt : as of `gallery`

    Raises
    ------
    RenderError
        If there is nothing to draw.

    Examples
    --------
    >>> sphere = gw.shapes.sphere(faces=80)
    >>> panel = viz.Shaded(sphere, sphere.barycenters[:, 2], title="height", view="sphere")
    >>> viz.shaded_gallery([panel], viz.factor_scale(0.5, 2.0), width=200).alt
    'Shaded surfaces: height'
    """
    scenes = [panel.scene(scale) for panel in panels]
    figure = grid(
        scenes,
        [(panel.title, panel.subtitle) for panel in panels],
        columns=columns,
        width=width,
        tallest=tallest,
        foot=FOOT,
        gap=GAP,
    )
    with style.applied():
        _foot(figure, scale, panels, width / style.WIDTH)
    described = alt or "Shaded surfaces: " + ", ".join(panel.title for panel in panels)
    return Picture(figure, described, (scale.colormap,), tuple(scenes))


def _foot(figure: Figure, scale: Scale, panels: Sequence[Shaded], unit: float) -> None:
    """Draw the colour bar at the bottom, and beside it one line for each label of curves."""
    height = figure.bbox.height
    labels = {each.label: each.colour for panel in panels for each in panel.families if each.label}
    centre, long = (0.36, 0.40) if labels else (0.5, 0.40)
    box = (centre - 0.5 * long, unit * 112 / height, long, unit * 18 / height)
    colour_bar(figure, scale, box, unit)
    if labels:
        handles = [Line2D([], [], color=colour, linewidth=unit * 3.0) for colour in labels.values()]
        figure.legend(
            handles, list(labels), loc="center left", bbox_to_anchor=(0.62, unit * 100 / height),
            fontsize=unit * 9.5, handlelength=1.8, labelspacing=0.5,
        )  # fmt: skip
