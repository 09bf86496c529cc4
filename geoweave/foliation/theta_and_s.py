"""The steps that minimise Eq. 8 in turns: theta alone, theta and s together, s alone (Section 4.2.4)."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from geoweave.arrays import Complexes, Indices, Scalars
from geoweave.fields import FaceField, as_complex, as_real
from geoweave.foliation.circle_function import wrapped
from geoweave.foliation.theta_energy import ThetaEnergy
from geoweave.foliation.theta_systems import ThetaSystems
from geoweave.sparse import Factorization, Ordering, bounded_minimum, smallest_eigenvectors
from geoweave.surface import TriMesh

SETTLED = 1e-12
"""What the eigenvector of theta may leave of its equation, as a share of its eigenvalue.

The next eigenvalue is often only a thousandth larger, and a crude eigenvector leaves it to its start where
ribbons lie (DEVIATIONS.md, theta-start). The steps that follow enlarge what it leaves a thousandfold.
"""

START_NOISE = 1e-3
"""Share of random numbers in the first z, whose other numbers are about 1."""

FLOOR = 0.2
"""s stays above this share of its first value."""

AT_FLOOR = 1e-9
"""A face is at its floor when it is above it by no more than this share."""

SHORTEST = 1e-3
"""A step is halved until the energy does not rise, but not below this share of its length."""


class HeldMean:
    """The condition that keeps theta and s from shrinking together where no loop has a period.

    On a component with first Betti number zero both could shrink and lower Eq. 8 without end. There the area
    mean of ``s / shat`` is held (DEVIATIONS.md, held-mean).

    Parameters
    ----------
    mesh : the surface
    groups : (components,) number of the group of each component, from 0, where those of a group share their
        s; each is a group of its own if not given. The mean is that of a group, and held where none of its
        components has a loop
    """

    def __init__(self, mesh: TriMesh, groups: Indices | None = None) -> None:
        groups = np.arange(mesh.n_components) if groups is None else groups
        self.count = int(groups.max()) + 1
        self.of_face, self.of_vertex = groups[mesh.face_components], groups[mesh.vertex_components]
        self.held = np.bincount(groups, mesh.bundle.betti_numbers, self.count) == 0
        areas = mesh.face_areas / np.bincount(self.of_face, mesh.face_areas)[self.of_face]
        self.share_of_area = np.where(self.held[self.of_face], areas, 0.0)

    def __bool__(self) -> bool:
        return bool(self.held.any())

    def _sums(self, values: Scalars) -> Scalars:
        """Sums of face values over each group."""
        return np.asarray(np.bincount(self.of_face, values, self.count))

    def corrected(self, step: Scalars, factors: Factorization, free: Scalars) -> Scalars:
        """Add to a joint step, (V + F,), what keeps the mean; `factors` are those that it was solved with."""
        n = len(self.of_vertex)
        mean = free * self.share_of_area
        lift = factors.solve(np.concatenate([np.zeros(n), mean]))
        rise, reach = (self._sums(mean * each[n:]) for each in (step, lift))
        amount = rise / np.where(reach > 0, reach, 1.0)
        return step - np.concatenate([amount[self.of_vertex], amount[self.of_face]]) * lift

    def restored(self, share: Scalars, best: Scalars) -> Scalars:
        """Scale the values `best`, (F,), to the means that `share` has."""
        means = [self._sums(self.share_of_area * each) for each in (share, best)]
        factor = np.where(self.held, means[0] / np.where(self.held, means[1], 1.0), 1.0)
        return np.asarray(best * factor[self.of_face])


class JointModel(NamedTuple):
    """A convex quadratic model in theta and s together, and the way downhill from where it was made."""

    in_theta: Scalars
    """(V,) minus the gradient in theta."""
    in_share: Scalars
    """(F,) minus the gradient in ``s / shat``."""
    factors_of: Callable[[Scalars], Factorization]
    """Its factors, where faces with a 0 in an array (F,) keep their s and those with a 1 do not."""


class Alternation:
    """The steps of Eq. 8 on one surface: the energy, its linear systems, and the mean that is held.

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
        self.energy = ThetaEnergy(field, unit, smoothness)
        self.systems = ThetaSystems(self.energy, ordering)
        self.held = HeldMean(field.mesh)
        self.mesh, self.unit = field.mesh, unit
        self.least = FLOOR * first / unit

    def start(self, seed: int) -> Complexes:
        """A first z for `eigenvector`: a standing wave round the centre, as long as the level sets are apart.

        It decides the phase of theta where Eq. 8 leaves that free, and it depends on the surface alone. The
        noise is there for an eigenvector that the wave is orthogonal to.
        """
        mesh, areas = self.mesh, self.mesh.face_areas
        center = np.average(mesh.barycenters, axis=0, weights=areas)
        turning = float(np.average(self.unit, weights=areas))
        wave = np.cos(turning * np.linalg.norm(mesh.vertices - center, axis=1))
        noise = np.random.default_rng(seed).normal(size=(2, mesh.n_vertices))
        return np.asarray(wave + START_NOISE * (noise[0] + 1j * noise[1]))

    def theta_change(self, before: Scalars, after: Scalars) -> float:
        """Root mean square change of theta, after the best constant on each component: 0 or pi if twisted."""
        component, mass = self.mesh.vertex_components, self.systems.mass
        turn = np.exp(1j * (after - before)) * mass
        mean = np.bincount(component, turn.real) + 1j * np.bincount(component, turn.imag)
        mean = np.where(self.mesh.bundle.twisted_components, mean.real, mean)
        left = wrapped(after - before - np.angle(mean)[component])
        return float(np.sqrt(np.average(left**2, weights=mass)))

    def eigenvector(self, z: Complexes, theta: Scalars | None, s: Scalars) -> tuple[Complexes, Scalars]:
        """Find the smallest eigenvector at s, from the last one; its angles replace theta if that pays."""
        component, mass, twisted = self.mesh.vertex_components, self.systems.mass, self.systems.twisted
        factors = self.systems.turned_factors(self.systems.turned(s))
        if twisted:
            groups = np.repeat(component, 2)
            _, found = smallest_eigenvectors(
                factors, np.repeat(mass, 2), as_real(z), groups, tolerance=SETTLED
            )
            z = as_complex(found)
        else:
            _, z = smallest_eigenvectors(factors, mass, z, component, tolerance=SETTLED)
        turned = np.angle(z)
        better = theta is None or self.energy(turned, s) < self.energy(theta, s)
        return z, turned if better or theta is None else theta

    def improve_theta(self, theta: Scalars, s: Scalars) -> Scalars:
        """One Gauss-Newton step of Eq. 8 in theta alone."""
        model = self.energy.model(theta, s)
        step = self.systems.theta_factors(model.weights).solve(model.in_theta)
        length = _damping(lambda length: self.energy(theta + length * step, s))
        return theta + length * step

    def objective(self, theta: Scalars, s: Scalars) -> float:
        """What the joint step lowers: Eq. 8."""
        return self.energy(theta, s)

    def joint_model(self, theta: Scalars, s: Scalars) -> JointModel:
        """The convex model of the objective near a theta and an s."""
        convex, in_theta, in_share = self.energy.model(theta, s)
        return JointModel(in_theta, in_share, lambda free: self.systems.joint_factors(convex, free))

    def improve_both(self, theta: Scalars, s: Scalars) -> tuple[Scalars, Scalars]:
        """One Gauss-Newton step of the objective in theta and s together; s stays above its floor."""
        n, share = self.mesh.n_vertices, s / self.unit
        in_theta, in_share, factors_of = self.joint_model(theta, s)
        # A face at its floor that would go below it stays where it is.
        free = ((share > self.least * (1 + AT_FLOOR)) | (in_share > 0)).astype(np.float64)
        factors = factors_of(free)
        step = factors.solve(np.concatenate([in_theta, free * in_share]))
        if self.held:
            step = self.held.corrected(step, factors, free)

        def at(length: float) -> tuple[Scalars, Scalars]:
            return theta + length * step[:n], self.unit * np.maximum(share + length * step[n:], self.least)

        return at(_damping(lambda length: self.objective(*at(length))))

    def improve_s(self, theta: Scalars, s: Scalars) -> Scalars:
        """One Gauss-Newton step of Eq. 8 in s alone, to the best s above its floor."""
        share = s / self.unit
        matrix, factors = self.systems.s_alone
        in_share = self.energy.model(theta, s).in_share
        # The model 1/2 r' K r - (K share + downhill)' r, minimised over r >= least.
        best = bounded_minimum(matrix, factors, matrix @ share + in_share, self.least, share)
        if self.held:
            best = np.maximum(self.held.restored(share, best), self.least)
        length = _damping(lambda length: self.energy(theta, self.unit * (share + length * (best - share))))
        return np.asarray(self.unit * (share + length * (best - share)))


def _damping(energy: Callable[[float], float]) -> float:
    """Length of a step, halved from 1 until the energy is no higher than at its start; 0 if it never is."""
    before, length = energy(0.0), 1.0
    while length > SHORTEST:
        if energy(length) <= before:
            return length
        length *= 0.5
    return 0.0
