"""Normals at points of a surface that change smoothly from face to face."""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Indices, Vectors, cross
from geoweave.surface.mesh import TriMesh

SMALLEST_SHARE = 1e-300
"""Added to barycentric shares, length^2: keeps their sum from being zero."""

CANCELLED = 1e-9
"""Vertex normals cancel where their mean is shorter than this; the normal of the face takes its place."""


def smooth_normals(surface: TriMesh, points: Vectors, faces: Indices) -> Vectors:
    """Interpolate the vertex normals at points of faces.

    Normals of faces jump at every edge. A ribbon that followed them would be bent edgewise in every joint.

    Parameters
    ----------
    surface : the surface
    points : (N, 3) points on it
    faces : (N,) the face of each point

    Returns
    -------
    (N, 3) unit normals

    See Also
    --------
    TriMesh.face_normals, TriMesh.vertex_normals : one normal per face or vertex

    Examples
    --------
    >>> sphere = gw.shapes.sphere(faces=800)
    >>> normals = gw.surface.smooth_normals(sphere, sphere.barycenters, np.arange(sphere.n_faces))
    >>> outward = sphere.barycenters / np.linalg.norm(sphere.barycenters, axis=1)[:, None]
    >>> bool(((normals * outward).sum(axis=1) > 0.999).all())
    True
    """
    corners = surface.vertices[surface.faces[faces]]
    normal = surface.face_normals[faces]
    shares = np.stack(
        [
            (normal * cross(corners[:, (k + 1) % 3] - points, corners[:, (k + 2) % 3] - points)).sum(axis=1)
            for k in range(3)
        ],
        axis=1,
    )
    shares = np.maximum(shares, 0.0) + SMALLEST_SHARE
    normals = (shares[:, :, None] * surface.vertex_normals[surface.faces[faces]]).sum(axis=1)
    size = np.linalg.norm(normals, axis=1)[:, None]
    usable = size > CANCELLED * shares.sum(axis=1)[:, None]
    return np.where(usable, normals / np.maximum(size, SMALLEST_SHARE), normal)
