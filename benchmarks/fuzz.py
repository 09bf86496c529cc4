"""Feed mutated files to the command line: each run must end with exit 0, or 2 and one sentence.

    python -m benchmarks.fuzz [--files N] [--seed S] [--kinds mesh ...]

A file is made from a sound one by a few random changes of its bytes, numbers and lines. The same seed makes
the same files. A file that breaks a rule is kept in ``build/fuzz`` and named; the exit status is then 1.
"""

from __future__ import annotations

import argparse
import gzip
import io
import json
import re
import sys
import tempfile
import time
import zipfile
from collections import Counter
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geoweave.cli.main import main as command_line
from geoweave.fabrication import pattern_of
from geoweave.meshing import write_mesh
from geoweave.models import shapes
from geoweave.pipeline.weave_folder import rod_file
from geoweave.rods import RodFile, rod_text
from geoweave.rods.rod_file import MAGIC
from geoweave.weave import Weave, weave_pattern

SLOWEST = 20.0
"""Seconds of the processor that one run may take, whatever else the machine does."""

MOST_CHANGES = 3
"""Changes that one file gets, at most."""

NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")

WORDS = (
    b"0", b"-1", b"1", b"3", b"7", b"nan", b"inf", b"-inf", b"1e400", b"1e300", b"1e-300", b"-1e308", b"0.5",
    b"99999999999999999999", b"2147483648", b"-9223372036854775808", b"x", b"", b"1,5", b"0x10", b"1e",
)  # fmt: skip
"""What a number is replaced by."""

PIECES = (
    b"\x00", b"\xff", b"\r", b"\n", b"\t", b"\\\n", b"#", b'"', b"{", b"]", b"\xef\xbb\xbf", b"\xff\xfe",
    b"solid", b"facet", b"vertex", b"OFF", b"f 1 2 3 4\n", b"v 0 0 0\n", b"end_header\n", b"-1 ",
    b"4 0 1 2 3\n",
)  # fmt: skip
"""What is put between bytes."""


@dataclass(frozen=True)
class Kind:
    """One kind of file: sound ones, and the arguments that read a file.

    ``sound`` makes (ending, bytes) pairs; ``arguments`` takes the path of a file and an empty folder.
    """

    sound: Callable[[], list[tuple[str, bytes]]]
    arguments: Callable[[Path, Path], list[str]]


@dataclass(frozen=True)
class Fault:
    """A run that broke a rule."""

    data: bytes
    ending: str
    says: str


def sound_meshes() -> list[tuple[str, bytes]]:
    """Small surfaces in every format that is read."""
    surfaces = (shapes.icosahedron(80), shapes.torus(faces=100), shapes.square(faces=32))
    found: list[tuple[str, bytes]] = []
    with tempfile.TemporaryDirectory() as folder:
        for mesh in surfaces:
            for ending in ("obj", "off", "ply"):
                path = Path(folder) / f"mesh.{ending}"
                write_mesh(mesh, path)
                found.append((ending, path.read_bytes()))
            corners = mesh.vertices[mesh.faces]
            rows = np.zeros(
                mesh.n_faces, dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")]
            )
            rows["corners"] = corners
            found.append(("stl", bytes(80) + np.uint32(len(rows)).astype("<u4").tobytes() + rows.tobytes()))
            found.append(("stl", _stl_text(corners)))
            found.append(("ply", _ply_text(mesh.vertices, mesh.faces)))
    pyramid = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv .5 .2 1\n"
    pyramid += b"f 1 4 3 2\nf 1/1/1 2//2 5\nf -4 -3 -1\nf 3 4 5\nf 4 1 5\n"
    found += [
        ("obj", pyramid),
        ("gltf", _gltf()),
        ("3mf", _threemf()),
        ("obj.gz", gzip.compress(pyramid, mtime=0)),
    ]
    return found


def _stl_text(corners: np.ndarray) -> bytes:
    lines = ["solid mesh"]
    for triangle in corners.tolist():
        lines += ["facet normal 0 0 0", "outer loop", *(f"vertex {x} {y} {z}" for x, y, z in triangle)]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid mesh", ""]).encode()


