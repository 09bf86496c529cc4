"""What a weave was made from, as its report says it, so that it can be made again with changes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, fields
from typing import Any

from geoweave.errors import FieldError
from geoweave.pipeline.request import WeaveRequest
from geoweave.pipeline.source import MeshSource

__all__ = ["made_from", "read_made_from"]


def made_from(source: MeshSource, request: WeaveRequest) -> dict[str, Any]:
    """What ``report.json`` says under ``made_from``: the mesh as it was named, and what was asked for."""
    return {
        "mesh": source.name,
        "faces": source.faces,
        "seed": source.seed,
        "repair": source.repair,
        "components": source.components,
        "request": {name: value for name, value in asdict(request).items() if name != "edits"},
        "edits": [each.document() for each in request.edits],
    }


def read_made_from(
    report: Mapping[str, Any], place: str, mesh: str | None = None
) -> tuple[MeshSource, WeaveRequest]:
    """The mesh and the request that a report names.

    Parameters
    ----------
    report : the contents of ``report.json``
    place : of the folder, for a refusal
    mesh : path of the mesh, if it lies elsewhere now

    Raises
    ------
    FieldError
        If the report does not say it, or says what cannot be asked for.
    """
    from geoweave.weave import Edits, Singularity

    said = report.get("made_from")
    again = "weave it again with 'geoweave weave ... --edits FILE'"
    if not isinstance(said, Mapping):
        raise FieldError(f"{place}: its report.json does not say what it was made from; {again}")
    try:
        asked = dict(said["request"])
        known = {each.name for each in fields(WeaveRequest)}
        if not asked.keys() <= known:
            raise FieldError(f"there is no '{sorted(asked.keys() - known)[0]}' to be asked for")
        if asked.get("formats") is not None:
            asked["formats"] = tuple(asked["formats"])
        if asked.get("align") is not None:
            asked["align"] = tuple(tuple(map(float, each)) for each in asked["align"])
        if asked.get("singularities") is not None:
            asked["singularities"] = tuple(
                Singularity((float(x), float(y), float(z)), int(index))
                for (x, y, z), index in asked["singularities"]
            )
        edits = tuple(Edits.of(each) for each in said["edits"])
        source = MeshSource(
            mesh or str(said["mesh"]), said["faces"], said["seed"], said["repair"], said["components"]
        )
        return source, WeaveRequest(**asked, edits=edits)
    except (KeyError, TypeError, ValueError, FieldError) as error:
        what = f"lacks {error}" if isinstance(error, KeyError) else str(error)
        raise FieldError(f"{place}: 'made_from' in its report.json: {what}; {again}") from error
