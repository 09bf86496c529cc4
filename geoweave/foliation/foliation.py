"""From a field to a circle-valued function whose level sets follow it (Section 4.2)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np

from geoweave.arrays import Complexes, Scalars, frozen
from geoweave.errors import FieldError, MeshError
from geoweave.fields import FaceField, Triples, vertex_indices
from geoweave.foliation.circle_function import CircleFunction
from geoweave.foliation.integrability import (
    Method,
    integrating_factor,
    vertices_and_faces,
)
from geoweave.foliation.level_set_alignment import Alignment, alignment
from geoweave.foliation.regular_steps import RegularSteps, regular_course
from geoweave.foliation.theta_and_s import Alternation
from geoweave.foliation.theta_energy import along_edges
from geoweave.sparse import Ordering, one_blas_thread
from geoweave.surface import Part, part_of

Weighting: TypeAlias = Literal["relative", "uniform"]
"""Whether Eq. 8 is measured in units of the first s, or as the paper prints it (DEVIATIONS.md, weighting)."""

SMOOTHNESS = 1e-4
"""mu of Eq. 8 for a surface of bounding radius 1."""

QUANTILE = 0.95
"""Share of the edges on which theta turns by no more than half a turn at scale 1; the paper's is 1."""

LEAST_FREQUENCY = 0.2
"""theta that changes by less than this share of what s asks for is no foliation."""

LEAST_FIRST = 0.02
"""A first s from Eq. 7 is raised to this share of its median where it is smaller or negative."""


Steps: TypeAlias = Literal["joint", "turns", "theta"]
"""Of an alternation: in theta and s together, in one after the other, in theta alone."""


@dataclass(frozen=True, eq=False)
class Foliation:
    """A geodesic almost-foliation: the field, its integrating factor and the function theta (Section 4.2.5).

    Attributes
    ----------
    field : the unit field w on the surface without its singular vertices
    part : that surface as a part of the one given
    s : (F',) integrating factor, positive, radians / length: ``grad theta ~ s w-perp``
    circle : theta on the vertices of the part, and its change along each edge
    energies : Eq. 8 at the start and after each alternation, in the unit that `foliate` says; with a phase
        that is coupled, after each joint step, and then it may rise
    theta_changes, s_changes : change in each alternation, root mean square over the area: radians, and as a
        share of s

    Examples
    --------
    >>> foliation = gw.foliate(gw.smoothest_field(gw.shapes.torus(faces=400)))
    >>> foliation.s_min > 0, foliation.alignment.median < 5.0  # degrees
    (True, True)
    """

    field: FaceField
    part: Part
    s: Scalars
    circle: CircleFunction
    energies: tuple[float, ...]
    theta_changes: tuple[float, ...]
    s_changes: tuple[float, ...]

    @property
    def alignment(self) -> Alignment:
        """How far level sets and field disagree, how evenly they are spaced, and the dislocations."""
        return alignment(self.field, self.circle)

    @property
    def s_min(self) -> float:
        """Smallest s as a share of its area mean."""
        areas = self.part.mesh.face_areas
        return float(self.s.min() / np.average(self.s, weights=areas))


def punctured(field: FaceField) -> tuple[FaceField, Part]:
    """Remove every singular vertex of a field together with the faces round it (Section 4.2.2).

    Returns
    -------
    field, part : the unit field on what is left, and what is left as a part of the surface

    Raises
    ------
    MeshError
        If every face touches a singular vertex.
    """
    mesh = field.mesh
    singular = vertex_indices(field) != 0
    kept = ~singular[mesh.faces].any(axis=1)
    if not kept.any():
        raise MeshError(
            f"all {mesh.n_faces} faces touch a singular vertex of the field and nothing is left; "
            "ask for more triangles (--faces N)"
        )
    part = part_of(mesh, kept)
    return FaceField(part.mesh, field.normalized().values[part.faces]), part


def global_scale(field: FaceField, s: Scalars, quantile: float = 1.0) -> float:
    """Find the factor pi / rho that keeps theta from turning too fast for the mesh (footnote 4).

    The paper's ``rho = max over edges |s_i w-perp_i . e_ij|`` allows half a turn on any edge. Here rho is a
    quantile of the same numbers: a change along an edge is stored with its full turns and cannot alias, and
    one edge near a singularity need not coarsen the whole surface (DEVIATIONS.md, global-scale).

    Parameters
    ----------
    field : the field w
    s : (F,) factors, of any scale
    quantile : share of edges with at most half a turn, in (0, 1]; 1 is the paper's maximum

    Raises
    ------
    FieldError
        If the quantile is out of range.
    """
    if not 0 < quantile <= 1:
        raise FieldError(f"the quantile of the global scale must be a share in (0, 1], not {quantile}")
    turn = np.abs(s[:, None] * along_edges(field))
    return float(np.pi / np.quantile(turn, quantile))


