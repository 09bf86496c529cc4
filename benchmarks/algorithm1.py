"""Measure Algorithm 1 on one sphere: total, stages, peak memory, and the limit it is compared with."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter

import numpy as np

from benchmarks.memory import peak_gigabytes
from geoweave.arrays import Complexes
from geoweave.fields.closed_projection import ClosedProjection, ordering_of
from geoweave.fields.face_field import total_curl
from geoweave.fields.geodesic import geodesic_field, sharpening_schedule
from geoweave.fields.operators import ClosedFields
from geoweave.fields.rosy import smoothest_field
from geoweave.models.shapes import sphere
from geoweave.sparse import cholesky
from geoweave.sparse.factorization import factorized, nested_dissection
from geoweave.surface.mesh import TriMesh


class Count:
    """How often a projection was called."""

    calls = 0


@contextmanager
def counting() -> Iterator[Count]:
    """Count the linear systems that are solved inside a block."""
    count, original = Count(), ClosedProjection.__call__

    def counted(self: ClosedProjection, w: Complexes) -> tuple[Complexes, float]:
        count.calls += 1
        return original(self, w)

    ClosedProjection.__call__ = counted  # type: ignore[method-assign]
    try:
        yield count
    finally:
        ClosedProjection.__call__ = original  # type: ignore[method-assign]


def compile_first() -> None:
    """Have numba compile, or load what it compiled before, outside of what is timed."""
    mesh = sphere(subdivisions=3)
    fields = ClosedFields(mesh)
    symbolic = cholesky.analysed(fields.mass, nested_dissection(fields.mass).order)
    cholesky.solve(symbolic, cholesky.factor(fields.mass, symbolic), np.ones(fields.mass.shape[0]))


def measure(subdivisions: int) -> dict:
    compile_first()
    made = sphere(subdivisions=subdivisions)
    mesh = TriMesh(made.vertices, made.faces)
    clock = perf_counter()
    start = smoothest_field(mesh)
    started = perf_counter() - clock

    with counting() as counted:
        clock = perf_counter()
        solve = geodesic_field(start)
        total = perf_counter() - clock
    memory = peak_gigabytes()

    clock = perf_counter()
    fields = ClosedFields(mesh)
    ordering = ordering_of(fields)
    _ = fields.mass, fields.basis_transposed
    setup = perf_counter() - clock
    schedule = sharpening_schedule(mesh)
    clock = perf_counter()
    project = ClosedProjection(fields, schedule[-1], ordering)
    factor = (perf_counter() - clock) * len(schedule)
    clock = perf_counter()
    for _ in range(5):
        project(start.values)
    step = (perf_counter() - clock) / 5

    systems = counted.calls
    limit = cotan_limit(fields, systems)
    return {
        "faces": mesh.n_faces,
        "start": started,
        "total": total,
        "setup": setup,
        "factor": factor,
        "steps": step * systems,
        "iterations": systems,
        "limit": limit,
        "multiple": total / limit,
        "memory_gb": memory,
        "curl": total_curl(solve.field),
    }


def cotan_limit(fields: ClosedFields, solves: int) -> float:
    """Seconds for one factorisation of the cotan Laplacian (its ordering included) and ``solves`` solves."""
    laplacian = fields.mass
    right = np.random.default_rng(0).normal(size=laplacian.shape[0])
    clock = perf_counter()
    factors = factorized(laplacian, nested_dissection(laplacian))
    factoring = perf_counter() - clock
    clock = perf_counter()
    for _ in range(5):
        factors.solve(right)
    return factoring + solves * (perf_counter() - clock) / 5


if __name__ == "__main__":
    print(json.dumps(measure(int(sys.argv[1]))))
