"""The command that weaves: ``geoweave weave``."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from typing import TYPE_CHECKING, Any, Literal

import click
from click.core import ParameterSource

from geoweave.cli.options import (
    Positive,
    as_json,
    print_json,
    print_table,
    seconds_text,
    status,
    text_of,
    up_option,
    weave_surface_options,
)
from geoweave.cli.steering_rows import aligned, mirrored, prescribed
from geoweave.wording import counted

if TYPE_CHECKING:
    from geoweave.pipeline import MeshSource, WeaveRequest, WovenFiles
    from geoweave.rods import StripKind
    from geoweave.surface import MirrorAxis
    from geoweave.weave import Inspection, Phase, Regularity, WeaveType

OPTIONS = (
    click.option(
        "--symmetry",
        type=click.IntRange(min=3),
        help="Vectors of the RoSy: 6 weaves triaxially, 4 two families (6; 4 with a --pattern of those).",
    ),
    click.option(
        "--pattern",
        type=click.Choice(["kagome", "plain", "twill", "basket"]),
        help="Over and under: in turn, of three families or two; or over two, by diagonals or blocks.",
    ),
    click.option(
        "--phase",
        type=click.Choice(["regular", "free"]),
        help="regular: triangles and hexagons, no three ribbons near a point (default with --symmetry 6); "
        "free: families lie as they happen to.",
    ),
    click.option(
        "--ribbons",
        type=click.IntRange(min=1),
        help="How many ribbons; a search finds the nearest number that the surface allows.",
    ),
    click.option(
        "--scale", type=Positive(), help="Factor on the number of ribbons (1), in place of --ribbons."
    ),
    click.option(
        "--singularities",
        metavar="FILE",
        help="Where families of ribbons branch: lines x y z index, the index in N-ths (sixths) of a turn.",
    ),
    click.option(
        "--align",
        metavar="FILE",
        help="What one family follows, softly: one line x y z for a direction, several for a curve.",
    ),
    click.option(
        "--merge",
        type=click.FloatRange(min=0),
        default=0.0,
        help="Spacings within which two branch points of opposite index are merged; 0 for none (0).",
    ),
    click.option(
        "--symmetric",
        type=click.Choice(("auto", "x", "y", "z", "off")),
        default="off",
        help="Make the field its own mirror image: in the plane of symmetry of the surface, or in one across "
        "x, y or z (off).",
    ),
    click.option(
        "--size", type=Positive(), help="Longest side of the bounding box in mm; results are then in mm."
    ),
    click.option(
        "--width", type=Positive(), help="Width of a ribbon, in mm with --size, else in the mesh's unit."
    ),
    click.option("--thickness", type=Positive(), help="Thickness of a ribbon (a twentieth of the width)."),
    click.option(
        "--formats",
        default="json",
        metavar="json,rod,svg,pdf",
        help="What to write, separated by commas: json (always), rod, pattern, csv, svg, dxf, pdf, glb, "
        "guide; those from pattern on need --size. By default json, and with --size also guide.",
    ),
    click.option(
        "--strips",
        type=click.Choice(("straight", "designed", "optimal", "holding")),
        default="straight",
        help="How strips are cut: straight, as curved as the design, or such that the weave at rest lies "
        "on its surface; holding: and that friction holds more crossings (straight).",
    ),
    up_option,
    click.option(
        "--no-relax",
        is_flag=True,
        help="Stop before the physics: nothing slides, and relaxed.json is not written.",
    ),
)
"""What a weave is to be like."""


def weave_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options of a weave and hand them over as one request, or refuse them."""

    @wraps(command)
    def bundled(
        *arguments: Any,
        symmetry: int | None,
        pattern: WeaveType | None,
        phase: Phase | None,
        ribbons: int | None,
        scale: float | None,
        singularities: str | None,
        align: str | None,
        merge: float,
        symmetric: MirrorAxis | Literal["off"],
        size: float | None,
        width: float | None,
        thickness: float | None,
        formats: str,
        strips: StripKind,
        up: str | None,
        no_relax: bool,
        **others: Any,
    ) -> None:
        if ribbons is not None and scale is not None:
            raise click.UsageError("--ribbons and --scale exclude each other; give one of them")
        from geoweave.errors import FieldError
        from geoweave.pipeline import WeaveRequest, formats_of
        from geoweave.weave import phase_of, read_guide, read_singularities, weave_type_of

        names = tuple(name.strip().lower() for name in formats.split(","))
        try:
            families = weave_type_of(symmetry, pattern)[0]
        except FieldError as error:
            raise click.UsageError(f"{error}, with --pattern and --symmetry") from error
        try:
            phase_of(families, phase)
        except FieldError as error:
            raise click.UsageError(f"{error}, with --phase and --symmetry") from error
        try:
            formats_of(names, size)
        except FieldError as error:
            raise click.UsageError(f"{error}, with --size") from error
        given = click.get_current_context().get_parameter_source("formats")
        request = WeaveRequest(
            symmetry=families,
            pattern=pattern,
            phase=phase,
            ribbons=ribbons,
            scale=scale,
            singularities=None if singularities is None else read_singularities(singularities),
            align=None if align is None else read_guide(align),
            merge=merge,
            symmetric=symmetric,
            size=size,
            width=width,
            thickness=thickness,
            formats=None if given is ParameterSource.DEFAULT else names,
            relax=not no_relax,
            strips=strips,
            up=up,
        )
        command(*arguments, request=request, **others)

    for option in reversed(OPTIONS):
        bundled = option(bundled)
    return bundled


