"""The linear systems of Eq. 8, assembled from the weights of half-edges and factored (Section 4.2.4).

There are four kinds: theta alone, real; theta as a complex number z; the same in real and imaginary parts
where values change sign; theta and s together. The places of their entries are found once per surface.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy import sparse

from geoweave.arrays import Indices, Scalars
from geoweave.foliation.integrability import vertices_and_faces
from geoweave.foliation.theta_energy import ThetaEnergy
from geoweave.sparse import Analysis, Assembly, Factorization, Ordering, Reused, analysed, factorized

DEFINITE = 1e-7
"""Share of the mean diagonal that is added to it: a constant theta has no energy."""


class ThetaSystems:
    """The matrices of Eq. 8 on one surface and their factors.

    Parameters
    ----------
    eq8 : the energy
    ordering : of `vertices_and_faces`, made here if not given
    """

    def __init__(self, eq8: ThetaEnergy, ordering: Ordering | None = None) -> None:
        mesh = eq8.mesh
        self.eq8, self.mesh = eq8, mesh
        mass = np.repeat(mesh.face_areas / eq8.unit**2, 3) / 3.0
        self.mass: Scalars = np.bincount(mesh.faces.ravel(), mass, mesh.n_vertices).astype(np.float64)
        self.twisted = bool((eq8.ends.between < 0).any())
        # What no edge crosses, no edge of the vertices alone or of the faces alone crosses either.
        self.ordering = vertices_and_faces(mesh) if ordering is None else ordering
        self.vertex_ordering = self.ordering.of(np.arange(mesh.n_vertices))
        self.face_ordering = self.ordering.of(mesh.n_vertices + np.arange(mesh.n_faces))
        self._analyses: dict[Assembly, Analysis] = {}
        # From step to step the weights change little, so that factors serve several of them.
        self.joint_reused = Reused(self.ordering, soft=self.constants())

    def constants(self) -> sparse.csr_array:
        """(V + F, components) theta that is constant on one component: it has no energy."""
        component, n = self.mesh.vertex_components, self.mesh.n_vertices
        shape = n + self.mesh.n_faces, self.mesh.n_components
        return sparse.csr_array((np.ones(n), (np.arange(n), component)), shape=shape)

    # -- where the entries are --------------------------------------------------------------------------

    @cached_property
    def _vertices(self) -> Assembly:
        """Each half-edge in both directions, and the diagonal."""
        n, ends = self.mesh.n_vertices, self.eq8.ends
        rows = np.concatenate([ends.head, ends.tail, np.arange(n)])
        return Assembly(rows, np.concatenate([ends.tail, ends.head, np.arange(n)]), n)

    @cached_property
    def _doubled(self) -> Assembly:
        """The same in real and imaginary parts: a block of four for each half-edge and direction."""
        n, ends = self.mesh.n_vertices, self.eq8.ends
        rows = (2 * ends.head[:, None] + [0, 0, 1, 1]).ravel()
        columns = (2 * ends.tail[:, None] + [0, 1, 0, 1]).ravel()
        diagonal = np.arange(2 * n)
        return Assembly(
            np.concatenate([rows, columns, diagonal]), np.concatenate([columns, rows, diagonal]), 2 * n
        )

    @cached_property
    def joint_places(self) -> tuple[list[Indices], list[Indices]]:
        """Rows and columns of `joint_entries`.

        Those of the vertices, each corner in both directions, the Laplacian of faces, its diagonal.
        """
        mesh, n, ends = self.mesh, self.mesh.n_vertices, self.eq8.ends
        corner, face = mesh.faces.ravel(), n + np.repeat(np.arange(mesh.n_faces), 3)
        i, j = (n + each for each in self._pairs)
        vertex, diagonal = np.arange(n), n + np.arange(mesh.n_faces)
        rows = [ends.head, ends.tail, vertex, corner, face, i, diagonal]
        columns = [ends.tail, ends.head, vertex, face, corner, j, diagonal]
        return rows, columns

    @cached_property
    def _joint(self) -> Assembly:
        rows, columns = self.joint_places
        return Assembly(
            np.concatenate(rows), np.concatenate(columns), self.mesh.n_vertices + self.mesh.n_faces
        )

    @cached_property
    def _pairs(self) -> tuple[Indices, Indices]:
        """Rows and columns of the entries of the Laplacian of faces."""
        rows = np.repeat(np.arange(self.mesh.n_faces), np.diff(self.eq8.laplacian.indptr))
        return rows, np.asarray(self.eq8.laplacian.indices)

    def _diagonal(self, weight: Scalars) -> Scalars:
        """(V,) sum of the weights (3F,) at each vertex, made definite."""
        n, ends = self.mesh.n_vertices, self.eq8.ends
        diagonal = np.bincount(ends.head, weight, n) + np.bincount(ends.tail, weight, n)
        shift = DEFINITE * float(diagonal.mean()) * self.mass / float(self.mass.mean())
        return np.asarray(diagonal + shift)

    def _factorized(self, pattern: Assembly, matrix: sparse.csr_array, ordering: Ordering) -> Factorization:
        if pattern not in self._analyses:
            self._analyses[pattern] = analysed(matrix, ordering)
        return factorized(matrix, self._analyses[pattern])

    # -- the systems ------------------------------------------------------------------------------------

    def turned(self, s: Scalars) -> sparse.csr_array:
        """``sum weight |u_b - exp(i s w-perp . e) u_a|^2``, u = z or its conjugate as the corner's sign says.

        Hermitian in z, (V, V), where all signs agree; otherwise a real matrix (2V, 2V), as it couples z to
        the conjugates of its neighbours too.
        """
        eq8, weight = self.eq8, self.eq8.weight.ravel()
        turn = weight * np.exp(1j * eq8.ends.head_sign * (s[:, None] * eq8.along).ravel())
        diagonal = self._diagonal(weight)
        if not self.twisted:
            return self._vertices(np.concatenate([-turn, -turn.conj(), diagonal]))
        # conj(z_b) c z_a, or conj(z_b) c conj(z_a), in real and imaginary parts.
        between = eq8.ends.between
        parts = [turn.real, -between * turn.imag, turn.imag, between * turn.real]
        blocks = -np.stack(parts, axis=1).ravel()
        return self._doubled(np.concatenate([blocks, blocks, np.repeat(diagonal, 2)]))

    def turned_factors(self, matrix: sparse.csr_array) -> Factorization:
        """Factors of a matrix of `turned`."""
        if self.twisted:
            return self._factorized(self._doubled, matrix, self.vertex_ordering.repeated(2))
        return factorized(matrix, self.vertex_ordering)

    def theta_factors(self, convex: Scalars) -> Factorization:
        """Factors of the model in theta alone, from its weights (F, 3)."""
        off = -self.eq8.ends.between * convex.ravel()
        matrix = self._vertices(np.concatenate([off, off, self._diagonal(convex.ravel())]))
        return self._factorized(self._vertices, matrix, self.vertex_ordering)

    def joint_entries(self, convex: Scalars, free: Scalars) -> list[Scalars]:
        """Entries of the model in theta and ``s / shat`` together; a face with ``free = 0`` keeps its s."""
        eq8 = self.eq8
        off = -eq8.ends.between * convex.ravel()
        mixed = convex * eq8.slope
        at_corner = self.mesh.bundle.corners * (mixed[:, [2, 0, 1]] - mixed[:, [1, 2, 0]])
        cross = (free[:, None] * at_corner).ravel()
        i, j = self._pairs
        lower = eq8.smoothness * eq8.laplacian.data * free[i] * free[j]
        # A face that keeps its s keeps its diagonal too, so that factors serve other sets of free faces.
        diagonal = (convex * eq8.slope**2).sum(axis=1)
        return [off, off, self._diagonal(convex.ravel()), cross, cross, lower, diagonal]

    def joint_factors(self, convex: Scalars, free: Scalars) -> Factorization:
        """Factors of the model of `joint_entries`."""
        return self.joint_reused.of(self._joint(np.concatenate(self.joint_entries(convex, free))))

    @cached_property
    def s_alone(self) -> tuple[sparse.csr_array, Factorization]:
        """The model in ``s / shat`` alone, the same at every theta, and its factors."""
        eq8 = self.eq8
        stiffness = (eq8.weight * eq8.slope**2).sum(axis=1)
        matrix = sparse.csr_array(sparse.diags_array(stiffness) + eq8.smoothness * eq8.laplacian)
        return matrix, factorized(matrix, self.face_ordering)
