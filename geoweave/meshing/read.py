"""From a path to the arrays in the file; whatever a reader raises becomes one sentence here."""

from __future__ import annotations

import logging
import stat
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from io import StringIO
from os import PathLike
from pathlib import Path

import numpy as np

from geoweave.errors import MeshError
from geoweave.meshing.obj_off_stl import RawMesh, read_obj, read_off, read_stl

_PACKED = {"gz", "bz2", "xz", "zst", "zip", "7z", "tar", "tgz"}


def read_arrays(path: str | PathLike[str]) -> RawMesh:
    """Read the vertices and triangles that a file holds, without mending anything.

    OBJ, OFF, PLY and STL are read here; any other format goes through trimesh. The extension decides.

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

    kind = file.suffix.lower().removeprefix(".")
    try:
        with _quiet():
            return _reader(kind, name)(file)
    except MeshError as error:
        text = str(error)
        if text.startswith(f"{name}: "):
            raise
        raise MeshError(f"{name}: cannot be read as {kind.upper()}: {text}; export the mesh again") from None
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


def _reader(kind: str, name: str) -> Callable[[Path], RawMesh]:
    if kind == "obj":
        return lambda file: read_obj(file.read_bytes())
    if kind == "off":
        return lambda file: read_off(file.read_bytes())
    if kind == "stl":
        return lambda file: read_stl(file.read_bytes())
    if kind == "ply":
        from geoweave.meshing.ply import read_ply  # numba takes half a second to import

        return lambda file: read_ply(file.read_bytes())
    if kind in _PACKED:
        raise MeshError(f"{name}: is a packed file; unpack it first")
    import trimesh

    if kind not in trimesh.exchange.load.mesh_formats():
        raise MeshError(f"{name}: '.{kind}' is no mesh format we read; save it as OBJ, OFF, PLY or STL")
    return _read_with_trimesh


def _read_with_trimesh(file: Path) -> RawMesh:
    """Read through trimesh, with the parts of a scene where the scene places them."""
    import trimesh

    scene = trimesh.load_scene(str(file.absolute()), process=False, skip_materials=True)
    vertices, faces, offset = [np.empty((0, 3))], [np.empty((0, 3), dtype=np.int64)], 0
    for node in scene.graph.nodes_geometry:
        placement, name = scene.graph[node]
        part = scene.geometry[name]
        points = np.asarray(part.vertices, dtype=np.float64)
        if points.shape[1] != 3:
            raise MeshError("it holds a flat drawing, not a surface")
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
