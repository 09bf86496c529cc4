"""Repairs of loose triangles, one function each.

Faces are (F, 3) vertex indices in any orientation. Half-edge ``k`` of a face lies opposite its corner ``k``.
Tolerances are relative to the model, so that its unit and its place do not matter.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geoweave.arrays import Flags, Indices, Scalars, Triangles, Vectors
from geoweave.surface import SMALLEST_ASPECT, connected_components

FLAT = 2.0 * SMALLEST_ASPECT
"""A face is flat when its area is at most this share of its longest edge squared; stricter than `TriMesh`."""

ROUNDING = 4 * float(np.finfo(np.float64).eps)
"""Error of a coordinate, relative to its size; it matters where a model lies far from the origin."""

COINCIDENT = 1e-7
"""Open vertices closer than this share of the model, or of a flat face's longest edge, are one vertex.

STL and most PLY files are written in single precision, whose error is about this share.
"""

CRACK = 1e-5
"""Open vertices closer than this share of the model are one vertex too, if all their open edges are long."""

LONG = 10.0
"""Open edges are long that have this many times the width of the crack beside them."""

INWARD = 1e-9
"""A closed component faces inwards if its volume is negative by more than this share of its area^1.5."""


@dataclass(frozen=True, eq=False)
class Edges:
    """The undirected edges of a face list.

    ``ends`` (E, 2) sorted vertices, ``of_halfedge`` (3F,) edge of each half-edge, ``counts`` (E,) faces
    on each.
    """

    ends: Indices
    of_halfedge: Indices
    counts: Indices

    @classmethod
    def of(cls, faces: Triangles) -> Edges:
        """Collect the edges of the faces."""
        tail, head = faces[:, [1, 2, 0]].ravel(), faces[:, [2, 0, 1]].ravel()
        size = int(faces.max(initial=0)) + 1
        key = np.minimum(tail, head) * size + np.maximum(tail, head)
        key, of_halfedge, counts = np.unique(key, return_inverse=True, return_counts=True)
        return cls(np.stack([key // size, key % size], axis=1), of_halfedge, counts)

    @cached_property
    def halfedge_pairs(self) -> Indices:
        """(P, 2) half-edges that lie on the same edge; an edge with n faces gives n - 1 pairs."""
        order = np.argsort(self.of_halfedge, kind="stable")
        same = np.flatnonzero(self.of_halfedge[order[1:]] == self.of_halfedge[order[:-1]])
        return np.stack([order[same], order[same + 1]], axis=1)

    @cached_property
    def manifold_pairs(self) -> Indices:
        """(P, 2) half-edges of the edges that exactly two faces share."""
        pairs = self.halfedge_pairs
        twice: Flags = self.counts[self.of_halfedge[pairs[:, 0]]] == 2
        return pairs[twice]

    @cached_property
    def face_components(self) -> Indices:
        """(F,) number of the component of each face; faces are connected over edges, not single vertices."""
        return connected_components(self.halfedge_pairs // 3, len(self.of_halfedge) // 3)


def first_of_each(labels: Indices) -> Indices:
    """(N,) lowest position that carries the same label."""
    _, first, inverse = np.unique(labels, return_index=True, return_inverse=True)
    return np.asarray(first[inverse], dtype=np.int64)


def repeated(faces: Triangles) -> Flags:
    """(F,) faces that name a vertex twice."""
    return np.asarray((faces == np.roll(faces, 1, axis=1)).any(axis=1))


def duplicates(faces: Triangles) -> Flags:
    """(F,) faces with the same three vertices as an earlier one, in any order."""
    corners = np.sort(faces, axis=1)
    order = np.lexsort(corners.T)  # stable, so the earliest face of a group comes first
    found = np.zeros(len(faces), dtype=bool)
    found[order[1:]] = (corners[order[1:]] == corners[order[:-1]]).all(axis=1)
    return found


def shapes_of(vertices: Vectors, faces: Triangles) -> tuple[Scalars, Scalars]:
    """(F, 3) lengths of the half-edges and (F,) areas."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    lengths = np.stack([np.linalg.norm(side, axis=1) for side in (c - b, a - c, b - a)], axis=1)
    return lengths, 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def flat(vertices: Vectors, faces: Triangles) -> Flags:
    """(F,) faces without area, or with no more area than the rounding of coordinates could cause."""
    lengths, areas = shapes_of(vertices, faces)
    longest = lengths.max(axis=1, initial=0.0)
    rounding = ROUNDING * np.abs(vertices[faces]).max(axis=(1, 2), initial=0.0)
    return np.asarray(areas <= (FLAT * longest + rounding) * longest)


