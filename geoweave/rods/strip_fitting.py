"""The inverse problem: cut strips so curved, and so long, that the weave at rest lies on its surface.

Unknowns are curvatures and changes of length at knots along the strips (`Knots`). The mean squared distance
of the shape at rest is lowered by Gauss-Newton steps in a trust region. Each linear problem is solved by
conjugate gradients with the derivative of the rest shape (`RestSensitivity`): one factorisation a step, two
solves an iteration.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple, TypeAlias

import numpy as np

from geoweave.arrays import Flags, Scalars
from geoweave.errors import FieldError, RodError
from geoweave.rods import hessian
from geoweave.rods.curvature_knots import STRAIN, Knots
from geoweave.rods.distance_at_rest import DistanceAtRest, Miss
from geoweave.rods.equilibrium import Equilibrium, minimized
from geoweave.rods.holding_at_rest import HoldingAtRest, Lack
from geoweave.rods.rest_sensitivity import RestSensitivity
from geoweave.rods.rods import Rods
from geoweave.rods.slide_and_relax import Springs, relax_rods, relaxing_terms
from geoweave.rods.steps import Stepping
from geoweave.surface import TriMesh
from geoweave.weave import WeaveType

__all__ = ["CurvedStep", "CurvedStrips", "Fitting", "optimal_strips"]


@dataclass(frozen=True)
class Fitting:
    """The numbers of the inverse problem.

    Attributes
    ----------
    sharpest : largest curvature x width of a strip; at 2 its inner edge would shrink to a point
    longest : largest change of a length, as a share of it
    smooth : weight of the mean squared second difference of curvature x width between knots, against the mean
        squared distance in diagonals
    hold : weight of the forces that friction must bear, against the mean squared distance: the mean squares
        of those along ribbons, and of what ribbons press less than by interlacing (`Lack`); 0 for none
    enough : the iteration has converged when a step is foreseen to lower the target by less than this share
    most_steps : largest number of trials
    most_inner : largest number of conjugate gradients for a step

    Raises
    ------
    FieldError
        If a number is not positive, or the edges of strips could cross.

    Examples
    --------
    >>> gw.rods.Fitting(sharpest=2.5)
    Traceback (most recent call last):
    geoweave.errors.FieldError: 'sharpest' is 2.5; from 2 on the edges of a strip cross
    """

    sharpest: float = 1.0
    longest: float = 0.05
    smooth: float = 1e-7
    hold: float = 0.0
    enough: float = 0.005
    most_steps: int = 60
    most_inner: int = 60

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value) and (value > 0 or (name == "hold" and value == 0))):
                raise FieldError(f"'{name}' of curved strips must be a positive number, not {value}")
        if self.sharpest >= 2:
            raise FieldError(f"'sharpest' is {self.sharpest:g}; from 2 on the edges of a strip cross")


@dataclass(frozen=True)
class CurvedStep:
    """One trial of the inverse problem.

    Attributes
    ----------
    number : of the trial, 0 for the start
    rms, mean : distance of the shape at rest from the surface, in diagonals
    energy : of the shape at rest, force x length
    sharpest : largest curvature x width of a strip
    taken : whether the trial was nearer than the last one that was taken
    """

    number: int
    rms: float
    mean: float
    energy: float
    sharpest: float
    taken: bool


@dataclass(frozen=True, eq=False)
class CurvedStrips:
    """Strips whose curvatures and lengths were chosen.

    Attributes
    ----------
    cut : the strips, in the shape that they had at the start
    rest : their shape at rest, relaxed from there
    steps : every trial
    converged : whether no step promises more, and the shape of the last one is that of `rest`
    ending : why the iteration ended, in words
    kind : "holding" if friction was part of the target, else "optimal"
    """

    cut: Rods
    rest: Equilibrium
    steps: tuple[CurvedStep, ...]
    converged: bool
    ending: str
    kind: Literal["optimal", "holding"] = "optimal"


TRUST = 0.02
"""First size of the trust region: root mean square change of curvature x width at the knots."""

LEAST_TRUST = 1e-6
"""Below this size the iteration ends."""

POOR, GOOD = 0.25, 0.75
"""Shares of the foreseen decrease below which the region shrinks, and above which it grows."""

SHRINK, GROW = 0.3, 2.5
"""By how much it does."""

INNER = 0.05
"""Conjugate gradients end when the residual is this share of the first."""

EXACT = 1e-7
"""Tolerance of the shapes at rest, as their derivatives are used."""

SAME = 1.02
"""A shape is the one that was followed if its distance is at most so many times as large."""

ENOUGH = 1e-3
"""Share of the foreseen decrease that a trial must achieve to be taken."""

CONVERGED = "no step promises to bring it nearer"
"""How an iteration that converged ended."""

LOOKS = 8
"""Trials that are relaxed anew at the end, the last first, until one comes to rest where it was followed."""

_Taken: TypeAlias = tuple[Scalars, float]
"""Unknowns of a trial that was taken, and its target."""


class _Target(NamedTuple):
    """What is lowered, at a shape at rest."""

    miss: Miss
    lack: Lack | None
    """What crossings lack to hold by friction; None if that is not part of it."""
    value: float
    """Half the mean squared distance, the smoothness, and what is lacking."""


class _Inverse:
    """What all trials share."""

    def __init__(
        self, start: Rods, surface: TriMesh, springs: Springs, still: Flags, numbers: Fitting, kind: WeaveType
    ) -> None:
        self.numbers, self.springs, self.still = numbers, springs, still
        self.held = np.concatenate([np.repeat(still, 3), still[start.layout.ends].all(axis=1)])
        self.terms = relaxing_terms(start, springs)
        self.pattern = hessian.analysed(start.size, self.terms, self.held)
        self.goal = DistanceAtRest(surface, start, placed=bool(still.any()))
        self.knots = Knots.of(start)
        wanted = numbers.hold > 0 and len(start.contacts) > 0
        self.holding = HoldingAtRest(start, springs, numbers.hold, kind) if wanted else None
        self.most = np.full(self.knots.number, numbers.sharpest)
        self.most[self.knots.curved :] = numbers.longest / STRAIN
        self.stepping = Stepping(tolerance=EXACT, most_steps=30)

    def smooth(self, z: Scalars) -> Scalars:
        """Derivative of the smoothness ``smooth / 2 mean (second difference of z)^2``."""
        second = self.knots.second
        return np.asarray(self.numbers.smooth / max(self.knots.number, 1) * (second.T @ (second @ z)))

    def target(self, rods: Rods, z: Scalars) -> _Target:
        """Measure a shape at rest of strips that are cut so."""
        miss = self.goal.miss(rods)
        lack = None if self.holding is None else self.holding.lack(rods)
        short = 0.0 if lack is None else lack.value
        return _Target(miss, lack, miss.value + 0.5 * float(z @ self.smooth(z)) + short)

    def nearby(self, shape: Rods, z: Scalars) -> Equilibrium:
        """Relax strips that are cut so from a shape nearby."""
        return minimized(
            self.knots.cut(z, shape),
            self.terms,
            stepping=self.stepping,
            fixed=self.held,
            pattern=self.pattern,
        )

    def anew(self, z: Scalars) -> Equilibrium:
        """Relax strips that are cut so from the start, as `relax_rods` does for any weave."""
        return relax_rods(self.knots.cut(z), springs=self.springs, fixed=self.still)

    def told(self, number: int, miss: Miss, rest: Equilibrium, z: Scalars, taken: bool) -> CurvedStep:
        """What is said of a trial."""
        mean = float(np.abs(miss.residuals) @ np.sqrt(self.goal.weights))
        sharpest = float(np.abs(z[: self.knots.curved]).max(initial=0.0))
        energy = rest.steps[-1].energy
        return CurvedStep(number, float(np.sqrt(2 * miss.value)), mean, energy, sharpest, taken)


class _Linear:
    """The target near one shape at rest."""

    def __init__(self, problem: _Inverse, rods: Rods, z: Scalars) -> None:
        self.problem, self.rods, self.z = problem, rods, z
        self.miss, self.lack, self.value = problem.target(rods, z)
        self.sensitivity = RestSensitivity(rods, problem.terms, problem.held, None, problem.pattern)
        self.gradient = self.back(self.residuals()) + problem.smooth(z)
        # What is at its bound and pushed against it does not take part.
        self.free = (np.abs(z) < problem.most * (1 - 1e-9)) | (z * self.gradient > 0)

    def moved(self, change: Scalars) -> Scalars:
        """(3 V + S,) change of the shape at rest."""
        return self.sensitivity.moved(*self.problem.knots.change(change))

    def residuals(self) -> Scalars:
        """(V,) distances, or (V + C,) with what contacts lack to hold."""
        far = self.miss.residuals
        return far if self.lack is None else np.concatenate([far, self.lack.residuals])

    def forward(self, change: Scalars) -> Scalars:
        """Change of the residuals."""
        moved = self.moved(change)
        far = self.miss.forward(moved[: self.rods.points.size].reshape(-1, 3))
        return far if self.lack is None else np.concatenate([far, self.lack.forward(moved)])

    def back(self, slope: Scalars) -> Scalars:
        """Derivative by the unknowns of what has this derivative by the residuals."""
        far = self.miss.backward(slope[: len(self.miss.residuals)]).ravel()
        pull = np.concatenate([far, np.zeros(self.rods.layout.segments)])
        if self.lack is not None:
            pull += self.lack.backward(slope[len(self.miss.residuals) :])
        return self.problem.knots.slope(*self.sensitivity.pulled(pull))

    def step(self, radius: float) -> tuple[Scalars, float]:
        """Lower the quadratic model by conjugate gradients inside a region (Steihaug 1983).

        Returns
        -------
        The step, and by how much it lowers the model.
        """
        p = np.zeros_like(self.gradient)
        r = np.where(self.free, -self.gradient, 0.0)
        d, lowered = r, 0.0
        first = size = float(r @ r)
        for _ in range(self.problem.numbers.most_inner):
            if not size > INNER**2 * first:
                break
            h = np.where(self.free, self.back(self.forward(d)) + self.problem.smooth(d), 0.0)
            curved = float(d @ h)
            if not curved > 0:
                break
            along = size / curved
            outside = float(np.linalg.norm(p + along * d)) >= radius
            if outside:
                a, b, c = d @ d, p @ d, p @ p - radius**2
                along = float((-b + np.sqrt(b * b - a * c)) / a)
            lowered += along * size - 0.5 * along**2 * curved
            p = p + along * d
            if outside:
                break
            r = r - along * h
            size, before = float(r @ r), size
            d = r + size / before * d
        return p, lowered


def optimal_strips(
    start: Rods,
    surface: TriMesh,
    *,
    springs: Springs | None = None,
    numbers: Fitting | None = None,
    fixed: Flags | None = None,
    pattern: WeaveType = "plain",
    callback: Callable[[CurvedStep], None] | None = None,
) -> CurvedStrips:
    """Choose curvatures and lengths of strips so that they come to rest on a surface.

    Minimises half the mean squared distance of the vertices at rest from the surface, after the best rigid
    fit, in squared diagonals, with a small term for smoothness and, with `Fitting.hold`, one for the forces
    that friction must bear. Each trial relaxes from the last shape at rest. Some weaves have several shapes
    at rest, and the one that was followed may not be the one that is reached from the surface. So the last
    trials are relaxed anew from the start, and the best is returned.

    Parameters
    ----------
    start : rods on the surface, their natural curvature the first guess
    surface : in the same place and size
    springs : stiffnesses of the contacts
    numbers : of the iteration
    fixed : (V,) vertices that do not move
    pattern : the weave that is meant: how hard its ribbons press by interlacing (`interlacing_force`)
    callback : called with every trial

    Returns
    -------
    CurvedStrips
        It says whether the iteration converged; the number of trials is bounded, so it always ends.

    Examples
    --------
    >>> surface = gw.shapes.cone(faces=400).normalized()[0]
    >>> rods = gw.elastic_rods(gw.weave_pattern(surface, ribbons=8)).rods
    >>> found = gw.rods.optimal_strips(rods, surface, numbers=gw.rods.Fitting(most_steps=4))
    >>> found.steps[-1].rms < found.steps[0].rms
    True
    """
    numbers = numbers or Fitting()
    still = np.zeros(start.layout.vertices, dtype=bool) if fixed is None else fixed
    problem = _Inverse(start, surface, springs or Springs(), still, numbers, pattern)
    path, steps, ending = _descent(problem, callback)
    z, rest, same = _reached(problem, path)
    if ending == CONVERGED and not same:
        ending = "the nearest shape is not the one that is reached from the surface"
    kind: Literal["optimal", "holding"] = "optimal" if problem.holding is None else "holding"
    return CurvedStrips(problem.knots.cut(z), rest, tuple(steps), ending == CONVERGED, ending, kind)


def _descent(
    problem: _Inverse, callback: Callable[[CurvedStep], None] | None
) -> tuple[list[_Taken], list[CurvedStep], str]:
    """Gauss-Newton steps in a trust region; what was taken, every trial, and why it ended."""
    numbers = problem.numbers
    z = np.clip(problem.knots.start(), -problem.most, problem.most)
    now = problem.nearby(problem.anew(z).rods, z)
    linear = _Linear(problem, now.rods, z)
    steps = [problem.told(0, linear.miss, now, z, True)]
    path = [(z, linear.value)]
    unit = np.sqrt(max(problem.knots.number, 1))
    radius = TRUST * unit
    while len(steps) <= numbers.most_steps:
        step, lowered = linear.step(radius)
        new = np.clip(linear.z + step, -problem.most, problem.most)
        size = float(np.linalg.norm(new - linear.z))
        if lowered <= numbers.enough * linear.value and size < 0.99 * radius:
            return path, steps, CONVERGED
        if radius < LEAST_TRUST * unit:
            return path, steps, "no step brings it nearer"
        trial = _trial(problem, linear, new)
        gained = -np.inf if trial is None else linear.value - trial[1].value
        taken = trial is not None and gained > ENOUGH * lowered
        if trial is None:
            steps.append(replace(steps[-1], number=len(steps), taken=False))
        else:
            steps.append(problem.told(len(steps), trial[1].miss, trial[0], new, taken))
        if callback is not None:
            callback(steps[-1])
        if gained < POOR * lowered:
            radius = SHRINK * min(size, radius)
        elif gained > GOOD * lowered and size > 0.8 * radius:
            radius *= GROW
        if taken and trial is not None:
            linear = _Linear(problem, trial[0].rods, new)
            path.append((new, linear.value))
    return path, steps, f"after {numbers.most_steps} trials the distance still falls"


def _trial(problem: _Inverse, linear: _Linear, z: Scalars) -> tuple[Equilibrium, _Target] | None:
    """Relax strips that are cut so from where they are foreseen to rest; None if they do not come to rest."""
    try:
        ahead = linear.rods.stepped(linear.moved(z - linear.z))
    except RodError:  # a segment would vanish or fold back
        return None
    rest = problem.nearby(ahead, z)
    if not rest.converged:
        return None
    return rest, problem.target(rest.rods, z)


def _reached(problem: _Inverse, path: list[_Taken]) -> tuple[Scalars, Equilibrium, bool]:
    """The best of the last trials when they are relaxed from the start, and whether it is the last."""
    best: tuple[float, Scalars, Equilibrium] | None = None
    for number, (z, value) in enumerate(reversed(path[-LOOKS:])):
        rest = problem.anew(z)
        found = problem.target(rest.rods, z).value
        if best is None or found < best[0]:
            best = found, z, rest
        if rest.converged and found <= SAME**2 * value:
            return z, rest, number == 0
    assert best is not None
    return best[1], best[2], False
