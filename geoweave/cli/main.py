"""The ``geoweave`` command, a contract that others script against.

Results go to stdout, progress to stderr and only if that is a terminal; ``--json`` prints one JSON object
and nothing else. Exit status 0: done; 2: bad usage or bad input, with one line on stderr that names the file,
what is wrong and what to do; 1: anything else. Heavy imports wait until a command needs them.
"""

from __future__ import annotations

import io
import os
import sys
import traceback
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NoReturn

import click

from geoweave.checkout import package_version
from geoweave.cli import field_commands, relax_command, sweep_command, twin_command, weave_command
from geoweave.cli.options import (
    as_json,
    check_output,
    components_option,
    faces_option,
    mesh_argument,
    print_json,
    print_table,
    read_surface,
    repair_option,
    status,
    text_of,
    to_faces,
)
from geoweave.errors import GeoweaveError, RenderError

if TYPE_CHECKING:
    from geoweave.meshing import Components


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit status; ``arguments`` default to those of the process."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # a file name must not break a result
    arguments = sys.argv[1:] if arguments is None else list(arguments)
    try:
        with commands.make_context("geoweave", list(arguments)) as context:
            commands.invoke(context)
        sys.stdout.flush()
    except click.exceptions.Exit as stop:
        return stop.exit_code
    except click.UsageError as error:
        command = error.ctx.command_path if error.ctx is not None else "geoweave"
        return _refuse(f"{error.format_message().rstrip('.')}; see '{command} --help'", 2)
    except click.ClickException as error:
        return _refuse(error.format_message(), 2)
    except RenderError as error:
        return _refuse(str(error), 1)
    except GeoweaveError as error:
        return _refuse(str(error), 2)
    except KeyboardInterrupt:
        return _refuse("interrupted; no file was left half-written", 1)
    except BrokenPipeError:
        # the reader of our output went away; the interpreter must not complain about it when it ends
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except MemoryError:
        return _refuse("not enough memory; ask for fewer triangles with --faces", 1)
    except Exception:
        traceback.print_exc()
        return _refuse("this is a fault of geoweave; please report it with the lines above", 1)
    return 0


def _refuse(message: str, status: int) -> int:
    line = " ".join(message.split())
    print(f"geoweave: {line}", file=sys.stderr)
    return status


def _version(context: click.Context, _: click.Parameter, wanted: bool) -> None:
    if wanted:
        click.echo(f"geoweave {package_version()}")
        context.exit()


@click.group(no_args_is_help=False, context_settings={"help_option_names": ["-h", "--help"]})
@click.option(
    "--version", is_flag=True, is_eager=True, expose_value=False, callback=_version, help="Version."
)
def commands() -> None:
    """Geodesic fields, foliations and weaves on triangle meshes."""


commands.add_command(field_commands.field)
commands.add_command(field_commands.foliate)
commands.add_command(weave_command.weave)
commands.add_command(relax_command.relax)
commands.add_command(twin_command.twin)
commands.add_command(sweep_command.sweep)


@commands.command()
@mesh_argument
@as_json
@repair_option
@components_option
@faces_option
@click.option("-o", "output", metavar="OUT", help="Write the mended mesh (.obj, .off or .ply).")
def info(
    name: str, as_json: bool, repair: bool, components: Components, faces: int | None, output: str | None
) -> None:
    """Read a mesh file (or a named data set), mend it, and say what it is and what was mended."""
    from geoweave.meshing import check_format, write_mesh

    if output is not None:
        check_format(output)
        check_output(output, name)
    with status() as say:
        prepared = to_faces(read_surface(name, components, repair, say), faces, name, say)
        if output is not None:
            say(f"writing {output}")
            write_mesh(prepared.mesh, output)
    mesh, report = prepared.mesh, prepared.report
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    result: dict[str, Any] = {
        "mesh": name,
        "vertices": mesh.n_vertices,
        "edges": mesh.n_edges,
        "faces": mesh.n_faces,
        "components": mesh.n_components,
        "genus": mesh.genus,
        "boundary_loops": len(mesh.boundary_loops),
        "euler_characteristic": mesh.euler_characteristic,
        "area": float(mesh.face_areas.sum()),
        "mean_edge": mesh.mean_edge,
        "bounding_box": [low.tolist(), high.tolist()],
        "repairs": report.as_dict(),
    }
    if output is not None:
        result["output"] = output
    if as_json:
        print_json(result)
        return
    size = " x ".join(f"{side:.5g}" for side in high - low)
    rows = [
        (key.replace("_", " "), text_of(result[key]))
        for key in result
        if isinstance(result[key], int | float)
    ]
    sentences = report.sentences() or ["none needed"]
    rows += [("size", size), ("repairs", sentences[0]), *(("", more) for more in sentences[1:])]
    rows += [("written to", output)] if output is not None else []
    print_table(name, rows)


@commands.command()
@click.argument("names", metavar="[NAME]...", nargs=-1)
@as_json
def fetch(names: tuple[str, ...], as_json: bool) -> None:
    """Bring named meshes (all, without a name) and check them by sha256."""
    from geoweave.models import datasets

    with status() as say:
        found: dict[str, str] = {}
        for name in names or tuple(datasets.names()):
            say(f"fetching {name}")
            found[name] = str(datasets.fetch(name))
    if as_json:
        print_json(found)
        return
    print_table(None, list(found.items()))


@commands.command()
@click.argument("names", metavar="[NAME]...", nargs=-1)
@click.option("--profile", type=click.Choice(["default", "paper"]), default="default", help="Quality.")
@click.option("--jobs", type=click.IntRange(min=1), default=1, help="Notebooks executed at the same time.")
@click.option("--force", is_flag=True, help="Execute also what is up to date.")
@as_json
def figures(names: tuple[str, ...], profile: str, jobs: int, force: bool, as_json: bool) -> NoReturn:
    """Execute the notebooks that are stale and write figures/."""
    from dataclasses import asdict

    from geoweave.artifact import doctor, figures

    doctor.require_rendering()
    results = figures.run(names, profile, jobs, force=force)
    if as_json:
        print_json({result.name: asdict(result) for result in results})
    else:
        print_table(None, [(result.name, result.problem or result.state) for result in results])
    sys.stdout.flush()
    raise click.exceptions.Exit(1 if any(result.state == "failed" for result in results) else 0)


@commands.command()
@as_json
def doctor(as_json: bool) -> NoReturn:
    """Say whether this machine can draw, which solver and data there are, and what to install."""
    from geoweave.artifact import examine

    diagnosis = examine()
    if as_json:
        print_json(diagnosis.as_dict())
    else:
        click.echo(diagnosis.as_text())
    sys.stdout.flush()
    raise click.exceptions.Exit(0 if diagnosis.rendering.works else 1)
