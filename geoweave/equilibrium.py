"""Equilibria of elastic rods: ribbons that slide on a surface, and weaves left to themselves (Appendix E).

Both are found by Gauss-Newton steps with a line search. A step moves vertices and turns sections; the line
search evaluates it on rods whose directors have been parallel-transported onto the new segments, as the paper
asks, because the energies of `geoweave.rod_energies` are only ever taken on such rods.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave import cholesky, rod_matrix
from geoweave.arrays import Flags, Indices, Scalars, Vectors
from geoweave.errors import FieldError
from geoweave.linalg import one_blas_thread
from geoweave.rod_energies import Table, Term
from geoweave.rodfiles import RodError
from geoweave.rods import Rods, cross

__all__ = ["Equilibrium", "Step", "Stepping", "minimized"]


@dataclass(frozen=True)
class Stepping:
    """The numbers of the Gauss-Newton iteration.

    Attributes
    ----------
    tolerance : the iteration has converged where the forces balance to this share of their size
    most_steps : no more steps than this
    turn : no segment turns by more than this in one step, radians
    sufficient : share of the predicted decrease of the energy that a step must achieve (Armijo)
    shortest : share of a step below which the line search gives up
    memory : steps from which the curvature that Gauss-Newton leaves out is learnt; 0 for none
    """

    tolerance: float = 1e-6
    most_steps: int = 500
    turn: float = 0.5
    sufficient: float = 1e-4
    shortest: float = 1e-6
    memory: int = 10

    def __post_init__(self) -> None:
        for name in ("tolerance", "most_steps", "turn", "sufficient", "shortest"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise FieldError(f"'{name}' of the equilibrium must be a positive number, not {value}")
        if self.memory < 0:
            raise FieldError(f"the memory of the equilibrium is zero or more steps, not {self.memory}")


@dataclass(frozen=True)
class Step:
    """One state of the iteration, as it is handed to a callback.

    Attributes
    ----------
    number : steps taken so far
    energies : energy by the name of its term, force x length
    gradient : size of the unbalanced forces as a share of the forces that balance
    share : share of the full step that the line search took to get here; 0 at the start
    """

    number: int
    energies: dict[str, float]
    gradient: float
    share: float

    @property
    def energy(self) -> float:
        """Sum of all terms."""
        return sum(self.energies.values())


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """Rods at rest, or as near to it as the iteration came.

    Attributes
    ----------
    rods : where they ended
    converged : whether the forces balance to the tolerance
    steps : every state from the start to the end
    ending : why the iteration ended, in words
    """

    rods: Rods
    converged: bool
    steps: tuple[Step, ...]
    ending: str

    @property
    def energies(self) -> dict[str, float]:
        """Energy by the name of its term at the end, force x length."""
        return self.steps[-1].energies

    @property
    def gradient(self) -> float:
        """Unbalanced forces at the end as a share of the forces that balance."""
        return self.steps[-1].gradient


NO_FORCE = 1e-15
"""Forces below this share of ``Y w h``, which would double a ribbon's length, are rounding."""

SETTLED = 0.03
"""The Gauss-Newton matrix is factored anew at every step until the forces balance to this share."""

NEAR = 0.3
"""Below this share, secant pairs are kept and taut segments add their stiffness against sideways motion."""

Solve: TypeAlias = Callable[[Scalars], Scalars]

DAMPING = (1e-12, 1e-9, 1e2)
"""Least, first and largest damping as a share of the stretching stiffness of a segment."""


