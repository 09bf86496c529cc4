"""One step that lowers the energy of elastic rods (Appendix E).

A step solves a linear system, loses its rigid motion, and is shortened until the energy falls.
`geoweave.rods.equilibrium` repeats steps until the forces balance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Flags, Indices, Scalars, Vectors, cross
from geoweave.errors import FieldError, RodError
from geoweave.rods import hessian
from geoweave.rods.compiled_stencils import local_gradient
from geoweave.rods.elastic_energies import Table, Term
from geoweave.rods.hessian import Pattern
from geoweave.rods.rods import Rods
from geoweave.sparse import cholesky

__all__ = ["DAMPING", "NEAR", "NEWTON", "Problem", "State", "Stepping", "Taken", "Trial", "free_parts"]


@dataclass(frozen=True)
class Stepping:
    """When the iteration ends, and how far one step may go.

    Attributes
    ----------
    tolerance : the iteration has converged when unbalanced forces are this share of all forces
    most_steps : largest number of steps
    turn : largest angle by which a step may turn a segment, radians
    sufficient : share of the predicted decrease of the energy that a step must achieve (Armijo)
    shortest : share of the full step at which the line search gives up
    least_gain : the iteration ends, not converged, when a step lowers the energy by at most this share of it;
        zero for never

    Raises
    ------
    FieldError
        If a number is not positive.

    Examples
    --------
    >>> gw.rods.Stepping(most_steps=100).tolerance
    1e-06
    """

    tolerance: float = 1e-6
    most_steps: int = 500
    turn: float = 0.5
    sufficient: float = 1e-4
    shortest: float = 1e-6
    least_gain: float = 0.0

    def __post_init__(self) -> None:
        for name in ("tolerance", "most_steps", "turn", "sufficient", "shortest", "least_gain"):
            value = getattr(self, name)
            if not (np.isfinite(value) and (value > 0 or (name == "least_gain" and value == 0))):
                raise FieldError(f"'{name}' of the equilibrium must be a positive number, not {value}")


NO_FORCE = 1e-15
"""Forces below this share of ``Y w h``, which would double a ribbon's length, are rounding."""

NEAR = 0.1
"""Newton steps are tried once unbalanced forces are at most this share of all forces."""

FORESEEN = 0.2
"""They are tried only while residuals differ from their prediction by at most this share of the energy."""

TRIES = 4
"""Dampings that are tried for a Newton step. If none works, a Gauss-Newton step is taken."""

CAUTION = 4.0
"""Factor by which the damping of Newton steps changes."""

SHORT_STEP, LONG_STEP = 0.25, 0.5
"""A line search that stops below the first share asks for more damping, one above the second for less."""

ROUNDING = 4.0
"""An energy is known to this many units in the last place of the sum of its terms."""

LEVEL = 1e3
"""The energy cannot judge a step whose predicted decrease is below this many times its rounding."""

Solve: TypeAlias = Callable[[Scalars], Scalars]

DAMPING = (1e-12, 1e-9, 1e2)
"""Least, first and largest damping as a share of the stretching stiffness of a segment."""

NEWTON = (1e-12, 1e-6, 1e-3)
"""Least, first and largest damping of Newton steps."""


class Trial(NamedTuple):
    """Rods with their residuals and energies."""

    rods: Rods
    residuals: list[Table]
    energies: dict[str, float]

    @property
    def energy(self) -> float:
        """Sum of all terms."""
        return sum(self.energies.values())


class State(NamedTuple):
    """A trial that was accepted, with its derivatives."""

    rods: Rods
    residuals: list[Table]
    energies: dict[str, float]
    jacobians: list[Table]
    gradient: Scalars
    relative: float

    @property
    def energy(self) -> float:
        """Sum of all terms."""
        return sum(self.energies.values())


class Taken(NamedTuple):
    """A step that was accepted."""

    trial: Trial
    """The rods after the step."""
    step: Scalars
    """(3 V + S,) solution of the linear system."""
    whole: float
    """Share of it, at most 1, at which no segment turns by more than `Stepping.turn`."""
    share: float
    """Share of that, at most 1, at which the energy fell enough."""


