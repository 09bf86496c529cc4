"""What every command of the ``geoweave`` command line shares: options, reading, progress, printing."""

from __future__ import annotations

import json
import math
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geoweave.errors import FieldError, MeshError

if TYPE_CHECKING:
    from geoweave.meshing import Components, Prepared

Say = Callable[[str], None]
"""Shows one line of progress."""

as_json = click.option("--json", "as_json", is_flag=True, help="Print one JSON object and nothing else.")
mesh_argument = click.argument("name", metavar="MESH")
meshes_argument = click.argument("names", metavar="MESH...", nargs=-1, required=True)
repair_option = click.option(
    "--repair", is_flag=True, help="Cut the surface apart along edges shared by more than two faces."
)
components_option = click.option(
    "--components",
    type=click.Choice(["keep", "largest"]),
    default="keep",
    help="Keep all components, or the one of largest area only.",
)
faces_option = click.option(
    "--faces", type=click.IntRange(min=4), help="Remesh to about this many triangles."
)
seed_option = click.option(
    "--seed", type=click.IntRange(min=0), default=0, help="Seed of the random numbers (0)."
)


class Positive(click.FloatRange):
    """A positive number, neither infinite nor nan."""

    def __init__(self) -> None:
        super().__init__(min=0, min_open=True)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number."""
        number = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value} is not a finite number.", param, ctx)
        return number


@dataclass(frozen=True)
class Surface:
    """The surface that a command is to work on, as it was asked for."""

    name: str
    faces: int | None
    seed: int
    repair: bool
    components: Components


def surface_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the argument and the options that name a surface, and hand them over as one."""

    @wraps(command)
    def bundled(
        name: str, faces: int | None, seed: int, repair: bool, components: Components, **others: Any
    ) -> None:
        command(Surface(name, faces, seed, repair, components), **others)

    return _with_options(bundled, mesh_argument)


def surfaces_options(command: Callable[..., None]) -> Callable[..., None]:
    """The same for a command that takes several meshes, which are handed over as a tuple."""

    @wraps(command)
    def bundled(
        names: tuple[str, ...],
        faces: int | None,
        seed: int,
        repair: bool,
        components: Components,
        **others: Any,
    ) -> None:
        command(tuple(Surface(name, faces, seed, repair, components) for name in names), **others)

    return _with_options(bundled, meshes_argument)


def _with_options(
    command: Callable[..., None], argument: Callable[[Callable[..., None]], Callable[..., None]]
) -> Callable[..., None]:
    for option in (components_option, repair_option, seed_option, faces_option, argument):
        command = option(command)
    return command


def prepared_surface(surface: Surface, seconds: dict[str, float], say: Say) -> Prepared:
    """Read a surface, and remesh it if that was asked for; enters the time of both."""
    with timed(seconds, "read"):
        prepared = read_surface(surface.name, surface.components, surface.repair, say)
    if surface.faces is not None:
        with timed(seconds, "remesh"):
            prepared = to_faces(prepared, surface.faces, surface.name, say)
    return prepared


def read_surface(name: str, components: Components, repair: bool, say: Say) -> Prepared:
    """Read a file, or a data set where no file has that name."""
    from geoweave.meshing import prepare_arrays, read_mesh

    say(f"reading {name}")
    # a data set's name is a plain word without an ending; a file of that name comes first
    if os.path.lexists(name) or not name.replace("-", "").replace("_", "").isalnum():
        return read_mesh(name, components=components, cut=repair)
    from geoweave.models import datasets

    if name not in datasets.names():
        known = ", ".join(datasets.names())
        raise MeshError(
            f"{name}: there is neither a file nor a data set of that name; the data sets are {known}"
        )
    path = datasets.fetch(name)
    if path.suffix != ".npz":
        return read_mesh(path, components=components, cut=repair)
    mesh = datasets.load(name)
    return prepare_arrays(mesh.vertices, mesh.faces, components=components, name=name)


def to_faces(prepared: Prepared, faces: int | None, name: str, say: Say) -> Prepared:
    """Remesh to about so many triangles, if a number was asked for."""
    if faces is None:
        return prepared
    from geoweave.meshing import remeshed

    say(f"remeshing {name} to {faces:,} triangles")
    return remeshed(prepared, faces, name=name)


def check_output(output: str, source: str) -> None:
    """Refuse an output that cannot be written, or that is the input, before the work begins."""
    from geoweave.files import OutputError, check_writable

    check_writable(output)
    if os.path.exists(output) and os.path.exists(source) and os.path.samefile(output, source):
        raise OutputError(f"{output}: is the input; name another file")


def new_folder(output: str) -> Path:
    """Refuse a folder for results that cannot be made or written to, before the work begins."""
    from geoweave.files import OutputError, check_writable

    folder = Path(output)
    if folder.is_dir():
        check_writable(folder / "weave.json")
    elif folder.exists():
        raise OutputError(f"{output}: is a file; name a folder with -o")
    else:
        check_writable(folder)
    return folder


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
def status() -> Iterator[Say]:
    """Show what is being done on stderr while it is a terminal."""
    if not sys.stderr.isatty():
        yield lambda text: None
        return
    from rich.console import Console
    from rich.markup import escape

    with Console(stderr=True).status("") as status:
        yield lambda text: status.update(escape(text))


@contextmanager
def timed(seconds: dict[str, float], key: str) -> Iterator[None]:
    """Enter the wall-clock seconds that a block takes."""
    start = time.perf_counter()
    yield
    seconds[key] = time.perf_counter() - start


def text_of(value: float) -> str:
    """Write a number for people."""
    return f"{value:,}" if isinstance(value, int) else f"{value:.6g}"


def print_json(result: dict[str, Any]) -> None:
    """Print one JSON object."""
    click.echo(json.dumps(result, indent=2, allow_nan=False))


def print_table(title: str | None, rows: list[tuple[str, str]]) -> None:
    """Print a table of two columns under a title."""
    width = max((len(key) for key, _ in rows), default=0)
    lines = ([title] if title is not None else []) + [
        f"  {key:{width}}  {value}".rstrip() for key, value in rows
    ]
    click.echo("\n".join(lines))
