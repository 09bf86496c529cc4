"""Steps that minimise Eq. 8 and the energy of the phase together, and the order in which they are made."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from geoweave.arrays import Scalars
from geoweave.fields import FaceField, Triples
from geoweave.foliation.integrability import vertices_and_faces
from geoweave.foliation.phase_energy import PhaseEnergy
from geoweave.foliation.theta_and_s import Alternation, HeldMean, JointModel
from geoweave.sparse import Assembly, Factorization, Ordering, Reused

ETA = 3.0
"""Weight of frequencies that do not fit together, beside Eq. 8."""

FITTING, FITTING_AGAIN = 4, 1
"""Steps with eta alone: from the first eigenvector, and from the one at the s that they found."""

STIFFEST = 30.0
"""The last kappa, times Eq. 8 per area: phi is then off by about ``sqrt(2 / 30)``, 15 degrees."""

MOST = 1.0
"""The last kappa is at most as large: beyond, level sets leave their field for the phase."""

SOFTEST = 1.0 / 30.0
"""The first kappa, as a share of the last. A stiff start stops in domains of phi = 0 and phi = pi."""

STIFFENING = 5
"""Steps from the first kappa to the last."""

OFF = 0.35
"""Radians, 20 degrees, by which m phi / 2 may be off: two crossings are 0.3 spacings apart at 43 degrees."""

EMPHASIS, MOST_EMPHASIS, EMPHASES = 3.0, 9.0, 3
"""Factor on kappa where phi is off by more, the most that it comes to, and how many steps raise it."""


NEARNESS, SOLVES = 1e-11, 25
"""What is left of a joint step, as a share, and the most solves that this takes with its own factors.

Steps solved for to a tenth ended at other minima when the vertices had other numbers, and at worse ones
(DEVIATIONS.md, exact-steps).
"""


class RegularSteps(Alternation):
    """The joint step of Eq. 8 with the energy of the phase in it.

    The unknowns are those of Eq. 8; vertices, and faces, over one place are coupled.

    Parameters
    ----------
    field, first, unit, smoothness : as for `Alternation`
    ordering : of `vertices_and_faces` with the places of the triples, made here if not given
    triples : on the surface of the field
    """

    def __init__(
        self,
        field: FaceField,
        first: Scalars,
        unit: Scalars,
        smoothness: float,
        ordering: Ordering | None,
        triples: Triples,
    ) -> None:
        ordering = ordering or vertices_and_faces(field.mesh, triples.places)
        super().__init__(field, first, unit, smoothness, ordering)
        self.phase = PhaseEnergy(field, unit, triples)
        self.held = HeldMean(field.mesh, triples.groups)
        self._reused = Reused(ordering, nearness=NEARNESS, steps=SOLVES, soft=self.systems.constants())

    @cached_property
    def _assembly(self) -> Assembly:
        rows, columns = self.systems.joint_places
        more = self.phase.places
        size = self.mesh.n_vertices + self.mesh.n_faces
        return Assembly(np.concatenate([*rows, more[0]]), np.concatenate([*columns, more[1]]), size)

    def _factors(self, convex: Scalars, weights: Scalars, free: Scalars) -> Factorization:
        entries = self.systems.joint_entries(convex, free) + self.phase.entries(weights, free)
        return self._reused.of(self._assembly(np.concatenate(entries)), anew=True)

    def objective(self, theta: Scalars, s: Scalars) -> float:
        """What the joint step lowers: Eq. 8 and the energy of the phase."""
        return self.energy(theta, s) + self.phase(theta, s / self.unit)

    def joint_model(self, theta: Scalars, s: Scalars) -> JointModel:
        """The convex model of the objective near a theta and an s."""
        convex, in_theta, in_share = self.energy.model(theta, s)
        weights, more_theta, more_share = self.phase.model(theta, s / self.unit)
        return JointModel(
            in_theta + more_theta, in_share + more_share, lambda free: self._factors(convex, weights, free)
        )


def regular_course(problem: RegularSteps, s: Scalars, seed: int) -> Iterator[tuple[Scalars, Scalars]]:
    """Find theta and s of three families that form a kagome where they can.

    First eta alone brings the frequencies together, so that phi does not drift; theta is found anew at the s
    of these steps. Then kappa grows, from a thirtieth of its last value, which follows from Eq. 8 as it
    stands by then: the worse the level sets fit their field, as in coarse weaves, the stiffer the phase. At
    last it grows where phi is still off by so much that crossings come near each other, and nowhere else:
    that bends ribbons less than a kappa that is large everywhere.

    Parameters
    ----------
    problem : the steps
    s : the first s
    seed : of the first eigenvector

    Yields
    ------
    theta, s at the start and after each step
    """
    phase = problem.phase
    z, theta = problem.eigenvector(problem.start(seed), None, s)
    yield theta, s
    phase.kappa, phase.eta = 0.0, ETA
    for number in range(FITTING + FITTING_AGAIN):
        if number == FITTING:
            # Taken whatever it costs in Eq. 8: it does not remember the s that did not fit together.
            z, theta = problem.eigenvector(z, None, s)
        theta, s = problem.improve_both(theta, s)
        yield theta, s
    theta = phase.aligned(theta)
    last = min(MOST, STIFFEST * problem.energy(theta, s) / float(problem.mesh.face_areas.sum()))
    for kappa in last * np.geomspace(SOFTEST, 1.0, STIFFENING):
        phase.kappa = float(kappa)
        theta, s = problem.improve_both(theta, s)
        yield theta, s
    for _ in range(EMPHASES):
        off = np.abs(phase.phase(theta)) > 2.0 * OFF / phase.triples.ribbons
        raised = np.minimum(EMPHASIS * phase.emphasis, MOST_EMPHASIS)
        phase.emphasis = np.where(off, raised, phase.emphasis)
        theta, s = problem.improve_both(theta, s)
        yield theta, s
