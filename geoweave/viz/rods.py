"""Ribbons as elastic rods: where they are, over and under, and where their energy is (Figs. 19, 22, 23)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from geoweave.arrays import Indices, Scalars, Vectors
from geoweave.errors import RenderError
from geoweave.rods import Relaxed, Rods, rigid_fit, vertex_weights
from geoweave.surface import TriMesh
from geoweave.viz import style
from geoweave.viz.layout import grid
from geoweave.viz.picture import Picture
from geoweave.viz.scales import FOOT, Scale, colour_bars
from geoweave.viz.scene import Scene
from geoweave.viz.views import View, view_of
from geoweave.viz.weaves import heights, strip

CUTS = 4
"""Cross sections that are drawn for each segment of a rod."""


class Bands(NamedTuple):
    """The outside of some rods as quadrilaterals."""

    points: Vectors
    """(P, 3)"""
    quads: NDArray[np.int64]
    """(Q, 4)"""
    segments: Indices
    """(P,) segment that each point belongs to"""


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
    lifted : whether the rods still lie on the surface, so that the drawing has to part them where they
        cross; rods at rest are a thickness apart as they are
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
    lifted: bool = False
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
        sunk = TriMesh(self.target.vertices - depth * self.target.vertex_normals, self.target.faces)
        if self.opacity < 1.0:
            # At 0 it still says how large the picture is.
            scene.add_surface(sunk, colour=style.LINE, opacity=self.opacity)
        else:
            scene.add_surface(sunk)
        if self.values is not None:
            if scale is None:
                raise RenderError(f"panel '{self.title}' has values: draw it in a gallery with a scale")
            made = bands(self.rods, np.arange(len(self.rods)), lifted=self.lifted)
            smooth = _at_points(self.rods, self.values)[made.segments]
            limits = (scale.low, scale.high)
            scene.add_solid(
                made.points, made.quads, values=smooth, limits=limits, colormap=scale.colormap, framed=True
            )
            return scene
        hues = np.zeros(len(self.rods), dtype=np.int64) if self.hues is None else self.hues
        for hue in np.unique(hues):
            made = bands(self.rods, np.flatnonzero(hues == hue), lifted=self.lifted)
            colour = style.FAMILIES[int(hue) % len(style.FAMILIES)]
            scene.add_solid(made.points, made.quads, colour, framed=True)
        return scene


def at_rest(relaxed: Relaxed) -> Rods:
    """Put a relaxed weave back on its design by the rigid motion that its departure is measured by."""
    rods, design = relaxed.left.rods, relaxed.slid.rods
    rotation, shift = rigid_fit(rods.points, design.points, vertex_weights(rods))
    return replace(
        rods,
        points=rods.points @ rotation.T + shift,
        edges=np.asarray(rods.edges) @ rotation.T,
        directors=rods.directors @ rotation.T,
    )


def bands(rods: Rods, which: Indices, *, lifted: bool = False) -> Bands:
    """Build some rods as solid strips of their width and thickness, smooth through their vertices.

    Parameters
    ----------
    rods : in space
    which : numbers of the rods
    lifted : part rods that cross by half a thickness each, over and under; between crossings the height goes
        from one to the next in half a wave of a cosine
    """
    layout, contacts, thin = rods.layout, rods.contacts, rods.material.thickness
    start = np.cumsum(rods.lengths) - rods.lengths
    points, quads, owners, count = [], [], [], 0
    for r in which:
        closed = bool(layout.closed[r])
        segments = np.arange(layout.segment_offsets[r], layout.segment_offsets[r + 1])
        along = start[segments] - start[segments[0]]
        length = float(rods.lengths[segments].sum())
        knots = np.append(along, length)
        vertices = np.append(layout.ends[segments, 0], layout.ends[segments[-1], 1])
        number = CUTS * len(segments)
        s = np.linspace(0.0, length, number + 1)[: number if closed else number + 1]
        own = segments[np.clip(np.searchsorted(along, s, side="right") - 1, 0, len(segments) - 1)]
        line = CubicSpline(knots, rods.points[vertices], bc_type="periodic" if closed else "natural")
        directors = rods.directors[segments]
        if closed:
            turned = directors + np.roll(directors, 1, axis=0)
            turned = np.append(turned, turned[:1], axis=0)
        else:
            turned = np.concatenate([directors[:1], directors[1:] + directors[:-1], directors[-1:]])
        up = np.stack([np.interp(s, knots, x) for x in turned.T], axis=1)
        ahead = _unit(line(s, 1))
        up = _unit(up - (up * ahead).sum(axis=1, keepdims=True) * ahead)
        middle = line(s)
        if lifted:
            mine = layout.rod_of_segment[contacts.segments] == r
            at = (
                start[contacts.segments]
                - start[segments[0]]
                + contacts.places * rods.lengths[contacts.segments]
            )
            side = np.where(contacts.over[:, None] == np.arange(2), 1.0, -1.0)
            level = 0.6 * float(rods.widths[segments[0]])
            height = heights(s, at[mine], side[mine], length, closed, level)
            middle = middle + 0.55 * thin * height[:, None] * up
        half = 0.5 * rods.widths[own][:, None] * np.cross(up, ahead)
        made = strip(middle, half, 0.5 * thin * up, closed)
        points.append(made.points)
        quads.append(count + made.quads)
        owners.append(np.repeat(own, 4))
        count += len(made.points)
    if not points:
        none = np.zeros(0, dtype=np.int64)
        return Bands(np.zeros((0, 3)), none.reshape(0, 4), none)
    return Bands(np.concatenate(points), np.concatenate(quads), np.concatenate(owners))


def rod_gallery(
    panels: Sequence[Sprung],
    *,
    scale: Scale | None = None,
    columns: int | None = None,
    width: int = style.WIDTH,
    tallest: int = 1100,
    alt: str = "",
) -> Picture:
    """Draw elastic rods in rows of equal columns, with one colour bar if there is a scale.

    Parameters
    ----------
    panels : what to draw; the order is kept
    scale : what the values of the panels mean
    columns : panels in a row; all in one row if not given
    width : pixels across the figure; a narrower one is the same figure, smaller
    tallest : height that no panel exceeds, in pixels of a figure of full width
    alt : one sentence that says what is to be seen

    Raises
    ------
    RenderError
        If there is nothing to draw, or values without a scale.
    """
    figure = grid(
        [panel.scene(scale) for panel in panels],
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
    return Picture(figure, words, () if scale is None else (scale.colormap,))


def _at_points(rods: Rods, values: Scalars) -> Scalars:
    """(S,) values, each averaged with those of the segments beside it, so that colours do not step."""
    a, b = rods.layout.joints.T
    sums, counts = 2.0 * values, np.full(len(values), 2.0)
    for one, other in ((a, b), (b, a)):
        np.add.at(sums, one, values[other])
        np.add.at(counts, one, 1.0)
    return np.asarray(sums / counts)


def _unit(vectors: NDArray[np.float64]) -> Vectors:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))
