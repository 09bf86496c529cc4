"""The methods of Fig. 15 side by side: one field, one puncture, one frequency (Section 4.2.4)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from geoweave.arrays import Scalars
from geoweave.comparisons.curl_correction import curl_corrected_scale
from geoweave.comparisons.mixed_integer import mixed_integer_parameterization
from geoweave.errors import FieldError
from geoweave.fields import (
    INTEGRABLE_END,
    FaceField,
    geodesic_field,
    random_field,
    sharpening_schedule,
    smoothest_field,
)
from geoweave.foliation import (
    QUANTILE,
    Alignment,
    CircleFunction,
    Steps,
    Weighting,
    alignment,
    foliate,
    global_scale,
    integrating_factor,
    punctured,
)
from geoweave.surface import Part, TriMesh

Method: TypeAlias = Literal[
    "periodic", "curl-corrected", "mixed-integer", "anisotropic", "ours", "s held", "relative curl"
]
"""How to find theta: see `integrated`."""

TITLES: dict[Method, str] = {
    "periodic": "periodic, no correction",
    "curl-corrected": "periodic, local curl correction",
    "mixed-integer": "mixed-integer",
    "anisotropic": "mixed-integer, anisotropic",
    "ours": "ours",
    "s held": "ours, s held in the joint step",
    "relative curl": "ours, s from relative curl",
}
"""Words for captions; those of `PAPER` are in the figure of the paper, the others are ablations."""

PAPER: tuple[Method, ...] = ("periodic", "curl-corrected", "mixed-integer", "anisotropic", "ours")
"""The methods of Fig. 15, in its order."""

ANISOTROPY = 0.001
"""alpha of the anisotropic variant in Fig. 15."""

CLOSE, ROUNDS = 0.04, 5
"""A frequency this close to the wanted one is taken; the scale is corrected at most so often."""


Start: TypeAlias = Literal["smoothest", "random"]
"""Where Algorithm 1 starts: see `geodesic_from`."""


@dataclass(frozen=True, eq=False)
class Integration:
    """One method's theta.

    Attributes
    ----------
    method : which
    field : the unit field on the punctured surface
    part : the punctured surface as a part of the whole
    circle : theta
    """

    method: Method
    field: FaceField
    part: Part
    circle: CircleFunction

    @property
    def alignment(self) -> Alignment:
        """Deviation, spacing and dislocations."""
        return alignment(self.field, self.circle)

    @property
    def frequency(self) -> float:
        """Area mean of ``|grad theta|``, radians / length."""
        return steepness(self.circle)

    @property
    def row(self) -> dict[str, str | float]:
        """The measures under the names of the columns of Fig. 15's table."""
        fit = self.alignment
        return {
            "method": TITLES[self.method],
            "mean": fit.mean,
            "median": fit.median,
            "p95": fit.p95,
            "spacing spread": fit.spacing_spread,
            "dislocations": fit.dislocations,
            "frequency": self.frequency,
        }


def geodesic_from(mesh: TriMesh, start: Start, seed: int = 0) -> FaceField:
    """Run Algorithm 1 as `geoweave foliate` does, or from a random field with a smoothing of one edge.

    From its smoothest field a torus gets the circles round its tube, without a singularity, and every
    method integrates them; from a random one, with ``lambda = h^2`` throughout, some singularities are left.

    Raises
    ------
    FieldError
        If there is no such start.
    """
    if start == "smoothest":
        schedule = sharpening_schedule(mesh, finest=INTEGRABLE_END)
        return geodesic_field(smoothest_field(mesh, seed), smoothness=schedule, phases=4).field
    if start == "random":
        return geodesic_field(random_field(mesh, seed), smoothness=[mesh.mean_edge**2]).field
    raise FieldError(f"there is no start '{start}': smoothest or random")


def steepness(circle: CircleFunction) -> float:
    """Area mean of ``|grad theta|``, radians / length: 2 pi times the length of level sets per area."""
    return float(np.average(np.abs(circle.gradient), weights=circle.mesh.face_areas))


def integrated(field: FaceField, method: Method, frequency: float) -> Integration:
    """Find theta for a field by one of the methods of Fig. 15, at a given frequency.

    All methods get the same field on the same punctured surface, and their one global factor is corrected
    until the area mean of ``|grad theta|`` is within 4 % of the wanted one, so that all draw about the same
    length of level sets. Periods are integers, so it may jump; of 5 tries the nearest is kept.

    - ``"periodic"``: Eq. 8 from s = 1, the paper's "no correction" (step 3 of 4.2.5 left out)
    - ``"curl-corrected"``: Eq. 8 from the s of `curl_corrected_scale`
    - ``"mixed-integer"``, ``"anisotropic"``: `mixed_integer_parameterization` with s = 1, alpha 1 and 0.001
    - ``"ours"``: `foliate` with its defaults
    - ``"s held"``, ``"relative curl"``: as ours, but with s held after step 3; from the s of
      `curl_corrected_scale` with ``measure="relative"``

    Parameters
    ----------
    field : the field on the whole surface, singularities included
    method : see above
    frequency : wanted area mean of ``|grad theta|``, radians / length

    Raises
    ------
    FieldError
        If there is no such method or the frequency is not a positive number.
    """
    if method not in TITLES:
        raise FieldError(f"there is no method '{method}': {', '.join(TITLES)}")
    if not 0 < frequency < np.inf:
        raise FieldError(f"the frequency must be positive and finite, not {frequency}")
    w, part = punctured(field)
    if method in ("mixed-integer", "anisotropic"):
        alpha = ANISOTROPY if method == "anisotropic" else 1.0
        circle = _at_frequency(
            lambda factor: mixed_integer_parameterization(w, factor, anisotropy=alpha), frequency, frequency
        )
        return Integration(method, w, part, circle)
    first, weighting = _first(w, method)
    mean = float(np.average(first, weights=w.mesh.face_areas))
    start = frequency / (mean * global_scale(w, first, QUANTILE))
    steps: Steps = "theta" if method == "s held" else "joint"

    def made(factor: float) -> CircleFunction:
        circle = foliate(field, scale=factor, rescaling=first, weighting=weighting, steps=steps).circle
        # On the one mesh that all methods share: each foliation cuts the same part anew.
        return CircleFunction(w.mesh, circle.theta, circle.jumps)

    return Integration(method, w, part, _at_frequency(made, start, frequency))


def _at_frequency(made: Callable[[float], CircleFunction], factor: float, frequency: float) -> CircleFunction:
    """Correct a global factor until the frequency fits; of all tries take the nearest."""
    tries: list[tuple[float, CircleFunction]] = []
    for _ in range(ROUNDS):
        circle = made(factor)
        # Where all periods round to zero theta may all but vanish: bounded steps.
        ratio = float(np.clip(frequency / max(steepness(circle), 1e-12), 0.01, 100.0))
        tries.append((abs(np.log(ratio)), circle))
        if tries[-1][0] < CLOSE:
            break
        factor *= ratio
    return min(tries, key=lambda each: each[0])[1]


def _first(w: FaceField, method: Method) -> tuple[Scalars, Weighting]:
    """The first s of a periodic method, and how Eq. 8 weighs faces: as printed for the paper's baselines."""
    if method == "periodic":
        return np.ones(w.mesh.n_faces), "uniform"
    if method == "curl-corrected":
        return curl_corrected_scale(w), "uniform"
    if method == "relative curl":
        return curl_corrected_scale(w, measure="relative"), "relative"
    return integrating_factor(w).s, "relative"
