"""The command that relaxes a weave made before: ``geoweave relax``."""

from __future__ import annotations

import click

from geoweave.cli.options import as_json, print_json, print_table, seconds_text, status
from geoweave.wording import counted


@click.command()
@click.argument("file", metavar="FILE", type=click.Path(exists=True, dir_okay=False))
@click.option(
    "-o", "output", metavar="DIR", required=True, help="Folder for the results; made if it is not there."
)
@as_json
def relax(file: str, output: str, as_json: bool) -> None:
    """Relax a weave.json of geoweave, or a .rod file of RibbonSim, to the shape that it takes."""
    from geoweave.pipeline import relax_file

    with status() as say:
        made = relax_file(file, output, callback=say)
    result = made.document()
    if as_json:
        print_json(result)
        return
    moved, ended = result["from_start"], "yes" if result["converged"] else "no"
    print_table(
        file,
        [
            ("rods", f"{result['rods']:,}"),
            ("contacts", f"{result['contacts']:,}"),
            *(("repaired", sentence) for sentence in result.get("repairs", ())),
            ("at rest", f"{ended}, after {counted(result['steps'], 'step')}: {result['ending']}"),
            ("elastic energy", f"{result['elastic_before']:.4g} -> {result['elastic_after']:.4g}"),
            ("moved", f"{moved['mean']:.2%} of the diagonal in the mean, at most {moved['largest']:.2%}"),
            ("seconds", seconds_text(made.seconds)),
            ("written to", ", ".join(result["files"])),
        ],
    )
