"""``weave.json`` read back, and put in another shape (DESIGN: the file is a contract)."""

from __future__ import annotations

import json
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from geoweave.arrays import Indices, Scalars, Vectors, frozen
from geoweave.errors import GeoweaveError
from geoweave.ribbon_rods import FINENESS
from geoweave.rodfiles import Rod, RodCrossing, RodFile
from geoweave.rods import Rods
from geoweave.woven import FORMAT, VERSION

__all__ = ["WeaveFileError", "WovenRods", "at_rest", "read_weave", "rods_of_document"]

YOUNG = 1e8
"""Young's modulus of ribbons on a model of bounding radius 1, that of the paper's cone."""


class WeaveFileError(GeoweaveError):
    """A file that is no weave, or one with a slip in it, and what to do about it."""


class WovenRods(NamedTuple):
    """The ribbons of a ``weave.json`` as rods, and which of them lie above."""

    file: RodFile
    """Centred at the mean of its points, the farthest of them at distance 1."""
    over: Indices
    """(C,) 0 or 1 for each crossing."""
    center: Vectors
    """(3,) of the points in the file's unit."""
    scale: float
    """Bounding radius in the file's unit."""


def read_weave(path: str | PathLike[str]) -> dict[str, Any]:
    """Read ``weave.json`` or ``relaxed.json`` and check that it is one.

    Raises
    ------
    WeaveFileError
        If the file cannot be read, is no JSON, or is no weave of a version that is known here.
    """
    name = Path(path).name
    try:
        document = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise WeaveFileError(f"{name}: cannot be read ({error.strerror}); check the path") from error
    except ValueError as error:
        raise WeaveFileError(
            f"{name}: is not JSON ({error}); write it again with 'geoweave weave'"
        ) from error
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise WeaveFileError(f"{name}: is not a weave; give a weave.json of 'geoweave weave'")
    if document.get("version") != VERSION:
        raise WeaveFileError(
            f"{name}: is of version {document.get('version')}, and {VERSION} is what is read here; "
            "write it again with this 'geoweave weave'"
        )
    return document


def rods_of_document(document: Mapping[str, Any], name: str = "weave.json") -> WovenRods:
    """Cut the ribbons of a weave into equal segments, a fifth of their spacing long.

    Raises
    ------
    WeaveFileError
        If an entry is missing or is not what it should be; the sentence names the ribbon or the crossing.
    """
    place = "its head"
    try:
        segment = FINENESS * float(document["metrics"]["spacing"])
        width, thickness = float(document["width"]), float(document["thickness"])
        ribbons = document["ribbons"]
        everything = np.concatenate([np.asarray(each["points"], dtype=np.float64) for each in ribbons])
        center = everything.mean(axis=0)
        scale = float(np.linalg.norm(everything - center, axis=1).max())
        rods, knots = [], []
        for number, ribbon in enumerate(ribbons):
            place = f"ribbon {number}"
            rod, at = _cut(ribbon, segment, width, center, scale)
            rods.append(rod)
            knots.append(at)
        crossings, over = [], []
        for number, crossing in enumerate(document["crossings"]):
            place = f"crossing {number}"
            pair = int(crossing["ribbons"][0]), int(crossing["ribbons"][1])
            found = [
                _located(knots[r], float(s), rods[r].closed)
                for r, s in zip(pair, crossing["arclength"], strict=True)
            ]
            (a, x), (b, y) = found
            crossings.append(RodCrossing(pair, (a, b), (x, y)))
            over.append(int(crossing["over_index"]))
        place = "the weave"
        file = RodFile(tuple(rods), tuple(crossings), thickness / scale, YOUNG, 1.0)
    except (KeyError, IndexError, TypeError, ValueError, GeoweaveError) as error:
        what = f"lacks {error}" if isinstance(error, KeyError) else str(error)
        raise WeaveFileError(f"{name}: {place}: {what}; write it again with 'geoweave weave'") from error
    return WovenRods(file, np.array(over, dtype=np.int64), frozen(center), scale)


