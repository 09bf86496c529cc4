"""N-RoSys that softly follow a direction or a curve (Section 4.1.2: "alignment to user-prescribed handles").

A guide says which number the RoSy should have on some faces, and how much that counts. It enters the
Dirichlet energy as a penalty, so the RoSy may differ from it where that saves energy.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse

from geoweave.arrays import Complexes, Indices, Scalars, Vectors
from geoweave.errors import FieldError
from geoweave.fields.connected_rosy import ConnectedRoSy, turns_of
from geoweave.fields.face_field import unit
from geoweave.fields.operators import connection_laplacian, face_laplacian, spectral_shift
from geoweave.fields.rosy import RoSyField, smoothest_eigenfield
from geoweave.sparse import factorized, nested_dissection, one_blas_thread
from geoweave.surface import TriMesh, closest_points, triangle_tree

SOFTNESS = 0.1
"""Distance from a guide, in bounding radii, over which the RoSy gives way: the penalty's length."""

ROUNDS = 5
"""Rounds in which the angle to a guide is taken modulo a turn anew; two or three are usual."""

SAMPLES = 4
"""Points taken on each mean edge's length of a curve."""

NEARLY = 0.99
"""Share of the first eigenvalue taken from the energy, so that far from the guide the RoSy is smoothest."""


@dataclass(frozen=True, eq=False)
class Guide:
    """What an N-RoSy is to follow.

    Attributes
    ----------
    mesh : the surface
    degree : N
    values : (F,) the wanted number, the N-th power of a unit vector; any where the weight is zero
    weights : (F,) how much it counts, an area: that of the face for a direction, length times `SOFTNESS`
        bounding radii for a curve
    """

    mesh: TriMesh
    degree: int
    values: Complexes
    weights: Scalars

    @property
    def penalty(self) -> Scalars:
        """(F,) weight of ``|u - values|^2`` beside the Dirichlet energy, a number."""
        return np.asarray(self.weights / (SOFTNESS * self.mesh.bounding_radius) ** 2)

    def deviation(self, vectors: Complexes, faces: Indices | None = None) -> Scalars:
        """(n,) angle between the wanted direction and the nearest of the given vectors (n, k), degrees.

        Parameters
        ----------
        faces : (n,) where the vectors are; all faces if not given
        """
        wanted = self.values if faces is None else self.values[faces]
        apart = np.angle(vectors**self.degree * wanted.conj()[:, None]) / self.degree
        return np.asarray(np.degrees(np.abs(apart)).min(axis=1))


def along_direction(mesh: TriMesh, degree: int, direction: ArrayLike) -> Guide:
    """A guide that has one family follow a direction in space, projected to each face.

    A face counts by its area times the squared length of the projection, so little where it is steep.

    Raises
    ------
    FieldError
        If the direction is zero.
    """
    vector = np.asarray(direction, dtype=np.float64)
    size = float(np.linalg.norm(vector))
    if not size > 0:
        raise FieldError("a direction to align with must not be zero")
    planar = mesh.planar(np.tile(vector / size, (mesh.n_faces, 1)))
    return Guide(mesh, degree, unit(planar) ** degree, mesh.face_areas * np.abs(planar) ** 2)


