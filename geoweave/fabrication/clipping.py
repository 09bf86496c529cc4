"""Clip segments and polygons by boxes, so that guides end at the edges of a strip and leave room for text."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from geoweave.fabrication.stroke_font import Box

__all__ = ["clipped", "dashes", "outside", "rectangle", "span", "within"]


def rectangle(left: float, right: float, half: float) -> NDArray[np.float64]:
    """Four corners of a rectangle centred on the x axis, counter-clockwise."""
    return np.array([[left, -half], [right, -half], [right, half], [left, half]])


def span(start: NDArray[np.float64], end: NDArray[np.float64], box: Box) -> tuple[float, float] | None:
    """Which share of a segment lies in a box."""
    low, high = 0.0, 1.0
    limits = ((box.left, box.right), (box.bottom, box.top))
    for (least, most), here, there in zip(limits, start.tolist(), end.tolist(), strict=True):
        way = there - here
        if abs(way) < 1e-15:
            if not least < here < most:
                return None
            continue
        one, other = (least - here) / way, (most - here) / way
        if one > other:
            one, other = other, one
        low, high = max(low, one), min(high, other)
    return (low, high) if high > low else None


def within(
    start: NDArray[np.float64], end: NDArray[np.float64], length: float, half: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]] | None:
    """The part of a segment that lies on the strip."""
    share = span(start, end, Box(0.0, -half, length, half))
    return None if share is None else (start + share[0] * (end - start), start + share[1] * (end - start))


def dashes(start: NDArray[np.float64], end: NDArray[np.float64], size: float) -> list[NDArray[np.float64]]:
    """Dashes that begin and end with a whole one."""
    total = float(np.linalg.norm(end - start))
    count = max(round((total / size + 0.8) / 1.8), 1)
    dash = total / (count + 0.8 * (count - 1))
    at = np.arange(count) * 1.8 * dash
    way = (end - start) / max(total, 1e-12)
    return [np.array([start + a * way, start + (a + dash) * way]) for a in at]


def outside(line: NDArray[np.float64], boxes: list[Box]) -> list[NDArray[np.float64]]:
    """The parts of a segment that lie in none of the boxes."""
    start, end = line
    left, right = sorted((float(start[0]), float(end[0])))
    near = (box for box in boxes if box.left < right and left < box.right)
    spans = sorted(found for box in near if (found := span(start, end, box)) is not None)
    parts, done = [], 0.0
    for low, high in [*spans, (1.0, 1.0)]:
        if low > done + 1e-9:
            parts.append(np.array([start + done * (end - start), start + low * (end - start)]))
        done = max(done, high)
    return parts


def clipped(polygon: NDArray[np.float64], length: float, half: float) -> NDArray[np.float64]:
    """The part of a convex polygon that lies on the strip (Sutherland and Hodgman 1974)."""
    for axis, sign, bound in ((0, 1.0, 0.0), (0, -1.0, -length), (1, 1.0, -half), (1, -1.0, -half)):
        kept: list[NDArray[np.float64]] = []
        depth = sign * polygon[:, axis] - bound
        for k in range(len(polygon)):
            here, there = depth[k - 1], depth[k]
            if (here < 0) != (there < 0):
                kept.append(polygon[k - 1] + here / (here - there) * (polygon[k] - polygon[k - 1]))
            if there >= 0:
                kept.append(polygon[k])
        polygon = np.array(kept).reshape(-1, 2)
        if not len(polygon):
            break
    return polygon