def at_rest(
    document: Mapping[str, Any], rods: Rods, points: Vectors, normals: Vectors, unit: float
) -> dict[str, Any]:
    """Return a weave with its ribbons in the shape of rods; arc lengths are those at rest.

    Parameters
    ----------
    document : the weave, as in ``weave.json``
    rods : its ribbons as rods, one each
    points, normals : (V, 3) vertices and thickness directions of the rods, in the document's unit
    unit : the document's unit of length over that of the rods
    """
    layout, contacts = rods.layout, rods.contacts
    assert contacts.group is not None
    before = np.cumsum(rods.rest) - rods.rest
    along: Scalars = before - before[layout.segment_offsets[:-1]][layout.rod_of_segment]
    ribbons = []
    for r, ribbon in enumerate(document["ribbons"]):
        own = slice(layout.offsets[r], layout.offsets[r + 1])
        length = rods.rest[layout.segment_offsets[r] : layout.segment_offsets[r + 1]].sum()
        shape = {"points": points[own].tolist(), "normals": normals[own].tolist()}
        ribbons.append(ribbon | {"length": float(length * unit)} | shape)
    known, first = np.unique(contacts.group, return_index=True)
    crossings: list[dict[str, Any]] = []
    for contact, x in sorted(zip(known.tolist(), first.tolist(), strict=True), key=lambda pair: pair[1]):
        if contact < 0:  # a rod that crosses itself within one segment is not held there
            continue
        pair, share = contacts.segments[contact], contacts.places[contact]
        ends = layout.ends[pair]
        both = points[ends[:, 0]] + share[:, None] * (points[ends[:, 1]] - points[ends[:, 0]])
        cosine = abs(float(rods.tangents[pair[0]] @ rods.tangents[pair[1]]))
        names, over = layout.rod_of_segment[pair].tolist(), int(contacts.over[contact])
        changed = {
            "id": len(crossings),
            "ribbons": names,
            "arclength": ((along[pair] + share * rods.rest[pair]) * unit).tolist(),
            "point": both.mean(axis=0).tolist(),
            "angle_deg": float(np.degrees(np.arccos(min(cosine, 1.0)))),
            "over": names[over],
            "over_index": over,
        }
        crossings.append(document["crossings"][x] | changed)
    return {**document, "ribbons": ribbons, "crossings": crossings}


def _cut(
    ribbon: Mapping[str, Any], segment: float, width: float, center: Vectors, scale: float
) -> tuple[Rod, Scalars]:
    """One ribbon as a rod of equal segments, and the arc length of their ends in the file's unit."""
    points, normals = (np.asarray(ribbon[key], dtype=np.float64) for key in ("points", "normals"))
    closed = bool(ribbon["closed"])
    if points.ndim != 2 or points.shape[1] != 3 or normals.shape != points.shape:
        raise ValueError(f"points of shape {points.shape} and normals of shape {normals.shape} do not fit")
    if closed:
        points, normals = np.concatenate([points, points[:1]]), np.concatenate([normals, normals[:1]])
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    at = np.concatenate([[0.0], np.cumsum(length)])
    count = max(int(np.round(at[-1] / segment)), 3 if closed else 1)
    knots = np.linspace(0.0, at[-1], count + 1)
    line = np.column_stack([np.interp(knots, at, points[:, x]) for x in range(3)])
    middle = 0.5 * (knots[1:] + knots[:-1])
    thick = np.column_stack([np.interp(middle, at, normals[:, x]) for x in range(3)])
    ways = np.diff(line, axis=0)
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    thick -= (thick * ways).sum(axis=1)[:, None] * ways
    thick /= np.linalg.norm(thick, axis=1)[:, None]
    vertices = (line[:-1] if closed else line) - center
    return Rod(vertices / scale, thick, np.full(count, width / scale), closed), knots


def _located(knots: Scalars, s: float, closed: bool) -> tuple[int, float]:
    """Segment, and place along it, of an arc length."""
    if not -1e-6 * knots[-1] <= s <= (1 + 1e-6) * knots[-1]:
        raise ValueError(f"arc length {s:g} is not on a ribbon of length {knots[-1]:g}")
    s = s % knots[-1] if closed else s
    at = int(np.clip(np.searchsorted(knots, s, side="right") - 1, 0, len(knots) - 2))
    return at, float(np.clip((s - knots[at]) / (knots[at + 1] - knots[at]), 0.0, 1.0))
