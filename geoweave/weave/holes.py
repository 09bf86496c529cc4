"""What no ribbon reaches or holds: holes, ends that hang, components without ribbons (Section 6)."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Indices
from geoweave.curves import nearest_curves
from geoweave.weave.places import Place, places
from geoweave.weave.ribbon_ends import outermost
from geoweave.weave.weave import Weave

__all__ = ["bare_components", "gaps", "hanging_ends"]


def hanging_ends(weave: Weave) -> list[Place]:
    """Open ends off the boundary without a crossing within a tail of them."""
    curves, met = weave.ribbons.curves, weave.ribbons.crossings
    ribbon, end = np.nonzero(weave.ribbons.loose)
    points = curves.points[np.where(end == 0, curves.offsets[ribbon], curves.offsets[ribbon + 1] - 1)]
    first, last = outermost(met, len(curves))
    beyond = np.where(end == 0, first[ribbon], curves.lengths[ribbon] - last[ribbon])
    # A ribbon that crosses nothing is loose all along.
    beyond = np.minimum(beyond, curves.lengths[ribbon]) * weave.placement.scale
    return places(weave, "loose_end", points, [(c,) for c in ribbon.tolist()], beyond, False)


def gaps(weave: Weave, limit: float) -> list[Place]:
    """Parts of the surface farther from any ribbon than the limit, in spacings: one place in each."""
    mesh, curves = weave.mesh, weave.ribbons.curves
    points = np.concatenate([mesh.vertices, mesh.barycenters])
    normals = np.concatenate([mesh.vertex_normals, mesh.face_normals])
    covered = np.isin(mesh.face_components, mesh.face_components[curves.faces])
    asked = np.concatenate([covered[_a_face(mesh.faces, mesh.n_vertices)], covered])
    distance = np.zeros(len(points))
    distance[asked], owner = nearest_curves(curves, points[asked], normals[asked])
    far = distance > limit * weave.ribbons.spacing
    if not far.any():
        return []
    # Vertices and faces that touch, faces as points after the vertices.
    face = mesh.n_vertices + np.repeat(np.arange(mesh.n_faces), 3)
    links = np.concatenate([np.stack([face, mesh.faces.ravel()], axis=1), mesh.edges])
    links = links[far[links].all(axis=1)]
    graph = sparse.coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(len(points),) * 2)
    label = csgraph.connected_components(graph, directed=False)[1][far]
    inside = np.flatnonzero(far)
    order = np.lexsort((inside, -distance[inside], label))
    middle = inside[order[np.unique(label[order], return_index=True)[1]]]
    ribbon = np.full(len(points), -1)
    ribbon[asked] = owner
    values = distance[middle] * weave.placement.scale
    return places(weave, "gap", points[middle], [(c,) for c in ribbon[middle].tolist()], values, False)


def _a_face(faces: Indices, count: int) -> Indices:
    """(V,) one of the faces at each vertex."""
    found = np.zeros(count, dtype=np.int64)
    found[faces.ravel()] = np.repeat(np.arange(len(faces)), 3)
    return found


def bare_components(weave: Weave) -> list[Place]:
    """Components of the surface on which no ribbon lies."""
    mesh = weave.mesh
    part = mesh.face_components
    area = np.zeros(mesh.n_components)
    np.add.at(area, part, mesh.face_areas)
    bare = np.setdiff1d(part, part[weave.ribbons.curves.faces])
    # A face of the component, so that the place is on the surface.
    first = np.unique(part, return_index=True)[1][bare]
    values = area[bare] * weave.placement.scale**2
    return places(weave, "bare_component", mesh.barycenters[first], [()] * len(bare), values, False)
