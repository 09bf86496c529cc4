"""Values of faces as a picture shows them without the grain of the mesh."""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Scalars
from geoweave.errors import RenderError
from geoweave.surface import TriMesh


def at_vertices(mesh: TriMesh, values: Scalars) -> Scalars:
    """Average face values at the vertices, ``sum A_i v_i / sum A_i`` over the faces i round each.

    Parameters
    ----------
    mesh : the surface
    values : (F,) one value a face; faces without one (not a number) are left out

    Returns
    -------
    (V,) averages; not a number where no face round a vertex has a value

    Raises
    ------
    RenderError
        If there is not one value a face.
    """
    if values.shape != (mesh.n_faces,):
        raise RenderError(f"values of faces need shape ({mesh.n_faces},), not {values.shape}")
    weights = np.where(np.isnan(values), 0.0, mesh.face_areas)
    corners = mesh.faces.ravel()
    total = np.bincount(corners, np.repeat(np.nan_to_num(values) * weights, 3), mesh.n_vertices)
    weight = np.bincount(corners, np.repeat(weights, 3), mesh.n_vertices)
    return np.where(weight > 0, total / np.where(weight > 0, weight, 1.0), np.nan)


def smoothed(mesh: TriMesh, values: Scalars) -> Scalars:
    """Average face values at the vertices, and give each face the mean of its three corners.

    The curl of a discrete field jumps from face to face (Appendix B.1): neighbours in a row of triangles see
    the same jump from two sides. The averages show what is left over a ring of faces.

    Parameters
    ----------
    mesh : the surface
    values : (F,) one value a face

    Returns
    -------
    (F,) averages

    Raises
    ------
    RenderError
        If there is not one value a face.

    Examples
    --------
    >>> disk = gw.shapes.disk(faces=600)
    >>> grain = np.where(np.arange(disk.n_faces) % 2, 1.0, -1.0)
    >>> bool(np.std(viz.smoothed(disk, grain)) < 0.5 * np.std(grain))
    True
    """
    return np.asarray(at_vertices(mesh, values)[mesh.faces].mean(axis=1))
