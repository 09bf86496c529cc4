"""From a ``weave.json`` or a ``.rod`` file to the shape that it takes: the physics alone."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geoweave.errors import RodError
from geoweave.files import OutputError, checked_folder
from geoweave.pipeline.source import Say, silent, timed
from geoweave.pipeline.weave_folder import DESIGN, earlier_report, text_jobs, write_reported

if TYPE_CHECKING:
    from geoweave.rods import Equilibrium, Rods, Step

__all__ = ["RestOfFile", "relax_file"]

ELASTIC = ("stretching", "normal curvature", "geodesic curvature", "twist")
"""The energies of the rods themselves; the others are those of their contacts."""


@dataclass(frozen=True, eq=False)
class RestOfFile:
    """The rods of a file at rest."""

    path: Path
    start: Rods
    """As read."""
    rest: Equilibrium
    unit: float
    """Length of one unit of the rods, in the unit of the file."""
    seconds: dict[str, float]
    files: dict[str, Path]
    repairs: tuple[str, ...] = ()
    """What was put right as the file was read, a sentence each."""

    def document(self) -> dict[str, Any]:
        """All numbers, as ``geoweave relax --json`` prints them."""
        return {
            "file": str(self.path),
            "rods": len(self.start),
            "contacts": len(self.start.contacts),
            **({"repairs": list(self.repairs)} if self.repairs else {}),
            **rest_numbers(self.start, self.rest, self.unit),
            "seconds": {key: round(value, 4) for key, value in self.seconds.items()},
            "files": [str(path) for path in self.files.values()],
        }


def relax_file(
    file: str | os.PathLike[str], folder: str | os.PathLike[str], *, callback: Say | None = None
) -> RestOfFile:
    """Relax a ``weave.json`` of geoweave, or a ``.rod`` file of RibbonSim, to the shape that it takes.

    Parameters
    ----------
    file : the weave or the rods
    folder : for ``relaxed.json`` or ``relaxed.rod`` and ``report.json``; it is made if it is not there. If it
        holds the design of this weave, that stays, and what was cut to another shape is removed
    callback : called with one line of progress at a time

    Raises
    ------
    FieldError, RodError, WeaveFileError
        If the file cannot be read.
    OutputError
        If the folder holds another weave, or cannot be written to.
    """
    from geoweave.rods import read_rods, read_weave, relax_rods, rods_of_document, rods_of_file

    path, target, say = Path(file), checked_folder(folder), callback or silent
    seconds: dict[str, float] = {}
    weave, center = None, None
    repairs: tuple[str, ...] = ()
    with timed(seconds, "read"):
        if path.suffix.lower() == ".rod":
            content = read_rods(path)
            repairs = content.repairs
            try:
                start, unit = rods_of_file(content), 1.0
            except RodError as error:
                raise RodError(f"{path}: {error}") from error
        else:
            weave = read_weave(path)
            start, center, unit = rods_of_document(weave, path.name)
    own = _holds_the_weave(target, path)
    with timed(seconds, "relax"):
        rest = relax_rods(start, callback=_telling(say))
    said = rest_numbers(start, rest, unit) | ({"repairs": list(repairs)} if repairs else {})
    with timed(seconds, "write"):
        name, text = _relaxed_text(weave, rest, center, unit, said)
        before = earlier_report(target) if own else {}
        before.pop("twin", None)  # of the pattern, which is removed
        report = before | {"file": path.name, "relax": said}
        files = write_reported(text_jobs({name: text}), report, target, kept=DESIGN if own else ())
    seconds["total"] = sum(seconds.values())
    return RestOfFile(path, start, rest, unit, seconds, files, repairs)


def rest_numbers(start: Rods, rest: Equilibrium, unit: float) -> dict[str, Any]:
    """How far rods moved, in bounding diagonals at the start, and what energy is left."""
    import numpy as np

    from geoweave.rods import contact_forces, fitted, vertex_weights

    moved = np.linalg.norm(fitted(rest.rods, start) - start.points, axis=1)
    diagonal = float(np.linalg.norm(np.ptp(start.points, axis=0)))
    before, after = rest.steps[0], rest.steps[-1]
    return {
        "converged": rest.converged,
        "ending": rest.ending,
        "steps": len(rest.steps) - 1,
        "energy_before": before.energy,
        "energy_after": after.energy,
        "elastic_before": sum(before.energies[name] for name in ELASTIC),
        "elastic_after": sum(after.energies[name] for name in ELASTIC),
        "energies_after": after.energies,
        "forces": contact_forces(rest.rods).document(),
        "from_start": {
            "mean": float(np.average(moved, weights=vertex_weights(start))) / diagonal,
            "largest": float(moved.max()) / diagonal,
        },
        "diagonal": diagonal * unit,
    }


def _telling(say: Say) -> Callable[[Step], None]:
    return lambda step: say(f"relaxing: step {step.number}, forces balance to {step.gradient:.1g}")


def _relaxed_text(
    weave: dict[str, Any] | None, rest: Equilibrium, center: Any, unit: float, said: dict[str, Any]
) -> tuple[str, str]:
    """Name and contents of the file that the rods at rest are written to."""
    from geoweave.rods import at_rest, contact_forces, file_of_rods, rod_text, vertex_normals

    if weave is None:
        return "relaxed.rod", rod_text(file_of_rods(rest.rods))
    points, normals = rest.rods.points * unit + center, vertex_normals(rest.rods)
    document = at_rest(weave, rest.rods, points, normals, unit, contact_forces(rest.rods))
    document["metrics"] = document["metrics"] | {"relax": said}
    return "relaxed.json", json.dumps(document, allow_nan=False) + "\n"


def _holds_the_weave(folder: Path, file: Path) -> bool:
    """Whether a folder holds the weave of a file; one that holds another weave is refused."""
    there = [folder / name for name in DESIGN if (folder / name).is_file()]
    if any(path.read_bytes() == file.read_bytes() for path in there):
        return True
    if there:
        raise OutputError(f"{folder}: holds another weave ({there[0].name}); name another folder with -o")
    return False
