"""Measure one delta step of Algorithm 1 by the reduced system and by the paper's KKT system."""

from __future__ import annotations

import json
import sys
from time import perf_counter

import numpy as np
from scipy.sparse.linalg import splu

from geoweave.comparisons.paper_systems import kkt_system
from geoweave.fields.closed_projection import ClosedProjection, ordering_of
from geoweave.fields.face_field import random_field
from geoweave.fields.operators import ClosedFields, as_complex
from geoweave.models.shapes import sphere

SMOOTHNESS = 1e-3


def measure(subdivisions: int) -> dict:
    mesh = sphere(subdivisions=subdivisions)
    field = random_field(mesh, 0)
    clock = perf_counter()
    fields = ClosedFields(mesh)
    project = ClosedProjection(fields, SMOOTHNESS, ordering_of(fields))
    v, _ = project(field.values)
    reduced = perf_counter() - clock

    clock = perf_counter()
    matrix, right, free = kkt_system(field, SMOOTHNESS)
    factors = splu(matrix)
    delta = as_complex(factors.solve(right)[: len(free)])
    kkt = perf_counter() - clock
    return {
        "faces": mesh.n_faces,
        "reduced": {"unknowns": project.size, "seconds": reduced, "fill": project.fill},
        "kkt": {"unknowns": len(right), "seconds": kkt, "fill": int(factors.nnz)},
        "ratio": kkt / reduced,
        "difference": float(np.abs(field.values + delta - v).max()),
    }


if __name__ == "__main__":
    print(json.dumps(measure(int(sys.argv[1]))))
