"""``design.npz``: a weave as designed, with all that later steps need, so that it is not solved again.

``weave.json`` is for readers and has no surface. This file has the surface and the curves on it, exactly.
"""

from __future__ import annotations

import json
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from geoweave.arrays import frozen
from geoweave.curves import Crossings, Curves
from geoweave.errors import FieldError, GeoweaveError
from geoweave.files import Job
from geoweave.surface import Similarity, TriMesh
from geoweave.weave import Cutting, Design, Ribbons, Weave, WeaveType, interlacing, weave_type_of

__all__ = ["design_job", "read_design"]

FORMAT, VERSION = "geoweave-design", 1

CURVES = ("points", "faces", "turning", "sliding", "offsets", "closed")
CROSSINGS = ("curves", "segments", "arclength", "points", "faces", "angle")


def design_job(weave: Weave) -> Job:
    """What writes ``design.npz``; the same weave, the same bytes."""
    ribbons, design = weave.ribbons, weave.design
    about = {
        "format": FORMAT,
        "version": VERSION,
        "symmetry": design.symmetry,
        "scale": design.scale,
        "tried": [list(each) for each in design.tried],
        "pattern": weave.interlacing.pattern,
        "bound": weave.interlacing.bound,
        "triples_proven": weave.interlacing.triples_proven,
        "spacing": ribbons.spacing,
        "cutting": vars(ribbons.cutting),
        "width": weave.width,
        "thickness": weave.thickness,
        "units": weave.units,
        "placement_scale": weave.placement.scale,
        "kept_names": weave.names if weave.kept_names is not None else None,
    }
    arrays: dict[str, Any] = {
        "about": np.array(json.dumps(about)),
        "vertices": weave.mesh.vertices,
        "triangles": weave.mesh.faces,
        **{f"curves_{name}": getattr(ribbons.curves, name) for name in CURVES},
        **{f"crossings_{name}": getattr(ribbons.crossings, name) for name in CROSSINGS},
        "origin": ribbons.origin,
        "families": weave.families,
        "over": weave.interlacing.over,
        "branch_points": design.branch_points,
        "center": weave.placement.center,
    }
    if design.numerators is not None:
        arrays["numerators"] = design.numerators

    def write(path: Path) -> None:
        with path.open("wb") as file:
            np.savez_compressed(file, **arrays)

    return write


def read_design(path: str | PathLike[str]) -> Weave:
    """Read ``design.npz``; theta and s of the foliation are not in it.

    Raises
    ------
    FieldError
        If it cannot be read, or is none.
    """
    name = Path(path).name
    try:
        with np.load(path, allow_pickle=False) as file:
            held = {key: file[key] for key in file.files}
        about = json.loads(str(held["about"]))
        if (about["format"], about["version"]) != (FORMAT, VERSION):
            raise ValueError(f"is not a {FORMAT} of version {VERSION}")
        return _weave(held, about)
    except (OSError, KeyError, IndexError, TypeError, ValueError, EOFError, GeoweaveError) as error:
        raise FieldError(
            f"{name}: holds no design that can be read ({error}); delete it, and the weave is designed anew"
        ) from error


def _pattern(about: dict[str, Any]) -> WeaveType:
    """The weave that is meant; files of earlier versions hold the default of their symmetry."""
    return weave_type_of(int(about["symmetry"]), about.get("pattern"))[1]


def _weave(held: dict[str, Any], about: dict[str, Any]) -> Weave:
    mesh = TriMesh(held["vertices"], held["triangles"])
    curves = Curves(mesh, *(held[f"curves_{name}"] for name in CURVES))
    crossings = Crossings(*(held[f"crossings_{name}"] for name in CROSSINGS))
    cutting: dict[str, Any] = {
        key: tuple(value) if isinstance(value, list) else value for key, value in about["cutting"].items()
    }
    ribbons = Ribbons(curves, crossings, frozen(held["origin"]), float(about["spacing"]), Cutting(**cutting))
    judged = interlacing.judged(ribbons.passages, held["over"], _pattern(about))
    names = about["kept_names"]
    return Weave(
        ribbons=ribbons,
        families=frozen(held["families"]),
        interlacing=replace(judged, bound=int(about["bound"]), triples_proven=bool(about["triples_proven"])),
        width=float(about["width"]),
        thickness=float(about["thickness"]),
        design=Design(
            symmetry=int(about["symmetry"]),
            branch_points=frozen(held["branch_points"]),
            scale=float(about["scale"]),
            tried=tuple((float(a), int(b)) for a, b in about["tried"]),
            numerators=frozen(held["numerators"]) if "numerators" in held else None,
        ),
        placement=Similarity(held["center"], float(about["placement_scale"])),
        units=about["units"],
        kept_names=None if names is None else tuple(names),
    )
