"""The commands ``geoweave fetch``, ``geoweave figures`` and ``geoweave doctor``."""

from __future__ import annotations

import sys
from typing import NoReturn

import click

from geoweave.cli.options import as_json, print_json, print_table, status


@click.command()
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


@click.command()
@click.argument("names", metavar="[NAME]...", nargs=-1)
@click.option("--profile", type=click.Choice(["default", "paper"]), default="default", help="Quality.")
@click.option("--jobs", type=click.IntRange(min=1), default=1, help="Notebooks executed at the same time.")
@click.option("--force", is_flag=True, help="Execute also what is up to date.")
@as_json
def figures(names: tuple[str, ...], profile: str, jobs: int, force: bool, as_json: bool) -> NoReturn:
    """Execute the notebooks that are stale and write figures/."""
    from dataclasses import asdict

    from geoweave.artifact import doctor

    doctor.require_notebooks()
    doctor.require_rendering()
    from geoweave.artifact import figures  # it loads what executes notebooks

    results = figures.run(names, profile, jobs, force=force)
    if as_json:
        print_json({result.name: asdict(result) for result in results})
    else:
        print_table(None, [(result.name, result.problem or result.state) for result in results])
    sys.stdout.flush()
    raise click.exceptions.Exit(1 if any(result.state == "failed" for result in results) else 0)


@click.command()
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
