"""The command that weaves: ``geoweave weave``."""

from __future__ import annotations

import click

from geoweave.terminal import (
    Surface,
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


@click.command()
@surface_options
@click.option(
    "-o", "output", metavar="DIR", required=True, help="Folder for the results; made if it is not there."
)
@click.option(
    "--symmetry", type=click.IntRange(min=3), default=6, help="Vectors of the RoSy: 6 weaves triaxially (6)."
)
@click.option(
    "--scale",
    type=click.FloatRange(min=0, min_open=True),
    default=1.0,
    help="Factor on the number of ribbons (1).",
)
@click.option(
    "--no-relax", is_flag=True, help="Stop before physics; needed for now, as relaxing is yet to come."
)
@as_json
def weave(surface: Surface, output: str, symmetry: int, scale: float, no_relax: bool, as_json: bool) -> None:
    """Design a weave: ribbons along geodesics, their crossings, over and under."""
    if not no_relax:
        raise click.UsageError("relaxing a weave by physics is yet to come; add --no-relax")
    from geoweave.prepare import evened
    from geoweave.weave import weave_pattern

    folder = new_folder(output)
    seconds: dict[str, float] = {}
    with status() as say:
        prepared = prepared_surface(surface, seconds, say)
        if surface.faces is None:
            with timed(seconds, "remesh"):
                prepared = evened(prepared, name=surface.name)
        pattern = weave_pattern(
            prepared.mesh,
            symmetry=symmetry,
            scale=scale,
            seed=surface.seed,
            callback=lambda stage: say(f"weaving: {stage}"),
        )
        seconds |= pattern.seconds
        with timed(seconds, "write"):
            folder.mkdir(exist_ok=True)
            pattern.save(folder / "weave.json")
    seconds["total"] = sum(seconds.values())
    result = {
        "mesh": surface.name,
        "faces": prepared.mesh.n_faces,
        "genus": prepared.mesh.genus,
        "boundary_loops": len(prepared.mesh.boundary_loops),
        "symmetry": symmetry,
        "scale": scale,
        "seed": surface.seed,
        "branch_points": len(pattern.branch_points),
        **pattern.metrics(),
        "seconds": {key: round(value, 4) for key, value in seconds.items()},
        "repairs": prepared.report.as_dict(),
        "output": str(folder / "weave.json"),
    }
    if as_json:
        print_json(result)
        return
    angle, turns = result["crossing_angle_deg"], result["alternation"]
    alternation = (
        f"{turns['fraction']:.1%} of neighbouring crossings; at most {turns['optimal_fraction_bound']:.1%}"
    )
    rows = [("faces", text_of(prepared.mesh.n_faces)), ("genus", text_of(prepared.mesh.genus))]
    rows += [("repairs", text) for text in prepared.report.sentences()]
    rows += [
        ("branch points", text_of(result["branch_points"])),
        (
            "ribbons",
            f"{result['ribbons']:,} in all {result['total_length']:.5g} long, {result['spacing']:.3g} apart",
        ),
        ("crossings", text_of(result["crossings"])),
        ("angle", f"{angle['median']:.1f} degrees in the median, 95 % above {angle['p05']:.1f}"),
        ("smallest angle", f"{angle['smallest']:.1f} degrees"),
        ("alternation", alternation),
        ("loose ends", text_of(result["loose_ends"])),
        ("seconds", ", ".join(f"{key} {value:.2f}" for key, value in seconds.items())),
        ("written to", result["output"]),
    ]
    print_table(surface.name, rows)
