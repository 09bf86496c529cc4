"""Discrete geodesic fields: Algorithm 1 on the reduced system (Sections 4.1.1 to 4.1.3, Appendix B)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from scipy import sparse

from geoweave.arrays import Complexes, Scalars
from geoweave.errors import FieldError
from geoweave.fields.closed_projection import ClosedProjection, ordering_of
from geoweave.fields.face_field import FaceField, Handles
from geoweave.fields.operators import AllFields, ClosedFields
from geoweave.fields.triples import Triples
from geoweave.fields.zero_sum import LAST_ETA, ZeroSum, falling_weights
from geoweave.sparse import Ordering, analysed, one_blas_thread
from geoweave.surface import TriMesh

Acceleration: TypeAlias = Literal["momentum", "none"]
"""How a step of Algorithm 1 starts: at the last field, or past it (DEVIATIONS.md, momentum)."""

SHARPENING_START = 0.02
"""First smoothness of the default schedule, in squared bounding radii."""

SHARPENING_END = 5e-3
"""Last smoothness of the default schedule, in squared `TriMesh.triangle_size`."""

INTEGRABLE_END = 4.0
"""Last smoothness, in squared `TriMesh.triangle_size`, of a field that is to be integrated (`foliate`)."""

ROUNDING = 1e-6
"""Rise of the energy, as a share of it, up to which it is rounding; slivers cost 2e-7 on a remeshed scan."""

AREA_ROUNDING = 1e-11
"""Rise of the energy, as a share of the area, up to which it is rounding; for fields that have hardly any."""

PROBING_STEPS = 10
"""Steps from each rotation of the initial field before the most promising one is chosen."""

LEVELS = 3
"""Values of lambda in the default schedule."""

STEPS = 25
"""Most steps of Algorithm 1 at one value of lambda."""

LAST_STEPS = 2
"""So many times `STEPS` are allowed at the last value of lambda, which decides the field."""

STILL = 1e-4
"""A value of lambda is done when the root mean square change of the unit field in a step is below this."""


def sharpening_schedule(
    mesh: TriMesh, levels: int = LEVELS, finest: float = SHARPENING_END
) -> tuple[float, ...]:
    """Smoothness weights from coarse to fine, a geometric sequence ("sharpening", Section 4.1.2).

    From 0.02 R^2, R the bounding radius, to 0.005 h^2, h the size of the triangles (the mean edge length
    unless they are long and thin, `TriMesh.triangle_size`): first the field settles as
    a whole, then its curl gathers on points and lines. The values were chosen by measurement
    (DEVIATIONS.md, sharpening).

    Parameters
    ----------
    mesh : the surface
    levels : number of weights
    finest : the last weight, in h^2. `INTEGRABLE_END`, a smoothing length of two edges, suits a field that is
        to be integrated: it leaves no domain walls, across which no theta is smooth (DEVIATIONS.md,
        integrable-field)

    Returns
    -------
    (levels,) lambda, unit length^2

    Examples
    --------
    >>> coarse, middle, fine = gw.sharpening_schedule(gw.shapes.sphere(faces=320))
    >>> round(coarse, 3), bool(np.isclose(middle**2, coarse * fine))
    (0.02, True)
    """
    radius = mesh.bounding_radius
    first, last = SHARPENING_START * radius**2, finest * mesh.triangle_size**2
    return tuple(float(value) for value in np.geomspace(max(first, last), last, levels))


@dataclass(frozen=True)
class Step:
    """One step of Algorithm 1, as the progress callback and the history see it.

    Attributes
    ----------
    smoothness : lambda, unit length^2
    energy : 1/2 |delta|^2 + lambda/2 |grad(w + delta)|^2 after the step (Eq. 5), unit length^2; with sheets
        that are coupled, and what `ZeroSum` adds
    change : root mean square of |w - previous w| over the surface
    """

    smoothness: float
    energy: float
    change: float


Callback: TypeAlias = Callable[[Step, FaceField], None]
"""Called after every step of Algorithm 1 with the step and the unit field it reached."""


@dataclass(frozen=True, eq=False)
class GeodesicSolve:
    """A discrete geodesic field and how Algorithm 1 came to it.

    Attributes
    ----------
    initial : the unit field it started from, after the choice of a phase if there was one
    field : the unit field w
    delta : the perturbation of Eq. 4, ``C (w + delta) = 0``, zero on handles; parallel to w once converged
    steps : every step, in order; within one smoothness the energy never rises
    converged : whether the last smoothness ended by the stopping test, not by its number of steps

    Examples
    --------
    >>> solve = gw.geodesic_field(gw.smoothest_field(gw.shapes.torus(faces=400)))
    >>> closed = solve.field + solve.delta
    >>> solve.converged, bool(abs(gw.edge_curl(closed)).max() < 1e-9)
    (True, True)
    """

    initial: FaceField
    field: FaceField
    delta: FaceField
    steps: tuple[Step, ...]
    converged: bool

    @property
    def iterations(self) -> int:
        """Number of steps of Algorithm 1, without those that only tried a phase."""
        return len(self.steps)

    @property
    def energies(self) -> Scalars:
        """(iterations,) energy after each step; comparable where the smoothness is the same."""
        return np.array([step.energy for step in self.steps])


@one_blas_thread()
def geodesic_field(
    initial: FaceField,
    *,
    smoothness: Sequence[float] | None = None,
    iterations: int = STEPS,
    tolerance: float = STILL,
    handles: Handles | None = None,
    phases: int = 1,
    acceleration: Acceleration = "momentum",
    curl_free: bool = True,
    triples: Triples | None = None,
    eta: float = LAST_ETA,
    callback: Callback | None = None,
) -> GeodesicSolve:
    """Compute a discrete geodesic field by Algorithm 1.

    Minimises ``1/2 |delta|^2 + lambda/2 |grad(w + delta)|^2`` subject to ``C (w + delta) = 0``, ``|w_i| = 1``
    and ``w_i = w_i^H``, ``delta_i = 0`` on the handles (Eq. 5), by turns in delta and in w, while lambda
    falls (Section 4.1.2). Each step lowers the energy.

    Parameters
    ----------
    initial : start field, scaled to unit length
    smoothness : values of lambda, unit length^2, one after the other; `sharpening_schedule` by default
    iterations : most steps per value of lambda; the last one gets twice as many
    tolerance : a value of lambda is done when the root mean square change of w is below this
    handles : faces with prescribed directions
    phases : try so many common rotations of the initial field, spread over half a turn, for ten steps each
        at the first smoothness, and go on from the one of least energy (DEVIATIONS.md, phases). A smoothest
        field is as smooth after every such rotation; a field that means its directions wants 1.
    acceleration : ``"momentum"`` or, for the paper's plain alternation, ``"none"``
    curl_free : False removes the constraint ``C (w + delta) = 0`` from Eq. 5: the field is then only smooth,
        as in the comparison of Fig. 10
    triples, eta : sheets that are to stay 120 degrees apart, and what weighs it at the end, see `ZeroSum`
    callback : called after every step with the `Step` and the field

    Returns
    -------
    GeodesicSolve

    Raises
    ------
    FieldError
        If a smoothness is negative, there is none, the handles contradict one another, or phases or triples
        are asked for beside handles.

    See Also
    --------
    smoothest_field : the usual start
    foliate : the level sets that follow the field

    Examples
    --------
    >>> surface = gw.shapes.genus_g(2, faces=600)
    >>> start = gw.smoothest_field(surface)
    >>> solve = gw.geodesic_field(start)
    >>> gw.total_curl(solve.field) < gw.total_curl(start)
    True
    """
    mesh = initial.mesh
    schedule = sharpening_schedule(mesh) if smoothness is None else tuple(smoothness)
    handles = handles if handles is not None and len(handles.faces) else None
    _check(min(len(schedule), iterations, phases), acceleration, handles, phases, triples)
    terms = _terms(triples, len(schedule), eta)
    fields = ClosedFields(mesh) if curl_free else AllFields(mesh)
    ordering = ordering_of(fields)
    start = initial.normalized()
    w = start.values if handles is None else _with_handles(start.values, handles)
    steps: list[Step] = []
    converged = False
    # Not enumerate: it would keep the last projection, and its factors, while the next one is made.
    for project in _projections(fields, schedule, ordering, handles):
        sums = terms.pop(0)
        limit = iterations if terms else LAST_STEPS * iterations
        if len(terms) == len(schedule) - 1 and phases > 1:
            w = _promising_phase(project, w, phases, tolerance, acceleration, sums)
            start = FaceField(mesh, w)
        w, v, converged = _alternate(project, w, limit, tolerance, acceleration, steps, callback, sums)
        del project  # its factors make room for the next
    return GeodesicSolve(start, FaceField(mesh, w), FaceField(mesh, v - w), tuple(steps), converged)


def _check(
    fewest: int, acceleration: str, handles: Handles | None, phases: int, triples: Triples | None
) -> None:
    """Refuse numbers that are too small, a name that is none, and what cannot go with handles."""
    if fewest < 1:
        raise FieldError("Algorithm 1 needs at least one smoothness, one iteration and one phase")
    if acceleration not in ("momentum", "none"):
        raise FieldError(f"there is no acceleration '{acceleration}': use 'momentum' or 'none'")
    if phases > 1 and handles is not None:
        raise FieldError("handles fix the phase of the field: leave out the phases")
    if triples is not None and handles is not None:
        raise FieldError("handles fix directions of single sheets: leave out the handles or the triples")


def _terms(triples: Triples | None, levels: int, last: float) -> list[ZeroSum | None]:
    """What keeps sheets apart at each smoothness, if anything does; it falls with lambda."""
    return [None if triples is None else ZeroSum(triples, each) for each in falling_weights(levels, last)]


def _projections(
    fields: ClosedFields | AllFields, schedule: Sequence[float], ordering: Ordering, handles: Handles | None
) -> Iterator[ClosedProjection]:
    """Factor the system of each smoothness in turn, the next while the last is in use."""
    # What both threads read is computed before there are two of them; factoring works without the GIL.
    system = sparse.csr_array(fields.mass + schedule[0] * fields.smoothness)
    _ = fields.basis_transposed
    analysis = analysed(system, ordering) if len(schedule) > 1 and handles is None else ordering
    with ThreadPoolExecutor(max_workers=1) as ahead:
        upcoming = ahead.submit(ClosedProjection, fields, schedule[0], analysis, handles)
        for weight in schedule[1:]:
            project = upcoming.result()
            upcoming = ahead.submit(ClosedProjection, fields, weight, analysis, handles)
            yield project
            del project
        yield upcoming.result()


def _alternate(
    project: ClosedProjection,
    w: Complexes,
    limit: int,
    tolerance: float,
    acceleration: Acceleration,
    steps: list[Step],
    callback: Callback | None,
    sums: ZeroSum | None,
) -> tuple[Complexes, Complexes, bool]:
    """Algorithm 1 at one smoothness: w, its closed field v = w + delta, and whether w stood still."""
    mesh = project.fields.mesh

    def nearest(v: Complexes, w: Complexes) -> Complexes:
        return project.unit(v) if sums is None else sums.nearest(v, w)

    v, energy = _closed(project, w, sums)
    previous, momentum = w, 1.0
    for _ in range(limit):
        plain = nearest(v, w)
        trial = plain
        if acceleration == "momentum":
            # Nesterov's sequence: go on in the direction of the last step.
            following = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * momentum**2))
            trial = nearest(plain + (momentum - 1.0) / following * (plain - previous), plain)
            momentum = following
        trial_v, trial_energy = _closed(project, trial, sums)
        if trial_energy > energy and trial is not plain:
            # The safeguard: a plain step cannot raise the energy.
            trial, momentum = plain, 1.0
            trial_v, trial_energy = _closed(project, trial, sums)
        if trial_energy > energy:
            if trial_energy > energy + ROUNDING * abs(energy) + AREA_ROUNDING * mesh.face_areas.sum():
                if not project.refine():
                    raise FieldError(
                        f"a step of Algorithm 1 raised the energy from {energy:.6g} to {trial_energy:.6g}: "
                        "the mesh is too distorted for double precision; remesh it (--faces N)"
                    )
                v, energy = _closed(project, w, sums)
                continue
            # Only rounding is left to gain: the field is stationary to working precision.
            return w, v, True
        change = float(np.sqrt(np.average(np.abs(trial - w) ** 2, weights=mesh.face_areas)))
        previous, w, v, energy = plain, trial, trial_v, trial_energy
        steps.append(Step(project.smoothness, energy, change))
        if callback is not None:
            callback(steps[-1], FaceField(mesh, w))
        if change < tolerance:
            return w, v, True
    return w, v, False


def _closed(project: ClosedProjection, w: Complexes, sums: ZeroSum | None) -> tuple[Complexes, float]:
    """The closed field v = w + delta and the energy, with what `ZeroSum` adds."""
    v, energy = project(w)
    return v, energy if sums is None else energy + sums.energy(w)


def _promising_phase(
    project: ClosedProjection,
    w: Complexes,
    phases: int,
    tolerance: float,
    acceleration: Acceleration,
    sums: ZeroSum | None,
) -> Complexes:
    """Of so many rotations of w, the one whose energy is least after the first steps from it."""
    rotated = [w * np.exp(1j * np.pi * k / phases) for k in range(phases)]
    energies = []
    for field in rotated:
        steps: list[Step] = []
        _alternate(project, field, PROBING_STEPS, tolerance, acceleration, steps, None, sums)
        energies.append(steps[-1].energy if steps else _closed(project, field, sums)[1])
    return rotated[int(np.argmin(energies))]


def _with_handles(values: Complexes, handles: Handles) -> Complexes:
    values = values.copy()
    values[handles.faces] = handles.values
    return values
