"""The closest point on a surface or on curves, exactly: a tree of bounding boxes over their pieces.

A segment is a triangle whose last two corners coincide, so one tree serves both. The tree is a tuple of flat
arrays, so that compiled loops can ask it one point at a time; `closest_points` asks for many.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geoweave.arrays import Indices, Scalars, Vectors
from geoweave.compiled import compiled

LEAF = 4
"""Pieces in a leaf of the tree."""

DEPTH = 96
"""Room on the stack of a descent; the tree halves its pieces, so this is never reached."""


class BoxTree(NamedTuple):
    """Bounding boxes over triangles, halved along the longest side of the box of their centres."""

    triangles: Vectors
    """(N, 3, 3) corners of the pieces; a segment repeats its second end."""
    normals: Vectors
    """(N, 3) unit normals, zero for segments."""
    order: Indices
    """(N,) pieces in the order of the leaves."""
    spans: Indices
    """(M, 2) first and last + 1 position in `order` of each node."""
    children: Indices
    """(M,) first of the two children of each node, -1 for a leaf."""
    boxes: Vectors
    """(M, 2, 3) lower and upper corner of each node."""


def triangle_tree(triangles: Vectors) -> BoxTree:
    """Build the tree of (N, 3, 3) triangles."""
    corners = np.ascontiguousarray(triangles, dtype=np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals / np.where(length > 0, length, 1.0)
    return BoxTree(corners, normals, *_split_boxes(corners))


def segment_tree(segments: Vectors) -> BoxTree:
    """Build the tree of (N, 2, 3) segments."""
    return triangle_tree(segments[:, [0, 1, 1]])


@compiled
def _split_boxes(corners: Vectors) -> tuple[Indices, Indices, Indices, Vectors]:
    count = len(corners)
    centres = np.empty((count, 3))
    for i in range(count):
        for x in range(3):
            centres[i, x] = (corners[i, 0, x] + corners[i, 1, x] + corners[i, 2, x]) / 3.0
    order = np.arange(count)
    room = 2 * count + 1
    spans = np.zeros((room, 2), dtype=np.int64)
    children = np.full(room, -1, dtype=np.int64)
    boxes = np.empty((room, 2, 3))
    spans[0, 1] = count
    made, node = 1, 0
    while node < made:
        first, last = spans[node]
        boxes[node, 0], boxes[node, 1] = np.inf, -np.inf
        low, high = np.full(3, np.inf), np.full(3, -np.inf)
        for place in range(first, last):
            piece = order[place]
            for x in range(3):
                low[x] = min(low[x], centres[piece, x])
                high[x] = max(high[x], centres[piece, x])
                for k in range(3):
                    boxes[node, 0, x] = min(boxes[node, 0, x], corners[piece, k, x])
                    boxes[node, 1, x] = max(boxes[node, 1, x], corners[piece, k, x])
        if last - first > LEAF:
            axis = np.argmax(high - low)
            part = order[first:last].copy()
            order[first:last] = part[np.argsort(centres[part, axis], kind="mergesort")]
            middle = (first + last) // 2
            children[node] = made
            spans[made, 0], spans[made, 1] = first, middle
            spans[made + 1, 0], spans[made + 1, 1] = middle, last
            made += 2
        node += 1
    return order, spans[:made].copy(), children[:made].copy(), boxes[:made].copy()


@compiled
def _box_distance(point: Scalars, box: Vectors) -> float:
    """Squared distance from a point to a box."""
    total = 0.0
    for x in range(3):
        gap = max(box[0, x] - point[x], 0.0, point[x] - box[1, x])
        total += gap * gap
    return total


@compiled
def _on_triangle(p: Scalars, triangle: Vectors) -> tuple[float, float]:
    """Barycentric weights (of corners 1 and 2) of the point of a triangle closest to p, by its regions."""
    d1 = d2 = d3 = d4 = d5 = d6 = 0.0
    for x in range(3):
        ab = triangle[1, x] - triangle[0, x]
        ac = triangle[2, x] - triangle[0, x]
        d1 += ab * (p[x] - triangle[0, x])
        d2 += ac * (p[x] - triangle[0, x])
        d3 += ab * (p[x] - triangle[1, x])
        d4 += ac * (p[x] - triangle[1, x])
        d5 += ab * (p[x] - triangle[2, x])
        d6 += ac * (p[x] - triangle[2, x])
    if d1 <= 0.0 and d2 <= 0.0:
        return 0.0, 0.0
    if d3 >= 0.0 and d4 <= d3:
        return 1.0, 0.0
    if d6 >= 0.0 and d5 <= d6:
        return 0.0, 1.0
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        return d1 / (d1 - d3), 0.0
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        return 0.0, d2 / (d2 - d6)
    if va <= 0.0 and d4 >= d3 and d5 >= d6:
        along = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return 1.0 - along, along
    return vb / (va + vb + vc), vc / (va + vb + vc)


@compiled
def nearest(tree: BoxTree, point: Scalars, normal: Scalars, found: Scalars) -> int:
    """Put into `found` the point of the tree closest to `point` and return its piece, or -1.

    Pieces whose normal points against `normal` are passed over, so that a thin sheet's far side is never
    taken for its near side; a zero `normal` accepts every piece.
    """
    best, piece = np.inf, -1
    stack = np.empty(DEPTH, dtype=np.int64)
    gaps = np.empty(DEPTH)
    stack[0], gaps[0], height = 0, 0.0, 1
    candidate = np.empty(3)
    while height:
        height -= 1
        node = stack[height]
        if gaps[height] >= best:
            continue
        child = tree.children[node]
        if child >= 0:
            near, far = child, child + 1
            near_gap, far_gap = _box_distance(point, tree.boxes[near]), _box_distance(point, tree.boxes[far])
            if far_gap < near_gap:
                near, far, near_gap, far_gap = far, near, far_gap, near_gap
            stack[height], gaps[height] = far, far_gap
            stack[height + 1], gaps[height + 1] = near, near_gap
            height += 2
            continue
        for place in range(tree.spans[node, 0], tree.spans[node, 1]):
            index = tree.order[place]
            facing = 0.0
            for x in range(3):
                facing += tree.normals[index, x] * normal[x]
            if facing < 0.0:
                continue
            triangle = tree.triangles[index]
            u, v = _on_triangle(point, triangle)
            distance = 0.0
            for x in range(3):
                candidate[x] = (1.0 - u - v) * triangle[0, x] + u * triangle[1, x] + v * triangle[2, x]
                distance += (candidate[x] - point[x]) ** 2
            if distance < best:
                best, piece = distance, index
                found[:] = candidate
    return piece


@compiled
def _nearest_all(tree: BoxTree, points: Vectors) -> tuple[Vectors, Indices]:
    found = np.empty_like(points)
    pieces = np.empty(len(points), dtype=np.int64)
    anywhere = np.zeros(3)
    for i in range(len(points)):
        pieces[i] = nearest(tree, points[i], anywhere, found[i])
    return found, pieces


def closest_points(tree: BoxTree, points: Vectors) -> tuple[Vectors, Indices]:
    """Return the (N, 3) points of the tree closest to N points, and the (N,) pieces they lie on."""
    return _nearest_all(tree, np.ascontiguousarray(points, dtype=np.float64))
