"""The commands that design: ``geoweave field`` and ``geoweave foliate``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from geoweave.cli.options import (
    Positive,
    Say,
    Surface,
    about,
    as_json,
    check_output,
    prepared_surface,
    print_json,
    print_table,
    status,
    surface_options,
    text_of,
    timed,
)

if TYPE_CHECKING:
    from geoweave.fields import FaceField, GeodesicSolve, Step
    from geoweave.foliation import Foliation
    from geoweave.meshing import Prepared
    from geoweave.surface import TriMesh

output_option = click.option(
    "-o", "output", metavar="OUT.npz", help="Write mesh and results (numpy, never pickled)."
)


@click.command()
@surface_options
@output_option
@as_json
def field(surface: Surface, output: str | None, as_json: bool) -> None:
    """Find a geodesic field by Algorithm 1 from the smoothest field, at bounding radius 1."""
    if output is not None:
        check_output(output, surface.name)
    seconds: dict[str, float] = {}
    with status() as say, about(surface.name):
        prepared, solve = _designed(surface, None, seconds, say)
        if output is not None:
            say(f"writing {output}")
            with timed(seconds, "write"):
                _write(output, _field_arrays(solve))
    result = _field_result(surface, prepared, solve)
    _report(result, seconds, prepared, output, as_json, [])


@click.command()
@surface_options
@click.option(
    "--scale",
    type=Positive(),
    default=1.0,
    help="Factor on the number of level sets (1).",
)
@output_option
@as_json
def foliate(surface: Surface, scale: float, output: str | None, as_json: bool) -> None:
    """Find a geodesic field, and a periodic function whose level sets follow it."""
    if output is not None:
        check_output(output, surface.name)
    from geoweave.fields import INTEGRABLE_END
    from geoweave.foliation import foliate as integrated

    seconds: dict[str, float] = {}
    with status() as say, about(surface.name):
        prepared, solve = _designed(surface, INTEGRABLE_END, seconds, say)
        say("finding the integrating factor")
        with timed(seconds, "foliate"):
            foliation = integrated(
                solve.field,
                scale=scale,
                seed=surface.seed,
                callback=lambda number, energy: say(
                    f"s and theta: alternation {number}, energy {energy:.6g}"
                ),
            )
        if output is not None:
            say(f"writing {output}")
            with timed(seconds, "write"):
                _write(output, {**_field_arrays(solve), **_foliation_arrays(foliation)})
    result = _field_result(surface, prepared, solve)
    measured = foliation.alignment
    result |= {
        "scale": scale,
        "deviation_deg": {"mean": measured.mean, "median": measured.median, "p95": measured.p95},
        "spacing_spread": measured.spacing_spread,
        "dislocations": measured.dislocations,
        "punctured_faces": int((~foliation.part.kept).sum()),
        "s_min": foliation.s_min,
        "energy": {"before": foliation.energies[0], "after": foliation.energies[-1]},
    }
    angle = result["deviation_deg"]
    spread = f"{angle['median']:.2f} median, {angle['mean']:.2f} mean, 95 % within {angle['p95']:.2f}"
    rows = [
        ("deviation", f"{spread} degrees"),
        ("dislocations", str(measured.dislocations)),
        ("spacing", f"spread {measured.spacing_spread:.2f} in its logarithm, 0 if even"),
        ("smallest s", f"{foliation.s_min:.3g} of its mean"),
    ]
    _report(result, seconds, prepared, output, as_json, rows)


def _designed(
    surface: Surface, finest: float | None, seconds: dict[str, float], say: Say
) -> tuple[Prepared, GeodesicSolve]:
    """Read a surface and run Algorithm 1 on it, sharpened to ``finest`` squared edges if given."""
    from geoweave.fields import geodesic_field, sharpening_schedule, smoothest_field

    prepared = prepared_surface(surface, seconds, say)
    mesh, _ = prepared.mesh.normalized()
    say("finding the smoothest field")
    with timed(seconds, "smoothest"):
        smoothest = smoothest_field(mesh, seed=surface.seed)
    done: list[Step] = []

    def follow(step: Step, _: FaceField) -> None:
        done.append(step)
        say(f"Algorithm 1: step {len(done)}, smoothness {step.smoothness:.2g}, energy {step.energy:.6g}")

    schedule = None if finest is None else sharpening_schedule(mesh, finest=finest)
    with timed(seconds, "geodesic"):
        # of the circle of smoothest fields, the one that Algorithm 1 does best from
        solve = geodesic_field(smoothest, smoothness=schedule, phases=4, callback=follow)
    return prepared, solve


def _field_result(surface: Surface, prepared: Prepared, solve: GeodesicSolve) -> dict[str, Any]:
    from geoweave.fields import total_curl

    mesh = solve.field.mesh
    return {
        "mesh": surface.name,
        "vertices": mesh.n_vertices,
        "faces": mesh.n_faces,
        "components": mesh.n_components,
        "genus": mesh.genus,
        "boundary_loops": len(mesh.boundary_loops),
        "total_curl": {"before": total_curl(solve.initial), "after": total_curl(solve.field)},
        "singularities": _singularities(mesh, solve.initial, solve.field),
        "iterations": len(solve.steps),
        "converged": solve.converged,
        "seed": surface.seed,
        "repairs": prepared.report.as_dict(),
    }


def _report(
    result: dict[str, Any],
    seconds: dict[str, float],
    prepared: Prepared,
    output: str | None,
    as_json: bool,
    rows_of_its_own: list[tuple[str, str]],
) -> None:
    """Print a result, as one JSON object or as a table for people."""
    seconds["total"] = sum(seconds.values())
    result["seconds"] = {key: round(value, 4) for key, value in seconds.items()}
    if output is not None:
        result["output"] = output
    if as_json:
        print_json(result)
        return
    curl, points = result["total_curl"], result["singularities"]
    rows = [
        (key.replace("_", " "), text_of(result[key]))
        for key in ("vertices", "faces", "genus", "boundary_loops")
    ]
    rows += [("repairs", text) for text in prepared.report.sentences()]
    rows += [
        ("total curl", f"{curl['before']:.4f} -> {curl['after']:.4f}"),
        ("singularities", f"{points['before']} -> {points['after']}"),
        ("index sum", f"{points['index_sum']} (Euler characteristic {points['euler_characteristic']})"),
        ("iterations", str(result["iterations"])),
        *rows_of_its_own,
        ("seconds", ", ".join(f"{key} {value:.2f}" for key, value in seconds.items())),
    ]
    rows += [("written to", output)] if output is not None else []
    print_table(result["mesh"], rows)


def _singularities(mesh: TriMesh, initial: FaceField, final: FaceField) -> dict[str, int]:
    from geoweave.fields import index_sum, vertex_indices

    return {
        "before": int((vertex_indices(initial) != 0).sum()),
        "after": int((vertex_indices(final) != 0).sum()),
        "index_sum": int(index_sum(final)),
        "euler_characteristic": mesh.euler_characteristic,
    }


def _field_arrays(solve: GeodesicSolve) -> dict[str, Any]:
    mesh = solve.field.mesh
    return {
        "vertices": mesh.vertices,
        "faces": mesh.faces,
        "field_initial": solve.initial.ambient,
        "field": solve.field.ambient,
        "delta": solve.delta.ambient,
    }


def _foliation_arrays(foliation: Foliation) -> dict[str, Any]:
    """Per face of the whole surface; what was punctured has no theta and no s, and holds nan."""
    import numpy as np

    part = foliation.part
    jump, s = np.full((part.whole.n_faces, 3), np.nan), np.full(part.whole.n_faces, np.nan)
    jump[part.faces] = foliation.circle.corner_jumps
    s[part.faces] = foliation.s
    return {"theta_jump": jump, "s": s, "kept": part.kept}


def _write(output: str, arrays: Mapping[str, Any]) -> None:
    import numpy as np

    from geoweave.files import replacing

    # through an open file, because numpy would add another ending to a name it does not know
    with replacing(output) as temporary, open(temporary, "wb") as file:
        np.savez(file, **arrays)
