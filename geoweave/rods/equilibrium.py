"""Equilibria of elastic rods: ribbons that slide on a surface, and weaves left to themselves (Appendix E).

Gauss-Newton steps with a line search lead near the equilibrium. Newton steps take over where the second
derivative is positive definite. A step moves vertices and turns sections. Before energies are evaluated,
directors are parallel-transported onto the moved segments, as the paper asks.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geoweave.arrays import Flags, Vectors
from geoweave.rods.elastic_energies import Term
from geoweave.rods.hessian import Pattern
from geoweave.rods.rods import Rods
from geoweave.rods.steps import DAMPING, LONG_STEP, NEAR, NEWTON, SHORT_STEP, Problem, Stepping
from geoweave.sparse import one_blas_thread
from geoweave.wording import counted

__all__ = ["Equilibrium", "Step", "Stepping", "minimized"]


STIFFER, LESS_SHORT, MORE_SHORT = 30.0, 0.1, 10.0
"""Factors on the damping: after no step worked, after a long step, after a short one (`SHORT_STEP`)."""


STALLED = 0.003
"""Newton steps are tried too once a step lowered the energy by less than this share of it."""


@dataclass(frozen=True)
class Step:
    """One state of the iteration, as it is handed to a callback.

    Attributes
    ----------
    number : steps taken so far
    energies : energy by the name of its term, force x length
    gradient : size of the unbalanced forces as a share of the forces that balance
    share : share of the full step that the line search took to get here; 0 at the start
    rods : where the rods are; known to the callback only, so that a history of steps stays small
    """

    number: int
    energies: dict[str, float]
    gradient: float
    share: float
    rods: Rods | None = None

    @property
    def energy(self) -> float:
        """Sum of all terms."""
        return sum(self.energies.values())


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """Rods at rest, or the last state of an iteration that did not converge.

    Attributes
    ----------
    rods : where they ended
    converged : whether the forces balance to the tolerance
    steps : every state from the start to the end
    ending : why the iteration ended, in words

    Examples
    --------
    >>> rods = gw.elastic_rods(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)).rods
    >>> found = gw.rods.relax_rods(rods)
    >>> found.converged, found.ending
    (True, 'the forces balance')
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


def minimized(
    rods: Rods,
    terms: Sequence[Term],
    *,
    stepping: Stepping | None = None,
    fixed: Flags | None = None,
    load: Vectors | None = None,
    anchored: bool = False,
    callback: Callable[[Step], None] | None = None,
    pattern: Pattern | None = None,
) -> Equilibrium:
    """Minimise a sum of energies over vertices and angles by damped (Gauss-)Newton steps with a line search.

    Every step lowers the energy, so the iteration ends. A step to a number that is not finite is never taken.
    Rigid motions are removed from every step: the centre of mass of each connected part stays and, to first
    order, its orientation (E.2). Parts that are held at a vertex need no such rule.

    Parameters
    ----------
    rods : the start
    terms : energies
    stepping : the numbers of the iteration
    fixed : (3 V + S,) unknowns that do not change
    load : (V, 3) constant force on each vertex; its potential is ``-load . p``
    anchored : whether the energies themselves hold the rods in space, so that no motion is rigid
    callback : called with every `Step`
    pattern : of the matrix, if one for the same unknowns has been analysed before
    """
    numbers = stepping or Stepping()
    held = np.zeros(rods.size, dtype=bool) if fixed is None else np.asarray(fixed, dtype=bool)
    problem = Problem(rods, tuple(terms), held, load, anchored, pattern)
    now, share = problem.completed(problem.tried(rods)), 0.0
    history: list[Step] = []
    foreseen = [np.zeros_like(r) for r in now.residuals]
    damping, shift, ending, gain = DAMPING[1], NEWTON[1], "", 1.0
    with one_blas_thread():
        while True:
            history.append(Step(len(history), now.energies, now.relative, share))
            if callback is not None:
                callback(replace(history[-1], rods=now.rods))
            if now.relative <= numbers.tolerance:
                ending = "the forces balance"
                break
            if len(history) > numbers.most_steps:
                ending = f"after {counted(numbers.most_steps, 'step')} the forces do not balance yet"
                break
            if numbers.least_gain > 0 and gain <= numbers.least_gain:
                ending = f"a step lowered the energy by at most {numbers.least_gain:g} of it"
                break
            taken = None
            if (now.relative < NEAR or gain < STALLED) and problem.is_foreseen(now, foreseen):
                taken, shift = problem.newton(now, shift, foreseen, numbers)
            matrix = problem.matrix(now) if taken is None else None
            while matrix is not None and taken is None and damping <= DAMPING[2]:
                taken = problem.advanced(now, problem.factored(matrix, damping), numbers)
                if taken is None:
                    damping *= STIFFER
                else:
                    change = 1.0
                    if taken.share > LONG_STEP:
                        change = LESS_SHORT
                    elif taken.share < SHORT_STEP:
                        change = MORE_SHORT
                    damping = min(max(change * damping, DAMPING[0]), DAMPING[2])
            if taken is None:
                ending = "no step lowers the energy any further"
                break
            reached = taken.share * taken.whole
            linear = problem.linear(now, taken.step)
            foreseen = [f + reached * (r - f) for f, r in zip(foreseen, linear, strict=True)]
            gain = (now.energy - taken.trial.energy) / max(abs(now.energy), 1e-300)
            now, share = problem.completed(taken.trial), taken.share
    return Equilibrium(now.rods, now.relative <= numbers.tolerance, tuple(history), ending)