def used_vertices(faces: Triangles, size: int) -> tuple[Indices, Triangles]:
    """Vertices (out of ``size``) that the faces use, in order, and the faces in their numbering."""
    used = np.zeros(size, dtype=bool)
    used[faces] = True
    number = np.cumsum(used) - 1
    return np.flatnonzero(used), number[faces]


def coincident(vertices: Vectors, faces: Triangles, edges: Edges, flat_faces: Flags) -> Indices:
    """(V,) lowest vertex that each vertex coincides with.

    Only ends of open edges are joined, so that closed surfaces that touch stay apart, and the ends of the
    short side of a needle, which is a flat face.
    """
    open_vertices = np.zeros(len(vertices), dtype=bool)
    open_vertices[edges.ends[edges.counts == 1]] = True
    size = float(np.linalg.norm(np.ptp(vertices[faces.ravel()], axis=0)))
    close = _close_pairs(vertices, np.flatnonzero(open_vertices), CRACK * size)
    width = np.linalg.norm(vertices[close[:, 0]] - vertices[close[:, 1]], axis=1)
    shortest = _shortest_open_edges(vertices, edges)
    close = close[
        (width <= COINCIDENT * size) | (LONG * width <= shortest[close].min(axis=1, initial=np.inf))
    ]

    corners = faces[flat_faces]
    lengths, _ = shapes_of(vertices, corners)
    needle = lengths.min(axis=1, initial=np.inf) <= COINCIDENT * lengths.max(axis=1, initial=0.0)
    rows, k = np.flatnonzero(needle), lengths[needle].argmin(axis=1)
    short = np.stack([corners[rows, (k + 1) % 3], corners[rows, (k + 2) % 3]], axis=1)
    pairs = np.concatenate([close, short])
    if not len(pairs):
        return np.arange(len(vertices))
    return first_of_each(connected_components(pairs, len(vertices)))


def _shortest_open_edges(vertices: Vectors, edges: Edges) -> Scalars:
    """(V,) length of the shortest open edge at each vertex; infinite off the open edges."""
    ends = edges.ends[edges.counts == 1]
    lengths = np.linalg.norm(vertices[ends[:, 0]] - vertices[ends[:, 1]], axis=1)
    shortest = np.full(len(vertices), np.inf)
    np.minimum.at(shortest, ends.ravel(), np.repeat(lengths, 2))
    return shortest


def _close_pairs(vertices: Vectors, candidates: Indices, distance: float) -> Indices:
    """Pairs of candidates that lie within a distance; points in the same place are joined in a chain."""
    points = vertices[candidates]
    order = np.lexsort(points.T)
    same = (points[order[1:]] == points[order[:-1]]).all(axis=1)
    exact = np.stack([order[:-1][same], order[1:][same]], axis=1)
    distinct = order[np.concatenate([[True], ~same])] if len(order) else order
    if len(distinct) > 1:
        from scipy.spatial import cKDTree

        # One point stands for all that coincide: in an STL file each point comes three times or more.
        tree = cKDTree(points[distinct], balanced_tree=False, compact_nodes=False)
        exact = np.concatenate([exact, distinct[tree.query_pairs(distance, output_type="ndarray")]])
    return np.asarray(candidates[exact], dtype=np.int64)