def _ply_text(vertices: np.ndarray, faces: np.ndarray) -> bytes:
    lines = ["ply", "format ascii 1.0", f"element vertex {len(vertices)}"]
    lines += [*(f"property float {axis}" for axis in "xyz"), f"element face {len(faces)}"]
    lines += ["property list uchar int vertex_indices", "end_header"]
    lines += [f"{x} {y} {z}" for x, y, z in vertices.tolist()]
    return "\n".join([*lines, *(f"3 {a} {b} {c}" for a, b, c in faces.tolist()), ""]).encode()


def _gltf() -> bytes:
    import trimesh

    mesh = shapes.icosahedron()
    scene = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).scene()
    files = trimesh.exchange.gltf.export_gltf(scene, embed_buffers=True)
    return bytes(files["model.gltf"])


def _threemf() -> bytes:
    mesh = shapes.icosahedron()
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in mesh.vertices.tolist())
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in mesh.faces.tolist())
    model = (
        '<model unit="inch" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources>'
        f'<object id="1"><mesh><vertices>{vertices}</vertices>'
        f"<triangles>{triangles}</triangles></mesh></object>"
        '</resources><build><item objectid="1" transform="1 0 0 0 1 0 0 0 1 5 0 0"/></build></model>'
    )
    relation = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:  # neither compressed nor dated
        archive.writestr(
            zipfile.ZipInfo("_rels/.rels"), f'<R><Relationship Type="{relation}" Target="/3D/a.model"/></R>'
        )
        archive.writestr(zipfile.ZipInfo("3D/a.model"), model)
    return buffer.getvalue()


def small_weave() -> Weave:
    """A weave of a few ribbons on a coarse cone, 100 mm wide."""
    return weave_pattern(shapes.cone(faces=200), ribbons=4).sized(100.0)


def sound_weaves() -> list[tuple[str, bytes]]:
    """A design: what ``geoweave relax`` reads."""
    return [("json", json.dumps(small_weave().document()).encode())]


def sound_patterns() -> list[tuple[str, bytes]]:
    """The strips of a weave."""
    return [("json", json.dumps(pattern_of(small_weave()).document()).encode())]


def sound_rods() -> list[tuple[str, bytes]]:
    """The ribbons of a weave as rods, in every version of the format."""
    content = rod_file(small_weave())
    return [
        ("rod", rod_text(content).encode()),
        *(("rod", _old_rods(content, version)) for version in (0, 1)),
    ]


def _old_rods(content: RodFile, version: int) -> bytes:
    """Rods as text of an older version, which has fewer entries."""
    lines = [str(MAGIC), "1"] if version else []
    lines += [f"{len(content.rods)} {len(content.crossings)}"]
    lines += [f"{content.thickness} {content.young} {content.density}"]
    for rod in content.rods:
        arrays = [rod.centerline, rod.directors, rod.angles, rod.widths]
        if not version:
            del arrays[2]
        lines += [f"{len(rod.centerline)} {int(rod.closed)}" + (" 1 0" if version else "")]
        lines += [" ".join(repr(value) for value in np.ravel(array).tolist()) for array in arrays]
    for one in content.crossings:
        lines.append(" ".join(map(repr, (*one.rods, *one.segments, *one.places, one.stiffness))))
    return ("\n".join(lines) + "\n").encode()


KINDS = {
    "mesh": Kind(sound_meshes, lambda path, folder: ["info", str(path), "--json"]),
    "rod": Kind(sound_rods, lambda path, folder: ["relax", str(path), "-o", str(folder), "--json"]),
    "weave": Kind(sound_weaves, lambda path, folder: ["relax", str(path), "-o", str(folder), "--json"]),
    "pattern": Kind(sound_patterns, lambda path, folder: ["twin", str(path), "-o", str(folder), "--json"]),
}
"""The kinds of files, by name."""


def mutated(data: bytes, rng: np.random.Generator) -> bytes:
    """Change a file in one to `MOST_CHANGES` places."""
    for _ in range(int(rng.integers(1, MOST_CHANGES + 1))):
        data = CHANGES[int(rng.integers(len(CHANGES)))](data, rng)
    return data


def _spot(data: bytes, rng: np.random.Generator) -> int:
    return int(rng.integers(len(data) + 1))


def _flip(data: bytes, rng: np.random.Generator) -> bytes:
    spot = _spot(data, rng)
    return data[:spot] + bytes([int(rng.integers(256))]) + data[spot + 1 :]


def _insert(data: bytes, rng: np.random.Generator) -> bytes:
    spot = _spot(data, rng) if rng.random() < 0.8 else 0
    return data[:spot] + PIECES[int(rng.integers(len(PIECES)))] + data[spot:]


