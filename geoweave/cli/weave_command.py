"""The command that weaves: ``geoweave weave``."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click
from click.core import ParameterSource

from geoweave.cli.options import (
    Positive,
    Say,
    Surface,
    about,
    as_json,
    new_folder,
    prepared_surface,
    print_json,
    print_table,
    status,
    surface_options,
    text_of,
    timed,
)
from geoweave.errors import FieldError

if TYPE_CHECKING:
    from geoweave.files import Job
    from geoweave.meshing import Prepared
    from geoweave.rods import Step
    from geoweave.weave import Inspection, Weave


@dataclass(frozen=True)
class Asked:
    """What a weave is to be like and what is to be written, as it was asked for."""

    symmetry: int
    ribbons: int | None
    scale: float | None
    size: float | None
    width: float | None
    thickness: float | None
    formats: tuple[str, ...]
    relax: bool
    spare: tuple[str, ...] = ()
    """Formats that nobody named, which a weave that they do not suit is written without."""


class Made(NamedTuple):
    """A weave that was designed, relaxed and written."""

    result: dict[str, Any]
    """What ``--json`` prints."""
    prepared: Prepared
    pattern: Weave
    report: Inspection


def weave_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options of a weave and hand them over as one, or refuse them."""

    @wraps(command)
    def bundled(
        *arguments: Any,
        symmetry: int,
        ribbons: int | None,
        scale: float | None,
        size: float | None,
        width: float | None,
        thickness: float | None,
        formats: str,
        no_relax: bool,
        **others: Any,
    ) -> None:
        if ribbons is not None and scale is not None:
            raise click.UsageError("--ribbons and --scale exclude each other; give one of them")
        names = tuple(name.strip().lower() for name in formats.split(","))
        cut, _ = formats_of(names)
        if cut and size is None:
            raise click.UsageError(f"a pattern ({', '.join(cut)}) is in mm; give the object a --size")
        asked = Asked(symmetry, ribbons, scale, size, width, thickness, names, not no_relax)
        given = click.get_current_context().get_parameter_source("formats")
        if size is not None and given is ParameterSource.DEFAULT:
            asked = replace(asked, formats=("json", "guide"), spare=("guide",))
        command(*arguments, asked=asked, **others)

    options = (
        click.option(
            "--symmetry",
            type=click.IntRange(min=3),
            default=6,
            help="Vectors of the RoSy: 6 weaves triaxially (6).",
        ),
        click.option(
            "--ribbons",
            type=click.IntRange(min=1),
            help="How many ribbons; the nearest number that a search meets.",
        ),
        click.option(
            "--scale", type=Positive(), help="Factor on the number of ribbons (1), in place of --ribbons."
        ),
        click.option(
            "--size", type=Positive(), help="Longest side of the bounding box in mm; results are then in mm."
        ),
        click.option(
            "--width", type=Positive(), help="Width of a ribbon, in mm with --size, else in the mesh's unit."
        ),
        click.option(
            "--thickness", type=Positive(), help="Thickness of a ribbon (a twentieth of the width)."
        ),
        click.option(
            "--formats",
            default="json",
            metavar="json,rod,svg,pdf",
            help="What to write, apart by commas: json (always), rod, pattern, csv, svg, dxf, pdf, glb, "
            "guide; those from pattern on need --size. By default json, and with --size guide.",
        ),
        click.option(
            "--no-relax",
            is_flag=True,
            help="Stop before physics: nothing slides, and relaxed.json is not written.",
        ),
    )
    for option in reversed(options):
        bundled = option(bundled)
    return bundled


