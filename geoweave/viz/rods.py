"""Ribbons as elastic rods: where they are, over and under, and where their energy is (Figs. 19, 22, 23)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from geoweave.arrays import Indices, Scalars
from geoweave.errors import RenderError
from geoweave.rods import Relaxed, Rods, rigid_fit, vertex_weights
from geoweave.surface import TriMesh
from geoweave.viz import style
from geoweave.viz.ground import add_ground
from geoweave.viz.layout import grid
from geoweave.viz.picture import Picture
from geoweave.viz.scales import FOOT, Scale, colour_bars
from geoweave.viz.scene import Scene
from geoweave.viz.solids import bands
from geoweave.viz.views import View, view_of


@dataclass(frozen=True, eq=False)
class Sprung:
    """Elastic rods in a gallery.

    Attributes
    ----------
    rods : to draw
    target : the surface they were designed on, in the same place
    title, subtitle : lines under the picture
    view : where from, or the name of a model in `VIEWS`
    hues : (R,) colour of each rod, from 0; all alike if not given
    values : (S,) value of each segment, shown by the scale of the gallery in place of hues
    opacity : of the target; it is drawn a little below the rods, at 0 not at all
    focus : a place and the radius round it that is to be seen; all of it if None
    """

    rods: Rods
    target: TriMesh
    title: str = ""
    subtitle: str = ""
    view: View | str = field(default_factory=View)
    hues: Indices | None = None
    values: Scalars | None = None
    opacity: float = 1.0
    focus: tuple[Sequence[float], float] | None = None

    def scene(self, scale: Scale | None = None) -> Scene:
        """Build the scene.

        Raises
        ------
        RenderError
            If there are values but no scale to show them by.
        """
        scene = Scene(view_of(self.view), focus=self.focus)
        # Flat strips cut a little into a surface that curves away from them; a veil would flicker with them.
        depth = (4.0 if self.opacity >= 1.0 else 2.0) * self.rods.material.thickness
        if self.opacity >= 1.0:
            add_ground(scene, self.target, depth)
        else:
            # At 0 it still says how large the picture is. Of a closed surface the far side is enough: the
            # near one would lie on what sank below it, and dull its colours.
            closed = not len(self.target.boundary_loops)
            sunk = TriMesh(self.target.vertices - depth * self.target.vertex_normals, self.target.faces)
            scene.add_surface(sunk, colour=style.LINE, opacity=self.opacity, behind=closed)
        if self.values is not None:
            if scale is None:
                raise RenderError(f"panel '{self.title}' has values: draw it in a gallery with a scale")
            made = bands(self.rods, np.arange(len(self.rods)))
            smooth = _at_points(self.rods, self.values)[made.segments]
            limits = (scale.low, scale.high)
            if scale.log:
                smooth, limits = (
                    np.log(np.maximum(smooth, scale.low)),
                    (np.log(scale.low), np.log(scale.high)),
                )
            scene.add_solid(
                made.points, made.quads, values=smooth, limits=limits, colormap=scale.colormap, framed=True
            )
            return scene
        hues = np.zeros(len(self.rods), dtype=np.int64) if self.hues is None else self.hues
        for hue in np.unique(hues):
            made = bands(self.rods, np.flatnonzero(hues == hue))
            colour = style.FAMILIES[int(hue) % len(style.FAMILIES)]
            scene.add_solid(made.points, made.quads, colour, framed=True)
        return scene


def at_rest(relaxed: Relaxed) -> Rods:
    """Put a relaxed weave back on its design by the rigid motion that its departure is measured by.

    Examples
    --------
    >>> rest = gw.relaxed_weave(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8), rounds=1)
    >>> bool(np.allclose(viz.at_rest(rest).points, rest.departure.points))
    True
    """
    rods, design = relaxed.left.rods, relaxed.slid.rods
    rotation, shift = rigid_fit(rods.points, design.points, vertex_weights(rods))
    return replace(
        rods,
        points=rods.points @ rotation.T + shift,
        edges=np.asarray(rods.edges) @ rotation.T,
        directors=rods.directors @ rotation.T,
    )


def rod_gallery(
    panels: Sequence[Sprung],
    *,
    scale: Scale | None = None,
    columns: int | None = None,
    width: int = style.WIDTH,
    tallest: int = 1100,
    alt: str = "",
    columns_alike: bool = False,
) -> Picture:
    """Draw elastic rods in rows of equal columns, with one colour bar if there is a scale.

    Parameters
    ----------
    panels : what to draw; the order is kept
    scale : what the values of the panels mean
    columns, width, tallest, alt : as of `gallery`
    columns_alike : whether panels below each other, of one target from one view, are drawn at one scale

    Raises
    ------
    RenderError
        If there is nothing to draw, or values without a scale.

    Examples
    --------
    >>> surface = gw.shapes.cone(faces=400)
    >>> rods = gw.elastic_rods(gw.weave_pattern(surface, ribbons=8)).rods
    >>> viz.rod_gallery([viz.Sprung(rods, surface, "a cone", view="cone")], width=200).alt
    'Ribbons as elastic rods: a cone'
    """
    scenes = [panel.scene(scale) for panel in panels]
    if columns_alike:
        per_row = columns or len(scenes)
        for first in range(per_row):
            _framed_alike(scenes[first::per_row])
    figure = grid(
        scenes,
        [(panel.title, panel.subtitle) for panel in panels],
        columns=columns,
        width=width,
        tallest=tallest,
        foot=0 if scale is None else FOOT,
    )
    if scale is not None:
        with style.applied():
            colour_bars(figure, [scale])
    words = alt or "Ribbons as elastic rods: " + ", ".join(panel.title for panel in panels)
    return Picture(figure, words, () if scale is None else (scale.colormap,), tuple(scenes))


def _framed_alike(scenes: Sequence[Scene]) -> None:
    """Make room in each scene for what any of them makes room for."""
    points = [each for scene in scenes for each in scene.framed()]
    for scene in scenes:
        scene.framed()[:] = points


def _at_points(rods: Rods, values: Scalars) -> Scalars:
    """(S,) values, each averaged with those of the segments beside it, so that colours do not step."""
    a, b = rods.layout.joints.T
    sums, counts = 2.0 * values, np.full(len(values), 2.0)
    for one, other in ((a, b), (b, a)):
        np.add.at(sums, one, values[other])
        np.add.at(counts, one, 1.0)
    return np.asarray(sums / counts)
