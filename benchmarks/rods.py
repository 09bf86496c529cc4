"""Measure sliding and relaxing of weaves, and of .rod files: ``python -m benchmarks.rods [FILE.rod ...]``."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from time import perf_counter, process_time

import numpy as np

from benchmarks.memory import peak_gigabytes
from geoweave.models import catalogue, shapes
from geoweave.rods.departure import fitted, held
from geoweave.rods.from_ribbons import rods_of_file
from geoweave.rods.rod_file import read_rods
from geoweave.rods.slide_and_relax import relax_rods
from geoweave.rods.weave_at_rest import relaxed_weave
from geoweave.weave.design import weave_pattern

WEAVES: list[tuple[str, int | None]] = [
    ("bunny", 54), ("bunny", 108), ("icosahedron", None), ("bumpy-box", None), ("torus", None),
    ("sphere", None),
]  # fmt: skip
"""Models and how many ribbons they get; none: what one click gives. Growth is measured from the first two."""

LIMITS = {"bunny": 60.0, "cone60": 1.0, "torus7": 5.0}
"""Seconds allowed, on two cores, from the ribbons to the shape at rest."""


def compile_all() -> None:
    """Have numba compile, or load, what relaxing needs."""
    relaxed_weave(weave_pattern(shapes.cone(faces=1000), ribbons=9), rounds=1)


def measure(name: str, ribbons: int | None = None) -> dict:
    """Slide and relax the weave of a model."""
    compile_all()
    weave = weave_pattern(catalogue.load(name), ribbons=ribbons)
    before, clock, work = peak_gigabytes(), perf_counter(), process_time()
    found = relaxed_weave(weave)
    wall, cpu = perf_counter() - clock, process_time() - work
    rods, gone = found.left.rods, found.departure
    return {
        "model": name,
        "ribbons": len(rods),
        "segments": rods.layout.segments,
        "contacts": len(rods.contacts),
        "slide_steps": len(found.slid.steps),
        "relax_steps": len(found.left.steps),
        "wall": wall,
        "cpu": cpu,
        "seconds": found.seconds,
        "memory_gb": max(peak_gigabytes() - before, 0.0),
        "converged": found.converged,
        "gradient": found.left.gradient,
        "energies": found.left.energies,
        "largest": gone.to_surface.largest,
        "mean": gone.to_surface.mean,
        "held": float(gone.distance[held(rods)].max() / gone.diagonal),
    }


def measure_file(path: str) -> dict:
    """Relax a .rod file; distances are from where its rods were, over the diagonal of their bounding box."""
    compile_all()
    rods = rods_of_file(read_rods(path))
    clock, work = perf_counter(), process_time()
    found = relax_rods(rods)
    wall, cpu = perf_counter() - clock, process_time() - work
    moved = np.linalg.norm(fitted(found.rods, rods) - rods.points, axis=1)
    moved /= np.linalg.norm(np.ptp(rods.points, axis=0))
    return {
        "model": Path(path).stem,
        "ribbons": len(rods),
        "segments": rods.layout.segments,
        "contacts": len(rods.contacts),
        "slide_steps": 0,
        "relax_steps": len(found.steps),
        "wall": wall,
        "cpu": cpu,
        "memory_gb": 0.0,
        "converged": found.converged,
        "gradient": found.gradient,
        "energies": found.energies,
        "largest": float(moved.max()),
        "mean": float(moved.mean()),
        "held": float(moved[held(found.rods)].max()),
    }


def table(files: list[str]) -> list[dict]:
    """Print a row for each weave and each file, every one measured in a process of its own."""
    print("Sliding and relaxing weaves to a relative gradient of 1e-6; seconds of wall clock and of CPU.")
    print("Distances from the surface (of .rod files: from the start), as shares of the bounding diagonal.\n")
    print(
        f"{'model':>12} {'ribbons':>7} {'contacts':>8} {'segments':>8} {'slide':>6} {'relax':>6} {'wall':>8} "
        f"{'CPU':>8} {'allowed':>8} {'share':>6} {'memory':>8} {'rest':>5} "
        f"{'largest':>8} {'held':>7} {'mean':>7}"
    )
    rows = []
    jobs = [[path] for path in files]
    jobs += [[name, *([str(ribbons)] if ribbons else [])] for name, ribbons in WEAVES]
    for job in jobs:
        command = [sys.executable, "-m", "benchmarks.rods", "--one", *job]
        row = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)
        allowed = LIMITS.get(row["model"])
        rows.append(row | {"allowed": allowed})
        print(
            f"{row['model']:>12} {row['ribbons']:>7} {row['contacts']:>8,} {row['segments']:>8,} "
            f"{row['slide_steps']:>6} {row['relax_steps']:>6} {row['wall']:>6.2f} s {row['cpu']:>6.2f} s "
            + (f"{allowed:>6.0f} s {row['wall'] / allowed:>6.0%} " if allowed else f"{'-':>8} {'-':>6} ")
            + f"{row['memory_gb']:>5.2f} GB {'yes' if row['converged'] else 'no':>5} "
            f"{row['largest']:>8.2%} {row['held']:>7.2%} {row['mean']:>7.2%}",
            flush=True,
        )
    few, many = rows[len(files) : len(files) + 2]
    growth = np.log(many["cpu"] / few["cpu"]) / np.log(many["ribbons"] / few["ribbons"])
    slide, relax = (many["seconds"][stage] for stage in ("slide", "relax"))
    print(f"\n{many['model']}: sliding {slide:.1f} s, relaxing {relax:.1f} s of wall clock")
    print(f"growth of both together: ribbons to the power {growth:.2f}")
    print(
        "\nsteps: of sliding, all rounds together, and of relaxing; held: between two contacts of a ribbon\n"
    )
    return rows


if __name__ == "__main__":
    if sys.argv[1:2] == ["--one"]:
        name, *count = sys.argv[2:]
        row = measure_file(name) if name.endswith(".rod") else measure(name, *map(int, count))
        print(json.dumps(row))
    else:
        table(sys.argv[1:])
