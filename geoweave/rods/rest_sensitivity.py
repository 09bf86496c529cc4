"""How a weave at rest moves when its strips are cut longer, or with another curvature.

At rest the forces balance, ``dE/dx (x, q) = 0``, so ``K dx = -d(dE/dx)/dq dq`` for any numbers q of
the strips. K is the second derivative of the energy by vertices and angles x. One factor of K serves all
directions, forwards and, as K is symmetric, backwards (adjoint).

- Natural curvatures k0 enter through the edgewise residuals ``w (k - k0)`` alone: the force is ``J' w dk0``,
  with J the derivative of these residuals by x.
- A rest length l pulls its segment with ``Y w h (|e| - l) / l``, whose derivative by l is
  ``-Y w h |e| / l^2``. Forces of joints are inversely proportional to the rest length of the joint.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geoweave.arrays import Flags, Scalars, Vectors
from geoweave.rods.elastic_energies import GEODESIC, JOINTS, Term, point_unknowns
from geoweave.rods.hessian import Pattern
from geoweave.rods.rods import Rods
from geoweave.rods.steps import Problem

__all__ = ["RestSensitivity"]

SHIFTS = (1e-12, 1e-10, 1e-8, 1e-6)
"""Dampings of K that are tried, as of `geoweave.rods.steps`: the least that makes it positive definite."""


class RestSensitivity:
    """Derivative of the shape at rest by natural curvatures and rest lengths.

    Rigid motions cost no energy, so K is singular by them. Elastic forces have no part along them; a shift of
    K that is far below any stiffness makes it definite and moves the answer by as little.

    Parameters
    ----------
    rods : at rest under the terms
    terms : all energies, the edgewise one among them
    fixed : (3 V + S,) unknowns that do not change
    load : (V, 3) constant force on each vertex
    pattern : of the matrix, if it has been analysed

    Raises
    ------
    RodError
        If the second derivative is not positive definite: the rods are not at rest, or not stably.
    """

    def __init__(
        self,
        rods: Rods,
        terms: Sequence[Term],
        fixed: Flags,
        load: Vectors | None = None,
        pattern: Pattern | None = None,
    ) -> None:
        problem = Problem(rods, tuple(terms), fixed, load, True, pattern)
        now = problem.completed(problem.tried(rods))
        matrix = problem.matrix(now, now.residuals)
        self.solve, self.fixed = problem.stable(matrix, SHIFTS), fixed
        layout, self.joints = rods.layout, rods.layout.joints
        self.ends = point_unknowns(layout.ends)
        pull = rods.material.stretching(rods.widths) * rods.lengths / rods.rest**2
        self.pull = pull[:, None] * np.concatenate([-rods.tangents, rods.tangents], axis=1)
        weight = np.sqrt(rods.material.edgewise(rods.joint_widths) / rods.spans)
        forces = np.zeros((len(self.joints), 11))
        for k, term in enumerate(terms):
            if term.name in JOINTS:
                self.unknowns = term.unknowns
                forces += now.residuals[k] * now.jacobians[k][:, 0]
            if term.name == GEODESIC:
                self.slopes = weight[:, None] * now.jacobians[k][:, 0]
        self.by_span = forces / rods.spans[:, None]

    def moved(self, natural: Scalars, rest: Scalars) -> Scalars:
        """(3 V + S,) change of vertices and angles at rest.

        Parameters
        ----------
        natural : (J,) change of the natural curvatures
        rest : (S,) change of the rest lengths
        """
        span = 0.5 * rest[self.joints].sum(axis=1)
        local = natural[:, None] * self.slopes + span[:, None] * self.by_span
        size = len(self.fixed)
        force = np.zeros(size)
        force += np.bincount(self.unknowns.ravel(), local.ravel(), minlength=size)
        force += np.bincount(self.ends.ravel(), (rest[:, None] * self.pull).ravel(), minlength=size)
        force[self.fixed] = 0.0
        return np.asarray(self.solve(force))

    def pulled(self, slope: Scalars) -> tuple[Scalars, Scalars]:
        """Derivatives by natural curvatures (J,) and rest lengths (S,), from that by the shape (3 V + S,)."""
        answer = self.solve(np.where(self.fixed, 0.0, slope))
        at_joints = answer[self.unknowns]
        by_rest = (answer[self.ends] * self.pull).sum(axis=1)
        by_span = 0.5 * (at_joints * self.by_span).sum(axis=1)
        for side in self.joints.T:
            by_rest += np.bincount(side, by_span, minlength=len(by_rest))
        return (at_joints * self.slopes).sum(axis=1), by_rest
