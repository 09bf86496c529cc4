"""Ribbons of a weave, and elastic rods, as solids to draw: their bodies are those of `geoweave.weave`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from geoweave.arrays import Indices, Vectors
from geoweave.errors import RenderError
from geoweave.rods import Rods
from geoweave.surface import smooth_normals
from geoweave.weave import Body, Centreline, Weave, bodies

CUTS = 4
"""Points that the smooth line through the vertices of a rod gets for each segment."""


class Strips(NamedTuple):
    """The outside of some ribbons as quadrilaterals."""

    points: Vectors
    """(P, 3)"""
    quads: NDArray[np.int64]
    """(Q, 4)"""


class Bands(NamedTuple):
    """The outside of some rods as quadrilaterals."""

    points: Vectors
    """(P, 3)"""
    quads: NDArray[np.int64]
    """(Q, 4)"""
    segments: Indices
    """(P,) segment that each point belongs to"""


def ribbon_bodies(
    weave: Weave, width: float | None = None, thickness: float | None = None
) -> tuple[Body, ...]:
    """Give the ribbons of a weave their bodies on its surface.

    Parameters
    ----------
    weave : the weave
    width, thickness : lengths on the surface; those of the weave if not given

    Raises
    ------
    RenderError
        If the width or the thickness is not positive.
    """
    wide, thin = weave.width if width is None else width, weave.thickness if thickness is None else thickness
    if not (wide > 0 and thin > 0):
        raise RenderError(f"a ribbon needs a positive width and thickness, not {wide} and {thin}")
    curves, met = weave.ribbons.curves, weave.ribbons.crossings
    middle = 0.5 * (curves.points + curves.points[curves.following])
    normals = smooth_normals(weave.mesh, middle, curves.faces)
    lines = []
    for c in range(len(curves)):
        own = slice(curves.offsets[c], curves.offsets[c + 1])
        lines.append(Centreline(curves.points[own], normals[own], bool(curves.closed[c])))
    over = weave.interlacing.over
    return bodies(lines, met.curves, met.arclength, over, width=wide, thickness=thin)


def strips(
    weave: Weave, which: Indices, width: float | None = None, thickness: float | None = None
) -> Strips:
    """Build some ribbons of a weave as solids, over and under each other (`geoweave.weave.bodies`).

    Parameters
    ----------
    weave : the weave
    which : numbers of the ribbons
    width, thickness : lengths on the surface; those of the weave if not given

    Raises
    ------
    RenderError
        If the width or the thickness is not positive.

    Examples
    --------
    >>> woven = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)
    >>> made = viz.strips(woven, np.arange(2))
    >>> made.points.shape[1], made.quads.shape[1]
    (3, 4)
    """
    found = ribbon_bodies(weave, width, thickness)
    return joined([found[c] for c in which])


def joined(found: Sequence[Body]) -> Strips:
    """Join the solids of some ribbons into one."""
    points, quads, count = [np.zeros((0, 3))], [np.zeros((0, 4), dtype=np.int64)], 0
    for body in found:
        vertices, sides = body.solid()
        points.append(vertices)
        quads.append(count + sides)
        count += len(vertices)
    return Strips(np.concatenate(points), np.concatenate(quads))


def bands(rods: Rods, which: Indices) -> Bands:
    """Build some rods as solids of their width and thickness, smooth through their vertices.

    Where rods cross they lie over and under each other, also those that were laid on a surface and go
    through each other there (`geoweave.weave.bodies`).

    Parameters
    ----------
    rods : in space
    which : numbers of the rods

    Examples
    --------
    >>> rods = gw.elastic_rods(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)).rods
    >>> made = viz.bands(rods, np.array([0]))
    >>> bool((rods.layout.rod_of_segment[made.segments] == 0).all())
    True
    """
    layout, contacts = rods.layout, rods.contacts
    drawn = [_drawn(rods, r) for r in range(len(rods))]
    rod = layout.rod_of_segment[contacts.segments]
    along = np.zeros(rod.shape)
    for r in range(len(rods)):
        first = layout.segment_offsets[r]
        mine = rod == r
        place = contacts.segments[mine] - first + contacts.places[mine]
        along[mine] = np.interp(place, np.arange(len(drawn[r].knots)), drawn[r].knots)
    found = bodies(
        [each.line for each in drawn], rod, along, contacts.over,
        width=float(rods.widths.max()), thickness=rods.material.thickness,
    )  # fmt: skip
    chosen = [
        found[r]._replace(width=float(rods.widths[layout.segment_offsets[r]])) for r in np.asarray(which)
    ]
    owners = [np.zeros(0, dtype=np.int64)]
    for r, body in zip(which, chosen, strict=True):
        at = body.at[:-1] if body.closed else body.at
        knots = drawn[r].knots
        own = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, len(knots) - 2)
        owners.append(np.repeat(layout.segment_offsets[r] + own, 4))
    made = joined(chosen)
    return Bands(made.points, made.quads, np.concatenate(owners))


class _Drawn(NamedTuple):
    line: Centreline
    knots: NDArray[np.float64]
    """(V,) length along the line at each vertex of the rod, for a closed rod also once round."""


def _drawn(rods: Rods, r: int) -> _Drawn:
    """The smooth line through the vertices of a rod, with thickness directions that turn evenly."""
    layout = rods.layout
    closed = bool(layout.closed[r])
    segments = np.arange(layout.segment_offsets[r], layout.segment_offsets[r + 1])
    knots = np.concatenate([[0.0], np.cumsum(rods.lengths[segments])])
    vertices = np.append(layout.ends[segments, 0], layout.ends[segments[-1], 1])
    spline = CubicSpline(knots, rods.points[vertices], bc_type="periodic" if closed else "natural")
    s = np.interp(np.arange(CUTS * len(segments) + 1) / CUTS, np.arange(len(knots)), knots)
    directors = rods.directors[segments]
    if closed:
        turned = directors + np.roll(directors, 1, axis=0)
        turned = np.append(turned, turned[:1], axis=0)
    else:
        turned = np.concatenate([directors[:1], directors[1:] + directors[:-1], directors[-1:]])
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    middle = 0.5 * (s[1:] + s[:-1])
    up = np.stack([np.interp(middle, knots, x) for x in turned.T], axis=1)
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    points = spline(s)
    line = (
        Centreline(points[:-1], up, True)
        if closed
        else Centreline(points, np.append(up, up[-1:], axis=0), False)
    )
    return _Drawn(line, line.arclength[::CUTS])
