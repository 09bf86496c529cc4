"""From a path to the arrays in the file; whatever a reader raises becomes one sentence here."""

from __future__ import annotations

import logging
import stat
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from io import BytesIO, StringIO
from os import PathLike
from pathlib import Path

import numpy as np

from geoweave.errors import MeshError
from geoweave.meshing.contents import PACKED, UNREAD, kind_of, plain_text, unpacked
from geoweave.meshing.obj_off_stl import read_obj, read_off, read_stl
from geoweave.meshing.polygons import RawMesh

_OWN = {"obj": "", "off": "", "stl": "solid", "ply": "ply", "3mf": ""}
"""The formats read here, and the word that their text begins with where there is also a binary form."""

_COMPRESSED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression")
"""Extensions of glTF that compress triangles; trimesh reads none of them."""


def read_arrays(path: str | PathLike[str]) -> RawMesh:
    """Read the vertices and triangles that a file holds, without mending anything.

    OBJ, OFF, PLY, STL and 3MF are read here; any other format goes through trimesh. The ending decides. A
    file packed by gzip, bzip2, xz or zip is unpacked first.

    Raises
    ------
    MeshError
        One line naming the file, what is wrong with it and what to do.
    """
    name = shown(path)
    file = Path(path)
    try:
        status = file.stat()
    except (OSError, ValueError) as error:
        if isinstance(error, FileNotFoundError | NotADirectoryError | ValueError):
            raise MeshError(f"{name}: there is no such file; check the path") from None
        raise MeshError(f"{name}: cannot be opened ({error.strerror}); check the path") from None
    if stat.S_ISDIR(status.st_mode):
        raise MeshError(f"{name}: is a folder; name a mesh file in it")
    if not stat.S_ISREG(status.st_mode):
        raise MeshError(f"{name}: is not a regular file; save the mesh to a file first")
    if status.st_size == 0:
        raise MeshError(f"{name}: the file is empty; export the mesh again")

    kind = kind_of(file)
    try:
        with _quiet():
            return _read(file, kind)
    except MeshError as error:
        text = str(error)
        if text.startswith(f"{name}: "):
            raise
        remedy = "" if ";" in text else "; export the mesh again"
        raise MeshError(f"{name}: cannot be read as {kind.upper()}: {text}{remedy}") from None
    except OSError as error:
        reason = _brief(error.strerror or error)
        raise MeshError(f"{name}: cannot be read ({reason}); check the file and its permissions") from None
    except (Exception, SystemExit) as error:
        # readers of foreign formats raise whatever their parser stumbles over, and one of them exits
        reason = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        raise MeshError(
            f"{name}: cannot be read as {kind.upper()} ({_brief(reason)}); export the mesh again"
        ) from None


def shown(path: str | PathLike[str]) -> str:
    """Return the path as it can be printed on one line."""
    return "".join(letter if letter.isprintable() else "?" for letter in str(path))


def _read(file: Path, kind: str) -> RawMesh:
    """Read a file by its ending, after unpacking it where it is packed."""
    if kind in PACKED:
        return _parse(*unpacked(file, _is_mesh_format))
    if kind in UNREAD:
        raise MeshError("a packed file of this kind is not unpacked here; unpack it first")
    if not _is_mesh_format(kind):
        raise MeshError("this is no mesh format we read; save it as OBJ, OFF, PLY or STL")
    return _parse(file.read_bytes() if kind in _OWN else file, kind)


def _parse(source: bytes | Path, kind: str) -> RawMesh:
    """Read the bytes of a file of an own format, or any other file by its path or bytes."""
    if kind not in _OWN:
        if not _is_mesh_format(kind):
            raise MeshError(
                f"what it holds ('.{kind}') is no mesh format we read; save it as OBJ, OFF, PLY or STL"
            )
        return _read_with_trimesh(source, kind)
    assert isinstance(source, bytes)
    if not source:
        raise MeshError("the mesh file in it is empty")
    if kind == "3mf":
        from geoweave.meshing.threemf import read_3mf

        return read_3mf(source)
    data = plain_text(source, _OWN[kind])
    if kind == "ply":
        from geoweave.meshing.ply import read_ply

        return read_ply(data)
    return {"obj": read_obj, "off": read_off, "stl": read_stl}[kind](data)


def _is_mesh_format(kind: str) -> bool:
    if kind in _OWN:
        return True
    import trimesh

    return kind in trimesh.exchange.load.mesh_formats()


def _read_with_trimesh(source: bytes | Path, kind: str) -> RawMesh:
    """Read through trimesh, with the parts of a scene where the scene places them."""
    import trimesh

    if kind in ("glb", "gltf"):
        data = source if isinstance(source, bytes) else source.read_bytes()
        for name in _COMPRESSED:
            if name.encode() in data:
                raise MeshError(f"its triangles are compressed ({name}); export it without compression")
    given = str(source.absolute()) if isinstance(source, Path) else BytesIO(source)
    scene = trimesh.load_scene(given, file_type=kind, process=False, skip_materials=True)
    vertices, faces, offset = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], 0
    for node in scene.graph.nodes_geometry:
        placement, name = scene.graph[node]
        part = scene.geometry[name]
        points = np.asarray(part.vertices, dtype=np.float64)
        if points.shape[1] != 3:
            raise MeshError("it holds a flat drawing, not a surface; export a surface")
        vertices.append(points @ placement[:3, :3].T + placement[:3, 3])
        if hasattr(part, "faces"):
            faces.append(np.asarray(part.faces, dtype=np.int64) + offset)
        offset += len(points)
    return RawMesh(np.concatenate(vertices), np.concatenate(faces))


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep what a reader logs, prints or warns of off the screen; a warning of lost data becomes an error."""
    logger = logging.getLogger("trimesh")
    disabled, logger.disabled = logger.disabled, True
    try:
        with warnings.catch_warnings(), redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            warnings.simplefilter("ignore")
            # numpy stops at the first word that is no number, and only warns about it
            warnings.filterwarnings("error", message=".*could not be read to its end.*")
            yield
    finally:
        logger.disabled = disabled


def _brief(reason: object) -> str:
    text = " ".join(shown(str(reason)).split())
    return text if len(text) <= 120 else text[:117] + "..."
