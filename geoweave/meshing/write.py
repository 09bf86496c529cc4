"""Write a surface as a mesh file that other programs read; no digit of its coordinates is lost."""

from __future__ import annotations

from os import PathLike
from pathlib import Path

import numpy as np

from geoweave.files import OutputError, replacing
from geoweave.surface import TriMesh

WRITTEN = (".obj", ".off", ".ply")
"""Formats that can be written; STL is not among them, because it forgets which vertices are shared."""


def check_format(path: str | PathLike[str]) -> None:
    """Raise OutputError if the extension names no format that can be written.

    Examples
    --------
    >>> gw.meshing.check_format("cup.stl")
    Traceback (most recent call last):
    geoweave.files.OutputError: cup.stl: a mesh is written as .obj, .off, .ply; choose one of these endings
    """
    if Path(path).suffix.lower() not in WRITTEN:
        raise OutputError(f"{path}: a mesh is written as {', '.join(WRITTEN)}; choose one of these endings")


def write_mesh(mesh: TriMesh, path: str | PathLike[str]) -> None:
    """Write a mesh as OBJ, OFF or binary PLY, by the extension; the file appears whole or not at all.

    Raises
    ------
    OutputError
        If the extension is another, or the file cannot be written.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     gw.meshing.write_mesh(gw.shapes.icosahedron(), f"{folder}/ball.off")
    ...     gw.read_mesh(f"{folder}/ball.off").mesh.n_faces
    20
    """
    check_format(path)
    kind = Path(path).suffix.lower()
    with replacing(path) as temporary, open(temporary, "wb") as file:
        if kind == ".ply":
            file.write(_ply_header(mesh))
            file.write(mesh.vertices.astype("<f8").tobytes())
            rows = np.empty(mesh.n_faces, dtype=[("n", "u1"), ("corners", "<i4", 3)])
            rows["n"], rows["corners"] = 3, mesh.faces
            file.write(rows.tobytes())
        elif kind == ".off":
            file.write(f"OFF\n{mesh.n_vertices} {mesh.n_faces} 0\n".encode())
            np.savetxt(file, mesh.vertices, fmt="%.17g")
            np.savetxt(file, mesh.faces, fmt="3 %d %d %d")
        else:
            np.savetxt(file, mesh.vertices, fmt="v %.17g %.17g %.17g")
            np.savetxt(file, mesh.faces + 1, fmt="f %d %d %d")


def _ply_header(mesh: TriMesh) -> bytes:
    """The header that announces what follows in a binary PLY file."""
    lines = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {mesh.n_vertices}",
        *(f"property double {axis}" for axis in "xyz"),
        f"element face {mesh.n_faces}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    return "".join(f"{line}\n" for line in lines).encode()
