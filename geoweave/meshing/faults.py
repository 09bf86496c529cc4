"""Faults of a surface that stay as they are: told with their places, because only its maker knows the remedy.

A surface is worked on with them, but they show in what comes out: it is open where it looks closed, or has
parts that nobody wants.
"""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Indices, Vectors
from geoweave.meshing.report import place
from geoweave.meshing.shells import crossing_shells
from geoweave.surface import TriMesh
from geoweave.wording import counted

TOUCHING = 1e-5
"""A corner closer to an edge than this share of the model's size lies on that edge."""

SPECK = 0.01
"""A component smaller than this share of the model is a speck."""

DUST = 10
"""So many specks are dust; fewer may be meant."""


def faults(mesh: TriMesh) -> tuple[str, ...]:
    """Name the faults of a surface, one sentence for each kind that is found.

    Found are corners of open edges that lie on the side of another open edge (T-junctions, and seams whose
    two sides have different corners), many components that are too small to be meant (dust), and components
    that run through each other.

    Examples
    --------
    >>> from geoweave.meshing.faults import faults
    >>> faults(gw.shapes.torus(faces=400))
    ()
    """
    size = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    said = []
    if len(mesh.boundary_edges):
        said += _open_seams(mesh, size)
    if mesh.n_components > DUST:
        said += _dust(mesh, size)
    if mesh.n_components > 1:
        said += _crossings(mesh)
    return tuple(said)


def _open_seams(mesh: TriMesh, size: float) -> list[str]:
    """Name the corners that lie on the side of an open edge."""
    found = _on_open_edges(mesh, TOUCHING * size)
    if not len(found):
        return []
    first = place(mesh.vertices[found[:1]])
    sentence = (
        f"{counted(len(found), 'corner')} of open edges {'lies' if len(found) == 1 else 'lie'} on the "
        "side of "
        f"another open edge (T-junctions; first at {first}), where the surface is open; split that edge at "
        "the corner in a mesh editor"
    )
    return [sentence]


def _on_open_edges(mesh: TriMesh, distance: float) -> Indices:
    """Boundary vertices within a distance of a boundary edge, but not of its ends."""
    from scipy.spatial import cKDTree

    candidates = np.flatnonzero(mesh.boundary_vertices)
    tree = cKDTree(mesh.vertices[candidates])
    ends = mesh.edges[mesh.boundary_edges]
    start, end = mesh.vertices[ends[:, 0]], mesh.vertices[ends[:, 1]]
    length = np.linalg.norm(end - start, axis=1)
    near = tree.query_ball_point(0.5 * (start + end), 0.5 * length + distance, return_sorted=False)
    edge = np.repeat(np.arange(len(ends)), [len(found) for found in near])
    vertex = candidates[np.concatenate(near).astype(np.int64)]
    apart = (vertex != ends[edge, 0]) & (vertex != ends[edge, 1])
    edge, vertex = edge[apart], vertex[apart]
    along = (end - start)[edge] / length[edge, None]
    offset = mesh.vertices[vertex] - start[edge]
    at = np.einsum("px,px->p", offset, along)
    away = np.linalg.norm(offset - at[:, None] * along, axis=1)
    on = (away <= distance) & (at > distance) & (at < length[edge] - distance)
    # The third corner of a thin face lies near its open edge, and is no corner of a seam.
    return np.unique(vertex[on & ~_is_apex(mesh, edge, vertex)])


def _is_apex(mesh: TriMesh, edge: Indices, vertex: Indices) -> np.ndarray:
    """Whether a vertex is the third corner of the face at a boundary edge."""
    faces = mesh.edge_faces[mesh.boundary_edges[edge], 0]
    return np.asarray((mesh.faces[faces] == vertex[:, None]).any(axis=1))


def _crossings(mesh: TriMesh) -> list[str]:
    """Components that run through each other."""
    found = crossing_shells(mesh)
    if not found:
        return []
    sentence = (
        f"{counted(len(found), 'pair')} of components run through each other (first at "
        f"{place(found[0][2][None])}), and so will what is made of them; unite them in a mesh editor"
    )
    return [sentence]


def _dust(mesh: TriMesh, size: float) -> list[str]:
    """Components that are too small to be meant, if there are many."""
    extents = _extents(mesh)
    specks = np.flatnonzero(extents < SPECK * size)
    if len(specks) < DUST:
        return []
    first = mesh.vertices[mesh.vertex_components == specks[0]]
    sentence = (
        f"{len(specks)} of {mesh.n_components} components are smaller than a hundredth of the model (dust; "
        f"first at {place(first)}); leave them out with --components largest, or in a mesh editor"
    )
    return [sentence]


def _extents(mesh: TriMesh) -> Vectors:
    """(components,) diagonal of the box around each component."""
    order = np.argsort(mesh.vertex_components, kind="stable")
    starts = np.searchsorted(mesh.vertex_components[order], np.arange(mesh.n_components))
    points = mesh.vertices[order]
    box = np.maximum.reduceat(points, starts) - np.minimum.reduceat(points, starts)
    return np.asarray(np.linalg.norm(box, axis=1))