@click.command()
@weave_surface_options
@click.option(
    "-o", "output", metavar="DIR", required=True, help="Folder for the results; made if it is not there."
)
@weave_options
@click.option(
    "--edits",
    metavar="FILE",
    help="Changes that the page of 'geoweave show' saved of the weave with these options.",
)
@click.option("--strict", is_flag=True, help="Exit with status 1 if the verdict is not to cut the strips.")
@as_json
def weave(
    source: MeshSource, output: str, request: WeaveRequest, edits: str | None, strict: bool, as_json: bool
) -> None:
    """Design a weave: ribbons along geodesics, their crossings, over and under.

    With a format of strips the last line is the verdict on them: "make it", "make it, but" why it is hard, or
    "do not cut this".
    """
    from geoweave.pipeline import DO_NOT, weave_file

    if edits is not None:
        from geoweave.weave import read_edits

        request = replace(request, edits=(read_edits(edits),))
    with status() as say:
        made = weave_file(source, output, request, callback=say)
    if as_json:
        print_json(made.document())
    else:
        print_table(source.name, _rows(made))
        if made.verdict is not None:
            click.echo(made.verdict.sentence)
    if strict and made.verdict is not None and made.verdict.word == DO_NOT:
        sys.stdout.flush()
        raise click.exceptions.Exit(1)


def _rows(made: WovenFiles) -> list[tuple[str, str]]:
    """What the table for people says."""
    result, report = made.document(), made.inspection
    unit = " mm" if made.weave.units == "mm" else ""
    angle = result["crossing_angle_deg"]
    rows = [("faces", text_of(result["faces"])), ("genus", text_of(result["genus"]))]
    rows += [("repairs", text) for text in made.prepared.report.sentences()]
    rows += [
        ("branch points", text_of(result["branch_points"])),
        *prescribed(result.get("prescribed_singularities"), result["symmetry"]),
        *aligned(result.get("aligned_deg")),
        *mirrored(result.get("mirror")),
        *_sizes(result, report, unit),
        ("crossings", text_of(result["crossings"])),
        ("angle", f"{angle['median']:.1f} degrees in the median, 95 % above {angle['p05']:.1f}"),
        ("smallest angle", f"{angle['smallest']:.1f} degrees"),
        _alternation(result["pattern"]),
        *_regularity(report.regularity, result["symmetry"]),
        ("loose ends", text_of(result["loose_ends"])),
    ]
    rows += _rest(result["relax"], unit)
    if result["slipped"]:
        near = f"near {counted(result['slipped'], 'crossing')} ribbons slid past each other"
        rows.append(
            ("  strips", f"as designed, not as at rest: {near}, and the strips would not go together")
        )
    rows += _strips(result["strips"], unit)
    rows += [("broken rule", text) for text in report.violations]
    rows += [("hard places", "none") if not report.places else ("hard places", "")]
    rows += [(f"  {kind.replace('_', ' ')}", _worst(kind, report)) for kind, n in report.counts.items() if n]
    rows += [
        *((f"no {name}", reason) for name, reason in result["left_out"].items()),
        ("seconds", seconds_text(made.seconds)),
        ("written to", ", ".join(result["files"])),
    ]
    return rows


