"""Which way an object stands, as its report says it: asked for, by its file's convention, or by its base."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from geoweave.surface import TriMesh

__all__ = ["CONVENTIONS", "found_up", "said_up"]

CONVENTIONS = {".glb": "y", ".gltf": "y", ".3mf": "z"}
"""Formats that say which axis is up (glTF 2.0, Section 3.4; 3MF core specification, Section 2.1)."""


def found_up(mesh: TriMesh, name: str, asked: str | None = None) -> dict[str, str]:
    """What ``report.json`` says under ``up``: the axis, and by what it was found.

    Parameters
    ----------
    mesh : the surface
    name : of its file, or of a data set
    asked : the axis, if it was asked for

    Raises
    ------
    FieldError
        If there is no such axis.
    """
    from geoweave.fabrication import base_axis, check_axis

    if asked is not None:
        return {"axis": check_axis(asked), "by": "request"}
    convention = CONVENTIONS.get(PurePath(name).suffix.lower())
    if convention is not None:
        return {"axis": convention, "by": "format"}
    corners = mesh.vertices[mesh.faces].mean(axis=1)
    middle = np.average(corners, axis=0, weights=mesh.face_areas)
    found = base_axis(mesh.vertices, middle)
    return {"axis": found or "z", "by": "default" if found is None else "base"}


def said_up(report: Mapping[str, Any]) -> str | None:
    """The axis that a report names, if it names one."""
    said = report.get("up")
    axis = said.get("axis") if isinstance(said, Mapping) else None
    from geoweave.fabrication import check_axis

    return check_axis(axis) if isinstance(axis, str) else None
