"""Weave scans on which no number was chosen, with no parameter: is each weave valid, and how good is it?

    python -m benchmarks.scans [NAME]...

The scans come out of a Debian package and a source distribution, as in scripts/embed_scans.py: taken by
apt-get, dpkg-deb and pip, checked by sha256, kept under build/scans and never committed. With them go the
data sets that are on this machine and the surfaces that we build. Each is read, remeshed and woven as by
``geoweave weave MESH --no-relax``, in a process of its own. The table is written to build/bench/scans.md.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np

from benchmarks.memory import peak_gigabytes
from geoweave.errors import GeoweaveError
from geoweave.meshing import Prepared, RepairReport, evened, read_mesh
from geoweave.models import catalogue, datasets
from geoweave.weave.design import weave_pattern
from geoweave.weave.regularity import Regularity
from geoweave.weave.validity import violations
from scripts.embed_scans import unpacked

KEPT = Path("build/scans")
TABLE = Path("build/bench/scans.md")

LICENCE = "CC0-1.0 as CGAL distributes files without a notice of their own; bob: Keenan Crane, CC0-1.0"

CGAL = {
    "b9_mesh": "b4427e4d7bd79324eaf962747e9e7243511a548a8963e266b63687d4c017df1d",
    "blade": "088832ae983887c8ed7a3eaf1993eff172edcf35adc2811f9237b635fb2d2798",
    "blobby_3cc": "62399b7868bdc6b918a01dca23ecf7d99935689331d1878a01b2307e20140c30",
    "boeing": "a50af346f5fda821844907e2f020f27a9d399dc5c39f4fbb5344f13ca6002a7a",
    "bones": "004bd26f0029910eb2e2fd38b7ca11ea05dd4182e247c0fb778533b860dd7ab2",
    "bull": "5c7b9631f8c278c12b30c0eea0b72da871504674516daf7d7eaaf5fa4154224a",
    "cactus": "333a41cbf5e30f2f675392adb7b0f7fb3f5919b39f15d2ae280830e662247925",
    "ChineseDragon-10kv": "f633bdfaac7a0f99e0fab668c34862f0c26f341cfdb4665bab282d79b788db02",
    "couplingdown": "01fc9017b44a803b1130f8f5d51f0c7d8bbfa27b908f5166c498fe21e57f2284",
    "dino": "acca16a64f425dd705375ada71ed4cf046beb2a1a06629a3c2325bb0530475db",
    "double-torus-3-holes": "12243967111005f77d8b1bf8fa09df9984738f5ed85a20603eead8a2dc7e0055",
    "eight": "58fa129fbd64d519034b12c73ecb463ae55832710aa34fddd0504debd044f71d",
    "elephant": "be4e1ea68f5f840a3d2ada69d828222e76a57d9e25b21e19a9deacd3f2328e02",
    "elephant-with-holes": "0262a20c433534623af10f2b8b3aeb9067792486195cac47738bc6abea0cb8d0",
    "elk": "7f1229fd3de0b4fc0884bbbfbd056a57ff0cb0f7afd71b5168a84209cc585abb",
    "fandisk": "edffb263f037b023757259befd5532fccb48bdc3c35a1da2e11e235a647bd050",
    "femur": "75d208fabf7a7b134cfcf2171bad68c331e3bff55309ffe38a01a7b31352fbc6",
    "hand": "cfcf1562726167ca704a091a8651bfd1d72f6eb96b4b2819321f0520721b35c7",
    "head": "75aecfdbf9c0386dd839f5bf0322fb5a889ed7efd31d040f125e383041b4b919",
    "helmet": "0669ab781a80570cfdd2932b06a7c33f89fd855a9ddb69dc45e50082253a5a32",
    "holes": "ddbef17f3e418c9c2eb1eddae0da64926f67ca52a37bf57b0f0004588388b970",
    "homer": "99396cceb6f97e9681545d5c718d4ed87da3ceb78d22afb0218d570e9f0a0873",
    "knot1": "13d9d2f3459189630680dad6a3b5528d5cc794967b791580a0e1f6642903d030",
    "knot2": "6c90e93f1a966abd73847d40909a90c0b2067affdd471a27b50c2d4416142c06",
    "lion": "5749c7a8d89a7fbda350e842c6b5f233595ea6e6201604087219325af9c82070",
    "lion-head": "cf159eeb12a3f3f345e57448693e9f0d115f3f6f38fd1d4519b336cede849289",
    "man": "9f04482c1028de539f02319c476d6c95141e9fbc389e9d469041ab63096de5d4",
    "mannequin-devil": "9424b7132b58766984051fb7757543e88972f91fe7e9565d4e5b715b204f74a5",
    "mask_cone": "30db79368dfa66bfa49ce763a413dcdace5e688da65d15f1adf537d086e391da",
    "mech-holes-shark": "2ad3d8fb970b319eb8a32040664c25d4e01370f20ad57f4fde5c63fef3b6cca9",
    "mushroom": "03768b314714676d9305361c7c124be3b2c991c59fe8c752a49047115b4dfa00",
    "nefertiti": "d8b13239b988d0262fbc91e88da1d314eeb1b284c327a3fe76089c2b54886ccf",
    "pig": "7a164eee3a5c3630687974862cb587082e25fca1e8cc99d43bd3626bb5f87ff2",
    "retinal": "02547bcd1f28149862ff28056614418c0fca73033dfec1a07e8e91e4c78544b7",
    "rotor_small": "4bb13c727456322d90aa21cf5270de83bde77435ea1c77ab1e264e1e1800bed2",
    "three_peaks": "6b985fb7f6f2a6dc15dd311758aa1eeb0725cfb32bcacef8a767b910c9a2d8d4",
    "triceratops": "0fb444933884486a09eb4329a832f15ab792590f2a5bb75385d157e654ddbf5c",
    "turbine": "8ae52b6b325a05e0755983706ab55aba0f42d3ea0569dd29b33cdcb16c20f4c8",
}
"""sha256 of ``data/meshes/NAME.off`` in libcgal-demo 5.5.1-2, ``data.tar.gz``."""

POTPOURRI3D = {"bob_small": "1c70d963ad5483f0d1a5644d9564146334fcaef74683970a70f06c9beaac961f"}
"""sha256 of ``deps/geometry-central/test/assets/NAME.ply`` in the source distribution 1.4.0."""

BUILT = {name: model.build for name, model in catalogue.MODELS.items() if model.build is not None}
"""Surfaces that we ship as formulas."""


def fetched() -> dict[str, Path]:
    """The scans on disk, taken from their packages if one is missing."""
    wanted = {name: (f"{name}.off", digest) for name, digest in CGAL.items()}
    wanted |= {name: (f"{name}.ply", digest) for name, digest in POTPOURRI3D.items()}
    paths = {name: KEPT / file for name, (file, _) in wanted.items()}
    if not all(path.is_file() for path in paths.values()):
        KEPT.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as work:
            folders = unpacked(Path(work), None)
            meshes = folders["cgal"] / "data" / "meshes"
            assets = folders["potpourri3d"] / "deps" / "geometry-central" / "test" / "assets"
            for name, path in paths.items():
                shutil.copyfile((meshes if name in CGAL else assets) / path.name, path)
    for name, (_, digest) in wanted.items():
        found = hashlib.sha256(paths[name].read_bytes()).hexdigest()
        if found != digest:
            paths[name].unlink()
            raise SystemExit(f"{paths[name]}: sha256 {found}, expected {digest}; removed, run again")
    return paths


def surface(name: str) -> Prepared:
    """A scan, a data set or a built surface by name, read as the command reads it."""
    for suffix in (".off", ".ply"):
        if (name in CGAL or name in POTPOURRI3D) and (KEPT / f"{name}{suffix}").is_file():
            return read_mesh(KEPT / f"{name}{suffix}")
    mesh = BUILT[name]() if name in BUILT else datasets.load(name)
    return Prepared(mesh, RepairReport())


def measure(name: str) -> dict:
    """Weave one surface with no parameter."""
    start = perf_counter()
    given = surface(name)
    row = {
        "name": name,
        "given": given.mesh.n_faces,
        "components": given.mesh.n_components,
        "genus": given.mesh.genus,
        "loops": len(given.mesh.boundary_loops),
    }
    try:
        mesh = evened(given, name=name).mesh
        weave = weave_pattern(mesh)
    except GeoweaveError as error:
        return row | {"broken": [f"{type(error).__name__}: {error}"], "seconds": perf_counter() - start}
    regular = Regularity.of(weave)
    angles, turns = weave.crossing_angles, weave.interlacing
    woven = np.unique(mesh.face_components[weave.ribbons.curves.faces])
    return row | {
        "faces": mesh.n_faces,
        "bare": mesh.n_components - len(woven),
        "ribbons": len(weave.ribbons),
        "crossings": len(weave.ribbons.crossings),
        "median_deg": float(np.median(angles)),
        "within_20": float((np.abs(angles - 60.0) <= 20.0).mean()),
        "alternation": turns.alternation,
        "bound": turns.alternation_bound,
        "piled": regular.piled,
        "order": regular.phase_order,
        "bare_area": regular.bare,
        "spread": regular.spacing_spread,
        "cells": regular.triangles + regular.hexagons,
        "interleaved": regular.interleaved,
        "loose": int(weave.ribbons.loose.sum()),
        "broken": violations(weave.ribbons, turns.over),
        "stages": weave.design.seconds,
        "seconds": perf_counter() - start,
        "memory_gb": peak_gigabytes(),
    }


FEW = ("nefertiti", "eight", "head", "bunny", "torus", "cone")
"""Those that `make bench` weaves; all of them take a quarter of an hour."""

HEAD = (
    "| surface | faces given | woven | parts | bare | genus | loops | ribbons | crossings | median angle | "
    "60 ± 20 | alternation | at most | piled | order | bare area | spread | 3- and 6-gons "
    "| interleaved | loose | valid | s |"
)


def line(row: dict) -> str:
    """One line of the table."""
    given, parts = [row["name"], f"{row['given']:,}"], str(row["components"])
    shape = [str(row[key]) for key in ("genus", "loops")]
    if "faces" not in row:
        cells = [*given, "", parts, "", *shape, *[""] * 13, "no", f"{row['seconds']:.0f}"]
        return "| " + " | ".join(cells) + " |"
    made = [f"{row['ribbons']:,}", f"{row['crossings']:,}", f"{row['median_deg']:.1f}°"]
    made += [f"{row[key]:.1%}" for key in ("within_20", "alternation", "bound")]
    made += [f"{row['piled']:.1%}", f"{row['order']:.2f}", f"{row['bare_area']:.2%}", f"{row['spread']:.2f}"]
    made += [f"{row['cells']:.0%}", f"{row['interleaved']:.1%}"]
    made += [str(row["loose"]), "no" if row["broken"] else "yes", f"{row['seconds']:.0f}"]
    return "| " + " | ".join([*given, f"{row['faces']:,}", parts, str(row["bare"]), *shape, *made]) + " |"


def table(names: list[str] | None = None) -> list[dict]:
    """Weave them all, print the table and keep it; every rule that a weave breaks is said below it."""
    everything = [*fetched(), *BUILT, *filter(datasets.available, datasets.names())]
    unknown = set(names or ()) - set(everything)
    if unknown:
        raise SystemExit(f"no such surface here: {', '.join(sorted(unknown))}")
    print("\nOne click: scans out of packages, data sets and built surfaces, woven with no parameter.\n")
    lines = [HEAD, "|---|" + "---:|" * 19 + ":---:|---:|"]
    print("\n".join(lines), flush=True)
    rows = []
    for name in names or everything:
        command = [sys.executable, "-m", "benchmarks.scans", "--one", name]
        rows.append(json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout))
        lines.append(line(rows[-1]))
        print(lines[-1], flush=True)
    broken = [f"{row['name']}: {sentence}" for row in rows for sentence in row["broken"]]
    valid = sum(not row["broken"] for row in rows)
    lines += ["", f"{valid} of {len(rows)} weaves are valid.", *broken]
    print("\n".join(["", *lines[len(rows) + 3 :]]))
    TABLE.parent.mkdir(parents=True, exist_ok=True)
    TABLE.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return rows


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.scans")
    parser.add_argument("--one", metavar="NAME", help="weave this one here and print the row as JSON")
    parser.add_argument("names", metavar="NAME", nargs="*", help="only these")
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure(options.one)))
        return 0
    return int(any(row["broken"] for row in table(options.names or None)))


if __name__ == "__main__":
    raise SystemExit(main())
