"""Ribbons of a weave as they would lie: wide, thick, over and under each other (Figs. 1, 18, 21, 24)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from geoweave.arrays import Scalars, Vectors
from geoweave.errors import RenderError
from geoweave.mesh import TriMesh
from geoweave.viz import style
from geoweave.viz.gallery import VIEWS
from geoweave.viz.layout import caption, place
from geoweave.viz.picture import Picture, sheet
from geoweave.viz.scene import Scene, View
from geoweave.weave import Weave

WIDTH, THICKNESS = 0.34, 0.05
"""Of a ribbon, in units of the spacing of its family."""

STEP = 0.12
"""Distance between the cross sections of a strip, in spacings."""


class Strips(NamedTuple):
    """The outside of some ribbons as quadrilaterals."""

    points: Vectors
    """(P, 3)"""
    quads: NDArray[np.int64]
    """(Q, 4)"""


def strips(weave: Weave, family: int, width: float = WIDTH, thickness: float = THICKNESS) -> Strips:
    """Build the ribbons of one family as solid strips, lifted by half a thickness over and under each other.

    Between crossings the height above the surface goes from one to the next in half a wave of a cosine.

    Parameters
    ----------
    weave : the weave
    family : which family
    width, thickness : in units of the spacing

    Raises
    ------
    RenderError
        If the width or the thickness is not positive.
    """
    if not (width > 0 and thickness > 0):
        raise RenderError(f"a ribbon needs a positive width and thickness, not {width} and {thickness}")
    ribbons, spacing = weave.ribbons, weave.ribbons.spacing
    curves, met = ribbons.curves, ribbons.crossings
    smooth = weave.mesh.vertex_normals
    points, quads, count = [], [], 0
    for c in np.flatnonzero(weave.families == family):
        own = np.arange(curves.offsets[c], curves.offsets[c + 1])
        closed, length = bool(curves.closed[c]), float(curves.lengths[c])
        at, place = curves.arclength[own], curves.points[own]
        normal = _normals(weave.mesh, smooth, place, curves.faces[own])
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
        height = _heights(s, met.arclength[here], sides, length, closed)
        middle = line + 0.55 * thickness * spacing * height[:, None] * up
        half, thick = 0.5 * width * spacing * across, 0.5 * thickness * spacing * up
        ring = np.stack(
            [middle - half - thick, middle + half - thick, middle + half + thick, middle - half + thick]
        )
        points.append(ring.swapaxes(0, 1).reshape(-1, 3))
        first = 4 * np.arange(len(s) if closed else len(s) - 1)
        second = (first + 4) % (4 * len(s))
        for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)):
            quads.append(count + np.stack([first + a, second + a, second + b, first + b], axis=1)[:, ::-1])
        if not closed:
            last = 4 * (len(s) - 1)
            quads.append(count + np.array([[3, 2, 1, 0], [last, last + 1, last + 2, last + 3]]))
        count += 4 * len(s)
    if not points:
        return Strips(np.zeros((0, 3)), np.zeros((0, 4), dtype=np.int64))
    return Strips(np.concatenate(points), np.concatenate(quads))


def weave_scene(
    weave: Weave, view: View | str, *, width: float = WIDTH, thickness: float = THICKNESS
) -> Scene:
    """Build the scene of a weave on its surface, one hue for each family."""
    scene = Scene(VIEWS[view] if isinstance(view, str) else view)
    # The surface a little below, so that what goes under is not lost in it.
    sunk = weave.mesh.vertices - 1.3 * thickness * weave.ribbons.spacing * weave.mesh.vertex_normals
    scene.add_surface(TriMesh(sunk, weave.mesh.faces), colour=style.SURFACE)
    for family in range(int(weave.families.max()) + 1):
        made = strips(weave, family, width, thickness)
        if len(made.quads):
            scene.add_solid(made.points, made.quads, style.FAMILIES[family % len(style.FAMILIES)])
    return scene


def weave_gallery(
    weaves: Sequence[tuple[str, str, Weave, View | str]],
    *,
    width: int = style.WIDTH,
    tallest: int = 1100,
    ribbon: float = WIDTH,
    thickness: float = THICKNESS,
    alt: str = "",
) -> Picture:
    """Draw weaves side by side: (title, subtitle, weave, view) each.

    Raises
    ------
    RenderError
        If there is nothing to draw.
    """
    if not weaves:
        raise RenderError("a gallery of weaves needs at least one weave")
    side, gap, words = 40, 50, 110
    scenes = [weave_scene(w, view, width=ribbon, thickness=thickness) for _, _, w, view in weaves]
    unit = width / style.WIDTH
    room = width - unit * (2 * side + gap * (len(weaves) - 1))
    height = min(round(unit * tallest), int(room / sum(scene.aspect for scene in scenes)))
    total = round(height + unit * (2 * side + words))
    figure = sheet(width, total)
    with style.applied():
        pictures = [scene.draw(height) for scene in scenes]
        spare = (width - sum(picture.shape[1] for picture in pictures)) / (len(pictures) + 1)
        left = spare
        for picture, (title, subtitle, _, _) in zip(pictures, weaves, strict=True):
            place(figure, picture, left, unit * side)
            middle = (left + 0.5 * picture.shape[1]) / width
            caption(figure, (title, subtitle), middle, unit * side + height, unit)
            left += picture.shape[1] + spare
    return Picture(figure, alt or "Weaves: " + ", ".join(each[0] for each in weaves))


def _heights(s: Scalars, at: Scalars, sides: Scalars, length: float, closed: bool) -> Scalars:
    """Height along a ribbon in half thicknesses: +1 over, -1 under, half cosines between."""
    if not len(at):
        return np.zeros(len(s))
    order = np.argsort(at)
    at, sides = at[order], sides[order]
    if closed:
        at = np.concatenate([[at[-1] - length], at, [at[0] + length]])
        sides = np.concatenate([[sides[-1]], sides, [sides[0]]])
    after = (
        np.clip(np.searchsorted(at, s, side="right"), 1, len(at) - 1)
        if len(at) > 1
        else np.zeros(len(s), int)
    )
    if len(at) == 1:
        return np.full(len(s), sides[0])
    before = after - 1
    share = np.clip((s - at[before]) / np.maximum(at[after] - at[before], 1e-12), 0.0, 1.0)
    blend = 0.5 - 0.5 * np.cos(np.pi * share)
    return np.asarray((1 - blend) * sides[before] + blend * sides[after])


def _normals(mesh: TriMesh, at_vertices: Vectors, points: Vectors, faces: NDArray[np.int64]) -> Vectors:
    """Smooth unit normals at points of faces."""
    a, b, c = (mesh.vertices[mesh.faces[faces, k]] for k in range(3))
    face_normal = np.cross(b - a, c - a)
    square = (face_normal**2).sum(axis=1)
    weights = np.stack(
        [
            (np.cross(q - p, points - p) * face_normal).sum(axis=1) / square
            for p, q in ((b, c), (c, a), (a, b))
        ],
        axis=1,
    )
    return _unit((weights[:, :, None] * at_vertices[mesh.faces[faces]]).sum(axis=1))


def _unit(vectors: Vectors) -> Vectors:
    size = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(size > 0, size, 1.0))
