"""The command that puts an exported pattern together in simulation: ``geoweave twin``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from geoweave.cli.options import as_json, print_json, print_table, seconds_text, status
from geoweave.wording import counted

if TYPE_CHECKING:
    from geoweave.pipeline import TwinOfFile

DOUBTS = 5
"""The table lists at most so many places that contradict themselves."""


@click.command()
@click.argument("source", metavar="DIR|PATTERN|SVG", type=click.Path(exists=True))
@click.option("-o", "output", metavar="DIR", help="Folder for twin.json; that of the pattern if not given.")
@click.option("--anyway", is_flag=True, help="Put together also a pattern that contradicts itself.")
@as_json
def twin(source: str, output: str | None, anyway: bool, as_json: bool) -> None:
    """Put a pattern.json or a pattern.svg together in simulation, and say whether the object comes back.

    Exits with 1 if the strips close into another surface than the design's, or into another shape.
    """
    from geoweave.pipeline import twin_file

    with status() as say:
        made = twin_file(source, output, anyway=anyway, callback=say)
    if as_json:
        print_json(made.document())
    else:
        print_table(str(made.path), _rows(made))
        click.echo(sentence(made))
    if made.reasons:
        raise click.exceptions.Exit(1)


def sentence(made: TwinOfFile) -> str:
    """What a maker is told in the end."""
    from geoweave.twin import contradiction_sentence

    pattern, doubts, target = made.twin.pattern, made.twin.contradictions, made.target
    if target is None:
        return "The strips go together; no relaxed.json or weave.json is beside the pattern to compare with."
    name = made.target_name
    far = f"{target.crossings.mean:.1%} of the diagonal in the mean, {target.crossings.largest:.1%} at most"
    one, other = (pattern.strips[r].label for r in pattern.ribbons[target.worst])
    where = f"{target.crossings.largest * target.diagonal:.3g} mm, where {one} crosses {other}"
    if not made.closes_as_designed:
        net = made.twin.surface
        return (
            f"Do not cut these strips: they close into a surface of genus {net.genus} with "
            f"{_openings(net.openings)}, and the design has genus {made.genus_designed} with "
            f"{_openings(made.openings_designed)}. Weave it again with fewer ribbons or more "
            "--faces."
        )
    if not target.comes_back:
        return f"The object does not come back: its crossings are {far} from those of {name} ({where})."
    end = f" Check {contradiction_sentence(pattern, doubts[0])}." if doubts else ""
    end += f" But {made.also}." if made.also else ""
    return f"The object comes back: its crossings are {far} from those of {name} ({where}).{end}"


def _openings(number: int | None) -> str:
    return "openings that are not said" if number is None else counted(number, "opening")


def _rows(made: TwinOfFile) -> list[tuple[str, str]]:
    """What the table for people says."""
    result = made.document()
    net, doubts = result["topology"], result["topology"]["contradictions"]
    closed = f"they close into a surface of genus {net['genus']} with {_openings(net['openings'])}"
    if made.genus_designed is not None:
        design = f"genus {made.genus_designed} with {_openings(made.openings_designed)}"
        closed += ", as designed" if made.closes_as_designed else f"; the design has {design}"
    strain, bow = result["strain"], result["bow"]
    rows = [
        ("ribbons", f"{result['ribbons']:,}"),
        ("crossings", f"{result['crossings']:,}"),
        ("faces", f"{net['faces']:,}; {closed}"),
        *(("  doubtful", text) for text in doubts[:DOUBTS]),
        *(
            [("  ", f"and {counted(len(doubts) - DOUBTS, 'more such place')}")]
            if len(doubts) > DOUBTS
            else []
        ),
        ("outside", "known" if result["side_known"] else "none: the mirror image is as possible"),
        (
            "at rest",
            f"{'yes' if made.twin.rest.converged else 'nearly'}, after {counted(result['steps'], 'step')}",
        ),
        ("stretched", f"{strain['largest']:+.2%} at most, {strain['ribbon']}"),
        # A drawing does not say how far a ribbon is from its straight strip.
        *(
            [("bow", f"{bow['largest']:.3g} mm at most, {bow['ribbon']}; strips are straight")]
            if made.path.suffix.lower() != ".svg"
            else []
        ),
    ]
    for what, each in made.likeness.items():
        off = each.crossings
        sizes = f"mean {off.mean:.2%} of the diagonal, rms {off.rms:.2%}, at most {off.largest:.2%}"
        rows.append((f"from {what}", f"crossings: {sizes}"))
        rows.append(("", f"along ribbons: mean {each.ribbons.mean:.2%}; of the shapes: {each.hausdorff:.2%}"))
    rows += [
        ("seconds", seconds_text(made.seconds)),
        ("written to", ", ".join(result["files"])),
    ]
    return rows
