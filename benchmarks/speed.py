"""Measure a regular weave beside a free one, the limit of its foliation, and a search for a number."""

from __future__ import annotations

import json
import sys
from time import perf_counter
from typing import Any

from benchmarks.cover import compile_all
from geoweave.meshing.remesh import isotropic_remesh
from geoweave.models import catalogue
from geoweave.sparse import reuse
from geoweave.sparse.factorization import Factorization, factorized
from geoweave.weave.design import weave_field

WANTED = (60, 100)
"""Numbers of ribbons that are searched for, on a mesh of `SEARCHED` faces."""

SEARCHED = 5_600

FACTORISATIONS = 4
"""Of the joint matrix, in the limit of a foliation; the solves are those that were made."""


class Timed:
    """Factors that note the seconds of their solves."""

    def __init__(self, factors: Factorization, seconds: list[float]) -> None:
        self._factors, self._seconds = factors, seconds

    def __getattr__(self, name: str) -> Any:
        return getattr(self._factors, name)

    def solve(self, right: Any) -> Any:
        """Solve, and note how long it took."""
        clock = perf_counter()
        found = self._factors.solve(right)
        self._seconds.append(perf_counter() - clock)
        return found


def woven(faces: int, phase: str) -> dict:
    """Stages of one weave of the bunny, and the factorisations and solves of its joint steps."""
    mesh = isotropic_remesh(catalogue.load("bunny"), faces)
    made: list[float] = []
    solves: list[float] = []

    def noted(*arguments: Any) -> Any:
        clock = perf_counter()
        factors = factorized(*arguments)
        made.append(perf_counter() - clock)
        return Timed(factors, solves)

    try:
        reuse.factorized = noted  # type: ignore[assignment]
        field = weave_field(mesh, phase=phase)  # type: ignore[arg-type]
        first = field.seconds["foliation"]
        weave = field.pattern()
    finally:
        reuse.factorized = factorized
    joint = weave.design.seconds["foliation"] - first
    limit = FACTORISATIONS * min(made) + sum(solves)
    return {
        "seconds": weave.design.seconds,
        "total": sum(weave.design.seconds.values()),
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