def _cut(data: bytes, rng: np.random.Generator) -> bytes:
    return data[: _spot(data, rng)]


def _drop(data: bytes, rng: np.random.Generator) -> bytes:
    spot = _spot(data, rng)
    return data[:spot] + data[spot + int(rng.integers(1, 60)) :]


def _repeat(data: bytes, rng: np.random.Generator) -> bytes:
    spot = _spot(data, rng)
    return data[:spot] + data[max(0, spot - int(rng.integers(1, 200))) :]


def _number(data: bytes, rng: np.random.Generator) -> bytes:
    found = list(NUMBER.finditer(data))
    if not found:
        return data
    one = found[int(rng.integers(min(len(found), 12) if rng.random() < 0.5 else len(found)))]
    return data[: one.start()] + WORDS[int(rng.integers(len(WORDS)))] + data[one.end() :]


def _swap_lines(data: bytes, rng: np.random.Generator) -> bytes:
    lines = data.split(b"\n")
    a, b = rng.integers(len(lines), size=2)
    lines[a], lines[b] = lines[b], lines[a]
    return b"\n".join(lines)


def _line_ends(data: bytes, rng: np.random.Generator) -> bytes:
    return data.replace(b"\n", (b"\r", b"\r\n", b"\n\n", b" ")[int(rng.integers(4))])


CHANGES = (_flip, _insert, _cut, _drop, _repeat, _number, _number, _number, _swap_lines, _line_ends)


def fault_of(kind: Kind, path: Path, folder: Path) -> tuple[int, str]:
    """Run the command on a file; return the exit status, and what rule was broken ("" if none)."""
    out, err = io.StringIO(), io.StringIO()
    start = time.process_time()
    with redirect_stdout(out), redirect_stderr(err):
        status = command_line(kind.arguments(path, folder))
    seconds = time.process_time() - start
    said = err.getvalue()
    if status not in (0, 2):
        return status, f"exit {status}: {said.strip().splitlines()[-2:]}"
    if status == 2 and (said.count("\n") != 1 or path.name not in said):
        return status, f"not one sentence that names the file: {said!r}"
    if status == 0 and said:
        return status, f"words on stderr: {said!r}"
    return status, f"took {seconds:.0f} s" if seconds > SLOWEST else ""


def fuzzed(kind: Kind, files: int, seed: int) -> tuple[Counter[int], list[Fault]]:
    """Run the command on mutated files of a kind; return how often each exit status came, and the faults."""
    rng = np.random.default_rng(seed)
    sound = kind.sound()
    statuses: Counter[int] = Counter()
    faults = []
    with tempfile.TemporaryDirectory() as work:
        ending, data = sound[0]
        path = Path(work) / f"sound.{ending}"
        path.write_bytes(data)
        fault_of(kind, path, Path(work) / "sound")  # compiles the loops, which no file has to answer for
        for number in range(files):
            ending, data = sound[int(rng.integers(len(sound)))]
            changed = mutated(data, rng)
            path, folder = Path(work) / f"file.{ending}", Path(work) / f"out{number}"
            path.write_bytes(changed)
            status, says = fault_of(kind, path, folder)
            statuses[status] += 1
            if says:
                faults.append(Fault(changed, ending, says))
    return statuses, faults


def main() -> int:
    """Fuzz every kind, and keep what broke a rule."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.fuzz", description=__doc__.splitlines()[0])
    parser.add_argument("--files", type=int, default=3_000, help="files of all kinds together")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kinds", nargs="+", choices=[*KINDS], default=[*KINDS])
    options = parser.parse_args()
    kept = Path("build/fuzz")
    broken = 0
    for name in options.kinds:
        start = time.perf_counter()
        statuses, faults = fuzzed(KINDS[name], options.files // len(options.kinds), options.seed)
        seconds = time.perf_counter() - start
        counts = ", ".join(f"exit {status}: {count:,}" for status, count in sorted(statuses.items()))
        print(f"{name}: {statuses.total():,} files in {seconds:.0f} s; {counts}; {len(faults)} break a rule")
        for number, fault in enumerate(faults):
            kept.mkdir(parents=True, exist_ok=True)
            path = kept / f"{name}-{number}.{fault.ending}"
            path.write_bytes(fault.data)
            print(f"  {path}: {fault.says[:300]}")
        broken += len(faults)
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
