"""One weave, or one weave at rest, on its surface: the picture to look at first."""

from __future__ import annotations

from geoweave.rods import Relaxed, surface_of_weave
from geoweave.surface import TriMesh
from geoweave.viz import style
from geoweave.viz.layout import gallery
from geoweave.viz.picture import Picture
from geoweave.viz.rods import Sprung, at_rest
from geoweave.viz.scene import Scene
from geoweave.viz.views import View
from geoweave.viz.weaves import colouring, weave_scene
from geoweave.weave import Weave
from geoweave.wording import counted

VEIL = 0.35
"""Opacity of the surface in front of which a weave is at rest."""

FROM_THE_FRONT = View(azimuth=30.0, elevation=30.0)


def weave(
    woven: Weave | Relaxed,
    on: TriMesh | None = None,
    *,
    view: View | str = FROM_THE_FRONT,
    title: str = "",
    width: int = 1200,
) -> Picture:
    """Draw a weave on its surface, as it was designed or as it comes to rest.

    Parameters
    ----------
    woven : a weave, or what `geoweave.relax` makes of one, which is drawn at rest over a veil
    on : the surface, in the position and size in which the weave is written; that of the weave if not given
    view : where from, or the name of a model in `VIEWS`
    title : a line under the picture
    width : pixels across

    Returns
    -------
    A picture: ``picture.show()`` shows it, `publish` writes it.

    Raises
    ------
    RodError
        If the surface lies elsewhere than the weave.

    Examples
    --------
    >>> surface = gw.shapes.cone(faces=400)
    >>> picture = viz.weave(gw.weave_pattern(surface, ribbons=8), on=surface, width=200)
    >>> picture.pixels.shape[1], picture.alt
    (200, 'A weave of 10 ribbons on its surface')
    """
    drawn = woven_scene(woven, on, view)
    design = woven.weave if isinstance(woven, Relaxed) else woven
    place = "at rest" if isinstance(woven, Relaxed) else "on its surface"
    hues = style.FAMILIES[: int(colouring(design).max()) + 1]
    words = f"A weave of {counted(len(design.ribbons), 'ribbon')} {place}"
    return gallery([drawn], [(title, "")], width=width, tallest=style.WIDTH, alt=words, accents=hues)


def woven_scene(woven: Weave | Relaxed, on: TriMesh | None, view: View | str) -> Scene:
    """Build the scene that `weave` draws."""
    if isinstance(woven, Relaxed):
        design = woven.weave
        points = woven.slid.rods.points
        surface = design.mesh if on is None else surface_of_weave(on, design, points)
        return Sprung(at_rest(woven), surface, view=view, hues=colouring(design), opacity=VEIL).scene()
    surface = woven.mesh if on is None else surface_of_weave(on, woven, woven.ribbons.curves.points)
    return weave_scene(woven, view, surface=surface)
