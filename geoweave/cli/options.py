"""What the commands share: options, progress, printing."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import wraps
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from geoweave.meshing import Components
    from geoweave.pipeline import Say

Option = Callable[[Callable[..., None]], Callable[..., None]]
"""Gives a command an option or an argument."""

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


class FacesOrGiven(click.ParamType[Any]):
    """A number of triangles, or the word "given"."""

    name = "faces"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number or the word."""
        if isinstance(value, str) and value.strip().lower() == "given":
            return "given"
        return click.IntRange(min=4).convert(value, param, ctx)


own_faces_option = click.option(
    "--faces",
    type=FacesOrGiven(),
    metavar="given|N",
    help="Remesh to about this many triangles, or weave on those that are given. By default weave finds a "
    "mesh by itself: even, and fine enough for the ribbons.",
)
seed_option = click.option(
    "--seed", type=click.IntRange(min=0), default=0, help="Seed of the random numbers (0)."
)


up_option = click.option(
    "--up",
    type=click.Choice(("x", "y", "z", "-x", "-y", "-z")),
    help="The axis that is up in guide, viewer and GLB; found by itself if not given.",
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


def surface_options(command: Callable[..., None], faces: Option = faces_option) -> Callable[..., None]:
    """Give a command the argument and the options that name a surface, and hand them over as one."""

    @wraps(command)
    def bundled(
        name: str, faces: Any, seed: int, repair: bool, components: Components, **others: Any
    ) -> None:
        from geoweave.pipeline import MeshSource

        command(MeshSource(name, faces, seed, repair, components), **others)

    return _with_options(bundled, mesh_argument, faces)


def surfaces_options(command: Callable[..., None]) -> Callable[..., None]:
    """The same for a command that takes several meshes, which are handed over as a tuple."""

    @wraps(command)
    def bundled(
        names: tuple[str, ...],
        faces: Any,
        seed: int,
        repair: bool,
        components: Components,
        **others: Any,
    ) -> None:
        from geoweave.pipeline import MeshSource

        command(tuple(MeshSource(name, faces, seed, repair, components) for name in names), **others)

    return _with_options(bundled, meshes_argument, own_faces_option)


def weave_surface_options(command: Callable[..., None]) -> Callable[..., None]:
    """As `surface_options`, for a command that works on triangles of its own unless it is told not to."""
    return surface_options(command, own_faces_option)


def _with_options(command: Callable[..., None], argument: Option, faces: Option) -> Callable[..., None]:
    for option in (components_option, repair_option, seed_option, faces, argument):
        command = option(command)
    return command


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


def seconds_text(seconds: Mapping[str, float]) -> str:
    """Write the time of each stage for people."""
    return ", ".join(f"{key} {value:.2f}" for key, value in seconds.items())


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