def foliate(
    field: FaceField,
    *,
    scale: float = 1.0,
    rescaling: Method | Scalars | None = "logarithm",
    weighting: Weighting = "relative",
    quantile: float = QUANTILE,
    alternations: int = 10,
    tolerance: float = 1e-4,
    steps: Steps = "joint",
    smoothness: float = SMOOTHNESS,
    seed: int = 0,
    ordering: Ordering | None = None,
    triples: Triples | None = None,
    callback: Callable[[int, float], None] | None = None,
) -> Foliation:
    """Integrate a field to a circle-valued function whose level sets follow it (steps 2 to 5 of 4.2.5).

    Puncture, find a first s, scale it, then alternate: theta from the smallest eigenvector of a Hermitian
    matrix, where that lowers the energy; a Gauss-Newton step in theta and s together; one in s alone, which
    keeps it positive (DEVIATIONS.md, joint-step). They minimise

        sum_i sum_ab  c_ab / shat_i^2 (1 - cos(theta_b - theta_a - s_i w-perp_i . e_ab))
                      + mu/2 |grad(s / shat)|^2

    over the faces i and their edges ab, c half the cotangent of the corner opposite.

    With ``weighting="uniform"`` shat is the mean of the first s on each component: Eq. 8 of the paper, but
    for a constant. With "relative" it is the first s: a disagreement counts by its angle (weighting).

    Parameters
    ----------
    field : the field w; the lengths of its vectors do not matter. One that was sharpened no further than
        ``sharpening_schedule(mesh, finest=INTEGRABLE_END)`` has no domain walls and integrates best
    scale : the user's factor on the frequency of theta, after the automatic one
    rescaling : how the first s is found (`integrating_factor`); a positive factor per face of the punctured
        surface (F',) or of the whole one (F,); None for s = 1
    weighting, quantile : see above and `global_scale`
    alternations : how often theta and s are updated at most
    tolerance : an alternation that lowers the energy by no more than this share is the last; none if negative
    steps : of each alternation: "joint" in theta and s together, "turns" in one after the other as the paper
        does, "theta" in theta alone, at the first s
    smoothness : mu of Eq. 8, in squared bounding radii
    seed : start of the first eigenvector iteration
    ordering : of `vertices_and_faces` on the punctured surface, with the places of triples; made if not given
    callback : called with the number of each alternation and its energy

    Raises
    ------
    FieldError
        If a parameter is out of range, or phases are coupled and the steps not joint.
    MeshError
        If every face touches a singular vertex.

    Examples
    --------
    >>> torus = gw.shapes.torus(faces=400)
    >>> foliation = gw.foliate(gw.smoothest_field(torus), scale=0.8)
    >>> bool((np.diff(foliation.energies) <= 0).all()), len(gw.isolines(foliation)) > 2
    (True, True)
    """
    _check(scale, alternations, weighting, steps, triples is not None)
    w, part = punctured(field)
    coupled = None if triples is None else triples.on(part)
    ordering = ordering or vertices_and_faces(w.mesh, None if coupled is None else coupled.places)
    first = _first_factor(w, part, rescaling, ordering)
    s = scale * global_scale(w, first, quantile) * first
    unit = s if weighting == "relative" else w.mesh.component_means(s)[w.mesh.face_components]
    mu = smoothness * field.mesh.bounding_radius**2
    with one_blas_thread():
        if coupled is None:
            problem = Alternation(w, s, unit, mu, ordering)
            found = _alternated(problem, problem.start(seed), s, alternations, tolerance, steps, callback)
        else:
            found = _regular(RegularSteps(w, s, unit, mu, ordering, coupled), s, seed, callback)
    circle = CircleFunction.nearest(w.mesh, found.theta, edge_prediction(w, found.s))
    _check_frequency(circle, found.s)
    changes = tuple(found.theta_changes), tuple(found.s_changes)
    return Foliation(w, part, frozen(found.s), circle, tuple(found.energies), *changes)


def _check(scale: float, alternations: int, weighting: str, steps: Steps, coupled: bool) -> None:
    if steps not in get_args(Steps):
        raise FieldError(f"there are no steps '{steps}': {', '.join(get_args(Steps))}")
    if coupled and steps != "joint":
        raise FieldError("the phases of families cannot be coupled while s is held, or in turns")
    if not (np.isfinite(scale) and scale > 0):
        raise FieldError(f"the scale of a foliation must be a positive number, not {scale}")
    if alternations < 1:
        raise FieldError(f"a foliation needs one alternation or more, not {alternations}")
    if weighting not in ("relative", "uniform"):
        raise FieldError(f"there is no weighting '{weighting}': relative or uniform")


