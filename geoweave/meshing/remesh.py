"""Isotropic remeshing: cover the same surface with a wanted number of nearly equilateral triangles.

This is the incremental remeshing of Botsch and Kobbelt, *A Remeshing Approach to Multiresolution Modeling*
(2004). Each round splits long edges, collapses short ones, flips edges towards six faces per vertex, and
slides vertices along the surface. The wanted edge length is adjusted until the number of faces is met.
"""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Flags, Indices, Scalars, Vectors
from geoweave.compiled import compiled
from geoweave.errors import MeshError
from geoweave.meshing.edge_edits import collapse_edges, flip_edges, relax_vertices, split_edges
from geoweave.meshing.halfedge_patch import FREE, LOCKED, ON_CURVE, Guide, Patch
from geoweave.surface import BoxTree, TriMesh, segment_tree, triangle_tree
from geoweave.wording import counted

LONG, SHORT = 4.0 / 3.0, 4.0 / 5.0
"""Edges are split above and collapsed below these multiples of the wanted length (Botsch and Kobbelt)."""

ROUNDS, FINISH = 10, 6
"""Rounds with all edits, and rounds with flips and sliding alone at the end."""

TRIMMED = 3
"""Rounds at the end that also bring the number of faces to the wanted one."""

STEADY = (0.7, 1.4)
"""Least and largest factor by which one round may change the wanted edge length."""

TOLERANCE = 0.05
"""Share by which the number of faces may differ from the wanted one."""

MOST_FACES = 5_000_000
"""Largest number of faces that is made."""

BYTES_PER_FACE = 720
"""Memory that remeshing takes for each face it makes, as measured at 300,000 faces."""

CORNER = np.pi / 4
"""A curve that turns by more than this within half an edge length has a corner there, which stays."""

_EVERYTHING = 2**62
"""A number of faces that no budget ends at."""


def isotropic_remesh(mesh: TriMesh, faces: int, *, feature_angle: float | None = None) -> TriMesh:
    """Cover the surface of a mesh with about `faces` nearly equilateral triangles.

    The wanted edge length is ``h = sqrt(4 A / (sqrt(3) faces))`` for the area A. Vertices lie on the faces of
    `mesh` and boundary vertices on its boundary. On parts thinner than the triangles are wide a few may lie
    off it, where moving them back would turn a face over. The corners of the boundary stay. The number of
    components, the genus and the number of boundary loops are those of `mesh`. The same input gives the same
    result. Section 5.2 of the paper remeshes its inputs in this way.

    Parameters
    ----------
    mesh : any orientable surface, of any scale
    faces : wanted number of faces
    feature_angle : degrees; edges whose faces meet at a larger angle (0 is flat) stay edges. None keeps no
        edge but the boundary.

    Raises
    ------
    MeshError
        If `faces` is less than 4 or more than `MOST_FACES`, or if the topology of the surface does not allow
        so few faces; the message then names the number that was reached.

    Examples
    --------
    >>> even = gw.isotropic_remesh(gw.shapes.cone(faces=800), 300)
    >>> 285 <= even.n_faces <= 315, len(even.boundary_loops)
    (True, 1)
    """
    check_face_count(faces)
    working, placement = mesh.normalized()
    creases = _creases(working, feature_angle)
    guide = Guide(
        triangle_tree(working.vertices[working.faces]),
        _lines(working, working.boundary_edges, directed=True),
        _lines(working, creases, directed=False),
    )
    length = float(np.sqrt(4.0 * working.face_areas.sum() / (np.sqrt(3.0) * faces)))
    patch = opened_patch(working, creases, length)
    _collapse(patch, guide, SHORT * length, LONG * length)
    patch = closed_up(patch)
    for i in range(ROUNDS + FINISH):
        if i < ROUNDS:
            patch = split_long(patch, guide, LONG * length)
            _collapse(patch, guide, SHORT * length, LONG * length)
            patch = closed_up(patch)
            flip_edges(patch, False)
        else:
            patch = _trimmed(patch, guide, faces, length) if i < ROUNDS + TRIMMED else patch
            flip_edges(patch, True)
        relax_vertices(patch, guide)
        length *= float(np.clip(np.sqrt(len(patch.at) / (3.0 * faces)), *STEADY)) if i < ROUNDS else 1.0
    flip_edges(patch, True)
    return _checked(mesh, TriMesh(placement.undo(patch.points), patch.at.reshape(-1, 3)), faces)


def check_face_count(faces: int) -> None:
    """Refuse a number of faces that no surface has, or that memory is too small for.

    Raises
    ------
    MeshError
        If `faces` is less than 4 or more than `MOST_FACES`.

    Examples
    --------
    >>> gw.meshing.check_face_count(1_000_000_000)
    Traceback (most recent call last):
    geoweave.errors.MeshError: cannot remesh to 1,000,000,000 faces: ... ask for at most 5,000,000
    """
    if faces < 4:
        raise MeshError(f"cannot remesh to {counted(faces, 'face')}: ask for at least 4")
    if faces > MOST_FACES:
        raise MeshError(
            f"cannot remesh to {counted(faces, 'face')}: they would take "
            f"{BYTES_PER_FACE * faces / 1e9:,.0f} GB of "
            f"memory; ask for at most {MOST_FACES:,}"
        )


