"""A search over the singularities of a weave by the energy of its finished field (Section 6, future work).

"Use our energy as a metric to power a search over the space of singularities": a trial moves index from
vertex to vertex, finds the geodesic field on the new cover, and is kept or not by the energy it ends with.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from geoweave.arrays import Indices
from geoweave.errors import FieldError
from geoweave.fields import (
    INTEGRABLE_END,
    EdgePaths,
    RoSyField,
    geodesic_field,
    moved,
    sharpening_schedule,
    total_curl,
)
from geoweave.weave.cover import branched_cover

__all__ = ["Stage", "finished_energy", "searched"]

CANDIDATES = 6
"""So many pairs, the nearest, are tried before one of them is merged."""

STRIDE = 3.0
"""Farthest that a singularity moves in one try, in mean edges."""

Kind: TypeAlias = Literal["start", "merge", "move"]


@dataclass(frozen=True, eq=False)
class Stage:
    """A set of singularities that the search kept, and the finished field on it.

    Attributes
    ----------
    rosy : with these singularities
    kind : how it came from the stage before
    energy : of Eq. 5 at the last smoothness, over the area of the cover: a number
    curl : total curl of the field on the sheets that it is solved on, a length
    tried : fields that were computed up to here
    """

    rosy: RoSyField
    kind: Kind
    energy: float
    curl: float
    tried: int

    @property
    def number(self) -> int:
        """Branch points."""
        return len(self.rosy.branch_points)


def finished_energy(rosy: RoSyField) -> tuple[float, float]:
    """Find the geodesic field on the cover of a RoSy: its energy over the area, and its total curl.

    More branch points leave less area, so energies are compared as means.
    """
    field = branched_cover(rosy).quotient.field
    solve = geodesic_field(field, smoothness=sharpening_schedule(field.mesh, finest=INTEGRABLE_END))
    return float(solve.energies[-1] / field.mesh.face_areas.sum()), total_curl(solve.field)


def searched(
    rosy: RoSyField,
    *,
    fewest: int = 0,
    tries: int = 0,
    seed: int = 0,
    callback: Callable[[Stage], None] | None = None,
) -> tuple[Stage, ...]:
    """Search for singularities by the energy of the finished field.

    By turns the pair of opposite indices is merged that costs the least energy, of the nearest pairs, until
    so many branch points are left; then each branch point is moved to vertices near it, and stays where the
    energy falls. What merging does to the energy is recorded, not bounded: the stages are a front of the
    number of branch points against energy and curl (DEVIATIONS.md, searched).

    Parameters
    ----------
    rosy : where the search starts
    fewest : merge until so many branch points are left, or no opposite pair
    tries : vertices that each branch point tries at the end
    seed : of the vertices that are tried
    callback : called with every stage that is kept

    Returns
    -------
    Every stage that was kept, the start first.

    Raises
    ------
    FieldError
        If a number is negative.

    Examples
    --------
    >>> from geoweave.weave import searched
    >>> mesh = gw.shapes.genus_g(2, faces=600)
    >>> stages = searched(gw.smoothest_rosy(mesh), fewest=34)
    >>> [stage.kind for stage in stages], stages[-1].number < stages[0].number
    (['start', 'merge'], True)
    """
    if fewest < 0 or tries < 0:
        raise FieldError(f"neither branch points left ({fewest}) nor tries ({tries}) can be negative")
    energy, curl = finished_energy(rosy)
    stages = [Stage(rosy, "start", energy, curl, 1)]

    def keep(found: RoSyField, kind: Kind, measured: tuple[float, float], tried: int) -> None:
        stages.append(Stage(found, kind, *measured, tried))
        if callback is not None:
            callback(stages[-1])

    tried = 1
    while stages[-1].number > fewest:
        pairs = _nearest_pairs(stages[-1].rosy)
        if not pairs:
            break
        trials = [moved(stages[-1].rosy, [pair]) for pair in pairs]
        measured = [finished_energy(trial) for trial in trials]
        tried += len(trials)
        best = min(range(len(trials)), key=lambda k: measured[k])
        keep(trials[best], "merge", measured[best], tried)
    rng = np.random.default_rng(seed)
    for vertex in stages[-1].rosy.branch_points:
        for target in _places_near(stages[-1].rosy, int(vertex), tries, rng):
            before = stages[-1].rosy
            trial = _carried(before, int(vertex), int(target))
            result, tried = finished_energy(trial), tried + 1
            if result[0] < stages[-1].energy:
                keep(trial, "move", result, tried)
                break
    return tuple(stages)


def _nearest_pairs(rosy: RoSyField) -> list[tuple[int, int]]:
    """The nearest pairs of a positive and a negative index, each singularity in one pair at most."""
    index = rosy.index_numerators
    positive, negative = np.flatnonzero(index > 0), np.flatnonzero(index < 0)
    if not len(positive) or not len(negative):
        return []
    far, _ = EdgePaths(rosy.mesh).within(positive, np.inf)
    near = far[:, negative]
    order = np.argsort(near, axis=None, kind="stable")
    rows, columns = np.unravel_index(order[np.isfinite(near.ravel()[order])], near.shape)
    pairs: list[tuple[int, int]] = []
    for a, b in zip(positive[rows].tolist(), negative[columns].tolist(), strict=True):
        if len(pairs) < CANDIDATES and not any(a == p or b == n for p, n in pairs):
            pairs.append((a, b))
    return pairs


def _places_near(rosy: RoSyField, vertex: int, count: int, rng: np.random.Generator) -> Indices:
    """Regular vertices inside the surface within a stride of one, drawn at random."""
    mesh = rosy.mesh
    if not count:
        return np.empty(0, dtype=np.int64)
    far, _ = EdgePaths(mesh).within(np.array([vertex]), STRIDE * mesh.mean_edge)
    free = np.isfinite(far[0]) & ~mesh.boundary_vertices & (rosy.index_numerators == 0)
    places = np.flatnonzero(free)
    return np.asarray(rng.choice(places, min(count, len(places)), replace=False), dtype=np.int64)


def _carried(rosy: RoSyField, vertex: int, target: int) -> RoSyField:
    """Move all of the index of a vertex to another."""
    index = int(rosy.index_numerators[vertex])
    step = (vertex, target) if index > 0 else (target, vertex)
    return moved(rosy, [step] * abs(index))
