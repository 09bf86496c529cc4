"""Derivatives of a face field, fitted to the neighbours of each face, for both comparison fields."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from geoweave.arrays import Complexes
from geoweave.surface import TriMesh


@dataclass(frozen=True, eq=False)
class Derivatives:
    """``u(c_f + z) = u_f + p z + q conj(z)``, fitted to the neighbours across the edges of each face.

    The neighbours are unfolded into the plane of the face and their vectors transported into it; p and q are
    the least squares solution. It is exact on linear fields of the plane. A face with one neighbour only
    does not determine it and gets zeros, in the misfit too.

    Attributes
    ----------
    p, q : (F, F) complex, acting on (F,) complex fields: the derivatives by z and by conj(z)
    misfit : (3F, F) complex: what the fit leaves of the difference to each neighbour
    """

    p: sparse.csr_array
    q: sparse.csr_array
    misfit: sparse.csr_array

    @classmethod
    def fitted(cls, mesh: TriMesh) -> Derivatives:
        """Fit the derivatives on every face of a mesh."""
        count = mesh.n_faces
        known = mesh.face_neighbors >= 0
        known &= known.sum(axis=1, keepdims=True) > 1
        turn, offset = (np.where(known, each, 0.0) for each in _unfolded(mesh))
        inverse = np.linalg.pinv(np.stack([offset, offset.conj()], axis=2))
        faces, sides = np.repeat(np.arange(count), 3), np.arange(3 * count)
        rows = np.concatenate([sides, sides])
        columns = np.concatenate([np.where(known, mesh.face_neighbors, 0).ravel(), faces])
        entries = np.concatenate([turn.ravel(), -known.ravel().astype(np.float64)])
        differences = sparse.csr_array((entries, (rows, columns)), shape=(3 * count, count))
        p, q = (
            sparse.csr_array((inverse[:, k].ravel(), (faces, sides)), shape=(count, 3 * count)) @ differences
            for k in (0, 1)
        )
        along, mirrored = (
            sparse.csr_array((way.ravel(), (sides, faces)), shape=(3 * count, count))
            for way in (offset, offset.conj())
        )
        return cls(p, q, sparse.csr_array(differences - along @ p - mirrored @ q))


def _unfolded(mesh: TriMesh) -> tuple[Complexes, Complexes]:
    """(F, 3) transport from each neighbour into the face, and the way to its unfolded centre; else 0."""
    sides = mesh.halfedge_vectors
    # From the middle of a side to the centre of its face: a third of the way to the opposite corner.
    inward = ((sides[:, [1, 2, 0]] - sides[:, [2, 0, 1]]) / 6.0).ravel()
    turn, offset = np.zeros((2, 3 * mesh.n_faces), dtype=np.complex128)
    along, against = mesh.edge_halfedges[mesh.interior_edges].T
    turn[along], turn[against] = mesh.transport.conj(), mesh.transport
    offset[along] = turn[along] * inward[against] - inward[along]
    offset[against] = turn[against] * inward[along] - inward[against]
    return turn.reshape(-1, 3), offset.reshape(-1, 3)