class Problem:
    """Energies, forces and steps of one minimisation."""

    def __init__(
        self,
        rods: Rods,
        terms: tuple[Term, ...],
        fixed: Flags,
        load: Vectors | None,
        anchored: bool,
        pattern: Pattern | None,
    ) -> None:
        self.terms, self.load, self.start = terms, load, rods.points
        self.pattern = pattern or hessian.analysed(rods.size, terms, fixed)
        self.fixed = fixed
        size = float(rods.rest.mean())
        angle = np.arange(rods.size) >= 3 * rods.layout.vertices
        self.unit = np.where(angle, size, 1.0)
        strength = rods.material.stretching(rods.widths)
        self.stiff = float(strength.mean()) / size
        self.least = NO_FORCE * float(np.linalg.norm(strength))
        self.parts = [] if anchored else free_parts(rods, fixed)

    def tried(self, rods: Rods) -> Trial:
        """Evaluate residuals and energies of rods."""
        residuals = [term.residual(rods) for term in self.terms]
        energies = {
            term.name: 0.5 * float((r**2).sum()) for term, r in zip(self.terms, residuals, strict=True)
        }
        if self.load is not None:
            energies["load"] = -float((self.load * (rods.points - self.start)).sum())
        return Trial(rods, residuals, energies)

    def moved(self, rods: Rods, step: Scalars) -> Trial | None:
        """Rods after a step; None if a segment would vanish or fold back."""
        try:
            return self.tried(rods.stepped(step))
        except RodError:
            return None

    def completed(self, trial: Trial) -> State:
        """Add Jacobians and the gradient of the energy.

        The size of the gradient is given as a share of the sum of the sizes of its terms.
        """
        jacobians = [term.derivative(trial.rods) for term in self.terms]
        parts = self.pulled(jacobians, trial.residuals)
        size = sum(float(np.linalg.norm(own / self.unit)) for own in parts)
        total = np.sum(parts, axis=0)
        if self.load is not None:
            total[: self.load.size] -= self.load.ravel()
            size += float(np.linalg.norm(self.load))
        total[self.fixed] = 0.0
        relative = float(np.linalg.norm(total / self.unit)) / max(size, self.least / 1e-6)
        return State(*trial, jacobians, total, relative)

    def pulled(self, jacobians: list[Table], residuals: list[Table]) -> list[Scalars]:
        """``J' r`` of each term."""
        return [
            local_gradient(term.unknowns, jacobian, residual, self.pattern.size)
            for term, jacobian, residual in zip(self.terms, jacobians, residuals, strict=True)
        ]

    def linear(self, now: State, step: Scalars) -> list[Table]:
        """Predict the residuals after a step from their Jacobians."""
        return [
            residual + np.einsum("nrk,nk->nr", jacobian, step[term.unknowns])
            for term, residual, jacobian in zip(self.terms, now.residuals, now.jacobians, strict=True)
        ]

    def is_foreseen(self, now: State, foreseen: list[Table]) -> bool:
        """Whether residuals came out nearly as the last steps predicted.

        If not, the forces of stiff contacts are far from balance. They enter the second derivative of the
        energy, which is then misleading.
        """
        off = sum(float(((r - f) ** 2).sum()) for r, f in zip(now.residuals, foreseen, strict=True))
        return 0.5 * off <= FORESEEN * sum(0.5 * float((r**2).sum()) for r in now.residuals)

    def matrix(self, now: State, forces: list[Table] | None = None) -> sparse.csr_array:
        """Return the second derivative of the energy.

        Without forces this is the Gauss-Newton matrix ``J' J``. Forces weigh the second derivatives of the
        residuals, which are added to it. The predicted residuals are better forces than the residuals
        themselves: in a stiff contact a small error of second order is a large force, which the next step
        removes. Multipliers in sequential quadratic programming play the same part.
        """
        extra: list[Table | None] = [None] * len(self.terms)
        for number, term in enumerate(self.terms if forces is not None else ()):
            if forces is not None and term.curvature is not None:
                extra[number] = term.curvature(now.rods, forces[number])
        return self.pattern.matrix(now.jacobians, extra)

    def stable(self, matrix: sparse.csr_array, shifts: Sequence[float]) -> Solve:
        """Factor the matrix of rods at rest, with the smallest of some dampings that will do.

        Raises
        ------
        RodError
            If none does: the rods are at rest where they would leave, or not at rest.
        """
        for shift in shifts:
            solve = self.factored(matrix, shift)
            if solve is not None:
                return solve
        raise RodError("the rods are not at rest in a stable shape; relax them further")

    def factored(self, matrix: sparse.csr_array, damping: float) -> Solve | None:
        """Factor a damped matrix; None if it is not positive definite to working precision."""
        pattern = self.pattern
        damped = pattern.shifted(matrix, damping * self.stiff * self.unit**2)
        try:
            factor = cholesky.factor(damped, pattern.symbolic)
        except cholesky.NotDefiniteError:
            return None

        def solve(right: Scalars) -> Scalars:
            own = right[pattern.free]
            solution = cholesky.solve(pattern.symbolic, factor, own)
            solution += cholesky.solve(pattern.symbolic, factor, own - damped @ solution)
            out = np.zeros(pattern.size)
            out[pattern.free] = solution
            return out

        return solve

    def newton(
        self, now: State, shift: float, foreseen: list[Table], numbers: Stepping
    ) -> tuple[Taken | None, float]:
        """Take a Newton step; return it, or None, and the damping for the next.

        Near a saddle the step along the unstable direction becomes very long when the damping is only just
        large enough to make the matrix positive definite. So the damping changes slowly.
        """
        matrix = self.matrix(now, foreseen)
        for attempt in range(TRIES):
            taken = self.advanced(now, self.factored(matrix, shift), numbers)
            if taken is not None:
                shorter = taken.share > LONG_STEP and not attempt
                change = CAUTION if taken.share < SHORT_STEP else 1.0 / CAUTION if shorter else 1.0
                return taken, min(max(change * shift, NEWTON[0]), NEWTON[2])
            shift = min(CAUTION * shift, NEWTON[2])
        return None, shift

    def solved(self, rods: Rods, solve: Solve, gradient: Scalars) -> Scalars | None:
        """Return the step against a gradient, without its rigid motion; None if it is not finite."""
        step = -solve(gradient)
        if not np.isfinite(step).all():
            return None
        for part in self.parts:
            _remove_rigid_motion(rods, part, step)
        return step

    def advanced(self, now: State, solve: Solve | None, numbers: Stepping) -> Taken | None:
        """Halve a step until the energy falls enough.

        Lengths and contacts are stiff, so low energies lie in a curved valley, and a straight step s leaves
        it. One more solution with the same matrix gives the step b that leads back into it. The search then
        goes along the arc ``t s + t^2 b`` (second-order correction).
        """
        step = None if solve is None else self.solved(now.rods, solve, now.gradient)
        if solve is None or step is None:
            return None
        largest = _turn(now.rods, step)
        whole = min(1.0, numbers.turn / largest) if largest > 0 else 1.0
        slope = whole * float(now.gradient @ step)
        if not slope < 0:
            return None
        rounding = ROUNDING * np.finfo(np.float64).eps * sum(abs(e) for e in now.energies.values())
        share, back = 1.0, None
        while share >= numbers.shortest:
            along = share * whole * step
            trial = self.moved(now.rods, along)
            goal = now.energy + numbers.sufficient * share * slope
            found = [] if trial is None else [trial]
            if trial is not None and not trial.energy <= goal:
                if back is None:
                    back = self.back(now, trial, along, solve)
                    back = None if back is None else back / share**2
                if back is not None and _turn(now.rods, share**2 * back) <= numbers.turn:
                    bent = self.moved(now.rods, along + share**2 * back)
                    found += [] if bent is None else [bent]
            for each in found:
                if each.energy <= goal:
                    return Taken(each, step, whole, share)
                # Near the end rounding hides the decrease of the energy; then forces decide.
                level = -share * slope < LEVEL * rounding and each.energy <= now.energy + rounding
                if level and self.completed(each).relative < now.relative:
                    return Taken(each, step, whole, share)
            share *= 0.5
        return None

    def back(self, now: State, trial: Trial, along: Scalars, solve: Solve) -> Scalars | None:
        """Return the step that takes residuals, after a straight step, to what was predicted."""
        linear = self.linear(now, along)
        off = [r - f for r, f in zip(trial.residuals, linear, strict=True)]
        force = np.sum(self.pulled(now.jacobians, off), axis=0)
        force[self.fixed] = 0.0
        return self.solved(now.rods, solve, force)


