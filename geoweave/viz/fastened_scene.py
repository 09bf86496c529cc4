"""A weave at rest with its crossings: which hold by friction, and which need glue or a rivet (Section 6)."""

from __future__ import annotations

from geoweave.rods import FRICTION, Relaxed
from geoweave.viz import style
from geoweave.viz.rods import Sprung, at_rest
from geoweave.viz.scene import Scene
from geoweave.viz.views import View
from geoweave.viz.weaves import colouring

__all__ = ["held_crossings"]

DOT = 0.4
"""Radius of a dot that is seen, in widths of a ribbon; others are half as large."""

VEIL = 0.35
"""Opacity of the surface behind."""


def held_crossings(relaxed: Relaxed, view: View | str, *, friction: float = FRICTION) -> Scene:
    """Build a scene of a weave at rest: a large dot where a crossing needs glue or a rivet, else a small one.

    Parameters
    ----------
    relaxed : the weave at rest
    view : where from, or the name of a model in `VIEWS`
    friction : coefficient of friction between two ribbons

    Examples
    --------
    >>> rest = gw.relaxed_weave(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8))
    >>> viz.held_crossings(rest, "cone").aspect > 0
    True
    """
    rods = at_rest(relaxed)
    panel = Sprung(rods, relaxed.weave.mesh, view=view, hues=colouring(relaxed.weave), opacity=VEIL)
    scene = panel.scene()
    segments, places = rods.contacts.segments[:, 0], rods.contacts.places[:, :1]
    start, end = rods.points[rods.layout.ends[segments]].swapaxes(0, 1)
    points = start + places * (end - start)
    needs = relaxed.forces.friction > friction
    width = float(rods.widths.mean())
    for these, size, colour in ((~needs, 0.5 * DOT, style.INK), (needs, DOT, style.RED)):
        if these.any():
            scene.add_dots(points[these], size * width, [colour] * int(these.sum()))
    return scene