def flip_caps(vertices: Vectors, faces: Triangles, edges: Edges, bad: Flags) -> tuple[Triangles, int]:
    """Flip the longest edge of flat faces whose apex lies on it; this removes the face and opens no slit.

    Return the new faces, and how many edges were flipped. Edges whose flips would touch the same face, or
    make the same new edge, are left for another round.
    """
    pairs = edges.manifold_pairs
    pairs = pairs[bad[pairs[:, 0] // 3] | bad[pairs[:, 1] // 3]]
    pairs = np.concatenate([pairs, pairs[:, ::-1]])  # (half-edge of the cap, half-edge across)
    lengths, _ = shapes_of(vertices, faces)
    longest = lengths.argmax(axis=1)
    cap, across = pairs[:, 0] // 3, pairs[:, 1] // 3
    fits = bad[cap] & ~bad[across] & (longest[cap] == pairs[:, 0] % 3)
    pairs, cap, across = pairs[fits], cap[fits], across[fits]
    apex, far = faces.ravel()[pairs[:, 0]], faces.ravel()[pairs[:, 1]]

    size = int(faces.max(initial=0)) + 1
    new = np.minimum(apex, far) * size + np.maximum(apex, far)
    free = (apex != far) & ~np.isin(new, edges.ends[:, 0] * size + edges.ends[:, 1])
    chosen = np.flatnonzero(free)
    for taken in (across, new):
        chosen = chosen[np.unique(taken[chosen], return_index=True)[1]]
    cap, across, apex, far = cap[chosen], across[chosen], apex[chosen], far[chosen]
    k = pairs[chosen, 1] % 3
    p, q = faces[across, (k + 1) % 3], faces[across, (k + 2) % 3]
    flipped = faces.copy()
    flipped[across] = np.stack([far, p, apex], axis=1)
    flipped[cap] = np.stack([far, apex, q], axis=1)
    return flipped, len(chosen)


def orientation(faces: Triangles, edges: Edges) -> tuple[Flags, Indices]:
    """Which faces to turn over so that neighbours agree, and the faces where that is impossible.

    Each face gives two nodes of a graph: as it is, and turned over. Nodes that agree across an edge are
    linked. An orientable component gives two components of the graph, each with all its faces; the one that
    turns fewer faces over is taken. A one-sided component gives one.
    """
    n = len(faces)
    first, second = edges.manifold_pairs.T
    tails = faces[:, [1, 2, 0]].ravel()
    clash = tails[first] == tails[second]
    i, j = first // 3, second // 3
    nodes = np.concatenate([np.stack([i, j + n * clash], axis=1), np.stack([i + n, j + n * ~clash], axis=1)])
    label = connected_components(nodes, 2 * n)
    kept, turned = label[:n], label[n:]
    votes = np.bincount(kept, minlength=2 * n)
    first_face = first_of_each(np.minimum(kept, turned))
    tie = votes[kept] == votes[turned]
    turn = np.where(tie, kept != kept[first_face], votes[turned] > votes[kept])
    return turn, np.flatnonzero(kept == turned)


def inside_out(vertices: Vectors, faces: Triangles, edges: Edges) -> Flags:
    """(F,) faces of closed components whose normals point inwards, by the sign of the enclosed volume."""
    component = edges.face_components
    n = int(component.max()) + 1
    bounded = np.zeros(n, dtype=bool)
    bounded[component[np.flatnonzero(edges.counts[edges.of_halfedge] == 1) // 3]] = True
    _, first = np.unique(component, return_index=True)
    origin = vertices[faces[first, 0]][component]  # a point of the component: far from 0, digits are lost
    a, b, c = (vertices[faces[:, k]] - origin for k in range(3))
    volume = np.bincount(component, np.einsum("fx,fx->f", a, np.cross(b, c)) / 6.0, n)
    area = np.bincount(component, shapes_of(vertices, faces)[1], n)
    return ((volume < -INWARD * area**1.5) & ~bounded)[component]


def separated_fans(faces: Triangles, edges: Edges) -> tuple[Triangles, Indices]:
    """Give each fan of faces around a vertex a vertex of its own.

    Two faces belong to the same fan if they share an edge that no third face has.

    Returns
    -------
    The new faces, and (N,) the vertex that each added one is a copy of; they are numbered after the old ones.
    """
    pairs = edges.manifold_pairs
    face, k = np.divmod(pairs, 3)
    joined = []
    for step in (1, 2):
        vertex = faces[face[:, 0], (k[:, 0] + step) % 3]
        other = (k[:, 1] + 1) % 3
        other = np.where(faces[face[:, 1], other] == vertex, other, (k[:, 1] + 2) % 3)
        joined.append(np.stack([3 * face[:, 0] + (k[:, 0] + step) % 3, 3 * face[:, 1] + other], axis=1))
    fan = connected_components(np.concatenate(joined), faces.size)
    _, first, fan = np.unique(fan, return_index=True, return_inverse=True)
    vertex = faces.ravel()[first]
    leading = np.zeros(len(vertex), dtype=bool)
    order = np.lexsort((first, vertex))
    leading[order[np.concatenate([[True], vertex[order[1:]] != vertex[order[:-1]]])]] = True
    number = vertex.copy()
    n_vertices = int(faces.max()) + 1
    number[~leading] = n_vertices + np.arange(int((~leading).sum()))
    return number[fan].reshape(-1, 3), vertex[~leading]
