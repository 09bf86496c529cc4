"""Measure the cover pipeline on one bunny, from RoSy to crossings: stages, memory, and its limit."""

from __future__ import annotations

import json
import sys
from itertools import pairwise
from time import perf_counter, process_time

import numpy as np

from benchmarks.algorithm1 import compile_first
from benchmarks.foliation import counting, timed
from benchmarks.memory import peak_gigabytes
from geoweave.fields.operators import ClosedFields
from geoweave.meshing.remesh import isotropic_remesh
from geoweave.models import catalogue
from geoweave.models.shapes import icosahedron
from geoweave.sparse import factorization
from geoweave.sparse.factorization import factorized, nested_dissection
from geoweave.weave.design import weave_pattern

STAGES = ("rosy", "cover", "field", "foliation", "ribbons", "interlacing")


def compile_all() -> None:
    """Have numba compile, or load, what a large weave and a small one need."""
    compile_first()
    small, usual = icosahedron(720), factorization.LARGE
    try:
        for factorization.LARGE in (usual, 100):
            weave_pattern(small)
    finally:
        factorization.LARGE = usual


def measure(faces: int) -> dict:
    mesh = isotropic_remesh(catalogue.load("bunny"), faces)
    compile_all()
    begun: list[tuple[str, float, float]] = []

    def note(name: str) -> None:
        begun.append((name.split(":")[0].split(" ")[0], perf_counter(), process_time()))

    before = peak_gigabytes()
    with counting() as (factors, solves):
        weave = weave_pattern(mesh, callback=note)
    note("end")
    wall, cpu = dict.fromkeys(STAGES, 0.0), dict.fromkeys(STAGES, 0.0)
    for (stage, clock, work), (_, next_clock, next_work) in pairwise(begun):
        wall[stage] += next_clock - clock
        cpu[stage] += next_work - work
    surface = weave.design.foliation.part.mesh
    system = ClosedFields(surface).mass
    ordering, order_seconds = timed(lambda: nested_dissection(system))
    one, factor_seconds = timed(lambda: factorized(system, ordering))
    right = np.random.default_rng(0).normal(size=system.shape[0])
    solve_seconds = min(timed(lambda: one.solve(right))[1] for _ in range(5))
    numbers = weave.metrics()
    return {
        "faces": mesh.n_faces,
        "faces_solved_on": surface.n_faces,
        "total": sum(wall.values()),
        "cpu": sum(cpu.values()),
        "seconds": wall,
        "cpu_seconds": cpu,
        "factorisations": len(factors),
        "solves": len(solves),
        "limit": order_seconds + len(factors) * factor_seconds + len(solves) * solve_seconds,
        "memory_gb": peak_gigabytes(),
        "memory_before_gb": before,
        "ribbons": numbers["ribbons"],
        "crossings": numbers["crossings"],
        "deviation_deg": numbers["deviation_deg"],
        "dislocations": numbers["dislocations"],
        "alternation": numbers["alternation"],
    }


if __name__ == "__main__":
    print(json.dumps(measure(int(sys.argv[1]))))