def _checked(mesh: TriMesh, result: TriMesh, faces: int) -> TriMesh:
    def topology(surface: TriMesh) -> tuple[int, int, int]:
        return surface.n_components, surface.genus, len(surface.boundary_loops)

    if topology(result) != topology(mesh):
        raise MeshError(
            f"remeshing to {counted(faces, 'face')} changed components, genus and boundary loops from "
            f"{topology(mesh)} "
            f"to {topology(result)}; ask for more faces"
        )
    if abs(result.n_faces - faces) > max(TOLERANCE * faces, 2):
        raise MeshError(
            f"cannot remesh to {counted(faces, 'face')}: keeping the surface's topology and thin parts "
            "ends at "
            f"{result.n_faces}; ask for at least that many"
        )
    return result


def _creases(mesh: TriMesh, feature_angle: float | None) -> Indices:
    """Interior edges whose faces meet at more than `feature_angle` degrees."""
    if feature_angle is None:
        return np.zeros(0, dtype=np.int64)
    i, j = mesh.edge_faces[mesh.interior_edges].T
    cosine = np.einsum("ex,ex->e", mesh.face_normals[i], mesh.face_normals[j])
    sharp: Indices = mesh.interior_edges[cosine < np.cos(np.radians(feature_angle))]
    return sharp


def _lines(mesh: TriMesh, edges: Indices, *, directed: bool) -> BoxTree:
    """The search tree of some edges; a directed edge is found only by a search along its direction."""
    tree = segment_tree(mesh.vertices[mesh.edges[edges]])
    if not directed:
        return tree
    along = mesh.edge_vectors[edges] / mesh.edge_lengths[edges][:, None]
    return tree._replace(normals=np.ascontiguousarray(along))


def opened_patch(mesh: TriMesh, creases: Indices, length: float) -> Patch:
    """The mesh as arrays to edit. Its boundary and creases are marked, their corners and ends are locked."""
    halfedges = mesh.edge_halfedges
    over = np.full(3 * mesh.n_faces, -1, dtype=np.int64)
    over[halfedges[:, 0]] = halfedges[:, 1]
    inner = halfedges[:, 1] >= 0
    over[halfedges[inner, 1]] = halfedges[inner, 0]
    curves = np.concatenate([mesh.boundary_edges, creases])
    marked = np.zeros(3 * mesh.n_faces, dtype=bool)
    marked[halfedges[curves, 0]] = True
    marked[halfedges[creases, 1]] = True
    corner = np.empty(mesh.n_vertices, dtype=np.int64)
    corner[mesh.faces.ravel()] = np.arange(3 * mesh.n_faces)
    kind = _kinds(mesh, curves, length)
    return Patch(mesh.vertices.copy(), kind, corner, mesh.faces.ravel().copy(), over, marked)


def _kinds(mesh: TriMesh, curves: Indices, length: float) -> Indices:
    """(V,) LOCKED where curves end, branch or turn sharply, ON_CURVE elsewhere on them, FREE off them."""
    ends = mesh.edges[curves]
    count = np.bincount(ends.ravel(), minlength=mesh.n_vertices)
    kind = np.where(count == 0, FREE, np.where(count == 2, ON_CURVE, LOCKED)).astype(np.int64)
    order = np.argsort(ends.ravel(), kind="stable")
    vertex, other = ends.ravel()[order], ends[:, ::-1].ravel()[order]
    first = np.flatnonzero(count[vertex] == 2)
    neighbors = np.full((mesh.n_vertices, 2), -1, dtype=np.int64)
    neighbors[vertex[first[::2]], 0] = other[first[::2]]
    neighbors[vertex[first[1::2]], 1] = other[first[1::2]]
    kind[_corners(mesh.vertices, neighbors, 0.5 * length)] = LOCKED
    return kind


