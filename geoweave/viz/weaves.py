"""Ribbons of a weave as they would lie: wide, thick, over and under each other (Figs. 1, 18, 21, 24)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import cKDTree

from geoweave.arrays import Indices, Vectors
from geoweave.surface import TriMesh
from geoweave.viz import style
from geoweave.viz.ground import add_ground
from geoweave.viz.layout import gallery
from geoweave.viz.picture import Picture
from geoweave.viz.scene import Scene
from geoweave.viz.solids import joined, ribbon_bodies
from geoweave.viz.views import View, view_of
from geoweave.weave import Weave

IN_FRONT = 0.75
"""Least cosine between the normal and the direction to the eye at the place of a close-up."""


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
    dots : whether to mark the branch points, in black
    marked : (n, 3) other places to mark, in white with a dark rim
    bright : numbers of the ribbons that are drawn in colour, the others in grey; all in colour if not given
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
    marked: Vectors | None = None
    bright: Indices | None = None

    def scene(self) -> Scene:
        """Build the scene."""
        chosen = self.weave.families if self.families else colouring(self.weave, self.hues)
        if self.bright is not None:
            chosen = np.where(np.isin(np.arange(len(chosen)), self.bright), chosen, -1)
        scene = weave_scene(self.weave, self.view, chosen, width=self.width, thickness=self.thickness)
        scene.focus = self.focus
        mesh, points = self.weave.mesh, self.weave.branch_points
        if self.dots:
            scene.add_dots(mesh.vertices[points], 0.022 * mesh.bounding_radius, [style.INK] * len(points))
        if self.marked is not None:
            _add_rimmed(scene, mesh, self.marked)
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

    Examples
    --------
    >>> woven = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)
    >>> set(viz.colouring(woven).tolist()) <= {0, 1, 2}
    True
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


def weave_scene(
    weave: Weave,
    view: View | str,
    chosen: Indices | None = None,
    *,
    width: float | None = None,
    thickness: float | None = None,
    surface: TriMesh | None = None,
) -> Scene:
    """Build the scene of a weave on its surface.

    Parameters
    ----------
    weave : the weave
    view : where from, or the name of a model in `VIEWS`
    chosen : (n,) colour of each ribbon, -1 for grey; those of `colouring` if not given
    width, thickness : lengths on the surface; those of the weave if not given
    surface : to draw in place of the weave's mesh

    Examples
    --------
    >>> woven = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)
    >>> 0.5 < viz.weave_scene(woven, "cone").aspect < 2
    True
    """
    mesh = weave.mesh if surface is None else surface
    scene = Scene(view_of(view))
    # The surface a little behind, so that what goes under is not lost in it; where normals point inwards one
    # looks at the ribbons from below.
    depth = 1.3 * (weave.thickness if thickness is None else thickness) * facing(mesh)
    add_ground(scene, mesh, depth)
    chosen = colouring(weave) if chosen is None else chosen
    found = ribbon_bodies(weave, width, thickness)
    for hue in np.unique(chosen):
        made = joined([found[c] for c in np.flatnonzero(chosen == hue)])
        scene.add_solid(
            made.points, made.quads, style.FAMILIES[hue % len(style.FAMILIES)] if hue >= 0 else style.LINE
        )
    return scene


def facing(mesh: TriMesh) -> float:
    """Whether normals point out, 1, as they do unless most of the area faces the middle, or in, -1."""
    weights = mesh.face_areas
    middle = np.average(mesh.barycenters, axis=0, weights=weights)
    away = mesh.barycenters - middle
    out = float(weights @ (away * mesh.face_normals).sum(axis=1))
    return -1.0 if out < -0.2 * float(weights @ np.linalg.norm(away, axis=1)) else 1.0


def _add_rimmed(scene: Scene, mesh: TriMesh, points: Vectors) -> None:
    """Add white dots in dark ones: no ribbon has either colour."""
    if not len(points):
        return
    radius, normals = 0.012 * mesh.bounding_radius, mesh.vertex_normals
    nearest = cKDTree(mesh.vertices).query(points)[1]
    scene.add_dots(points, 1.4 * radius, [style.INK] * len(points))
    lifted = points + facing(mesh) * radius * normals[nearest]
    scene.add_dots(lifted, radius, ["white"] * len(points))


def clear_place(candidates: Vectors, avoided: Vectors, mesh: TriMesh, view: View | str) -> Vectors:
    """Choose a place for a close-up: in front, and as far as can be from what would spoil it.

    Parameters
    ----------
    candidates : (n, 3) places on the surface to choose from, such as branch points
    avoided : (m, 3) places to stay away from, such as ends of ribbons
    mesh : the surface
    view : where from, or the name of a model in `VIEWS`

    Returns
    -------
    (3,) of the candidates where the surface turns to the eye, but for 40 degrees, the one farthest from
    all that is avoided; of all candidates, if nowhere it does

    Examples
    --------
    >>> ball = gw.shapes.sphere(faces=320)
    >>> poles = np.array([[1.0, 0, 0], [-1.0, 0, 0]])
    >>> viz.clear_place(poles, poles[1:], ball, viz.View(azimuth=0.0, elevation=0.0)).tolist()
    [1.0, 0.0, 0.0]
    """
    eye = view_of(view).axes[2]
    nearest = cKDTree(mesh.vertices).query(candidates)[1]
    # What turns to the eye may still be hidden: of a model the part in front is asked for first.
    ahead = facing(mesh) * (mesh.vertex_normals[nearest] @ eye) > IN_FRONT
    ahead &= candidates @ eye > np.median(mesh.vertices @ eye)
    chosen = candidates[ahead] if ahead.any() else candidates
    away = cKDTree(avoided).query(chosen)[0] if len(avoided) else np.zeros(len(chosen))
    found: Vectors = chosen[int(np.argmax(away))]
    return found


def weave_gallery(
    panels: Sequence[Woven],
    *,
    columns: int | None = None,
    width: int = style.WIDTH,
    tallest: int = 1100,
    alt: str = "",
    filling: bool = False,
) -> Picture:
    """Draw weaves in rows of equal columns.

    Parameters
    ----------
    panels : what to draw; the order is kept
    columns, width, tallest, alt, filling : as of `gallery`

    Raises
    ------
    RenderError
        If there is nothing to draw.

    Examples
    --------
    >>> woven = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)
    >>> viz.weave_gallery([viz.Woven(woven, "a cone", view="cone")], width=200).alt
    'Weaves: a cone'
    """
    return gallery(
        [panel.scene() for panel in panels],
        [(panel.title, panel.subtitle) for panel in panels],
        columns=columns,
        width=width,
        tallest=tallest,
        filling=filling,
        alt=alt or "Weaves: " + ", ".join(panel.title for panel in panels),
    )
