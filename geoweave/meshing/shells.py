"""Components of a surface that run through each other, found by their edges and triangles."""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Indices, Vectors
from geoweave.surface import TriMesh

MOST_SHELLS = 200
"""So many components are looked at, the largest first; more would be dust."""

MOST_PAIRS = 10_000_000
"""So many pairs of triangles are tested for two components; two with more pairs are passed over."""

SHIFT = 1e-6
"""How far a component is shifted to look for crossings, in sizes of the box that both share."""

ASKEW = np.array([0.61, 0.53, 0.59])
"""The direction of the shift, which no surface made by hand is likely to have."""

CLEAR = 1e-8
"""An edge runs through a triangle if the point is this share clear of the sides and of the edge's ends."""


def crossing_shells(mesh: TriMesh) -> list[tuple[int, int, Vectors]]:
    """Find the pairs of components that run through each other.

    Components that only touch, or lie one inside the other, do not. Those that fit into each other exactly,
    such as a peg in its hole, are taken to.

    Returns
    -------
    (first component, second component, a point (3,) where they cross) of each pair

    Examples
    --------
    >>> from geoweave.meshing.shells import crossing_shells
    >>> crossing_shells(gw.shapes.torus(faces=400))
    []
    """
    corners = mesh.vertices[mesh.faces]
    low, high = corners.min(axis=1), corners.max(axis=1)
    component = mesh.face_components
    order = np.argsort(component, kind="stable")
    starts = np.searchsorted(component[order], np.arange(mesh.n_components))
    least, most = np.minimum.reduceat(low[order], starts), np.maximum.reduceat(high[order], starts)
    members = np.split(order, starts[1:])
    largest = np.sort(np.argsort(-np.linalg.norm(most - least, axis=1), kind="stable")[:MOST_SHELLS])
    found = []
    for place, i in enumerate(largest.tolist()):
        for j in largest[place + 1 :].tolist():
            inner, outer = np.maximum(least[i], least[j]), np.minimum(most[i], most[j])
            if (inner > outer).any():
                continue
            first, second = (
                faces[((low[faces] <= outer) & (high[faces] >= inner)).all(axis=1)]
                for faces in (members[i], members[j])
            )
            # Equal shells may cross at corners and edges only; a small shift either way ends that. Shells
            # that touch cross after one of the two shifts, not after both.
            shift = SHIFT * float(np.linalg.norm(outer - inner)) * ASKEW
            points = [_crossing(corners[first], corners[second] + side * shift) for side in (1.0, -1.0)]
            if points[0] is not None and points[1] is not None:
                found.append((i, j, points[0]))
    return found


def _crossing(first: Vectors, second: Vectors) -> Vectors | None:
    """A point (3,) where triangles (A, 3, 3) cross triangles (B, 3, 3), if there is one."""
    if not len(first) or not len(second):
        return None
    a, b = _near(first, second)
    for edges, faces in ((first[a], second[b]), (second[b], first[a])):
        for k in range(3):
            start, end = edges[:, k], edges[:, (k + 1) % 3]
            at = _through(start, end, faces)
            hit = np.flatnonzero(np.isfinite(at))
            if len(hit):
                return np.asarray(start[hit[0]] + at[hit[0]] * (end[hit[0]] - start[hit[0]]))
    return None


def _near(first: Vectors, second: Vectors) -> tuple[Indices, Indices]:
    """Pairs of triangles whose boxes overlap; none if there are too many to tell."""
    from scipy.spatial import cKDTree

    low_a, high_a, low_b, high_b = first.min(1), first.max(1), second.min(1), second.max(1)
    reach = 0.5 * float((high_a - low_a).max() + (high_b - low_b).max())
    tree, other = cKDTree(0.5 * (low_a + high_a)), cKDTree(0.5 * (low_b + high_b))
    if tree.count_neighbors(other, reach, p=np.inf) > MOST_PAIRS:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    pairs = tree.sparse_distance_matrix(other, reach, p=np.inf, output_type="ndarray")
    a, b = pairs["i"].astype(np.int64), pairs["j"].astype(np.int64)
    near = ((low_a[a] <= high_b[b]) & (high_a[a] >= low_b[b])).all(axis=1)
    order = np.lexsort((b[near], a[near]))
    return a[near][order], b[near][order]


def _through(start: Vectors, end: Vectors, faces: Vectors) -> Vectors:
    """(N,) share of each segment at which it runs through its triangle; nan where it does not.

    After Moeller and Trumbore, *Fast, Minimum Storage Ray-Triangle Intersection* (1997).
    """
    along, one, two = end - start, faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0]
    normal = np.cross(one, two)
    slope = np.einsum("nx,nx->n", along, normal)
    scale = np.linalg.norm(along, axis=1) * np.linalg.norm(normal, axis=1)
    level = np.abs(slope) <= CLEAR * scale
    slope = np.where(level, 1.0, slope)
    offset = start - faces[:, 0]
    at = -np.einsum("nx,nx->n", offset, normal) / slope
    spot = offset + at[:, None] * along
    size = np.einsum("nx,nx->n", normal, normal)
    u = np.einsum("nx,nx->n", np.cross(spot, two), normal) / size
    v = np.einsum("nx,nx->n", np.cross(one, spot), normal) / size
    inside = (np.minimum(u, v) > CLEAR) & (u + v < 1.0 - CLEAR) & (at > CLEAR) & (at < 1.0 - CLEAR)
    return np.where(inside & ~level, at, np.nan)
