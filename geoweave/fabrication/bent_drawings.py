"""Drawings of strips that are cut curved: what is drawn along a straight strip is bent with it.

A strip is drawn along x, its middle at y = 0 (`strip_drawing`). Here the place x goes to the point of the
flat centreline there, and y is measured square to it, so outlines keep their width. Marks and letters are not
distorted: each is turned as a whole. The piece is then turned so that it is as low as can be on its sheet.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.pieces import Making, Piece, lowest, rim
from geoweave.fabrication.strip_figures import Drawn, Figure
from geoweave.fabrication.stroke_font import Box
from geoweave.weave import FlatCurve

__all__ = ["bent"]

WHOLE = frozenset({"heading", "hollow", "solid", "hole", "label", "name"})
"""Roles of what is turned and not bent."""

CHORD = 0.01
"""Lines that are bent are cut so finely that they miss their arc by at most this, mm."""

FINEST = 0.2
"""They are not cut finer than this, mm."""


def bent(sheet: Drawn, pattern: Pattern, making: Making) -> Drawn:
    """The drawing of a piece of a strip as it is cut; as it is where the strip is straight.

    Parameters
    ----------
    sheet : of the straight strip, by `drawn`
    pattern : the strips
    making : how strips are cut; seen from the inside, a strip curves the other way

    Returns
    -------
    Drawn
        `Drawn.spine` is its middle line. The box around the outline begins at x = 0 and is centred on y = 0.
    """
    curve = pattern.strips[sheet.piece.strip].curve
    if curve is None:
        return sheet
    curve = curve.mirrored if making.mirror else curve
    piece = sheet.piece
    turn = lowest(rim(curve, piece, pattern.width))
    angle = float(np.degrees(np.arctan2(turn[0, 1], turn[0, 0])))
    step = float(max(np.sqrt(8 * CHORD / max(curve.sharpest, 1e-9)), FINEST))
    figures = [_turned(_bent(figure, curve, piece, step), turn, angle) for figure in sheet.figures]
    outline = np.concatenate([path for each in figures if each.role == "outline" for path in each.paths])
    low, high = outline.min(axis=0), outline.max(axis=0)
    shift = np.array([-low[0], -0.5 * (low[1] + high[1])])
    half = 0.5 * float(high[1] - low[1])
    along = np.linspace(piece.start, piece.end, 2 + int(piece.length / step))
    return sheet._replace(
        figures=tuple(figure.moved(*shift) for figure in figures),
        extent=Box(0.0, -half, float(high[0] - low[0]), half),
        spine=curve.points(along) @ turn + shift,
    )


def _turned(figure: Figure, turn: NDArray[np.float64], angle: float) -> Figure:
    """Turn a figure about the origin."""
    spot = figure.spot
    if spot is not None:
        x, y = np.array([spot.x, spot.y]) @ turn
        spot = spot._replace(x=float(x), y=float(y), turn=spot.turn + angle)
    return figure._replace(paths=tuple(path @ turn for path in figure.paths), spot=spot)


def _bent(figure: Figure, curve: FlatCurve, piece: Piece, step: float) -> Figure:
    """Bend a figure, or move and turn it as a whole."""
    if not figure.paths and figure.spot is None:
        return figure
    if figure.role not in WHOLE:
        paths = tuple(_mapped(_cut(path, figure.closed, step), curve, piece) for path in figure.paths)
        return figure._replace(paths=paths)
    if figure.spot is not None:
        middle = np.array([figure.spot.x, figure.spot.y])
    else:
        points = np.concatenate(figure.paths)
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    angle = float(curve.heading([middle[0] + piece.start])[0])
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    shift = _mapped(middle[None], curve, piece)[0] - middle @ turn
    return _turned(figure, turn, float(np.degrees(angle))).moved(*shift)


def _mapped(path: NDArray[np.float64], curve: FlatCurve, piece: Piece) -> NDArray[np.float64]:
    """Points (x, y) of a straight strip, on the curved one."""
    place = path[:, 0] + piece.start
    angle = curve.heading(place)
    return np.asarray(curve.points(place) + path[:, 1:] * np.column_stack([-np.sin(angle), np.cos(angle)]))


def _cut(path: NDArray[np.float64], closed: bool, step: float) -> NDArray[np.float64]:
    """The same line with its pieces at most a step long in x."""
    ends = np.concatenate([path, path[:1]]) if closed else path
    counts = np.maximum(np.ceil(np.abs(np.diff(ends[:, 0])) / step).astype(np.int64), 1)
    at = np.concatenate([k + np.arange(n) / n for k, n in enumerate(counts.tolist())] or [np.zeros(0)])
    at = at if closed else np.append(at, len(path) - 1.0)
    return np.column_stack([np.interp(at, np.arange(len(ends)), ends[:, x]) for x in (0, 1)])
