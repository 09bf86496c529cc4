"""Make the embedded scans in geoweave/data from the packages they are taken from.

    python scripts/embed_scans.py [--packages FOLDER]

Needs a Debian or Ubuntu machine with apt-get and dpkg-deb, and pip. Downloads `libcgal-demo` (Debian) and the
source distribution of potpourri3d (PyPI), takes one mesh file each out of them, checks it by sha256, remeshes
it and writes the compressed arrays. Nothing of the packages is kept. With `--packages` the two files are
taken from a folder instead of being downloaded.

The result is the same on every run; the new sha256 sums belong into geoweave/models/datasets.py.
"""

from __future__ import annotations

import argparse
import hashlib
import subprocess
import sys
import tarfile
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geoweave.meshing import isotropic_remesh, read_mesh
from geoweave.surface import TriMesh

TARGET = Path(__file__).resolve().parent.parent / "geoweave" / "data"

DEBIAN = "libcgal-demo"
"""Taken from version 5.5.1-2, sha256 78b09b23d4d6d1bf15552a1060b419ab3fc09918486462faed197e5fc6ac3735.

Each mesh is checked by its own sha256, so another version of the package that holds the same meshes serves.
"""

PYPI = "potpourri3d==1.4.0"
"""Its source distribution has sha256 83c31ac4ee69b90cc0f3af1139f91ec952077defcc9166056cc4434712679292."""


@dataclass(frozen=True)
class Scan:
    """A mesh inside one of the packages, and what is made of it."""

    name: str
    package: str
    member: str
    sha256: str
    faces: int


SCANS = (
    Scan(
        name="armadillo",
        package="cgal",
        member="data/meshes/armadillo.off",
        sha256="6f7f3ca1abc506569466b72f2f59d49493a284e7376d7a7e23c08115ec8cec4e",
        faces=9_000,
    ),
    Scan(
        name="bunny",
        package="cgal",
        member="data/meshes/bunny00.off",
        sha256="ab651cb04955c161efaeb079035a1e5e1f0e0d1f816a2df67beaea68f393ff2b",
        faces=6_000,
    ),
    Scan(
        name="camel",
        package="cgal",
        member="data/meshes/camel.off",
        sha256="9ac960a9fee27e6fcc6baaa2340260834625084ee20f4a97194212404e650a22",
        faces=8_000,
    ),
    Scan(
        name="spot",
        package="potpourri3d",
        member="deps/geometry-central/test/assets/spot.ply",
        sha256="2d24cc184dec9a03c32281312f7d2e44f70b51180d982dc0a81899e77efc275a",
        faces=6_000,
    ),
)


def main() -> int:
    """Download, check, remesh, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--packages", type=Path, help="folder that holds the two downloaded packages")
    packages = parser.parse_args().packages
    TARGET.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as work:
        folders = unpacked(Path(work), packages)
        for scan in SCANS:
            source = folders[scan.package] / scan.member
            found = hashlib.sha256(source.read_bytes()).hexdigest()
            if found != scan.sha256:
                print(f"{scan.member}: sha256 {found}, expected {scan.sha256}", file=sys.stderr)
                return 1
            mesh = isotropic_remesh(read_mesh(source).mesh, scan.faces)
            print(written(scan.name, mesh))
    return 0


def unpacked(work: Path, packages: Path | None) -> dict[str, Path]:
    """Download the two packages, unless a folder holds them, and unpack what is needed of them."""
    folder = packages or work
    if packages is None:
        run("apt-get", "download", DEBIAN, cwd=work)
        options = ["--no-deps", "--no-binary", ":all:", "--dest", str(work)]
        run(sys.executable, "-m", "pip", "download", *options, PYPI, cwd=work)
    deb, sdist = one(folder, f"{DEBIAN}_*.deb"), one(folder, "potpourri3d-*.tar.gz")
    for package in (deb, sdist):
        print(f"{package.name}  sha256 {hashlib.sha256(package.read_bytes()).hexdigest()}")
    run("dpkg-deb", "-x", str(deb), str(work / "deb"), cwd=work)
    with tarfile.open(one(work / "deb", "**/data.tar.gz")) as archive:
        archive.extractall(work / "cgal", filter="data")
    with tarfile.open(sdist) as archive:
        archive.extractall(work / "sdist", filter="data")
    return {"cgal": work / "cgal", "potpourri3d": one(work / "sdist", "potpourri3d-*")}


def written(name: str, mesh: TriMesh) -> str:
    """Write a mesh as compressed float32 and int32 arrays; return a line that says what it is."""
    path = TARGET / f"{name}.npz"
    vertices, faces = mesh.vertices.astype(np.float32), mesh.faces.astype(np.int32)
    np.savez_compressed(path, vertices=vertices, faces=faces)
    kept = TriMesh(vertices, faces)
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    return (
        f"{path.name}: {kept.n_faces} faces, genus {kept.genus}, {len(kept.boundary_loops)} boundary loops, "
        f"smallest angle {np.degrees(kept.corner_angles.min()):.0f} degrees, {path.stat().st_size} bytes, "
        f"sha256 {digest}"
    )


def one(folder: Path, pattern: str) -> Path:
    """The one path in a folder that matches a pattern; there must be no other."""
    (found,) = folder.glob(pattern)
    return found


def run(*command: str, cwd: Path) -> None:
    """Run a command and stop where it fails."""
    subprocess.run(command, cwd=cwd, check=True)


if __name__ == "__main__":
    raise SystemExit(main())