def _regularity(found: Regularity, symmetry: int) -> list[tuple[str, str]]:
    """How near the weave is to a regular one, in which no three ribbons meet near one point."""
    said = f"{found.piled:.1%} of the crossings have another within 0.3 spacings"
    if found.phase_order is not None:
        said += f"; order of the phase {found.phase_order:.2f}"
    cells = f"{found.triangles:.0%} triangles, {found.hexagons:.0%} hexagons"
    if symmetry == 6:
        cells += f"; {found.interleaved:.1%} of the triangles interleave"
    rows = [
        ("piled", said),
        ("cells", cells),
        ("bare", f"{found.bare:.2%} of the area is farther than a spacing from every ribbon"),
        ("evenness", f"spacing varies by {math.expm1(found.spacing_spread):.0%} (one standard deviation)"),
    ]
    if found.few_crossings:
        rows.append(
            ("short", f"{counted(found.few_crossings, 'ribbon', 'has have')} fewer than four crossings")
        )
    if found.parts > 1:
        rows.append(("parts", f"the ribbons make {found.parts} parts that do not hang together"))
    return rows


def _strips(strips: dict[str, Any] | None, unit: str) -> list[tuple[str, str]]:
    """What is measured on the strips as they are cut, beside the design where that differs."""
    if strips is None:
        return []
    differs, ends = strips["differs"], strips["free_ends"]
    rows = []
    for name, what, form in (
        ("alternation", "alternation", "{:.1%}"),
        ("crossing_angle_deg.smallest", "smallest angle", "{:.1f} degrees"),
        ("share_that_fits", "neighbours that fit", "{:.0%}"),
    ):
        if name in differs:
            on, designed = form.format(differs[name]["strips"]), form.format(differs[name]["design"])
            rows.append((f"  {what}", f"{on} on the strips as they are cut, {designed} in the design"))
    said = f"{ends['count']:,} of open strips, {ends['longest']:.3g}{unit} at most beyond the last crossing"
    if ends["trimmed"]:
        said += f"; {ends['trimmed']:,} hung and were trimmed by {ends['trimmed_length']:.4g}{unit} in all"
    if ends["count"]:
        rows.append(("  ends", said))
    return rows


def _sizes(result: dict[str, Any], report: Inspection, unit: str) -> list[tuple[str, str]]:
    """How many ribbons there are, how long and how wide, and how many crossings that width fits."""
    asked, count = result["ribbons_asked"], text_of(result["ribbons"])
    if asked is not None:
        tries = f"in {result['scales_tried']} tries"
        found = "as asked" if asked == result["ribbons"] else f"the nearest to {asked:,}"
        count = f"{count}, {found} {tries}: --scale {result['scale']:g}"
    length = f"{result['total_length']:.5g} in the mesh's unit"
    if unit:
        length = f"{result['metres']:.2f} metres"
    size = f"{result['width']:.3g} wide, {result['thickness']:.2g} thick, {result['spacing']:.3g} apart"
    shares = f"{report.share_that_fits:.0%} of the neighbouring crossings fit"
    if report.suggested_width is not None:
        shares += f", {report.limits.fitting:.0%} up to a width of {report.suggested_width:.3g}{unit}"
    return [
        ("ribbons", count),
        ("length", length),
        ("size", f"{size}{' (mm)' if unit else ''}"),
        ("width", shares),
    ]


