"""The command that draws the strips of a weave anew: ``geoweave cut``."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any

import click

from geoweave.cli.options import Positive, as_json, print_json, print_table, seconds_text, status, up_option
from geoweave.wording import counted

if TYPE_CHECKING:
    from geoweave.pipeline import CutFiles, CutRequest

FROM_ZERO = click.FloatRange(min=0)

OPTIONS = (
    click.option("--preset", metavar="NAME", help="A material and its machine; see docs/making.md."),
    click.option(
        "--sheet",
        metavar="WxH|a4|...|roll:W",
        help="Of SVG and DXF: 600x400 (mm), 12x24in, a4, a3, letter, tabloid, or a roll of a width.",
    ),
    click.option("--paper", metavar="a4,letter", help="Of the pages: a4, a3, letter, tabloid."),
    click.option("--margin", type=FROM_ZERO, help="Left free along the edges of a sheet, mm (5)."),
    click.option("--gap", type=FROM_ZERO, help="Left free between strips on a sheet, mm (1)."),
    click.option("--kerf", type=FROM_ZERO, help="Width of the cut, mm (0)."),
    click.option("--overlap", type=FROM_ZERO, help="By which pieces of a strip are joined, mm (15)."),
    click.option(
        "--end", type=FROM_ZERO, help="What open strips keep beyond the last crossing, mm (four widths)."
    ),
    click.option("--extra", type=FROM_ZERO, default=0.0, help="Added beyond ends of open strips, mm (0)."),
    click.option("--stock-length", type=Positive(), help="Of what the cut list counts, mm (1000)."),
    click.option("--width", type=Positive(), help="Of a strip, mm (as designed)."),
    click.option("--thickness", type=Positive(), help="Of a strip, mm (as designed)."),
    click.option("--mirror", is_flag=True, help="Draw strips as seen from the inside, to print them there."),
    click.option(
        "--holes", type=FROM_ZERO, default=0.0, metavar="DIAMETER", help="A hole at every crossing, mm."
    ),
    click.option("--score", is_flag=True, help="A nick in both edges at every crossing."),
    click.option(
        "--hoops",
        type=FROM_ZERO,
        default=0.0,
        metavar="MM",
        help="A hoop at every opening; strips end so far beyond its middle.",
    ),
    click.option(
        "--colours",
        metavar="laser|paper|#rrggbb,...",
        help="Of SVG and DXF: one for each layer (laser), those of families, or your own for families.",
    ),
    click.option(
        "--labels", metavar="engraved|printed|none", help="Names as lines, as letters of a font, or none."
    ),
    click.option("--title", help="Of the drawings (the name of the folder)."),
    up_option,
    click.option(
        "--formats",
        metavar="svg,pdf",
        help="What to write: pattern, csv, svg, dxf, pdf, glb, guide; by default what the folder holds.",
    ),
)
"""How strips are cut."""


def cut_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options of cutting, and hand them over as one request."""

    @wraps(command)
    def bundled(*arguments: Any, paper: str | None, formats: str | None, **options: Any) -> None:
        from geoweave.pipeline import CutRequest

        names = {each.name for option in OPTIONS for each in _parameters(option)} - {"paper", "formats"}
        wished = {name: options.pop(name) for name in names}
        request = CutRequest(papers=_names(paper), formats=_names(formats), **wished)
        command(*arguments, request=request, **options)

    for option in reversed(OPTIONS):
        bundled = option(bundled)
    return bundled


def _parameters(option: Callable[..., Any]) -> list[click.Parameter]:
    """The parameters that an option adds to a command."""
    return click.command()(option(lambda: None)).params


def _names(text: str | None) -> tuple[str, ...] | None:
    return None if text is None else tuple(name.strip().lower() for name in text.split(",") if name.strip())


@click.command()
@click.argument("folder", metavar="DIR", type=click.Path(exists=True, file_okay=False))
@click.option("-o", "output", metavar="DIR", help="Folder for the files; DIR if not given.")
@cut_options
@as_json
def cut(folder: str, output: str | None, request: CutRequest, as_json: bool) -> None:
    """Draw the strips of a weave anew, on other sheets or of another material, without weaving again.

    DIR holds the weave.json of a weave in mm, and relaxed.json if it was relaxed.
    """
    from geoweave.pipeline import cut_folder

    with status() as say:
        made = cut_folder(folder, output, request, callback=say)
    if as_json:
        print_json(made.document())
    else:
        print_table(folder, _rows(made))


def _rows(made: CutFiles) -> list[tuple[str, str]]:
    """What the table for people says."""
    result = made.document()
    bill, shares = result["bill"], result["used_share"]
    rows = [
        ("strips", f"{result['strips']:,} in {counted(result['pieces'], 'piece')}, of {result['strips_of']}"),
        ("size", f"{result['width']:.3g} wide, {result['thickness']:.2g} thick (mm)"),
    ]
    if made.thickness_at_rest is not None:
        said = f"lengths are those of strips {made.thickness_at_rest:.2g} mm thick; weave again with "
        rows.append(("  at rest", f"{said}--thickness {result['thickness']:.2g}, or look at 'geoweave twin'"))
    if result["sheets"]:
        wide, high = result["sheet_size"]
        rows.append(("sheets", f"{result['sheets']:,} of {wide:g} x {high:g} mm, {_full(shares['sheet'])}"))
    rows += [(f"pages {name}", f"{n:,}, {_full(shares[name])}") for name, n in result["pages"].items()]
    text = result["smallest_text_mm"]
    if text is not None:
        said = f"{text:.3g} mm; {result['in_key']:,} names of partners stand in the key"
        if result["unmarked"]:
            said += f", {result['unmarked']:,} of them without a mark"
        rows.append(("smallest text", said))
    rows += [
        ("material", f"{bill['metres']:.2f} metres, {bill['grams']:.0f} g"),
        ("fasten", f"{counted(bill['fasten'], 'crossing')}, {counted(bill['joins'], 'join')}"),
        ("work", f"about {bill['hours']:.1f} hours; {bill['difficulty']}: {', '.join(bill['reasons'])}"),
        ("seconds", seconds_text(made.seconds)),
        ("written to", ", ".join(result["files"])),
    ]
    return rows


def _full(share: float) -> str:
    return f"{share:.0%} of them strips"