@compiled
def _corners(points: Vectors, neighbors: Indices, reach: float) -> Flags:
    """(V,) whether the curve through a vertex turns sharply there, and nowhere more sharply within `reach`.

    The turn is the lesser of two: at the vertex itself, and between the points `reach` along the curve to
    either side. So the steps of a jagged boundary are no corners.
    """
    sharp = np.zeros(len(points), dtype=np.bool_)
    turn = np.zeros(len(points))
    arms = np.empty((2, 2, 3))
    for vertex in range(len(points)):
        if neighbors[vertex, 0] < 0:
            continue
        for side in range(2):
            last, here = vertex, neighbors[vertex, side]
            arms[0, side] = points[here] - points[vertex]
            walked = np.sqrt((arms[0, side] ** 2).sum())
            while walked < reach and neighbors[here, 0] >= 0 and here != vertex:
                onward = neighbors[here, 0] if neighbors[here, 0] != last else neighbors[here, 1]
                last, here = here, onward
                walked += np.sqrt(((points[here] - points[last]) ** 2).sum())
            arms[1, side] = points[here] - points[vertex]
        least = np.pi
        for scale in range(2):
            a, b = arms[scale, 0], arms[scale, 1]
            size = np.sqrt((a**2).sum() * (b**2).sum())
            cosine = -(a * b).sum() / size if size > 0.0 else 1.0
            least = min(least, np.arccos(min(1.0, max(-1.0, cosine))))
        turn[vertex] = least
        sharp[vertex] = least > CORNER
    for vertex in range(len(points)):
        if not sharp[vertex]:
            continue
        for side in range(2):
            last, here, walked = vertex, neighbors[vertex, side], 0.0
            while neighbors[here, 0] >= 0 and here != vertex:
                walked += np.sqrt(((points[here] - points[last]) ** 2).sum())
                if walked > reach:
                    break
                if turn[here] > turn[vertex] or (turn[here] == turn[vertex] and here < vertex):
                    sharp[vertex] = False
                onward = neighbors[here, 0] if neighbors[here, 0] != last else neighbors[here, 1]
                last, here = here, onward
    return sharp


def _lengths(patch: Patch) -> tuple[Indices, Scalars]:
    """One half-edge of each living edge, and their lengths."""
    h = np.flatnonzero((patch.at >= 0) & (patch.over < np.arange(len(patch.at))))
    corner = h - h % 3
    a, b = patch.at[corner + (h + 1) % 3], patch.at[corner + (h + 2) % 3]
    return h, np.linalg.norm(patch.points[a] - patch.points[b], axis=1)


def split_long(patch: Patch, guide: Guide, longest: float, budget: int = _EVERYTHING) -> Patch:
    """Split edges, the longest first, until none is longer than `longest` or `budget` faces are new."""
    while budget > 0:
        h, length = _lengths(patch)
        chosen = h[length > longest][np.argsort(-length[length > longest], kind="stable")]
        if not len(chosen):
            break
        vertices, faces = len(patch.points), len(patch.at) // 3
        patch = _grown(patch, len(chosen))
        used_vertices, used_faces = split_edges(patch, guide, chosen, longest, budget, vertices, faces)
        patch = _cut(patch, used_vertices, used_faces)
        budget -= used_faces - faces
    return patch


def _collapse(patch: Patch, guide: Guide, shortest: float, longest: float, budget: int = _EVERYTHING) -> None:
    h, length = _lengths(patch)
    chosen = h[length < shortest][np.argsort(length[length < shortest], kind="stable")]
    collapse_edges(patch, guide, chosen, shortest, longest, budget)


def _trimmed(patch: Patch, guide: Guide, faces: int, length: float) -> Patch:
    """Bring the count to the wanted one by splitting the longest or collapsing the shortest edges."""
    excess = len(patch.at) // 3 - faces
    if excess > 1:
        _collapse(patch, guide, LONG * length, 1.5 * LONG * length, excess)
        return closed_up(patch)
    return split_long(patch, guide, SHORT * length, -excess) if excess < -1 else patch


def _grown(patch: Patch, splits: int) -> Patch:
    """The patch with room for so many splits."""
    vertices, corners = splits, 6 * splits
    return Patch(
        np.concatenate([patch.points, np.zeros((vertices, 3))]),
        np.concatenate([patch.kind, np.zeros(vertices, dtype=np.int64)]),
        np.concatenate([patch.corner, np.full(vertices, -1)]),
        np.concatenate([patch.at, np.full(corners, -1)]),
        np.concatenate([patch.over, np.full(corners, -1)]),
        np.concatenate([patch.marked, np.zeros(corners, dtype=bool)]),
    )


def _cut(patch: Patch, vertices: int, faces: int) -> Patch:
    """The patch without the room that was not used."""
    return Patch(
        patch.points[:vertices].copy(),
        patch.kind[:vertices].copy(),
        patch.corner[:vertices].copy(),
        patch.at[: 3 * faces].copy(),
        patch.over[: 3 * faces].copy(),
        patch.marked[: 3 * faces].copy(),
    )


def closed_up(patch: Patch) -> Patch:
    """The patch without the faces and vertices that were removed."""
    alive, used = patch.at >= 0, patch.corner >= 0
    corner_now, vertex_now = np.cumsum(alive) - 1, np.cumsum(used) - 1
    over = patch.over[alive]
    return Patch(
        patch.points[used],
        patch.kind[used],
        corner_now[patch.corner[used]],
        vertex_now[patch.at[alive]],
        np.where(over >= 0, corner_now[over], -1),
        patch.marked[alive],
    )