def _check_frequency(circle: CircleFunction, s: Scalars) -> None:
    """Refuse a theta that turns much more slowly than s asks for."""
    areas = circle.mesh.face_areas
    wanted, got = (np.average(each, weights=areas) for each in (s, np.abs(circle.gradient)))
    if got < LEAST_FREQUENCY * wanted:
        raise FieldError(
            "the level sets would lie farther apart than the surface is wide, so theta is nearly constant; "
            "ask for a larger scale"
        )


@dataclass
class _Course:
    """Where the alternation has come to, and how (`Foliation` says what the lists hold)."""

    theta: Scalars
    s: Scalars
    energies: list[float]
    theta_changes: list[float]
    s_changes: list[float]


def _alternated(
    problem: Alternation,
    z: Complexes,
    s: Scalars,
    alternations: int,
    tolerance: float,
    kind: Steps,
    callback: Callable[[int, float], None] | None,
) -> _Course:
    """Update theta and s in turns, from the eigenvector at the first s."""
    areas = problem.mesh.face_areas
    z, theta = problem.eigenvector(z, None, s)
    course = _Course(theta, s, [problem.energy(theta, s)], [], [])
    searching = True
    for number in range(1, alternations + 1):
        old_theta, old_s = theta, s
        if number > 1 and searching:
            z, theta = problem.eigenvector(z, theta, s)
            # Where it did not help once, theta has settled, and it does not help later either.
            searching = theta is not old_theta or kind == "turns"
        if kind == "theta":
            theta = problem.improve_theta(theta, s)
        elif kind == "joint":
            theta, s = problem.improve_both(theta, s)
        if kind != "theta":
            s = problem.improve_s(theta, s)
        course.theta, course.s = theta, s
        course.energies.append(problem.energy(theta, s))
        course.theta_changes.append(problem.theta_change(old_theta, theta))
        course.s_changes.append(float(np.sqrt(np.average((s / old_s - 1.0) ** 2, weights=areas))))
        if callback is not None:
            callback(number, course.energies[-1])
        if course.energies[-2] - course.energies[-1] <= tolerance * course.energies[-1]:
            break
    return course


def _regular(
    problem: RegularSteps, s: Scalars, seed: int, callback: Callable[[int, float], None] | None
) -> _Course:
    """Take the steps of `regular_course`."""
    areas, states = problem.mesh.face_areas, regular_course(problem, s, seed)
    theta, s = next(states)
    course = _Course(theta, s, [problem.energy(theta, s)], [], [])
    for number, (theta, s) in enumerate(states, 1):
        course.energies.append(problem.energy(theta, s))
        course.theta_changes.append(problem.theta_change(course.theta, theta))
        course.s_changes.append(float(np.sqrt(np.average((s / course.s - 1.0) ** 2, weights=areas))))
        course.theta, course.s = theta, s
        if callback is not None:
            callback(number, course.energies[-1])
    return course


def _first_factor(
    w: FaceField, part: Part, rescaling: Method | Scalars | None, ordering: Ordering
) -> Scalars:
    if rescaling is None:
        return np.ones(w.mesh.n_faces)
    if isinstance(rescaling, str):
        s = integrating_factor(w, method=rescaling, ordering=ordering).s
        # Eq. 7 may come out with faces of the wrong sign; theta needs a positive factor everywhere.
        return np.maximum(s, LEAST_FIRST * float(np.median(s)))
    s = np.asarray(rescaling, dtype=np.float64)
    if s.shape == (part.whole.n_faces,):
        s = s[part.faces]
    if s.shape != (w.mesh.n_faces,) or not (np.isfinite(s) & (s > 0)).all():
        raise FieldError(
            f"a first integrating factor needs one positive number for each of the {w.mesh.n_faces} faces "
            "of the punctured surface"
        )
    return s


def edge_prediction(field: FaceField, s: Scalars) -> Scalars:
    """(E,) change of theta expected along each edge, ``s w-perp . e``, the mean of its faces', radians."""
    mesh = field.mesh
    turn = s[:, None] * along_edges(field) * mesh.bundle.forms
    total = np.bincount(mesh.face_edges.ravel(), turn.ravel(), mesh.n_edges)
    return np.asarray(total / np.bincount(mesh.face_edges.ravel(), minlength=mesh.n_edges))
