"""Where and in which direction a surface bends most, as a number on every face (Section 5.1).

An N-RoSy that is as smooth as possible may be rotated by one common angle. This is what decides that angle.
"""

from __future__ import annotations

import numpy as np

from geoweave.arrays import Complexes, Scalars
from geoweave.surface import TriMesh

FOLD = np.pi
"""Angle at a boundary edge: there the surface is taken to be folded back on itself."""


def bending_directions(mesh: TriMesh) -> Complexes:
    """Find the direction in which each face bends most, and how much.

    The second fundamental form of a face is ``II = 1/A sum over its sides of beta |e| n n' / 2``, beta the
    angle by which the normals of both faces differ, positive where the edge is convex, and n the direction
    across the edge. With its eigenvalues k1 and k2 and the angle a of the first eigenvector, the product of
    ``k1 + k2`` and ``(k1 - k2) exp(2ia)`` is ``(k1^2 - k2^2) exp(2ia)``: the same whichever side of the
    surface is outside and whichever eigenvalue comes first.

    A boundary edge counts as one at which the surface is folded back: ``beta = pi``.

    Parameters
    ----------
    mesh : any surface

    Returns
    -------
    (F,) complex: as argument twice the angle of the direction of largest bending in the frame of the face, as
        modulus ``sqrt |k1^2 - k2^2|``, 1 / length; zero where all directions bend alike

    Examples
    --------
    >>> torus = gw.shapes.torus(major=1.0, minor=0.4, faces=2_000)
    >>> around = torus.planar(np.cross([0.0, 0.0, 1.0], torus.barycenters))  # the long way
    >>> bends = gw.fields.bending_directions(torus)
    >>> bool(np.mean(np.real(bends * np.conj(around) ** 2)) < 0)  # it bends most across that
    True
    """
    sides = mesh.halfedge_vectors
    across = 1j * sides
    amount = 0.5 * _dihedral_angles(mesh)[mesh.face_edges] / mesh.face_areas[:, None]
    length = np.abs(sides)
    trace = (amount * length).sum(axis=1)
    traceless = (amount * across**2 / length).sum(axis=1)
    squared = trace * traceless
    size = np.abs(squared)
    return np.asarray(squared / np.sqrt(np.where(size > 0, size, 1.0)))


def bending_power(mesh: TriMesh, degree: int) -> tuple[Complexes, Scalars]:
    """Return what an N-RoSy is compared with that is to lie where the surface bends least.

    For even N the N-th power of the directions of least bending; they are known but for a half turn, which it
    forgets. For odd N the power is one less, times the direction from the centre of the component.

    Parameters
    ----------
    mesh : any surface
    degree : N >= 1

    Returns
    -------
    powers : (F,) complex, of modulus 1, or 0 where there is no such direction
    weights : (F,) how much more it bends across them, 1 / length

    Examples
    --------
    >>> cone = gw.shapes.cone(faces=800)
    >>> powers, weights = gw.fields.bending_power(cone, 6)
    >>> bool(np.abs(np.abs(powers[weights > 0]) - 1).max() < 1e-12)
    True
    """
    bends = bending_directions(mesh)
    weights = np.abs(bends)
    powers = _direction(-bends) ** (degree // 2)
    if degree % 2:
        centers = np.stack([mesh.component_means(x) for x in mesh.barycenters.T], axis=1)
        powers = powers * _direction(mesh.planar(mesh.barycenters - centers[mesh.face_components]))
    return powers, weights


def _direction(values: Complexes) -> Complexes:
    """Numbers of modulus 1; zero stays zero."""
    size = np.abs(values)
    return np.asarray(np.where(size > 0, values / np.where(size > 0, size, 1.0), 0.0))


def _dihedral_angles(mesh: TriMesh) -> Scalars:
    """(E,) angle between the normals of the faces of each edge, positive where convex, radians."""
    angles = np.full(mesh.n_edges, FOLD)
    inner = mesh.interior_edges
    i, j = mesh.edge_faces[inner].T
    first, second = mesh.face_normals[i], mesh.face_normals[j]
    along = mesh.edge_vectors[inner] / mesh.edge_lengths[inner][:, None]
    sine = np.einsum("ex,ex->e", np.cross(first, second), along)
    angles[inner] = np.arctan2(sine, np.einsum("ex,ex->e", first, second))
    return angles
