"""The steps that minimise Eq. 8 in turns: theta alone, theta and s together, s alone (Section 4.2.4)."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np
from scipy import sparse

from geoweave.arrays import Complexes, Indices, Scalars
from geoweave.fields import FaceField, as_complex, as_real, face_laplacian
from geoweave.foliation.circle_function import wrapped
from geoweave.foliation.integrability import perpendicular, vertices_and_faces
from geoweave.sparse import (
    Analysis,
    Assembly,
    Factorization,
    Ordering,
    analysed,
    bounded_minimum,
    factorized,
)
from geoweave.surface import TriMesh

__all__ = ["Alternation", "along_edges"]

EIGENVALUE_TOLERANCE = 1e-4
"""Relative change of the smallest eigenvalue at which inverse iteration ends."""

LEAST_COTANGENT = 0.02
"""Floor of the cotangent weights: half the cotangent of an angle of 88 degrees."""

LEAST_COSINE = 0.1
"""The quadratic model of ``1 - cos`` stays at least so convex."""

FLOOR = 0.2
"""s stays above this share of its first value."""


def along_edges(field: FaceField) -> Scalars:
    """(F, 3) ``w-perp . e`` on the half-edge opposite each corner."""
    return np.asarray((perpendicular(field).conj()[:, None] * field.mesh.halfedge_vectors).real)


def _cotangents(mesh: TriMesh) -> Scalars:
    """(F, 3) half the cotangent of each corner, the weight of the half-edge opposite, kept positive."""
    h = mesh.halfedge_vectors
    at_corner = -(h[:, [1, 2, 0]].conj() * h[:, [2, 0, 1]]).real
    return np.maximum(at_corner / (4.0 * mesh.face_areas[:, None]), LEAST_COTANGENT)


class Alternation:
    """The steps of Eq. 8 on one surface, with what they share: weights, patterns, the factors for s alone.

    Where no loop of a component has a period, theta and s can shrink together and lower Eq. 8 without end.
    There the mean of ``s / shat`` is held (DEVIATIONS.md, held-mean).

    Parameters
    ----------
    field : the unit field w
    first : (F,) the first s, which bounds the others from below
    unit : (F,) shat, the unit in which Eq. 8 measures s
    smoothness : mu, unit length^2
    ordering : of `vertices_and_faces`, made here if not given
    """

    def __init__(
        self,
        field: FaceField,
        first: Scalars,
        unit: Scalars,
        smoothness: float,
        ordering: Ordering | None = None,
    ) -> None:
        mesh = field.mesh
        self.mesh, self.unit, self.smoothness = mesh, unit, smoothness
        self.least = FLOOR * first / unit
        self.along = along_edges(field)
        self.slope = unit[:, None] * self.along
        self.weight = _cotangents(mesh) / unit[:, None] ** 2
        self.tail, self.head = mesh.faces[:, [1, 2, 0]].ravel(), mesh.faces[:, [2, 0, 1]].ravel()
        self.tail_sign = mesh.bundle.corners[:, [1, 2, 0]].ravel()
        self.head_sign = mesh.bundle.corners[:, [2, 0, 1]].ravel()
        self.between = self.tail_sign * self.head_sign
        self.twisted = bool((self.between < 0).any())
        mass = np.repeat(mesh.face_areas / unit**2, 3) / 3.0
        self.mass = np.bincount(mesh.faces.ravel(), mass, mesh.n_vertices)
        self.component = mesh.vertex_components
        self.free = mesh.bundle.betti_numbers == 0
        areas = mesh.face_areas / np.bincount(mesh.face_components, mesh.face_areas)[mesh.face_components]
        self.share_of_area = np.where(self.free[mesh.face_components], areas, 0.0)
        self.laplacian = face_laplacian(mesh)
        # What no edge crosses, no edge of the vertices alone or of the faces alone crosses either.
        ordering = vertices_and_faces(mesh) if ordering is None else ordering
        self.joint_ordering = ordering
        self.vertex_ordering = ordering.of(np.arange(mesh.n_vertices))
        self.face_ordering = ordering.of(mesh.n_vertices + np.arange(mesh.n_faces))
        self._analyses: dict[Assembly, Analysis] = {}

    def start(self, seed: int) -> Complexes:
        """A first z for `eigenvector`."""
        noise = np.random.default_rng(seed).normal(size=(2, self.mesh.n_vertices))
        return np.asarray(noise[0] + 1j * noise[1])

    def residual(self, theta: Scalars, s: Scalars) -> Scalars:
        """(F, 3) ``theta_b - theta_a - s_i w-perp_i . e_ab``, radians, any representative."""
        rise = self.head_sign * theta[self.head] - self.tail_sign * theta[self.tail]
        return np.asarray(rise.reshape(-1, 3) - s[:, None] * self.along)

    def energy(self, theta: Scalars, s: Scalars) -> float:
        """Eq. 8, in the unit that `geoweave.foliation.foliation.foliate` says."""
        share = s / self.unit
        smooth = 0.5 * self.smoothness * share @ (self.laplacian @ share)
        return float((self.weight * (1.0 - np.cos(self.residual(theta, s)))).sum() + smooth)

    def theta_change(self, before: Scalars, after: Scalars) -> float:
        """Root mean square change of theta, after the best constant on each component: 0 or pi if twisted."""
        turn = np.exp(1j * (after - before)) * self.mass
        mean = np.bincount(self.component, turn.real) + 1j * np.bincount(self.component, turn.imag)
        mean = np.where(self.mesh.bundle.twisted_components, mean.real, mean)
        left = wrapped(after - before - np.angle(mean)[self.component])
        return float(np.sqrt(np.average(left**2, weights=self.mass)))

    @cached_property
    def _vertices(self) -> Assembly:
        """Each half-edge in both directions, and the diagonal."""
        n = self.mesh.n_vertices
        rows = np.concatenate([self.head, self.tail, np.arange(n)])
        return Assembly(rows, np.concatenate([self.tail, self.head, np.arange(n)]), n)

    @cached_property
    def _doubled(self) -> Assembly:
        """The same in real and imaginary parts: a block of four for each half-edge and direction."""
        n = self.mesh.n_vertices
        rows = (2 * self.head[:, None] + [0, 0, 1, 1]).ravel()
        columns = (2 * self.tail[:, None] + [0, 1, 0, 1]).ravel()
        diagonal = np.arange(2 * n)
        return Assembly(
            np.concatenate([rows, columns, diagonal]), np.concatenate([columns, rows, diagonal]), 2 * n
        )

    @cached_property
    def _joint(self) -> Assembly:
        """Those of the vertices, each corner in both directions, the Laplacian of faces, its diagonal."""
        mesh, n = self.mesh, self.mesh.n_vertices
        corner, face = mesh.faces.ravel(), n + np.repeat(np.arange(mesh.n_faces), 3)
        i, j = (n + each for each in self._pairs)
        vertex, diagonal = np.arange(n), n + np.arange(mesh.n_faces)
        rows = [self.head, self.tail, vertex, corner, face, i, diagonal]
        columns = [self.tail, self.head, vertex, face, corner, j, diagonal]
        return Assembly(np.concatenate(rows), np.concatenate(columns), n + mesh.n_faces)

    @cached_property
    def _pairs(self) -> tuple[Indices, Indices]:
        """Rows and columns of the entries of the Laplacian of faces."""
        rows = np.repeat(np.arange(self.mesh.n_faces), np.diff(self.laplacian.indptr))
        return rows, np.asarray(self.laplacian.indices)

    def _diagonal(self, weight: Scalars) -> Scalars:
        """(V,) sum of the weights (3F,) at each vertex, made definite."""
        n = self.mesh.n_vertices
        diagonal = np.bincount(self.head, weight, n) + np.bincount(self.tail, weight, n)
        # A constant is in the kernel of the real matrix, and nearly in that of the Hermitian one.
        shift = 1e-7 * float(diagonal.mean()) * self.mass / float(self.mass.mean())
        return np.asarray(diagonal + shift)

    def turned(self, s: Scalars) -> sparse.csr_array:
        """``sum weight |u_b - exp(i s w-perp . e) u_a|^2``, u = z or its conjugate as the corner's sign says.

        Hermitian in z, (V, V), where all signs agree; otherwise a real matrix (2V, 2V), as it couples z to
        the conjugates of its neighbours too.
        """
        weight = self.weight.ravel()
        turn = weight * np.exp(1j * self.head_sign * (s[:, None] * self.along).ravel())
        diagonal = self._diagonal(weight)
        if not self.twisted:
            return self._vertices(np.concatenate([-turn, -turn.conj(), diagonal]))
        # conj(z_b) c z_a, or conj(z_b) c conj(z_a), in real and imaginary parts.
        parts = [turn.real, -self.between * turn.imag, turn.imag, self.between * turn.real]
        blocks = -np.stack(parts, axis=1).ravel()
        return self._doubled(np.concatenate([blocks, blocks, np.repeat(diagonal, 2)]))

    def _factorized(self, pattern: Assembly, matrix: sparse.csr_array, ordering: Ordering) -> Factorization:
        if pattern not in self._analyses:
            self._analyses[pattern] = analysed(matrix, ordering)
        return factorized(matrix, self._analyses[pattern])

    def eigenvector(self, z: Complexes, theta: Scalars | None, s: Scalars) -> tuple[Complexes, Scalars]:
        """Inverse iteration for the smallest eigenvector at s; its angles replace theta if that pays."""
        matrix = self.turned(s)
        if self.twisted:
            factors = self._factorized(self._doubled, matrix, self.vertex_ordering.repeated(2))
        else:
            factors = factorized(matrix, self.vertex_ordering)
        quotient = np.inf
        for _ in range(60):
            right = self.mass * z
            z = as_complex(factors.solve(as_real(right))) if self.twisted else factors.solve(right)
            z = z / np.sqrt(np.bincount(self.component, self.mass * np.abs(z) ** 2))[self.component]
            image = np.asarray(as_complex(matrix @ as_real(z)) if self.twisted else matrix @ z)
            last, quotient = quotient, float((z.conj() @ image).real)
            if last - quotient < EIGENVALUE_TOLERANCE * quotient:
                break
        found = np.angle(z)
        better = theta is None or self.energy(found, s) < self.energy(theta, s)
        return z, found if better or theta is None else theta

    def _model(self, theta: Scalars, s: Scalars) -> tuple[Scalars, Scalars, Scalars]:
        """Convex weights (F, 3) of the quadratic model, the way downhill in theta (V,), in s / shat (F,)."""
        residual, n = self.residual(theta, s), self.mesh.n_vertices
        convex = self.weight * np.maximum(np.cos(residual), LEAST_COSINE)
        pull = self.weight * np.sin(residual)
        in_theta = np.bincount(self.tail, self.tail_sign * pull.ravel(), n)
        in_theta -= np.bincount(self.head, self.head_sign * pull.ravel(), n)
        in_share = (pull * self.slope).sum(axis=1) - self.smoothness * (self.laplacian @ (s / self.unit))
        return convex, np.asarray(in_theta, dtype=np.float64), np.asarray(in_share)

    def improve_theta(self, theta: Scalars, s: Scalars) -> Scalars:
        """One Gauss-Newton step of Eq. 8 in theta alone."""
        convex, in_theta, _ = self._model(theta, s)
        off = -self.between * convex.ravel()
        matrix = self._vertices(np.concatenate([off, off, self._diagonal(convex.ravel())]))
        step = self._factorized(self._vertices, matrix, self.vertex_ordering).solve(in_theta)
        length = _damping(lambda length: self.energy(theta + length * step, s))
        return theta + length * step

    def improve_both(self, theta: Scalars, s: Scalars) -> tuple[Scalars, Scalars]:
        """One Gauss-Newton step of Eq. 8 in theta and s together; s stays above its floor."""
        n, share = self.mesh.n_vertices, s / self.unit
        convex, in_theta, in_share = self._model(theta, s)
        # A face at its floor that would go below it stays where it is.
        free = ((share > self.least * (1 + 1e-9)) | (in_share > 0)).astype(np.float64)
        off = -self.between * convex.ravel()
        mixed = convex * self.slope
        at_corner = self.mesh.bundle.corners * (mixed[:, [2, 0, 1]] - mixed[:, [1, 2, 0]])
        cross = (free[:, None] * at_corner).ravel()
        i, j = self._pairs
        lower = self.smoothness * self.laplacian.data * free[i] * free[j]
        diagonal = (convex * self.slope**2).sum(axis=1) * free + (1.0 - free)
        entries = [off, off, self._diagonal(convex.ravel()), cross, cross, lower, diagonal]
        matrix = self._joint(np.concatenate(entries))
        factors = self._factorized(self._joint, matrix, self.joint_ordering)
        step = factors.solve(np.concatenate([in_theta, free * in_share]))
        if self.free.any():
            mean = free * self.share_of_area
            lift = factors.solve(np.concatenate([np.zeros(n), mean]))
            rise, reach = (self._per_component(mean * each[n:]) for each in (step, lift))
            step = step - self._spread(rise / np.where(reach > 0, reach, 1.0)) * lift

        def at(length: float) -> tuple[Scalars, Scalars]:
            return theta + length * step[:n], self.unit * np.maximum(share + length * step[n:], self.least)

        return at(_damping(lambda length: self.energy(*at(length))))

    @cached_property
    def _alone(self) -> tuple[sparse.csr_array, Factorization]:
        """The quadratic model of Eq. 8 in s alone, the same at every theta, and its factors."""
        stiffness = (self.weight * self.slope**2).sum(axis=1)
        matrix = sparse.csr_array(sparse.diags_array(stiffness) + self.smoothness * self.laplacian)
        return matrix, factorized(matrix, self.face_ordering)

    def _per_component(self, values: Scalars) -> Scalars:
        """Sums of face values over each component."""
        return np.asarray(np.bincount(self.mesh.face_components, values, self.mesh.n_components))

    def _spread(self, values: Scalars) -> Scalars:
        """Values of the components at their vertices, then at their faces."""
        return np.concatenate([values[self.component], values[self.mesh.face_components]])

    def improve_s(self, theta: Scalars, s: Scalars) -> Scalars:
        """One Gauss-Newton step of Eq. 8 in s alone, to the best s above its floor."""
        share = s / self.unit
        matrix, factors = self._alone
        _, _, in_share = self._model(theta, s)
        # The model 1/2 r' K r - (K share + downhill)' r, minimised over r >= least.
        best = bounded_minimum(matrix, factors, matrix @ share + in_share, self.least, share)
        if self.free.any():
            means = [self._per_component(self.share_of_area * each) for each in (share, best)]
            factor = np.where(self.free, means[0] / np.where(self.free, means[1], 1.0), 1.0)
            best = np.maximum(best * factor[self.mesh.face_components], self.least)
        length = _damping(lambda length: self.energy(theta, self.unit * (share + length * (best - share))))
        return np.asarray(self.unit * (share + length * (best - share)))


def _damping(energy: Callable[[float], float]) -> float:
    """Length of a step, halved from 1 until the energy is no higher than at its start; 0 if it never is."""
    before, length = energy(0.0), 1.0
    while length > 1e-3:
        if energy(length) <= before:
            return length
        length *= 0.5
    return 0.0
