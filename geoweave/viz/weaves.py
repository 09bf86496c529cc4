"""Ribbons of a weave as they would lie: wide, thick, over and under each other (Figs. 1, 18, 21, 24)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geoweave.arrays import Indices, Scalars, Vectors
from geoweave.errors import RenderError
from geoweave.surface import TriMesh, smooth_normals
from geoweave.viz import style
from geoweave.viz.layout import gallery
from geoweave.viz.picture import Picture
from geoweave.viz.scene import Scene
from geoweave.viz.views import View, view_of
from geoweave.weave import Weave

STEP = 0.06
"""Distance between the cross sections of a strip, in spacings."""


class Strips(NamedTuple):
    """The outside of some ribbons as quadrilaterals."""

    points: Vectors
    """(P, 3)"""
    quads: NDArray[np.int64]
    """(Q, 4)"""


@dataclass(frozen=True, eq=False)
class Woven:
    """One weave in a gallery.

    Attributes
    ----------
    weave : the weave
    title, subtitle : lines under the picture
    view : where from, or the name of a model in `VIEWS`
    width, thickness : of the ribbons, lengths on the surface; those of the weave if not given
    hues : number of colours; by default three, or as many as there are families
    families : whether a ribbon has the colour of its family, as on its strip in a pattern
    focus : a place on the surface and the radius round it that is to be seen; all of it if None
    dots : whether to mark the branch points
    """

    weave: Weave
    title: str = ""
    subtitle: str = ""
    view: View | str = field(default_factory=View)
    width: float | None = None
    thickness: float | None = None
    hues: int | None = None
    families: bool = False
    focus: tuple[Sequence[float], float] | None = None
    dots: bool = False

    def scene(self) -> Scene:
        """Build the scene."""
        chosen = self.weave.families if self.families else colouring(self.weave, self.hues)
        scene = weave_scene(self.weave, self.view, chosen, width=self.width, thickness=self.thickness)
        scene.focus = self.focus
        if self.dots:
            mesh, points = self.weave.mesh, self.weave.branch_points
            scene.add_dots(mesh.vertices[points], 0.022 * mesh.bounding_radius, [style.INK] * len(points))
        return scene


def colouring(weave: Weave, count: int | None = None) -> Indices:
    """Choose a colour for each ribbon such that ribbons which cross differ wherever that can be.

    A ribbon that passes branch cuts belongs to one family here and to another there, so families alone give
    a third of the crossings one colour. Starting from them, each ribbon in turn takes the colour that fewest
    of its crossings have, until none wants to change.

    Parameters
    ----------
    weave : the weave
    count : number of colours; by default three, or as many as there are families

    Returns
    -------
    (n,) colour of each ribbon, from 0
    """
    number = count or max(3, int(weave.families.max()) + 1)
    pairs = weave.ribbons.crossings.curves
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    met = np.zeros((len(weave.families),) * 2)
    np.add.at(met, (pairs[:, 0], pairs[:, 1]), 1.0)
    met += met.T
    chosen = weave.families % number
    while True:
        before = chosen.copy()
        for ribbon in np.argsort(-met.sum(axis=1), kind="stable"):
            same = np.bincount(chosen, met[ribbon], number)
            if same.min() < same[chosen[ribbon]]:
                chosen[ribbon] = same.argmin()
        # Every change lowers the number of crossings in one colour: this ends.
        if (chosen == before).all():
            return np.asarray(chosen, dtype=np.int64)


def strips(
    weave: Weave, which: Indices, width: float | None = None, thickness: float | None = None
) -> Strips:
    """Build some ribbons as solid strips, lifted by half a thickness over and under each other.

    Between crossings the height above the surface goes from one to the next in half a wave of a cosine.

    Parameters
    ----------
    weave : the weave
    which : numbers of the ribbons
    width, thickness : lengths on the surface; those of the weave if not given

    Raises
    ------
    RenderError
        If the width or the thickness is not positive.
    """
    wide, thin = weave.width if width is None else width, weave.thickness if thickness is None else thickness
    if not (wide > 0 and thin > 0):
        raise RenderError(f"a ribbon needs a positive width and thickness, not {wide} and {thin}")
    ribbons, spacing = weave.ribbons, weave.ribbons.spacing
    curves, met = ribbons.curves, ribbons.crossings
    points, quads, count = [], [], 0
    for c in which:
        own = np.arange(curves.offsets[c], curves.offsets[c + 1])
        closed, length = bool(curves.closed[c]), float(curves.lengths[c])
        at, place = curves.arclength[own], curves.points[own]
        normal = smooth_normals(weave.mesh, place, curves.faces[own])
        if closed:
            at, place, normal = np.append(at, length), *(np.vstack([x, x[:1]]) for x in (place, normal))
        number = max(int(np.ceil(length / (STEP * spacing))), 4)
        s = np.linspace(0.0, length, number + 1)
        if closed:
            s = s[:-1]
        line = np.stack([np.interp(s, at, x) for x in place.T], axis=1)
        up = _unit(np.stack([np.interp(s, at, x) for x in normal.T], axis=1))
        ahead, behind = (np.roll(line, k, axis=0) for k in (-1, 1))
        if not closed:
            ahead[-1], behind[0] = line[-1], line[0]
        across = _unit(np.cross(up, ahead - behind))
        here = met.curves == c
        sides = np.where(weave.interlacing.over[:, None] == np.arange(2), 1.0, -1.0)[here]
        height = heights(s, met.arclength[here], sides, length, closed, 0.6 * wide)
        middle = line + 0.55 * thin * height[:, None] * up
        made = strip(middle, 0.5 * wide * across, 0.5 * thin * up, closed)
        points.append(made.points)
        quads.append(count + made.quads)
        count += 4 * len(s)
    if not points:
        return Strips(np.zeros((0, 3)), np.zeros((0, 4), dtype=np.int64))
    return Strips(np.concatenate(points), np.concatenate(quads))


def strip(middle: Vectors, half: Vectors, thick: Vectors, closed: bool) -> Strips:
    """Build one solid strip of cross sections with four corners each, closed or with a cap at both ends.

    Parameters
    ----------
    middle : (n, 3) middle of each cross section
    half, thick : (n, 3) from there to the edge of the strip, and to its upper side
    closed : whether the last section is joined to the first
    """
    n = len(middle)
    ring = np.stack(
        [middle - half - thick, middle + half - thick, middle + half + thick, middle - half + thick]
    )
    first = 4 * np.arange(n if closed else n - 1)
    second = (first + 4) % (4 * n)
    quads = [
        np.stack([first + a, second + a, second + b, first + b], axis=1)[:, ::-1]
        for a, b in ((0, 1), (1, 2), (2, 3), (3, 0))
    ]
    if not closed:
        last = 4 * (n - 1)
        quads.append(np.array([[3, 2, 1, 0], [last, last + 1, last + 2, last + 3]]))
    return Strips(ring.swapaxes(0, 1).reshape(-1, 3), np.concatenate(quads))


def weave_scene(
    weave: Weave,
    view: View | str,
    chosen: Indices | None = None,
    *,
    width: float | None = None,
    thickness: float | None = None,
) -> Scene:
    """Build the scene of a weave on its surface, ribbons in the chosen colours or in those of `colouring`."""
    scene = Scene(view_of(view))
    # The surface a little behind, so that what goes under is not lost in it; where normals point inwards one
    # looks at the ribbons from below.
    depth = 1.3 * (weave.thickness if thickness is None else thickness) * facing(weave.mesh)
    sunk = weave.mesh.vertices - depth * weave.mesh.vertex_normals
    scene.add_surface(TriMesh(sunk, weave.mesh.faces), colour=style.SURFACE)
    chosen = colouring(weave) if chosen is None else chosen
    for hue in range(int(chosen.max()) + 1):
        made = strips(weave, np.flatnonzero(chosen == hue), width, thickness)
        if len(made.quads):
            scene.add_solid(made.points, made.quads, style.FAMILIES[hue % len(style.FAMILIES)])
    return scene


def facing(mesh: TriMesh) -> float:
    """Whether normals point out, 1, as they do unless most of the area faces the middle, or in, -1."""
    weights = mesh.face_areas
    middle = np.average(mesh.barycenters, axis=0, weights=weights)
    away = mesh.barycenters - middle
    out = float(weights @ (away * mesh.face_normals).sum(axis=1))
    return -1.0 if out < -0.2 * float(weights @ np.linalg.norm(away, axis=1)) else 1.0


def weave_gallery(
    panels: Sequence[Woven],
    *,
    columns: int | None = None,
    width: int = style.WIDTH,
    tallest: int = 1100,
    alt: str = "",
) -> Picture:
    """Draw weaves in rows of equal columns.

    Parameters
    ----------
    panels : what to draw; the order is kept
    columns : panels in a row; all in one row if not given
    width : pixels across the figure; a narrower one is the same figure, smaller
    tallest : height that no panel exceeds, in pixels of a figure of full width
    alt : one sentence that says what is to be seen

    Raises
    ------
    RenderError
        If there is nothing to draw.
    """
    return gallery(
        [panel.scene() for panel in panels],
        [(panel.title, panel.subtitle) for panel in panels],
        columns=columns,
        width=width,
        tallest=tallest,
        alt=alt or "Weaves: " + ", ".join(panel.title for panel in panels),
    )


def heights(
    s: Scalars, at: Scalars, sides: Scalars, length: float, closed: bool, level: float = 0.0
) -> Scalars:
    """Height along a ribbon in half thicknesses: +1 over, -1 under, half cosines between.

    It stays as it is up to ``level`` to either side of a crossing, at most three tenths of the way on.
    """
    if not len(at):
        return np.zeros(len(s))
    order = np.argsort(at)
    at, sides = at[order], sides[order]
    if closed:
        at = np.concatenate([[at[-1] - length], at, [at[0] + length]])
        sides = np.concatenate([[sides[-1]], sides, [sides[0]]])
    if len(at) == 1:
        return np.full(len(s), sides[0])
    after = np.clip(np.searchsorted(at, s, side="right"), 1, len(at) - 1)
    before = after - 1
    gap = np.maximum(at[after] - at[before], 1e-12)
    flat = np.minimum(level / gap, 0.3)
    share = np.clip(((s - at[before]) / gap - flat) / (1.0 - 2.0 * flat), 0.0, 1.0)
    blend = 0.5 - 0.5 * np.cos(np.pi * share)
    return np.asarray((1 - blend) * sides[before] + blend * sides[after])


def _unit(vectors: Vectors) -> Vectors:
    size = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(size > 0, size, 1.0))
