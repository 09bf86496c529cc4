"""Weaves with known answers, as the contents of weave.json, for the tests of patterns."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from geoweave.fabrication.flattening import pattern_of
from geoweave.fabrication.nesting import Sheet, Stock, nested
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.pieces import Making, pieces_of
from geoweave.fabrication.strip_drawing import drawn
from geoweave.models import shapes
from geoweave.weave.design import weave_field
from geoweave.weave.weave import Weave

UP = (0.0, 0.0, 1.0)


def document(
    ribbons: list[dict[str, Any]], crossings: list[dict[str, Any]], *, width: float = 6.0
) -> dict[str, Any]:
    """A document with what `pattern_of` and `solid_ribbons` read."""
    return {
        "format": "geoweave-weave",
        "version": 1,
        "units": "mm",
        "width": width,
        "thickness": 0.5,
        "ribbons": [{"id": r, **each} for r, each in enumerate(ribbons)],
        "crossings": [{"id": x, **each} for x, each in enumerate(crossings)],
    }


def ribbon(label: str, family: int, points: Any, normals: Any, *, closed: bool = False) -> dict[str, Any]:
    places = np.array(points, dtype=np.float64)
    steps = np.diff(places, axis=0, append=places[:1]) if closed else np.diff(places, axis=0)
    up = np.broadcast_to(np.array(normals, dtype=np.float64), places.shape)
    return {
        "label": label,
        "family": family,
        "closed": closed,
        "length": float(np.linalg.norm(steps, axis=1).sum()),
        "points": places.tolist(),
        "normals": up.tolist(),
    }


def crossing(one: int, other: int, at: tuple[float, float], over: int) -> dict[str, Any]:
    return {"ribbons": [one, other], "arclength": list(at), "over_index": over}


def flat(each: int = 4, spacing: float = 30.0, reach: float = 75.0, width: float = 8.0) -> dict[str, Any]:
    """Three families of parallel lines in the plane at 60 degrees: every angle is known."""
    lines = []
    for family in range(3):
        angle = np.pi / 3 * family
        way = np.array([np.cos(angle), np.sin(angle), 0.0])
        left = np.array([-way[1], way[0], 0.0])
        for k in range(each):
            foot = (k - 0.5 * (each - 1) + 0.25) * spacing * left
            lines.append((f"{'ABC'[family]}{k + 1}", family, foot - reach * way, way))
    ribbons = [ribbon(name, family, [p, p + 2 * reach * w], UP) for name, family, p, w in lines]
    crossings = []
    for a in range(len(lines)):
        for b in range(a + 1, len(lines)):
            if lines[a][1] == lines[b][1]:
                continue
            (_, _, p, v), (_, _, q, w) = lines[a], lines[b]
            s, t = np.linalg.solve(np.stack([v[:2], -w[:2]], axis=1), (q - p)[:2])
            if 0 < s < 2 * reach and 0 < t < 2 * reach:
                crossings.append(crossing(a, b, (float(s), float(t)), (a + b) % 2))
    return document(ribbons, crossings, width=width)


def circles(radius: float = 60.0, points: int = 120) -> dict[str, Any]:
    """Three great circles at right angles: closed, and each two of them cross twice."""
    axes = np.eye(3)
    ribbons, angle = [], 2 * np.pi * np.arange(points) / points
    for k in range(3):
        u, v = axes[(k + 1) % 3], axes[(k + 2) % 3]
        # A normal belongs to the segment after its point.
        middle = angle + np.pi / points
        places = radius * (np.cos(angle)[:, None] * u + np.sin(angle)[:, None] * v)
        normals = np.cos(middle)[:, None] * u + np.sin(middle)[:, None] * v
        ribbons.append(ribbon("ABC"[k] + "1", k, places, normals, closed=True))
    quarter = ribbons[0]["length"] / 4
    crossings = []
    for k in range(3):  # circle k meets circle k + 1 on the axis k + 2, which is v of one and u of the other
        other = (k + 1) % 3
        crossings.append(crossing(k, other, (quarter, 0.0), 0))
        crossings.append(crossing(k, other, (3 * quarter, 2 * quarter), 1))
    return document(ribbons, crossings)


def bow_tie() -> dict[str, Any]:
    """One line in the plane that crosses itself at a right angle after 50 sqrt 2 and 150 sqrt 2 + 100."""
    points = [(-50, -50, 0), (50, 50, 0), (50, -50, 0), (-50, 50, 0)]
    root = float(50 * np.sqrt(2))
    return document([ribbon("A1", 0, points, UP)], [crossing(0, 0, (root, 3 * root + 100), 1)])


def pairs_often(times: int = 20) -> dict[str, Any]:
    """Two lines that cross more often than there are marks: one straight, one in zigzag over it."""
    zigzag = [(12.0 * k, 8.0 * (-1) ** k, 0.0) for k in range(times + 1)]
    straight = [(0.0, 0.0, 0.0), (12.0 * times, 0.0, 0.0)]
    step = float(np.hypot(12, 16))
    return document(
        [ribbon("A1", 0, straight, UP), ribbon("B1", 1, zigzag, UP)],
        [crossing(0, 1, (12.0 * (k + 0.5), step * (k + 0.5)), k % 2) for k in range(times)],
        width=5.0,
    )


@cache
def cone() -> Weave:
    """A weave that was solved, with about forty crossings, 120 mm wide."""
    field = weave_field(shapes.cone(faces=700))
    scale = float(np.sqrt(40 / field.expected_crossings(1.0)))
    return field.pattern(scale=scale).sized(size=120.0)


@cache
def patterns() -> dict[str, Pattern]:
    """The patterns of all of them."""
    return {
        "flat": pattern_of(flat()),
        "circles": pattern_of(circles()),
        "bow tie": pattern_of(bow_tie()),
        "often": pattern_of(pairs_often()),
        "cone": pattern_of(cone()),
    }


NAMES = ("flat", "circles", "bow tie", "often", "cone")


def sheet(name: str, making: Making | None = None, stock: Stock | None = None) -> Sheet:
    """The one sheet that a pattern is laid on."""
    pattern, how, sheets = patterns()[name], making or Making(), stock or Stock()
    (only,) = nested([drawn(pattern, p, how) for p in pieces_of(pattern, how, sheets.room)], sheets)
    return only