def minimized(
    rods: Rods,
    terms: Sequence[Term],
    *,
    stepping: Stepping | None = None,
    fixed: Flags | None = None,
    load: Vectors | None = None,
    anchored: bool = False,
    callback: Callable[[Step], None] | None = None,
) -> Equilibrium:
    """Minimise a sum of energies over vertices and angles by Gauss-Newton steps with a line search.

    Every step lowers the energy, so the iteration ends; it cannot accept a number that is not finite. Rigid
    motions are taken out of every step: the centre of mass of each connected part and, to first order, its
    orientation stay (E.2). Parts that are held anywhere keep theirs by that.

    Parameters
    ----------
    rods : the start
    terms : energies
    stepping : the numbers of the iteration
    fixed : (3 V + S,) unknowns that do not change
    load : (V, 3) constant force on each vertex; its potential is ``-load . p``
    anchored : whether the energies themselves hold the rods in space, so that no motion is rigid
    callback : called with every `Step`
    """
    numbers = stepping or Stepping()
    held = np.zeros(rods.size, dtype=bool) if fixed is None else np.asarray(fixed, dtype=bool)
    problem = _Problem(rods, tuple(terms), held, load, anchored)
    current, energies, share = rods, problem.energies(rods), 0.0
    history: list[Step] = []
    memory: deque[tuple[Scalars, Scalars]] = deque(maxlen=max(numbers.memory, 1))
    damping, solve, ending = DAMPING[1], None, ""
    gradient, jacobians, relative = problem.forces(current)
    with one_blas_thread():
        while True:
            history.append(Step(len(history), energies, relative, share))
            if callback is not None:
                callback(history[-1])
            if relative <= numbers.tolerance:
                ending = "the forces balance"
                break
            if len(history) > numbers.most_steps:
                ending = f"after {numbers.most_steps} steps the forces do not balance yet"
                break
            if solve is None or relative > SETTLED or share < 1.0:
                solve = problem.factored(current, jacobians, damping, relative < NEAR)
            taken = problem.attempt(current, history[-1], gradient, solve, memory, numbers)
            while taken is None and damping <= DAMPING[2]:
                damping *= 1.0 if memory else 30.0
                memory.clear()
                solve = problem.factored(current, jacobians, damping, relative < NEAR)
                taken = problem.attempt(current, history[-1], gradient, solve, memory, numbers)
            if taken is None:
                ending = "no step lowers the energy any further"
                break
            current, energies, share, step = taken
            damping = max(damping * (0.3 if share > 0.5 else 10.0 if share < 0.5 else 1.0), DAMPING[0])
            before = gradient
            gradient, jacobians, relative = problem.forces(current)
            if step is None:  # a corrected step is no secant of the gradient
                solve = None
            elif numbers.memory and relative < NEAR and float((gradient - before) @ step) > 0:
                memory.append((step, gradient - before))
    return Equilibrium(current, relative <= numbers.tolerance, tuple(history), ending)


