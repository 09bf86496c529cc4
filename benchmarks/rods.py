"""Measure sliding and relaxing of the weave of a model, or of a .rod file."""

from __future__ import annotations

import json
import sys
from time import perf_counter

from geoweave import models
from geoweave.departure import departure, held
from geoweave.relaxation import relax, slide
from geoweave.ribbon_rods import rods_of_file, rods_of_ribbons
from geoweave.rodfiles import read_rods
from geoweave.weave import weave_pattern


def relaxed(rods) -> tuple[dict, object]:
    clock = perf_counter()
    found = relax(rods)
    return {
        "segments": rods.layout.segments,
        "contacts": len(rods.contacts),
        "seconds": perf_counter() - clock,
        "steps": len(found.steps) - 1,
        "converged": found.converged,
        "gradient": found.gradient,
        "energies": found.energies,
    }, found.rods


def measure(name: str, ribbons: int) -> dict:
    if name.endswith(".rod"):
        rods = rods_of_file(read_rods(name))
        relaxed(rods)  # compiled loops are read from disk once
        return relaxed(rods)[0]
    weave = weave_pattern(models.load(name), ribbons=ribbons)
    rods = rods_of_ribbons(weave.ribbons, weave.interlacing.over, weave.width, weave.thickness)
    relax(rods)
    row, end = relaxed(rods)
    clock = perf_counter()
    slid = slide(rods, weave.mesh)
    sliding = perf_counter() - clock
    after, last = relaxed(slid.rods)
    for each, at in ((row, end), (after, last)):
        gone = departure(at, rods, weave.mesh)
        each["to_surface"] = vars(gone.to_surface)
        each["held"] = float(gone.distance[held(at)].max() / gone.diagonal)
    return {"model": name, "ribbons": len(rods), "relax": row, "slide_seconds": sliding, "slid": after}


if __name__ == "__main__":
    print(json.dumps(measure(sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 100)))
