"""From a mesh file to a geodesic field, or a foliation, and its arrays in a file."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from geoweave.files import check_output, replacing
from geoweave.pipeline.source import MeshSource, Say, about, prepared_surface, silent, source_of, timed

if TYPE_CHECKING:
    from geoweave.fields import FaceField, GeodesicSolve, Step
    from geoweave.foliation import Foliation
    from geoweave.meshing import Prepared
    from geoweave.surface import TriMesh

__all__ = ["FieldOfFile", "field_file", "foliate_file"]

PHASES = 4
"""Of the circle of smoothest fields, Algorithm 1 starts from the best of so many."""

SCALES = (1.0, 2.0, 4.0)
"""Scales that are tried if none is asked for, until the level sets follow the field.

Level sets close up round every handle, so their number round it is a whole one. On a long thin tube few go
round, and a whole number is far from the one that the field asks for. With twice as many it is nearer.
"""

FOLLOWS = 5.0
"""Level sets follow the field if the median of the angle between them is at most so many degrees."""


@dataclass(frozen=True, eq=False)
class FieldOfFile:
    """A geodesic field on the mesh of a file, and its foliation if that was asked for."""

    source: MeshSource
    prepared: Prepared
    solve: GeodesicSolve
    foliation: Foliation | None
    scale: float
    """Factor on the number of level sets."""
    tried: tuple[tuple[float, float], ...]
    """Scales that were tried, each with the median deviation there, degrees; none for a field alone."""
    seconds: dict[str, float]
    """Wall-clock time of each step, and in total."""
    output: str | None
    """Where the arrays were written."""

    def document(self) -> dict[str, Any]:
        """All numbers of the run, as ``geoweave field --json`` and ``geoweave foliate --json`` print them."""
        from geoweave.fields import total_curl

        solve, mesh = self.solve, self.solve.field.mesh
        said = {
            "mesh": self.source.name,
            "vertices": mesh.n_vertices,
            "faces": mesh.n_faces,
            "components": mesh.n_components,
            "genus": mesh.genus,
            "boundary_loops": len(mesh.boundary_loops),
            "total_curl": {"before": total_curl(solve.initial), "after": total_curl(solve.field)},
            "singularities": _singularities(mesh, solve.initial, solve.field),
            "iterations": len(solve.steps),
            "converged": solve.converged,
            "seed": self.source.seed,
            "repairs": self.prepared.report.as_dict(),
        }
        if self.foliation is not None:
            tried = [{"scale": scale, "median_deg": median} for scale, median in self.tried]
            said |= {"scale": self.scale, "scales_tried": tried, **_foliation_numbers(self.foliation)}
        said["seconds"] = {key: round(value, 4) for key, value in self.seconds.items()}
        return said if self.output is None else said | {"output": self.output}


def field_file(
    mesh: str | os.PathLike[str] | MeshSource,
    output: str | os.PathLike[str] | None = None,
    *,
    callback: Say | None = None,
) -> FieldOfFile:
    """Find a geodesic field on the mesh of a file, by Algorithm 1 from the smoothest field.

    Parameters
    ----------
    mesh : path of a file, or name of a data set; it is scaled to bounding radius 1 about its vertex mean
    output : a file for the arrays ``vertices, faces, field_initial, field, delta`` (numpy, never pickled)
    callback : called with one line of progress at a time

    Raises
    ------
    MeshError, FieldError
        If the surface does not allow it; the text begins with the name of the mesh.
    OutputError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from geoweave.meshing import write_mesh
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_mesh(gw.shapes.cone(faces=400), f"{folder}/cone.obj")
    ...     found = gw.pipeline.field_file(f"{folder}/cone.obj")
    >>> curl = found.document()["total_curl"]
    >>> curl["after"] < curl["before"]
    True
    """
    return _of_file(source_of(mesh), output, (), callback or silent)


def foliate_file(
    mesh: str | os.PathLike[str] | MeshSource,
    output: str | os.PathLike[str] | None = None,
    *,
    scale: float | None = None,
    callback: Say | None = None,
) -> FieldOfFile:
    """Find a geodesic field on the mesh of a file, and a periodic function whose level sets follow it.

    As `field_file`, and with a factor ``scale`` on the number of level sets. If it is not given, it is 1, or
    2 or 4 where fewer level sets do not follow the field; if they never do, it is that of these at which they
    follow it best. The file has three arrays more: ``theta_jump (F, 3)``, ``s (F,)`` and ``kept (F,)``; faces
    that were punctured hold nan.

    Examples
    --------
    >>> import tempfile
    >>> from geoweave.meshing import write_mesh
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_mesh(gw.shapes.cone(faces=400), f"{folder}/cone.obj")
    ...     found = gw.pipeline.foliate_file(f"{folder}/cone.obj", scale=2.0)
    >>> found.document()["s_min"] > 0
    True
    """
    return _of_file(source_of(mesh), output, SCALES if scale is None else (scale,), callback or silent)


def _of_file(
    source: MeshSource, output: str | os.PathLike[str] | None, scales: tuple[float, ...], say: Say
) -> FieldOfFile:
    """A field, and with scales also its foliation, at the first of them at which it follows the field."""
    from geoweave.fields import INTEGRABLE_END

    if output is not None:
        check_output(output, source.name)
    seconds: dict[str, float] = {}
    tried: list[tuple[float, Foliation]] = []
    with about(source.name):
        prepared, solve = _solved(source, INTEGRABLE_END if scales else None, seconds, say)
        if scales:
            with timed(seconds, "foliate"):
                tried = _foliated(solve, scales, source.seed, say)
        # Of those that follow the field equally well min takes the first, which has the fewest level sets.
        scale, foliation = min(tried, key=lambda each: _median(each[1]), default=(1.0, None))
        if output is not None:
            say(f"writing {output}")
            with timed(seconds, "write"):
                _write(output, _field_arrays(solve) | _foliation_arrays(foliation))
    seconds["total"] = sum(seconds.values())
    name = None if output is None else os.fspath(output)
    medians = tuple((each, _median(found)) for each, found in tried)
    return FieldOfFile(source, prepared, solve, foliation, scale, medians, seconds, name)


def _solved(
    source: MeshSource, finest: float | None, seconds: dict[str, float], say: Say
) -> tuple[Prepared, GeodesicSolve]:
    """Read a mesh and run Algorithm 1 on it, sharpened to ``finest`` squared edges if given."""
    from geoweave.fields import geodesic_field, sharpening_schedule, smoothest_field

    prepared = prepared_surface(source, seconds, say)
    mesh, _ = prepared.mesh.normalized()
    say("finding the smoothest field")
    with timed(seconds, "smoothest"):
        smoothest = smoothest_field(mesh, seed=source.seed)
    done: list[Step] = []

    def follow(step: Step, _: FaceField) -> None:
        done.append(step)
        say(f"Algorithm 1: step {len(done)}, smoothness {step.smoothness:.2g}, energy {step.energy:.6g}")

    schedule = None if finest is None else sharpening_schedule(mesh, finest=finest)
    with timed(seconds, "geodesic"):
        solve = geodesic_field(smoothest, smoothness=schedule, phases=PHASES, callback=follow)
    return prepared, solve


def _foliated(
    solve: GeodesicSolve, scales: tuple[float, ...], seed: int, say: Say
) -> list[tuple[float, Foliation]]:
    """The foliations at the scales, in order, up to the first one that follows the field."""
    from geoweave.foliation import foliate

    found: list[tuple[float, Foliation]] = []
    for scale in scales:
        say(f"finding the integrating factor, at scale {scale:g}")
        foliation = foliate(
            solve.field,
            scale=scale,
            seed=seed,
            callback=lambda number, energy: say(f"s and theta: alternation {number}, energy {energy:.6g}"),
        )
        found.append((scale, foliation))
        if _median(foliation) <= FOLLOWS:
            break
    return found


def _median(foliation: Foliation) -> float:
    """Median angle between the level sets and the field, degrees."""
    return foliation.alignment.median


def _singularities(mesh: TriMesh, initial: FaceField, final: FaceField) -> dict[str, int]:
    from geoweave.fields import index_sum, vertex_indices

    return {
        "before": int((vertex_indices(initial) != 0).sum()),
        "after": int((vertex_indices(final) != 0).sum()),
        "index_sum": int(index_sum(final)),
        "euler_characteristic": mesh.euler_characteristic,
    }


def _foliation_numbers(foliation: Foliation) -> dict[str, Any]:
    measured = foliation.alignment
    return {
        "deviation_deg": {"mean": measured.mean, "median": measured.median, "p95": measured.p95},
        "spacing_spread": measured.spacing_spread,
        "dislocations": measured.dislocations,
        "punctured_faces": int((~foliation.part.kept).sum()),
        "s_min": foliation.s_min,
        "energy": {"before": foliation.energies[0], "after": foliation.energies[-1]},
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


def _foliation_arrays(foliation: Foliation | None) -> dict[str, Any]:
    """Per face of the whole surface; what was punctured has no theta and no s, and holds nan."""
    if foliation is None:
        return {}
    import numpy as np

    part = foliation.part
    jump, s = np.full((part.whole.n_faces, 3), np.nan), np.full(part.whole.n_faces, np.nan)
    jump[part.faces] = foliation.circle.corner_jumps
    s[part.faces] = foliation.s
    return {"theta_jump": jump, "s": s, "kept": part.kept}


def _write(output: str | os.PathLike[str], arrays: Mapping[str, Any]) -> None:
    import numpy as np

    # Through an open file, because numpy adds another ending to a name that it does not know.
    with replacing(output) as temporary, open(temporary, "wb") as file:
        np.savez(file, **arrays)
