"""The mesh that a command or a call is to work on: named, read, remeshed, and what is said meanwhile."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from geoweave.errors import FieldError, MeshError
from geoweave.wording import counted

if TYPE_CHECKING:
    from geoweave.meshing import Components, Prepared

__all__ = ["MeshSource", "Say", "about", "prepared_surface", "read_surface", "silent", "source_of", "timed"]

Say = Callable[[str], None]
"""Is given one line of progress at a time."""


def silent(text: str) -> None:
    """Say nothing of the progress."""


@dataclass(frozen=True)
class MeshSource:
    """A mesh by its name, and how it is to be read.

    Examples
    --------
    >>> source = gw.MeshSource("bunny", faces=2_000)
    >>> source.name, source.seed
    ('bunny', 0)
    """

    name: str
    """Path of a file, or name of a data set."""
    faces: int | Literal["given"] | None = None
    """Number of triangles that it is remeshed to, or "given" for those that it has.

    None leaves it to the method: a field is found on the triangles that are there, a weave on even ones.
    """
    seed: int = 0
    """Of the random numbers that the methods start from."""
    repair: bool = False
    """Whether to cut the surface apart along edges that more than two faces share."""
    components: Components = "keep"
    """Keep all components, or the one of largest area."""

    def __post_init__(self) -> None:
        """Refuse a number of triangles that is out of reach."""
        if isinstance(self.faces, int):
            from geoweave.meshing import check_face_count

            with about(self.name):
                check_face_count(self.faces)


def source_of(mesh: str | os.PathLike[str] | MeshSource) -> MeshSource:
    """Return a mesh that is given by its name alone as a `MeshSource`, any other as it is."""
    return mesh if isinstance(mesh, MeshSource) else MeshSource(os.fspath(mesh))


def prepared_surface(source: MeshSource, seconds: dict[str, float], say: Say) -> Prepared:
    """Read a mesh, and remesh it if that was asked for.

    Parameters
    ----------
    source : the mesh
    seconds : the time of both steps is entered here, as "read" and "remesh"
    say : called with what is being done
    """
    with timed(seconds, "read"):
        prepared = read_surface(source, say)
    if isinstance(source.faces, int):
        from geoweave.meshing import remeshed

        say(f"remeshing {source.name} to {counted(source.faces, 'triangle')}")
        with timed(seconds, "remesh"):
            prepared = remeshed(prepared, source.faces, name=source.name)
    return prepared


def read_surface(source: MeshSource, say: Say) -> Prepared:
    """Read a file, or a data set where no file has that name; its number of triangles stays.

    Raises
    ------
    MeshError
        If there is neither, or the file holds no mesh that the methods are defined on.
    DataError
        If the data set cannot be brought.
    """
    from geoweave.meshing import prepare_arrays, read_mesh

    name, components = source.name, source.components
    say(f"reading {name}")
    if not names_a_data_set(name):
        return read_mesh(name, components=components, cut=source.repair)
    from geoweave.models import datasets

    if name not in datasets.names():
        known = ", ".join(datasets.names())
        raise MeshError(
            f"{name}: there is neither a file nor a data set of that name; the data sets are {known}"
        )
    path = datasets.fetch(name)
    if path.suffix != ".npz":
        return read_mesh(path, components=components, cut=source.repair)
    mesh = datasets.load(name)
    return prepare_arrays(mesh.vertices, mesh.faces, components=components, name=name)


def names_a_data_set(name: str) -> bool:
    """Whether a name is that of a data set: a plain word without an ending, and no file has it."""
    return not os.path.lexists(name) and name.replace("-", "").replace("_", "").isalnum()


@contextmanager
def about(name: str) -> Iterator[None]:
    """Have what a method says about a surface begin with the name of its file."""
    try:
        yield
    except (FieldError, MeshError) as error:
        if str(error).startswith(name):
            raise
        raise type(error)(f"{name}: {error}") from error


@contextmanager
def timed(seconds: dict[str, float], key: str) -> Iterator[None]:
    """Enter the wall-clock seconds that a block takes."""
    start = time.perf_counter()
    yield
    seconds[key] = time.perf_counter() - start
