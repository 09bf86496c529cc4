"""Measure a regular weave beside a free one, the limit of its foliation, and a search for a number."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from time import process_time
from typing import Any

import numpy as np

from benchmarks.cover import compile_all
from benchmarks.foliation import Counted
from geoweave.meshing.remesh import isotropic_remesh
from geoweave.models import catalogue
from geoweave.sparse import reuse
from geoweave.sparse.factorization import factorized, one_blas_thread
from geoweave.weave.design import weave_field

WANTED = (60, 100)
"""Numbers of ribbons that are searched for, on a mesh of `SEARCHED` faces."""

SEARCHED = 5_600

FACTORISATIONS = 4
"""Of the joint matrix, in the limit of a foliation; beside them as many solves as were made.

Both are timed in double precision, whatever the foliation itself uses: the limit does not move with it.
"""


class Clock:
    """CPU seconds of each stage, as it is told of them."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._name, self._since = "", process_time()

    def __call__(self, name: str) -> None:
        now = process_time()
        if self._name:
            self.seconds[self._name] = self.seconds.get(self._name, 0.0) + now - self._since
        self._name, self._since = name.split(":")[0], now


def seconds(work: Callable[[], Any]) -> float:
    """The least CPU seconds of three calls."""
    found = []
    for _ in range(3):
        clock = process_time()
        work()
        found.append(process_time() - clock)
    return min(found)


def woven(faces: int, phase: str) -> dict:
    """Stages of one weave of the bunny, and the factorisations and solves of its joint steps."""
    mesh = isotropic_remesh(catalogue.load("bunny"), faces)
    made: list[tuple[Any, ...]] = []
    solves: list[int] = []

    def noted(*arguments: Any, single: bool) -> Any:
        made.append(arguments)
        return Counted(factorized(*arguments, single=single), solves)

    clock = Clock()
    field = weave_field(mesh, phase=phase, callback=clock)  # type: ignore[arg-type]
    clock("")
    first = clock.seconds["foliation"]
    try:
        reuse.factorized = noted  # type: ignore[assignment]
        weave = field.pattern(callback=clock)
        clock("")
    finally:
        reuse.factorized = factorized
    joint = clock.seconds["foliation"] - first
    with one_blas_thread():
        factors = factorized(*made[-1])
        right = np.ones(factors.size)
        factor, solve = seconds(lambda: factorized(*made[-1])), seconds(lambda: factors.solve(right))
    limit = FACTORISATIONS * factor + len(solves) * solve
    return {
        "seconds": clock.seconds,
        "total": sum(clock.seconds.values()),
        "first_factor": first,
        "joint": joint,
        "limit": limit,
        "multiple": joint / limit,
        "factorisations": len(made),
        "solves": len(solves),
        "crossings": len(weave.ribbons.crossings),
        "alternation": weave.interlacing.alternation,
        "proven": weave.interlacing.proven,
    }


def measure(faces: int) -> dict:
    compile_all()
    regular, free = woven(faces, "regular"), woven(faces, "free")
    field = weave_field(isotropic_remesh(catalogue.load("bunny"), SEARCHED))
    searches = []
    for wanted in WANTED:
        found = field.pattern(ribbons=wanted)
        searches.append(
            {"wanted": wanted, "found": len(found.ribbons), "integrations": len(found.design.tried)}
        )
    return {
        "faces": faces,
        "regular": regular,
        "free": free,
        "phase_against_free": regular["joint"] / free["joint"],
        "searches": searches,
    }


if __name__ == "__main__":
    print(json.dumps(measure(int(sys.argv[1]))))
