"""The command that changes a weave as a person did on its page: ``geoweave edit``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from geoweave.cli.options import as_json, print_json, print_table, seconds_text, status
from geoweave.wording import counted

if TYPE_CHECKING:
    from geoweave.pipeline import EditedFiles

NAMES = {
    "ribbons": ("ribbons", "{:,}"),
    "crossings": ("crossings", "{:,}"),
    "total_length": ("length", "{:.5g}"),
    "spacing": ("spacing", "{:.4g}"),
    "alternation.fraction": ("alternation", "{:.1%}"),
    "pattern.fraction": ("pattern met", "{:.1%}"),
    "crossing_angle_deg.smallest": ("smallest angle", "{:.1f} degrees"),
    "regularity.piled": ("piled", "{:.1%}"),
    "regularity.phase_order": ("order of the phase", "{:.2f}"),
    "regularity.bare": ("bare", "{:.2%}"),
    "regularity.near_ideal": ("near the ideal angle", "{:.1%}"),
    "regularity.few_crossings": ("ribbons of few crossings", "{:,}"),
    "regularity.parts": ("parts", "{:,}"),
    "aligned_deg": ("aligned", "{:.1f} degrees off"),
    "relax.mean": ("at rest, mean", "{:.2%} of the diagonal"),
    "relax.hausdorff": ("at rest, at most", "{:.2%} of the diagonal"),
    "verdict.word": ("verdict", "{}"),
}
"""How each of the numbers that may differ is called and written."""


@click.command()
@click.argument("folder", metavar="DIR", type=click.Path(exists=True, file_okay=False))
@click.argument("edits", metavar="EDITS", type=click.Path(exists=True, dir_okay=False))
@click.option("-o", "output", metavar="DIR", help="Folder for the results; the same one if not given.")
@click.option("--mesh", metavar="MESH", help="The mesh, if it lies elsewhere than when it was woven.")
@as_json
def edit(folder: str, edits: str, output: str | None, mesh: str | None, as_json: bool) -> None:
    """Make a weave again with the changes of an edits.json, and say what they change.

    DIR is a folder that 'geoweave weave' wrote; EDITS is what the page of 'geoweave show DIR' saved: ribbons
    dropped, crossings flipped, branch points pinned or moved, a direction to follow.
    """
    from geoweave.pipeline import edit_folder

    with status() as say:
        made = edit_folder(folder, edits, output, mesh=mesh, callback=say)
    if as_json:
        print_json(made.document())
        return
    print_table(folder, _rows(made))
    if made.made.verdict is not None:
        click.echo(made.made.verdict.sentence)


def _rows(made: EditedFiles) -> list[tuple[str, str]]:
    """What the table for people says."""
    done = [
        f"{counted(len(made.edits.drop), 'ribbon')} dropped" if made.edits.drop else "",
        f"{counted(len(made.edits.flip), 'crossing')} flipped" if made.edits.flip else "",
        "branch points placed" if made.edits.singularities is not None else "",
        "a direction followed" if made.edits.align is not None else "",
    ]
    rows = [("edits", ", ".join(each for each in done if each) or "none")]
    for name, (before, after) in made.differs.items():
        what, form = NAMES[name]
        rows.append((what, f"{_said(form, before)} -> {_said(form, after)}"))
    if not made.differs:
        rows.append(("numbers", "all as before"))
    rows += [
        ("seconds", seconds_text(made.made.seconds)),
        ("written to", ", ".join(str(path) for path in made.made.files.values())),
    ]
    return rows


def _said(form: str, value: Any) -> str:
    return "none" if value is None else form.format(value)
