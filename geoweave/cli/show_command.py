"""The command that shows a weave on a page of its own: ``geoweave show``."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import click

from geoweave.cli.options import as_json, print_json, print_table, seconds_text, status, up_option
from geoweave.wording import counted


@click.command()
@click.argument("folder", metavar="DIR", type=click.Path(exists=True, file_okay=False))
@click.option("-o", "output", metavar="FILE", help="The page; viewer.html in DIR if not given.")
@click.option("--no-open", is_flag=True, help="Do not open the page in a browser.")
@up_option
@as_json
def show(folder: str, output: str | None, no_open: bool, up: str | None, as_json: bool) -> None:
    """Write a page that shows a weave, at rest and as designed, to be turned, looked at and changed.

    DIR holds the weave.json of a weave. The page needs no network. What is changed on it is saved as
    edits.json.
    """
    from geoweave.pipeline import show_folder

    with status() as say:
        made = show_folder(folder, output, up=up, callback=say)
    if as_json:
        print_json(made.document())
    else:
        shapes = "at rest and as designed" if made.at_rest else "as designed"
        print_table(
            folder,
            [
                (
                    "weave",
                    f"{counted(made.ribbons, 'ribbon')}, {counted(made.crossings, 'crossing')}, {shapes}",
                ),
                ("hard places", f"{made.places:,}"),
                ("seconds", seconds_text(made.seconds)),
                ("written to", str(made.path)),
            ],
        )
    if not no_open:
        _open(made.path)


def _open(page: Path) -> None:
    """Open a page in a browser where there is a screen; elsewhere its path was printed."""
    if sys.platform.startswith("linux") and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        return
    click.launch(page.resolve().as_uri())
