"""The ``geoweave`` command, a contract that others script against.

Results go to stdout, progress to stderr and only if that is a terminal; ``--json`` prints one JSON object
and nothing else. Exit status 0: done; 2: bad usage or bad input, with one line on stderr that names the file,
what is wrong and what to do; 1: anything else. Heavy imports wait until a command needs them.
"""

from __future__ import annotations

import io
import json
import os
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NoReturn

import click

from geoweave.errors import GeoweaveError, MeshError, RenderError
from geoweave.places import package_version

if TYPE_CHECKING:
    from geoweave.fields import FaceField
    from geoweave.geodesic import GeodesicSolve, Step
    from geoweave.mesh import TriMesh
    from geoweave.prepare import Components, Prepared

Say = Callable[[str], None]


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


as_json = click.option("--json", "as_json", is_flag=True, help="Print one JSON object and nothing else.")
mesh_argument = click.argument("name", metavar="MESH")
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
    from geoweave.writing import check_format, write_mesh

    if output is not None:
        check_format(output)
        _check_output(output, name)
    with _status() as say:
        prepared = _remeshed(_read(name, components, repair, say), faces, name, say)
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
        _print_json(result)
        return
    size = " x ".join(f"{side:.5g}" for side in high - low)
    rows = [
        (key.replace("_", " "), _text(result[key])) for key in result if isinstance(result[key], int | float)
    ]
    sentences = report.sentences() or ["none needed"]
    rows += [("size", size), ("repairs", sentences[0]), *(("", more) for more in sentences[1:])]
    rows += [("written to", output)] if output is not None else []
    _print_table(name, rows)


@commands.command()
@mesh_argument
@faces_option
@click.option("--seed", type=click.IntRange(min=0), default=0, help="Seed of the random numbers (0).")
@click.option("-o", "output", metavar="OUT.npz", help="Write mesh and fields (numpy, never pickled).")
@as_json
@repair_option
@components_option
def field(
    name: str,
    faces: int | None,
    seed: int,
    output: str | None,
    as_json: bool,
    repair: bool,
    components: Components,
) -> None:
    """Find a geodesic field by Algorithm 1 from the smoothest field, at bounding radius 1."""
    if output is not None:
        _check_output(output, name)
    from geoweave.fields import total_curl
    from geoweave.geodesic import geodesic_field
    from geoweave.rosy import smoothest_field

    seconds: dict[str, float] = {}
    with _status() as say:
        with _timed(seconds, "read"):
            prepared = _read(name, components, repair, say)
        if faces is not None:
            with _timed(seconds, "remesh"):
                prepared = _remeshed(prepared, faces, name, say)
        mesh, _ = prepared.mesh.normalized()
        say("finding the smoothest field")
        with _timed(seconds, "smoothest"):
            smoothest = smoothest_field(mesh, seed=seed)
        done: list[Step] = []

        def follow(step: Step, _: FaceField) -> None:
            done.append(step)
            say(f"Algorithm 1: step {len(done)}, smoothness {step.smoothness:.2g}, energy {step.energy:.6g}")

        with _timed(seconds, "geodesic"):
            # of the circle of smoothest fields, the one that Algorithm 1 does best from
            solve = geodesic_field(smoothest, phases=4, callback=follow)
        if output is not None:
            say(f"writing {output}")
            with _timed(seconds, "write"):
                _write_field(output, mesh, solve)
    seconds["total"] = sum(seconds.values())
    result: dict[str, Any] = {
        "mesh": name,
        "vertices": mesh.n_vertices,
        "faces": mesh.n_faces,
        "components": mesh.n_components,
        "genus": mesh.genus,
        "boundary_loops": len(mesh.boundary_loops),
        "total_curl": {"before": total_curl(solve.initial), "after": total_curl(solve.field)},
        "singularities": _singularities(mesh, solve.initial, solve.field),
        "iterations": len(solve.steps),
        "converged": solve.converged,
        "seed": seed,
        "seconds": {key: round(value, 4) for key, value in seconds.items()},
        "repairs": prepared.report.as_dict(),
    }
    if output is not None:
        result["output"] = output
    if as_json:
        _print_json(result)
        return
    curl, points = result["total_curl"], result["singularities"]
    rows = [
        (key.replace("_", " "), _text(result[key]))
        for key in ("vertices", "faces", "genus", "boundary_loops")
    ]
    rows += [("repairs", text) for text in prepared.report.sentences()]
    rows += [
        ("total curl", f"{curl['before']:.4f} -> {curl['after']:.4f}"),
        ("singularities", f"{points['before']} -> {points['after']}"),
        ("index sum", f"{points['index_sum']} (Euler characteristic {points['euler_characteristic']})"),
        ("iterations", str(result["iterations"])),
        ("seconds", ", ".join(f"{key} {value:.2f}" for key, value in seconds.items())),
    ]
    rows += [("written to", output)] if output is not None else []
    _print_table(name, rows)