def _alternation(pattern: dict[str, Any]) -> tuple[str, str]:
    """How often ribbons do as the pattern asks, and whether more often is possible."""
    share, most = f"{pattern['fraction']:.1%}", f"at most {pattern['optimal_fraction_bound']:.1%}"
    if pattern["name"] in ("twill", "basket"):
        doubt = "" if pattern["proven"] else ", which need not be in reach"
        return pattern["name"], f"{share} of {pattern['relations']:,} rules are met; {most}{doubt}"
    doubt = "" if pattern["proven"] else " (not proven to be out of reach: the effort was used up)"
    return "alternation", f"{share} of neighbours; {most}{doubt}"


def _rest(relax: dict[str, Any] | None, unit: str) -> list[tuple[str, str]]:
    """Whether the whole weave, free ends included, holds its shape; and where a crossing departs most."""
    if relax is None:
        return []
    from geoweave.pipeline import HOLDS

    worst, far = relax["worst"], relax["hausdorff"]
    verdict = "it holds its shape" if far < HOLDS else "it departs from its shape"
    if not relax["converged"]:
        verdict = f"not at rest ({relax['ending']})"
    where = ", ".join(f"{x:.4g}" for x in worst["point"])
    rows = [
        ("at rest", f"{verdict}: {relax['mean']:.1%} of the diagonal from the surface, at most {far:.1%}"),
        ("  farthest", f"{worst['distance']:.3g}{unit} at ({where}), {worst['ribbon']}"),
    ]
    rows += _holding(relax["forces"])
    bent = relax.get("curved_strips")
    if bent is not None:
        said = f"{bent['kind']}, curvature x width at most {bent['sharpest']:.2g}"
        if "history" in bent:
            first, last = bent["history"][0]["mean"], relax["mean"]
            end = "converged" if bent["converged"] else f"not converged: {bent['ending']}"
            said += f"; {first:.2%} -> {last:.2%} of the diagonal in {len(bent['history'])} trials ({end})"
        rows.append(("  curved strips", said))
    return rows


def _holding(forces: dict[str, Any]) -> list[tuple[str, str]]:
    """How many crossings need glue or a rivet, and what friction would hold a half and nine tenths."""
    if not forces["contacts"]:
        return []
    need, all_of_them = forces["fasten"], forces["contacts"]
    said = f"friction of {forces['friction']:g} holds {all_of_them - need:,} of {all_of_them:,} crossings"
    if need:
        said += f"; glue or rivet {need:,}, the most important first in report.json"
    shares = [
        f"{share} % of them would hold with {forces['needed'][f'p{share}']:.2g}"
        for share in (50, 90)
        if forces["needed"][f"p{share}"] is not None
    ]
    if forces["pulled_apart"]:
        shares.append(f"{forces['pulled_apart']:,} are pulled apart")
    return [("  crossings", said), *([("  friction", "; ".join(shares))] if shares else [])]


def _worst(kind: str, report: Inspection) -> str:
    """How many places there are of a kind, and where the worst of them is."""
    worst = next(place for place in report.places if place.kind == kind)
    what, where_or_how = {
        "near_parallel": ("crossing", f" below {report.limits.angle:g} degrees"),
        "alongside": ("stretch", " where ribbons lie on each other side by side"),
        "lap": ("pair", " of ends that lie on each other, one going on where the other stops"),
        "crowded": ("place", " where crossings overlap"),
        "knot": ("knot", f" of ribbons shorter than {report.limits.short:g} spacings"),
        "gap": ("hole", f" with more than {report.limits.gap:g} spacings to any ribbon"),
        "loose_end": ("loose end", ""),
        "bare_component": ("piece", " of the surface without a ribbon"),
    }[kind]
    where = ", ".join(f"{x:.4g}" for x in worst.point)
    names = f", {' '.join(worst.ribbons)}" if worst.ribbons else ""
    said = f"{counted(report.counts[kind], what)}{where_or_how}"
    return f"{said}; the worst, {worst.value:.3g}, at ({where}){names}"
