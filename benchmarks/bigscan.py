"""What a scan of millions of faces costs, as a ratio to the same weave from its remeshed mesh.

    python -m benchmarks.bigscan [--subdivisions N ...]

The Armadillo of 9,000 faces is cut into four faces each, three times (576,000) and four times (2,304,000),
and moved a little off its flat faces, so that no two lie in one plane. Both are woven as by
``geoweave weave scan.ply --ribbons 100 --no-relax``, and so is the mesh that the first of them is remeshed
to. Every run is a process of its own. Times are those of the processor, which other work on the machine
changes little; a first run before the table compiles what has to be. The limits are those of a machine with
two cores of which nothing else makes use. The table is written to build/bench/bigscan.md.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from benchmarks.memory import peak_gigabytes
from geoweave.arrays import Triangles, Vectors
from geoweave.meshing import evened, read_mesh, write_mesh
from geoweave.models import datasets
from geoweave.pipeline import MeshSource, WeaveRequest, weave_file
from geoweave.surface import TriMesh

TABLE = Path("build/bench/bigscan.md")

RIBBONS = 100

LIMITS = {3: (60.0, 3.0), 4: (120.0, 6.0)}
"""Seconds and gigabytes that a weave may take, by the number of subdivisions."""

BUMP = 1e-4
"""How far vertices are moved at random, in lengths of the model, before a subdivision halves the edges."""

HEAD = (
    "| faces given | woven on | seconds | allowed | ratio | reading and remeshing | "
    "memory, GB | allowed | ratio |"
)


def subdivided(points: Vectors, faces: Triangles) -> tuple[Vectors, Triangles]:
    """Cut every face into four by the middles of its sides."""
    ends = np.sort(faces[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2), axis=1)
    key, side = np.unique(ends @ [len(points), 1], return_inverse=True)
    middles = 0.5 * (points[key // len(points)] + points[key % len(points)])
    a, b, c = faces.T
    x, y, z = len(points) + side.reshape(-1, 3).T
    parts = ((a, z, y), (z, b, x), (y, x, c), (x, y, z))
    return np.concatenate([points, middles]), np.concatenate([np.stack(part, axis=1) for part in parts])


def scan(subdivisions: int) -> TriMesh:
    """The Armadillo with so many times four times the faces."""
    mesh = datasets.load("armadillo")
    points, faces = mesh.vertices, mesh.faces
    for _ in range(subdivisions):
        points, faces = subdivided(points, faces)
    bump = BUMP * float(np.ptp(points, axis=0).max()) / 2**subdivisions
    return TriMesh(points + bump * np.random.default_rng(0).normal(size=points.shape), faces)


def measure(path: str, folder: str) -> dict[str, Any]:
    """Weave a file as the command does."""
    start = process_time()
    woven = weave_file(MeshSource(path), folder, WeaveRequest(ribbons=RIBBONS, relax=False))
    repairs, seconds = woven.prepared.report.as_dict(), woven.seconds
    return {
        "given": repairs["remeshed_from"] or woven.prepared.mesh.n_faces,
        "woven": woven.prepared.mesh.n_faces,
        "seconds": process_time() - start,
        "mesh": (seconds["read"] + seconds.get("remesh", 0.0)) / seconds["total"],
        "memory_gb": peak_gigabytes(),
    }


def child(option: str, *arguments: object) -> dict[str, Any]:
    """Do one thing in a process of its own.

    The scans are made in such processes too, because the peak memory of a process counts for its children.
    """
    command = [sys.executable, "-m", "benchmarks.bigscan", option, *map(str, arguments)]
    return json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout)


def make(subdivisions: int, path: str, even: str) -> dict[str, Any]:
    """Write a scan, and the mesh that it is remeshed to."""
    write_mesh(scan(subdivisions), path)
    write_mesh(evened(read_mesh(path), ribbons=RIBBONS).mesh, even)
    return {}


def line(row: dict[str, Any], base: dict[str, Any], limits: tuple[float, float] | None) -> str:
    """One line of the table."""
    seconds, gigabytes = ("", "") if limits is None else (f"{limits[0]:.0f}", f"{limits[1]:.0f}")
    cells = [f"{row['given']:,}", f"{row['woven']:,}", f"{row['seconds']:.1f}", seconds]
    cells += [f"{row['seconds'] / base['seconds']:.2f}", f"{row['mesh']:.0%}"]
    cells += [f"{row['memory_gb']:.2f}", gigabytes, f"{row['memory_gb'] / base['memory_gb']:.2f}"]
    return "| " + " | ".join(cells) + " |"


def table(subdivisions: list[int]) -> bool:
    """Weave the scans and print the table; whether all is within its limits."""
    print(f"\nWeaves of {RIBBONS} ribbons, not relaxed; seconds of the processor.\n", flush=True)
    lines, within = [HEAD, "|---:|" + "---:|" * 8], True
    with tempfile.TemporaryDirectory() as folder:
        files = {n: Path(folder) / f"scan{n}.ply" for n in subdivisions}
        even = Path(folder) / "even.ply"
        for n, path in reversed(files.items()):
            child("--make", n, path, even)
        child("--one", even, Path(folder) / "first")
        base = child("--one", even, Path(folder) / "even")
        lines.append(line(base, base, None))
        print("\n".join(lines), flush=True)
        for n, path in files.items():
            row = child("--one", path, Path(folder) / f"woven{n}")
            within &= n not in LIMITS or (row["seconds"] <= LIMITS[n][0] and row["memory_gb"] <= LIMITS[n][1])
            lines.append(line(row, base, LIMITS.get(n)))
            print(lines[-1], flush=True)
    TABLE.parent.mkdir(parents=True, exist_ok=True)
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return within


def main() -> int:
    """Print the table, or weave one file."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.bigscan")
    parser.add_argument("--one", nargs=2, metavar=("FILE", "FOLDER"), help="weave this file, print JSON")
    parser.add_argument("--make", nargs=3, metavar=("N", "FILE", "EVEN"), help="write this scan")
    parser.add_argument("--subdivisions", type=int, nargs="+", default=[*LIMITS], metavar="N")
    options = parser.parse_args()
    if options.make:
        print(json.dumps(make(int(options.make[0]), *options.make[1:])))
        return 0
    if options.one:
        print(json.dumps(measure(*options.one)))
        return 0
    return int(not table(options.subdivisions))


if __name__ == "__main__":
    raise SystemExit(main())