class _Problem:
    """Energies, forces and steps of one minimisation."""

    def __init__(
        self, rods: Rods, terms: tuple[Term, ...], fixed: Flags, load: Vectors | None, anchored: bool
    ) -> None:
        self.terms, self.load, self.start = terms, load, rods.points
        self.pattern = rod_matrix.analysed(rods.size, terms, fixed)
        self.fixed = fixed
        size = float(rods.rest.mean())
        angle = np.arange(rods.size) >= 3 * rods.layout.vertices
        self.unit = np.where(angle, size, 1.0)
        strength = rods.material.stretching(rods.widths)
        self.stiff = float(strength.mean()) / size
        self.least = NO_FORCE * float(np.linalg.norm(strength))
        self.parts = [] if anchored else _parts(rods, fixed)

    def energies(self, rods: Rods) -> dict[str, float]:
        found = {term.name: term.energy(rods) for term in self.terms}
        if self.load is not None:
            found["load"] = -float((self.load * (rods.points - self.start)).sum())
        return found

    def forces(self, rods: Rods) -> tuple[Scalars, list[Table], float]:
        """Gradient of the energy, local Jacobians, and the gradient as a share of its parts."""
        total, size = np.zeros(rods.size), 0.0
        jacobians = []
        for term in self.terms:
            derivative = term.derivative(rods)
            local = np.einsum("nr,nrk->nk", term.residual(rods), derivative)
            own = np.bincount(term.unknowns.ravel(), local.ravel(), minlength=rods.size)
            size += float(np.linalg.norm(own / self.unit))
            total += own
            jacobians.append(derivative)
        if self.load is not None:
            total[: self.load.size] -= self.load.ravel()
            size += float(np.linalg.norm(self.load))
        total[self.fixed] = 0.0
        unbalanced = float(np.linalg.norm(total / self.unit))
        return total, jacobians, unbalanced / max(size, self.least / 1e-6)

    def factored(self, rods: Rods, jacobians: list[Table], damping: float, taut: bool) -> Solve | None:
        """Factor the damped Gauss-Newton matrix; None if it is not definite to working precision."""
        pattern = self.pattern
        extra = [term.curvature(rods) if taut and term.curvature else None for term in self.terms]
        matrix = pattern.matrix(jacobians, extra, damping * self.stiff * self.unit**2)
        try:
            factor = cholesky.factor(matrix, pattern.symbolic)
        except cholesky.NotDefiniteError:
            return None

        def solve(right: Scalars) -> Scalars:
            own = right[pattern.free]
            solution = cholesky.solve(pattern.symbolic, factor, own)
            solution += cholesky.solve(pattern.symbolic, factor, own - matrix @ solution)
            out = np.zeros(pattern.size)
            out[pattern.free] = solution
            return out

        return solve

    def attempt(
        self,
        rods: Rods,
        now: Step,
        gradient: Scalars,
        solve: Solve | None,
        memory: Sequence[tuple[Scalars, Scalars]],
        numbers: Stepping,
    ) -> tuple[Rods, dict[str, float], float, Scalars | None] | None:
        """Return where a step leads, its energies, its share, and the step itself if it was straight."""
        if solve is None:
            return None
        step = self.step(rods, gradient, solve, memory, numbers.turn)
        found = None if step is None else self.search(rods, now, gradient, step, solve, numbers)
        if found is None or step is None:
            return None
        return (*found[:3], found[2] * step if found[3] else None)

    def step(
        self,
        rods: Rods,
        gradient: Scalars,
        solve: Solve,
        memory: Sequence[tuple[Scalars, Scalars]],
        turn: float,
    ) -> Scalars | None:
        """Return the step without its rigid motion, shortened where a segment turns too far.

        What Gauss-Newton leaves out of the second derivative is learnt from how the gradient changed over the
        last steps: limited-memory secant pairs about the Gauss-Newton matrix (Nocedal 1980).
        """
        q = gradient.copy()
        taken: list[tuple[float, float]] = []
        for shift, changed in reversed(memory):
            rate = 1.0 / float(changed @ shift)
            taken.append((rate, rate * float(shift @ q)))
            q -= taken[-1][1] * changed
        step = solve(q)
        for (shift, changed), (rate, part) in zip(memory, reversed(taken), strict=True):
            step += (part - rate * float(changed @ step)) * shift
        step = -step
        if not np.isfinite(step).all():
            return None
        for whole in self.parts:
            _remove_rigid_motion(rods, whole, step)
        moved = step[: 3 * rods.layout.vertices].reshape(-1, 3)
        start, end = rods.layout.ends.T
        change = np.linalg.norm(moved[end] - moved[start], axis=1) / rods.lengths
        largest = max(float(change.max()), float(np.abs(step[3 * rods.layout.vertices :]).max()))
        return step * min(1.0, turn / largest) if largest > 0 else step

    @staticmethod
    def moved(rods: Rods, step: Scalars) -> Rods | None:
        """Rods after a step, or None if they would be none."""
        try:
            return rods.stepped(step)
        except RodError:
            return None

    def search(
        self, rods: Rods, now: Step, gradient: Scalars, step: Scalars, solve: Solve, numbers: Stepping
    ) -> tuple[Rods, dict[str, float], float, bool] | None:
        """Halve the step until the energy falls enough.

        A straight step leaves the curved valley in which lengths and contacts hold. Before it is halved the
        same matrix may take it back there, for the price of a gradient (second-order correction): halving
        alone would creep along the valley. Also says whether the step was straight.
        """
        slope = float(gradient @ step)
        if not slope < 0:
            return None
        share = 1.0
        rounding = 4.0 * np.finfo(np.float64).eps * sum(abs(e) for e in now.energies.values())
        while share >= numbers.shortest:
            trial = self.moved(rods, share * step)
            if trial is None:
                share *= 0.5
                continue
            energies = self.energies(trial)
            energy = sum(energies.values())
            if energy <= now.energy + numbers.sufficient * share * slope:
                return trial, energies, share, True
            back = self.step(trial, self.forces(trial)[0], solve, (), numbers.turn)
            corrected = None if back is None else self.moved(trial, back)
            if corrected is not None:
                again = self.energies(corrected)
                if sum(again.values()) <= now.energy + numbers.sufficient * share * slope:
                    return corrected, again, share, False
            # Where the energy can no longer tell the two apart, the forces can.
            level = -share * slope < 1e3 * rounding and energy <= now.energy + rounding
            if level and self.forces(trial)[2] < now.gradient:
                return trial, energies, share, True
            share *= 0.5
        return None


def _parts(rods: Rods, fixed: Flags) -> list[tuple[Indices, Indices]]:
    """Vertices and segments of each part of the weave that nothing holds."""
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
    """Take out of a step what moves the centre of mass of a part or turns it as a whole."""
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
