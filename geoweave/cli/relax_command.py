"""The command that relaxes a weave made before: ``geoweave relax``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geoweave.cli.options import as_json, new_folder, print_json, print_table, status, timed

if TYPE_CHECKING:
    from geoweave.rods import Equilibrium, Rods


@click.command()
@click.argument("file", metavar="FILE", type=click.Path(exists=True, dir_okay=False))
@click.option(
    "-o", "output", metavar="DIR", required=True, help="Folder for the results; made if it is not there."
)
@as_json
def relax(file: str, output: str, as_json: bool) -> None:
    """Relax a weave.json of geoweave, or a .rod file of RibbonSim, to the shape that it takes."""
    from geoweave.pipeline import DESIGN, earlier_report, text_jobs, write_reported
    from geoweave.rods import (
        at_rest,
        file_of_rods,
        read_rods,
        read_weave,
        relax_rods,
        rod_text,
        rods_of_document,
        rods_of_file,
        vertex_normals,
    )

    folder = new_folder(output)
    seconds: dict[str, float] = {}
    document = None
    with status() as say:
        with timed(seconds, "read"):
            if Path(file).suffix.lower() == ".rod":
                start, unit = rods_of_file(read_rods(file)), 1.0
            else:
                document = read_weave(file)
                start, center, unit = rods_of_document(document, Path(file).name)
        own = _check_other_weave(folder, Path(file))
        with timed(seconds, "relax"):
            found = relax_rods(
                start,
                callback=lambda step: say(
                    f"relaxing: step {step.number}, forces balance to {step.gradient:.1g}"
                ),
            )
        result = _result(start, found, unit)
        with timed(seconds, "write"):
            if document is None:
                name, text = "relaxed.rod", rod_text(file_of_rods(found.rods))
            else:
                points, normals = found.rods.points * unit + center, vertex_normals(found.rods)
                rested = at_rest(document, found.rods, points, normals, unit)
                rested["metrics"] = rested["metrics"] | {"relax": result}
                name, text = "relaxed.json", json.dumps(rested, allow_nan=False) + "\n"
            # Beside its own weave: the design and what the report says of it stay, what was cut to another
            # shape at rest does not.
            before = earlier_report(folder) if own else {}
            before.pop("twin", None)  # of the pattern that goes
            said = before | {"file": Path(file).name, "relax": result}
            files = write_reported(text_jobs({name: text}), said, folder, kept=DESIGN if own else ())
    seconds["total"] = sum(seconds.values())
    if as_json:
        print_json(
            {
                "file": file,
                "rods": len(found.rods),
                "contacts": len(found.rods.contacts),
                **result,
                "seconds": {key: round(value, 4) for key, value in seconds.items()},
                "files": [str(path) for path in files.values()],
            }
        )
        return
    moved = result["from_start"]
    print_table(
        file,
        [
            ("rods", f"{len(found.rods):,}"),
            ("contacts", f"{len(found.rods.contacts):,}"),
            (
                "at rest",
                f"{'yes' if found.converged else 'no'}, after {result['steps']} steps: {found.ending}",
            ),
            ("elastic energy", f"{result['elastic_before']:.4g} -> {result['elastic_after']:.4g}"),
            ("moved", f"{moved['mean']:.2%} of the diagonal in the mean, at most {moved['largest']:.2%}"),
            ("seconds", ", ".join(f"{key} {value:.2f}" for key, value in seconds.items())),
            ("written to", ", ".join(str(path) for path in files.values())),
        ],
    )


def _check_other_weave(folder: Path, file: Path) -> bool:
    """Whether a folder holds the weave of a file; one that holds another weave is refused."""
    from geoweave.files import OutputError
    from geoweave.pipeline import DESIGN

    there = [folder / name for name in DESIGN if (folder / name).is_file()]
    if any(path.read_bytes() == file.read_bytes() for path in there):
        return True
    if there:
        raise OutputError(f"{folder}: holds another weave ({there[0].name}); name another folder with -o")
    return False


def _yes(holds: bool) -> str:
    return "yes" if holds else "no"


def _result(start: Rods, found: Equilibrium, unit: float) -> dict[str, Any]:
    """Say how far the rods moved, in bounding diagonals at the start, and what energy is left."""
    import numpy as np

    from geoweave.rods import fitted, vertex_weights

    moved = np.linalg.norm(fitted(found.rods, start) - start.points, axis=1)
    diagonal = float(np.linalg.norm(np.ptp(start.points, axis=0)))
    before, after = found.steps[0], found.steps[-1]
    elastic = ("stretching", "normal curvature", "geodesic curvature", "twist")
    return {
        "converged": found.converged,
        "ending": found.ending,
        "steps": len(found.steps) - 1,
        "energy_before": before.energy,
        "energy_after": after.energy,
        "elastic_before": sum(before.energies[name] for name in elastic),
        "elastic_after": sum(after.energies[name] for name in elastic),
        "energies_after": after.energies,
        "from_start": {
            "mean": float(np.average(moved, weights=vertex_weights(start))) / diagonal,
            "largest": float(moved.max()) / diagonal,
        },
        "diagonal": diagonal * unit,
    }
