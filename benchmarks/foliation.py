"""Measure field, s and theta on one surface of genus 4: stages, memory, and the limit they compare with."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import Any

import numpy as np

from benchmarks.algorithm1 import compile_first
from benchmarks.memory import peak_gigabytes
from geoweave.fields.geodesic import INTEGRABLE_END, geodesic_field, sharpening_schedule
from geoweave.fields.operators import ClosedFields
from geoweave.fields.rosy import smoothest_field
from geoweave.foliation import integrability, theta_systems
from geoweave.foliation.foliation import foliate, punctured
from geoweave.foliation.integrability import integrating_factor
from geoweave.models.shapes import genus_g
from geoweave.sparse import reuse
from geoweave.sparse.factorization import Factorization, factorized, nested_dissection
from geoweave.surface.mesh import TriMesh


class Counted:
    """Factors that count their solves in the list they are given."""

    def __init__(self, factors: Factorization, solves: list[int]) -> None:
        self._factors, self._solves = factors, solves

    def __getattr__(self, name: str) -> Any:
        return getattr(self._factors, name)

    def solve(self, right: Any) -> Any:
        """Solve, and count it."""
        self._solves.append(1)
        return self._factors.solve(right)


@contextmanager
def counting() -> Iterator[tuple[list[int], list[int]]]:
    """Count the factorisations and the solves of integration inside a block."""
    made: list[int] = []
    solves: list[int] = []

    def counted(*arguments: Any, **precision: Any) -> Any:
        made.append(1)
        return Counted(factorized(*arguments, **precision), solves)

    try:
        for module in (theta_systems, integrability, reuse):
            module.factorized = counted  # type: ignore[attr-defined]
        yield made, solves
    finally:
        for module in (theta_systems, integrability, reuse):
            module.factorized = factorized  # type: ignore[attr-defined]


def timed(work: Callable[[], Any]) -> tuple[Any, float]:
    """Return what a call returns, and its seconds."""
    clock = perf_counter()
    result = work()
    return result, perf_counter() - clock


def measure(faces: int) -> dict:
    compile_first()
    made = genus_g(4, faces=faces)
    mesh = TriMesh(made.vertices, made.faces).normalized()[0]
    start, smoothest = timed(lambda: smoothest_field(mesh))
    schedule = sharpening_schedule(mesh, finest=INTEGRABLE_END)
    solve, geodesic = timed(lambda: geodesic_field(start, smoothness=schedule, phases=4))
    with counting() as (factors, solves):
        (w, part), puncture = timed(lambda: punctured(solve.field))
        factor, first = timed(lambda: integrating_factor(w))
        found, joint = timed(lambda: foliate(solve.field, rescaling=factor.s))
    system = ClosedFields(part.mesh).mass
    ordering, order_seconds = timed(lambda: nested_dissection(system))
    one, factor_seconds = timed(lambda: factorized(system, ordering))
    right = np.random.default_rng(0).normal(size=system.shape[0])
    solve_seconds = min(timed(lambda: one.solve(right))[1] for _ in range(5))
    integrating = puncture + first + joint
    limit = order_seconds + len(factors) * factor_seconds + len(solves) * solve_seconds
    measured = found.alignment
    return {
        "faces": mesh.n_faces,
        "genus": mesh.genus,
        "smoothest": smoothest,
        "geodesic": geodesic,
        "puncture": puncture,
        "rescaling": first,
        "joint": joint,
        "total": smoothest + geodesic + integrating,
        "factorisations": len(factors),
        "solves": len(solves),
        "limit": limit,
        "multiple": integrating / limit,
        "memory_gb": peak_gigabytes(),
        "median_deviation_deg": measured.median,
        "dislocations": measured.dislocations,
        "s_min": found.s_min,
    }


if __name__ == "__main__":
    print(json.dumps(measure(int(sys.argv[1]))))