def along_curve(mesh: TriMesh, degree: int, points: ArrayLike) -> Guide:
    """A guide that has one family follow a polyline on the surface or near it.

    Parameters
    ----------
    points : (n, 3) its corners, n >= 2

    Raises
    ------
    FieldError
        If it has no length.
    """
    corners = np.asarray(points, dtype=np.float64)
    steps = np.diff(corners, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    if not lengths.sum() > 0:
        raise FieldError("a curve to align with needs two points that are apart")
    count = np.maximum(np.ceil(SAMPLES * lengths / mesh.mean_edge).astype(np.int64), 1)
    piece = np.repeat(np.arange(len(steps)), count)
    share = (np.arange(len(piece)) - np.repeat(np.cumsum(count) - count, count) + 0.5) / count[piece]
    samples: Vectors = corners[piece] + share[:, None] * steps[piece]
    _, face = closest_points(triangle_tree(mesh.vertices[mesh.faces]), samples)
    # The frame of a face spans it, so the dot products drop what is normal.
    across = np.einsum("nkx,nx->nk", mesh.frames[face], steps[piece])
    length = lengths[piece] / count[piece]
    values, weights = np.zeros(mesh.n_faces, dtype=np.complex128), np.zeros(mesh.n_faces)
    np.add.at(values, face, length * unit(across[:, 0] + 1j * across[:, 1]) ** degree)
    np.add.at(weights, face, length)
    return Guide(mesh, degree, unit(values), weights * SOFTNESS * mesh.bounding_radius)


@one_blas_thread()
def aligned_rosy(guide: Guide, seed: int | np.random.Generator = 0) -> RoSyField:
    """Find the smoothest N-RoSy that softly follows a guide.

    Solves ``(L - 0.99 mu M + P) u = P q`` and scales to modulus 1: the Dirichlet energy, the penalty P of the
    guide's numbers q, and mu the first eigenvalue of each component. Without the eigenvalue the RoSy would
    fade away from the guide, and turn as it must to fade.

    Parameters
    ----------
    guide : what to follow
    seed : of the first eigenvector

    Examples
    --------
    >>> disk = gw.shapes.disk(faces=400)
    >>> guide = gw.fields.along_curve(disk, 6, [[-0.8, 0.0, 0.0], [0.8, 0.0, 0.0]])
    >>> rosy = gw.fields.aligned_rosy(guide)
    >>> bool(guide.deviation(rosy.vectors)[guide.weights > 0].max() < 0.1)
    True
    """
    mesh, degree = guide.mesh, guide.degree
    energies, _ = smoothest_eigenfield(mesh, seed, degree)
    areas = mesh.face_areas
    penalty = guide.penalty
    laplacian = connection_laplacian(mesh, degree)
    shift = spectral_shift(areas) - NEARLY * np.maximum(energies, 0.0)[mesh.face_components]
    factors = factorized(
        laplacian + sparse.diags_array(shift * areas + penalty), nested_dissection(laplacian)
    )
    return RoSyField(mesh, degree, unit(factors.solve((penalty * guide.values).astype(np.complex128))))


@one_blas_thread()
def aligned_connection(rosy: RoSyField, guide: Guide) -> ConnectedRoSy:
    """Turn an N-RoSy towards a guide without moving its singularities.

    ``argmin sum of weight_ij (phi_j - phi_i)^2 + sum of penalty_i (phi_i - a_i)^2``, a the angle from the
    RoSy to the guide, in the branch that is nearest to phi; then ``u <- u exp(i phi)``.

    Raises
    ------
    FieldError
        If the guide is one of another surface or degree.
    """
    mesh = rosy.mesh
    if guide.mesh is not mesh or guide.degree != rosy.degree:
        raise FieldError("the guide is not one for this RoSy: its surface or its N is another")
    penalty = guide.penalty
    laplacian = face_laplacian(mesh)
    # A component without a guide keeps its angle.
    held = sparse.diags_array(penalty + spectral_shift(mesh.face_areas) * mesh.face_areas)
    factors = factorized(sparse.csr_array(laplacian + held), nested_dissection(laplacian))
    target = np.angle(guide.values * rosy.values.conj())
    common = np.zeros(mesh.n_components, dtype=np.complex128)
    np.add.at(common, mesh.face_components, penalty * np.exp(1j * target))
    phi = np.angle(common)[mesh.face_components]
    for _ in range(ROUNDS):
        nearest = phi + np.angle(np.exp(1j * (target - phi)))
        phi = factors.solve(penalty * nearest + spectral_shift(mesh.face_areas) * mesh.face_areas * phi)
    i, j = mesh.edge_faces[mesh.interior_edges].T
    turns = turns_of(rosy) + phi[j] - phi[i]
    return ConnectedRoSy(mesh, rosy.degree, rosy.values * np.exp(1j * phi), turns)