def formats_of(names: Iterable[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Part formats into those of a pattern and those of a weave; an unknown one is refused."""
    from geoweave import fabrication
    from geoweave.pipeline import check_formats

    asked = tuple(names)
    cut = fabrication.check_formats(name for name in asked if name in fabrication.FORMATS)
    return cut, check_formats((name for name in asked if name not in cut), fabrication.FORMATS)


def woven(surface: Surface, asked: Asked, folder: Path, say: Say) -> Made:
    """Read a surface, weave it, relax the weave, and write what was asked for into a folder."""
    from geoweave import fabrication
    from geoweave.fabrication import pattern_of
    from geoweave.meshing import evened
    from geoweave.pipeline import write_weave
    from geoweave.rods import relaxed_weave
    from geoweave.twin import contradictions_of, surface_of
    from geoweave.weave import inspected, weave_pattern

    cut, wanted = formats_of(asked.formats)
    seconds: dict[str, float] = {}
    with about(surface.name):
        prepared = prepared_surface(surface, seconds, say)
        if surface.faces is None:
            with timed(seconds, "remesh"):
                prepared = evened(prepared, name=surface.name)
        pattern = weave_pattern(
            prepared.mesh,
            symmetry=asked.symmetry,
            scale=asked.scale,
            ribbons=asked.ribbons,
            seed=surface.seed,
            callback=lambda stage: say(f"weaving: {stage}"),
        )
        seconds |= pattern.seconds
        pattern = pattern.sized(asked.size, asked.width, asked.thickness)
        with timed(seconds, "inspection"):
            report = inspected(pattern)
        rest = None
        if asked.relax:
            rest = relaxed_weave(pattern, callback=lambda stage, step: say(_progress(stage, step)))
            seconds |= rest.seconds
        with timed(seconds, "write"):
            # A pattern is cut to the lengths at rest, as long as its crossings still follow each other as the
            # surface has them; it is laid out before anything is written.
            lies = rest.document() if cut and rest is not None else None
            strips = pattern_of(lies or pattern) if cut else None
            slipped = 0
            if strips is not None and lies is not None:
                slipped = sum(each.plain for each in contradictions_of(surface_of(strips)))
                if slipped:  # nobody could put these strips together
                    strips, lies = pattern_of(pattern), None
            without: dict[str, str] = {}
            more: dict[str, Job] = {}
            if strips is not None:
                bench = fabrication.Bench(title=Path(surface.name).stem)
                try:
                    more = fabrication.jobs_of(strips, cut, bench=bench, weave=pattern, rest=lies)
                except FieldError as error:
                    if set(cut) - set(asked.spare):
                        raise
                    without = {name: str(error) for name in cut}
            files = write_weave(pattern, folder, wanted, report, rest, more)
    seconds["total"] = sum(seconds.values())
    result = {
        "mesh": surface.name,
        "faces": prepared.mesh.n_faces,
        "genus": prepared.mesh.genus,
        "boundary_loops": len(prepared.mesh.boundary_loops),
        "symmetry": asked.symmetry,
        "scale": pattern.scale,
        "ribbons_asked": asked.ribbons,
        "scales_tried": len(pattern.tried) or 1,
        "seed": surface.seed,
        "branch_points": len(pattern.branch_points),
        "units": pattern.units,
        **pattern.metrics(),
        "width": pattern.width * pattern.placement.scale,
        "thickness": pattern.thickness * pattern.placement.scale,
        "suggested_width": report.suggested_width,
        "places": report.counts,
        "relax": None if rest is None else rest.metrics(),
        "strips_of": None if strips is None else "weave.json" if lies is None else "relaxed.json",
        "slipped": slipped,
        "violations": len(report.violations),
        "seconds": {key: round(value, 4) for key, value in seconds.items()},
        "repairs": prepared.report.as_dict(),
        "output": str(files["weave.json"]),
        "files": [str(path) for path in files.values()],
        "left_out": without,
    }
    return Made(result, prepared, pattern, report)


@click.command()
@surface_options
@click.option(
    "-o", "output", metavar="DIR", required=True, help="Folder for the results; made if it is not there."
)
@weave_options
@as_json
def weave(surface: Surface, output: str, asked: Asked, as_json: bool) -> None:
    """Design a weave: ribbons along geodesics, their crossings, over and under."""
    folder = new_folder(output)
    with status() as say:
        made = woven(surface, asked, folder, say)
    if as_json:
        print_json(made.result)
        return
    print_table(surface.name, _rows(made.result, made.prepared, made.pattern, made.report))


def _rows(
    result: dict[str, Any], prepared: Prepared, pattern: Weave, report: Inspection
) -> list[tuple[str, str]]:
    """What the table for people says."""
    angle, turns = result["crossing_angle_deg"], result["alternation"]
    mm = pattern.units == "mm"
    unit = " mm" if mm else ""
    asked = result["ribbons_asked"]
    count = text_of(result["ribbons"])
    if asked is not None:
        tries = f"in {result['scales_tried']} tries"
        found = "as asked" if asked == result["ribbons"] else f"the nearest to {asked:,}"
        count = f"{count}, {found} {tries}: --scale {result['scale']:g}"
    length = f"{result['metres']:.2f} metres" if mm else f"{result['total_length']:.5g} in the mesh's unit"
    size = f"{result['width']:.3g} wide, {result['thickness']:.2g} thick, {result['spacing']:.3g} apart"
    shares = f"{report.share_that_fits:.0%} of the neighbouring crossings fit"
    if report.suggested_width is not None:
        shares += f", {report.limits.fitting:.0%} up to a width of {report.suggested_width:.3g}{unit}"
    rows = [("faces", text_of(prepared.mesh.n_faces)), ("genus", text_of(prepared.mesh.genus))]
    rows += [("repairs", text) for text in prepared.report.sentences()]
    rows += [
        ("branch points", text_of(result["branch_points"])),
        ("ribbons", count),
        ("length", length),
        ("size", f"{size}{' (mm)' if mm else ''}"),
        ("width", shares),
        ("crossings", text_of(result["crossings"])),
        ("angle", f"{angle['median']:.1f} degrees in the median, 95 % above {angle['p05']:.1f}"),
        ("smallest angle", f"{angle['smallest']:.1f} degrees"),
        ("alternation", _alternation(turns)),
        ("loose ends", text_of(result["loose_ends"])),
    ]
    rows += _rest(result["relax"], unit)
    if result["slipped"]:
        near = f"near {_places(result['slipped'])} ribbons slid past each other"
        rows.append(
            ("  strips", f"as designed, not as at rest: {near}, and the strips would not go together")
        )
    rows += [("broken rule", text) for text in report.violations]
    rows += [("hard places", "none") if not report.places else ("hard places", "")]
    rows += [(f"  {kind.replace('_', ' ')}", _worst(kind, report)) for kind, n in report.counts.items() if n]
    rows += [
        *((f"no {name}", reason) for name, reason in result["left_out"].items()),
        ("seconds", ", ".join(f"{key} {value:.2f}" for key, value in result["seconds"].items())),
        ("written to", ", ".join(result["files"])),
    ]
    return rows


def _places(number: int) -> str:
    return "one crossing" if number == 1 else f"{number} crossings"


def _alternation(turns: dict[str, Any]) -> str:
    """How often ribbons change sides, and whether more often is possible."""
    said = f"{turns['fraction']:.1%} of neighbours; at most {turns['optimal_fraction_bound']:.1%}"
    if turns["proven"]:
        return said
    ended = "time ran out, another run may find more" if turns["out_of_time"] else "the effort was used up"
    return f"{said} (not proven to be out of reach: {ended})"


def _progress(stage: str, step: Step) -> str:
    doing = {"slide": "sliding", "relax": "relaxing"}[stage]
    return f"{doing}: step {step.number}, forces balance to {step.gradient:.1g}"


HOLDS = 0.05
"""A weave that rests nearer to its surface than this share of the bounding diagonal holds its shape."""


def _rest(relax: dict[str, Any] | None, unit: str) -> list[tuple[str, str]]:
    """Whether the weave will hold its shape, and where it departs most."""
    if relax is None:
        return []
    worst, far = relax["worst"], relax["hausdorff_held"]
    verdict = "it holds its shape" if far < HOLDS else "it departs from its shape"
    if not relax["converged"]:
        verdict = f"not at rest ({relax['ending']})"
    where = ", ".join(f"{x:.4g}" for x in worst["point"])
    return [
        ("at rest", f"{verdict}: {relax['mean']:.1%} of the diagonal from the surface, at most {far:.1%}"),
        ("  farthest", f"{worst['distance']:.3g}{unit} at ({where}), {worst['ribbon']}"),
    ]


def _worst(kind: str, report: Inspection) -> str:
    """How many places there are of a kind, and where the worst of them is."""
    worst = next(place for place in report.places if place.kind == kind)
    what = {
        "near_parallel": f"crossings below {report.limits.angle:g} degrees",
        "alongside": "stretches where ribbons lie on each other side by side",
        "lap": "pairs of ends that lie on each other, one going on where the other stops",
        "crowded": "places where crossings overlap",
        "knot": f"knots of ribbons shorter than {report.limits.short:g} spacings",
        "gap": f"holes with more than {report.limits.gap:g} spacings to any ribbon",
        "loose_end": "loose ends",
        "bare_component": "pieces of the surface without a ribbon",
    }[kind]
    where = ", ".join(f"{x:.4g}" for x in worst.point)
    names = f", {' '.join(worst.ribbons)}" if worst.ribbons else ""
    return f"{report.counts[kind]:,} {what}; the worst, {worst.value:.3g}, at ({where}){names}"