def _turn(rods: Rods, step: Scalars) -> float:
    """Return the largest angle by which a step turns a segment, in its direction or about it."""
    moved = step[: 3 * rods.layout.vertices].reshape(-1, 3)
    start, end = rods.layout.ends.T
    change = np.linalg.norm(moved[end] - moved[start], axis=1) / rods.lengths
    return max(float(change.max()), float(np.abs(step[3 * rods.layout.vertices :]).max()))


def free_parts(rods: Rods, fixed: Flags) -> list[tuple[Indices, Indices]]:
    """Vertices and segments of each connected part of the weave that has no fixed vertex."""
    layout, pair = rods.layout, rods.layout.rod_of_segment[rods.contacts.segments]
    links = sparse.csr_array((np.ones(len(pair)), (pair[:, 0], pair[:, 1])), shape=(len(rods),) * 2)
    count, label = csgraph.connected_components(links, directed=False)
    of_vertex, of_segment = label[layout.rod_of_vertex], label[layout.rod_of_segment]
    still = fixed[: 3 * layout.vertices].reshape(-1, 3).any(axis=1)
    held = set(of_vertex[still].tolist())
    return [
        (np.flatnonzero(of_vertex == k), np.flatnonzero(of_segment == k))
        for k in range(count)
        if k not in held
    ]


def _remove_rigid_motion(rods: Rods, part: tuple[Indices, Indices], step: Scalars) -> None:
    """Remove from a step the motion of a part's centre of mass and its rotation as a whole."""
    vertices, segments = part
    mass = np.zeros(rods.layout.vertices)
    for end in rods.layout.ends.T:
        np.add.at(mass, end, 0.5 * rods.rest)
    mass = mass[vertices] / mass[vertices].sum()
    moved = step[: 3 * rods.layout.vertices].reshape(-1, 3)
    arm = rods.points[vertices] - mass @ rods.points[vertices]
    moved[vertices] -= mass @ moved[vertices]
    inertia = (mass * (arm**2).sum(axis=1)).sum() * np.eye(3) - (arm * mass[:, None]).T @ arm
    spin = np.linalg.pinv(inertia, rcond=1e-12) @ (mass @ cross(arm, moved[vertices]))
    moved[vertices] -= cross(spin, arm)
    angles = step[3 * rods.layout.vertices :]
    angles[segments] -= rods.tangents[segments] @ spin