def _singularities(mesh: TriMesh, initial: FaceField, final: FaceField) -> dict[str, int]:
    from geoweave.singularities import index_sum, vertex_indices

    return {
        "before": int((vertex_indices(initial) != 0).sum()),
        "after": int((vertex_indices(final) != 0).sum()),
        "index_sum": int(index_sum(final)),
        "euler_characteristic": mesh.euler_characteristic,
    }


def _write_field(output: str, mesh: TriMesh, solve: GeodesicSolve) -> None:
    import numpy as np

    from geoweave.output import replacing

    # through an open file, because numpy would add another ending to a name it does not know
    with replacing(output) as temporary, open(temporary, "wb") as file:
        np.savez(
            file,
            vertices=mesh.vertices,
            faces=mesh.faces,
            field_initial=solve.initial.ambient,
            field=solve.field.ambient,
            delta=solve.delta.ambient,
        )


@commands.command()
@click.argument("names", metavar="[NAME]...", nargs=-1)
@as_json
def fetch(names: tuple[str, ...], as_json: bool) -> None:
    """Bring named meshes (all, without a name) and check them by sha256."""
    from geoweave import datasets

    with _status() as say:
        found: dict[str, str] = {}
        for name in names or tuple(datasets.names()):
            say(f"fetching {name}")
            found[name] = str(datasets.fetch(name))
    if as_json:
        _print_json(found)
        return
    _print_table(None, list(found.items()))


@commands.command()
@click.argument("names", metavar="[NAME]...", nargs=-1)
@click.option("--profile", type=click.Choice(["default", "paper"]), default="default", help="Quality.")
@click.option("--jobs", type=click.IntRange(min=1), default=1, help="Notebooks executed at the same time.")
@click.option("--force", is_flag=True, help="Execute also what is up to date.")
@as_json
def figures(names: tuple[str, ...], profile: str, jobs: int, force: bool, as_json: bool) -> NoReturn:
    """Execute the notebooks that are stale and write figures/."""
    from dataclasses import asdict

    from geoweave import doctor, runner

    doctor.require_rendering()
    results = runner.run(names, profile, jobs, force=force)
    if as_json:
        _print_json({result.name: asdict(result) for result in results})
    else:
        _print_table(None, [(result.name, result.problem or result.state) for result in results])
    sys.stdout.flush()
    raise click.exceptions.Exit(1 if any(result.state == "failed" for result in results) else 0)


@commands.command()
@as_json
def doctor(as_json: bool) -> NoReturn:
    """Say whether this machine can draw, which solver and data there are, and what to install."""
    from geoweave.doctor import examine

    diagnosis = examine()
    if as_json:
        _print_json(diagnosis.as_dict())
    else:
        click.echo(diagnosis.as_text())
    sys.stdout.flush()
    raise click.exceptions.Exit(0 if diagnosis.rendering.works else 1)


def _read(name: str, components: Components, repair: bool, say: Say) -> Prepared:
    """Read a file, or a data set where no file has that name."""
    from geoweave.prepare import prepare_arrays, read_mesh

    say(f"reading {name}")
    # a data set's name is a plain word without an ending; a file of that name comes first
    if os.path.lexists(name) or not name.replace("-", "").replace("_", "").isalnum():
        return read_mesh(name, components=components, cut=repair)
    from geoweave import datasets

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


def _remeshed(prepared: Prepared, faces: int | None, name: str, say: Say) -> Prepared:
    if faces is None:
        return prepared
    from geoweave.prepare import remeshed

    say(f"remeshing {name} to {faces:,} triangles")
    return remeshed(prepared, faces, name=name)


def _check_output(output: str, source: str) -> None:
    """Refuse an output that cannot be written, or that is the input, before the work begins."""
    from geoweave.output import OutputError, check_writable

    check_writable(output)
    if os.path.exists(output) and os.path.exists(source) and os.path.samefile(output, source):
        raise OutputError(f"{output}: is the input; name another file")


@contextmanager
def _status() -> Iterator[Say]:
    """Show what is being done on stderr while it is a terminal."""
    if not sys.stderr.isatty():
        yield lambda text: None
        return
    from rich.console import Console
    from rich.markup import escape

    with Console(stderr=True).status("") as status:
        yield lambda text: status.update(escape(text))


@contextmanager
def _timed(seconds: dict[str, float], key: str) -> Iterator[None]:
    start = time.perf_counter()
    yield
    seconds[key] = time.perf_counter() - start


def _text(value: float) -> str:
    return f"{value:,}" if isinstance(value, int) else f"{value:.6g}"


def _print_json(result: dict[str, Any]) -> None:
    click.echo(json.dumps(result, indent=2, allow_nan=False))


def _print_table(title: str | None, rows: list[tuple[str, str]]) -> None:
    width = max((len(key) for key, _ in rows), default=0)
    lines = ([title] if title is not None else []) + [
        f"  {key:{width}}  {value}".rstrip() for key, value in rows
    ]
    click.echo("\n".join(lines))
