"""The command that weaves many meshes: ``geoweave sweep``."""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any, NoReturn

import click

from geoweave.cli.options import as_json, print_json, print_table, status, surfaces_options
from geoweave.cli.weave_command import weave_options

if TYPE_CHECKING:
    from geoweave.pipeline import MeshSource, Row, WeaveRequest


@click.command()
@surfaces_options
@click.option(
    "-o", "output", metavar="DIR", required=True, help="Folder for a folder per mesh and the table of them."
)
@click.option("--jobs", type=click.IntRange(min=1), help="Meshes woven at the same time on this machine (1).")
@click.option(
    "--dask", metavar="ADDRESS", help="Scheduler of a Dask cluster that is there, such as tcp://host:8786."
)
@weave_options
@as_json
def sweep(
    sources: tuple[MeshSource, ...],
    output: str,
    jobs: int | None,
    dask: str | None,
    request: WeaveRequest,
    as_json: bool,
) -> NoReturn:
    """Weave many meshes, each into a folder of its own, and make one table of them.

    A mesh that is woven already, from the same file with the same options by the same version, is kept. One
    that fails stops no other; the exit status is then 1.
    """
    if jobs is not None and dask is not None:
        raise click.UsageError("--jobs and --dask exclude each other; give one of them")
    from geoweave.files import checked_folder
    from geoweave.pipeline import TABLES, check_dask, sweep as sweep_meshes

    folder = checked_folder(output)
    if dask is not None:
        check_dask(dask)
    start = time.perf_counter()
    with _terminated(), status() as say:
        say(f"weaving {_meshes(len(sources))}")
        rows = sweep_meshes(sources, request, folder, jobs=jobs or 1, dask=dask, callback=_lines())
    counts = {state: sum(row.state == state for row in rows) for state in ("done", "kept", "failed")}
    for row in rows:
        if row.fault:
            print(row.fault, file=sys.stderr, end="")
    tables = [str(Path(output) / name) for name in TABLES]
    if as_json:
        result = {
            "output": output,
            "meshes": len(rows),
            **counts,
            "tables": tables,
            "seconds": round(time.perf_counter() - start, 4),
            "results": [_as_dict(row) for row in rows],
        }
        print_json(result)
    else:
        told = [(row.folder, row.sentence()) for row in rows]
        ended = ", ".join(f"{count} {state}" for state, count in counts.items() if count)
        print_table(f"{_meshes(len(rows))}: {ended}", [*told, ("written to", ", ".join(tables))])
    sys.stdout.flush()
    raise click.exceptions.Exit(1 if counts["failed"] else 0)


@contextmanager
def _terminated() -> Iterator[None]:
    """Have what ends a batch job by SIGTERM tidy up as Ctrl-C does."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _lines() -> Callable[[Row, int], None] | None:
    """On a terminal, write a line on stderr for each mesh as it is ready."""
    if not sys.stderr.isatty():
        return None
    ended = count(1)

    def line(row: Row, total: int) -> None:
        print(f"[{next(ended)}/{total}] {row.folder}: {row.sentence()}", file=sys.stderr)

    return line


def _as_dict(row: Row) -> dict[str, Any]:
    found = {"mesh": row.mesh, "folder": row.folder, "state": row.state}
    return found | ({"problem": row.problem} if row.result is None else {"result": dict(row.result)})


def _meshes(number: int) -> str:
    return "1 mesh" if number == 1 else f"{number} meshes"
