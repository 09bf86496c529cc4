"""The commands ``geoweave field`` and ``geoweave foliate``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from geoweave.cli.options import (
    Positive,
    as_json,
    print_json,
    print_table,
    seconds_text,
    status,
    surface_options,
    text_of,
)

if TYPE_CHECKING:
    from geoweave.pipeline import FieldOfFile, MeshSource

output_option = click.option(
    "-o", "output", metavar="OUT.npz", help="Write the mesh and the results to this file (arrays of numpy)."
)


@click.command()
@surface_options
@output_option
@as_json
def field(source: MeshSource, output: str | None, as_json: bool) -> None:
    """Find a geodesic field: Algorithm 1 from the smoothest field, on the mesh at bounding radius 1."""
    from geoweave.pipeline import field_file

    with status() as say:
        found = field_file(source, output, callback=say)
    _report(found, as_json)


@click.command()
@surface_options
@click.option(
    "--scale",
    type=Positive(),
    help="Factor on the number of level sets (1; if not given, 2 or 4 where fewer do not follow the field).",
)
@output_option
@as_json
def foliate(source: MeshSource, scale: float | None, output: str | None, as_json: bool) -> None:
    """Find a geodesic field, and a periodic function whose level sets follow it."""
    from geoweave.pipeline import foliate_file

    with status() as say:
        found = foliate_file(source, output, scale=scale, callback=say)
    _report(found, as_json)


def _report(found: FieldOfFile, as_json: bool) -> None:
    """Print a result, as one JSON object or as a table for people."""
    result = found.document()
    if as_json:
        print_json(result)
        return
    curl, points = result["total_curl"], result["singularities"]
    rows = [
        (key.replace("_", " "), text_of(result[key]))
        for key in ("vertices", "faces", "genus", "boundary_loops")
    ]
    rows += [("repairs", text) for text in found.prepared.report.sentences()]
    rows += [
        ("total curl", curl_text(curl["before"], curl["after"])),
        ("singularities", f"{points['before']} -> {points['after']}"),
        ("index sum", f"{points['index_sum']} (Euler characteristic {points['euler_characteristic']})"),
        ("iterations", str(result["iterations"])),
        *(_foliation_rows(result) if found.foliation is not None else []),
        ("seconds", seconds_text(found.seconds)),
    ]
    rows += [("written to", found.output)] if found.output is not None else []
    print_table(result["mesh"], rows)


def curl_text(before: float, after: float) -> str:
    """The total curl of the start and of the field, and a word where it rose."""
    text = f"{before:.4f} -> {after:.4f}"
    if f"{after:.4f}" == f"{before:.4f}" or after < before:
        return text
    return f"{text}: it rose; even triangles (--faces N) give a field with less"


def _foliation_rows(result: dict[str, Any]) -> list[tuple[str, str]]:
    angle = result["deviation_deg"]
    spread = f"{angle['median']:.2f} median, {angle['mean']:.2f} mean, 95 % within {angle['p95']:.2f}"
    return [
        *([("scale", _scale_text(result))] if len(result["scales_tried"]) > 1 else []),
        ("deviation", f"{spread} degrees"),
        ("dislocations", str(result["dislocations"])),
        ("spacing", f"spread {result['spacing_spread']:.2f} in its logarithm, 0 if even"),
        ("smallest s", f"{result['s_min']:.3g} of its mean"),
    ]


def _scale_text(result: dict[str, Any]) -> str:
    """The scale, and why it is not 1."""
    others = [each for each in result["scales_tried"] if each["scale"] != result["scale"]]
    said = ", ".join(f"{each['median_deg']:.2f} at {each['scale']:g}" for each in others)
    return f"{result['scale']:g}; the level sets are farther from the field at others (median {said})"
