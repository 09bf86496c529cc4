"""Read ``weave.json``, make rods of it, and write it for ribbons at rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from geoweave import documents
from geoweave.arrays import Scalars, Vectors, frozen
from geoweave.documents import read_json
from geoweave.errors import GeoweaveError, WeaveFileError
from geoweave.rods.crossing_forces import ContactForces
from geoweave.rods.from_ribbons import FINENESS, rods_of_polylines
from geoweave.rods.natural_curvature import curvature_knots, natural_of_strips
from geoweave.rods.rods import Contacts, Material, Rods
from geoweave.weave import WEAVE_FORMAT, WEAVE_VERSION, FlatCurve, Passages, check_curvature

__all__ = ["WovenRods", "at_rest", "crossings_at_rest", "read_weave", "rods_of_document"]

YOUNG = 1e8
"""Young's modulus of ribbons on a model of bounding radius 1, that of the paper's cone."""


AGAIN = "write it again with 'geoweave weave'"
"""What to do about a file with a slip in it."""

MOST_SEGMENTS = 1_000_000
"""Rods of more segments than this are refused; those of the largest weaves here have a hundredth of it."""

AS_LONG = 0.1
"""The points of a ribbon may make a line whose length differs from the ribbon's by this share of it.

Chords are a little shorter than a curve, and rods at rest are a little stretched.
"""

WEAVE = documents.entries(
    units=documents.text("mesh", "mm"),
    width=documents.number(above=0),
    thickness=documents.number(above=0),
    surface=documents.entries(genus=documents.whole(), boundary_loops=documents.whole()),
    ribbons=documents.each(
        documents.entries(
            {
                "curvature": documents.each(documents.each(documents.number(), 2)),
                "openings": documents.each(documents.whole(-1), 2),
            },
            label=documents.text(),
            family=documents.whole(),
            closed=documents.flag(),
            length=documents.number(above=0),
            points=documents.points(2),
            normals=documents.points(2),
        )
    ),
    crossings=documents.each(
        documents.entries(
            ribbons=documents.each(documents.whole(), 2),
            arclength=documents.each(documents.number(), 2),
            point=documents.each(documents.number(), 3),
            over_index=documents.whole(0, 1),
        )
    ),
    metrics=documents.entries(spacing=documents.number(above=0)),
)
"""What is read of a ``weave.json``."""


class WovenRods(NamedTuple):
    """The ribbons of a ``weave.json`` as rods, and where they are in the file."""

    rods: Rods
    """Centred at the mean of the ribbons' points, the farthest of them at distance 1."""
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

    Examples
    --------
    >>> gw.rods.read_weave("no such.json")
    Traceback (most recent call last):
    ...
    geoweave.errors.WeaveFileError: no such.json: cannot be read (No such file or directory); ...
    """
    name = Path(path).name
    document = read_json(path, WeaveFileError, AGAIN)
    if document.get("format") != WEAVE_FORMAT:
        raise WeaveFileError(f"{name}: is not a weave; give a weave.json of 'geoweave weave'")
    if document.get("version") != WEAVE_VERSION:
        raise WeaveFileError(
            f"{name}: is of version {document.get('version')}, and {WEAVE_VERSION} is what is read here; "
            "write it again with this 'geoweave weave'"
        )
    try:
        WEAVE(document, "")
        _check_crossings(document)
    except ValueError as error:
        raise WeaveFileError(f"{name}: {error}; {AGAIN}") from error
    return document


def _check_crossings(document: Mapping[str, Any]) -> None:
    """Refuse crossings of ribbons that are not there, and ribbons that would need too many segments."""
    lengths = [each["length"] for each in document["ribbons"]]
    for number, ribbon in enumerate(document["ribbons"]):
        along = _line(ribbon)[2]
        if abs(along - lengths[number]) > AS_LONG * lengths[number]:
            raise ValueError(
                f"ribbons[{number}] is {lengths[number]:g} long by its length, and {along:g} by its points"
            )
        check_curvature(ribbon.get("curvature", ()), document["width"], f"ribbons[{number}].curvature")
    for number, crossing in enumerate(document["crossings"]):
        if max(crossing["ribbons"]) >= len(lengths):
            raise ValueError(f"crossings[{number}].ribbons names a ribbon that is not there")
    spacing = document["metrics"]["spacing"]
    if sum(lengths) > MOST_SEGMENTS * FINENESS * spacing:
        raise ValueError(
            f"metrics.spacing is {spacing:g}, which would cut ribbons of a length of {sum(lengths):g} into "
            f"more than {MOST_SEGMENTS:,} segments"
        )


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
        lines, normals, lengths = [], [], []
        for number, ribbon in enumerate(ribbons):
            place = f"ribbon {number}"
            line, normal, length = _line(ribbon)
            lines.append((line - center) / scale)
            normals.append(normal)
            lengths.append(length)
        pairs, places, over = [], [], []
        for number, crossing in enumerate(document["crossings"]):
            place = f"crossing {number}"
            pair = [int(r) for r in crossing["ribbons"]]
            along = [float(s) for s in crossing["arclength"]]
            for r, s in zip(pair, along, strict=True):
                if not -1e-6 * lengths[r] <= s <= (1 + 1e-6) * lengths[r]:
                    raise ValueError(f"arc length {s:g} is not on a ribbon of length {lengths[r]:g}")
            pairs.append(pair)
            places.append(along)
            over.append(int(crossing["over_index"]))
        place = "the weave"
        closed = np.array([bool(each["closed"]) for each in ribbons])
        rods = rods_of_polylines(
            lines,
            normals,
            Passages(np.array(pairs), np.array(places) / scale, closed),
            np.array(over, dtype=np.int64),
            width / scale,
            Material(thickness / scale, YOUNG),
            segment / scale,
        )
        curves = [_curve(ribbon) for ribbon in ribbons]
        if any(curve is not None for curve in curves):
            rods = replace(rods, natural=natural_of_strips(rods, curves))
    except (KeyError, IndexError, TypeError, ValueError, GeoweaveError) as error:
        what = f"lacks {error}" if isinstance(error, KeyError) else str(error)
        raise WeaveFileError(f"{name}: {place}: {what}; write it again with 'geoweave weave'") from error
    return WovenRods(rods, frozen(center), scale)


def at_rest(
    document: Mapping[str, Any],
    rods: Rods,
    points: Vectors,
    normals: Vectors,
    unit: float,
    forces: ContactForces | None = None,
) -> dict[str, Any]:
    """Return a weave with its ribbons in the shape of rods; arc lengths are those at rest.

    Parameters
    ----------
    document : the weave, as in ``weave.json``
    rods : its ribbons as rods, one each
    points, normals : (V, 3) vertices and thickness directions of the rods, in the document's unit
    unit : the document's unit of length over that of the rods
    forces : at the contacts of the rods, if they are known

    Returns
    -------
    dict
        The contents of ``relaxed.json``. ``designed`` of a crossing is how far along its two ribbons it is in
        the design, so that their order can be compared. ``curvature`` of a ribbon that is cut curved lists
        places along it and the curvature of its strip there, left is positive; it is linear in between.
        ``force`` of a crossing is for a Young's modulus of 1: in newtons per N/mm2 if the document is in mm;
        its ``friction`` is null where ribbons are pulled apart.
    """
    layout, contacts = rods.layout, rods.contacts
    before = np.cumsum(rods.rest) - rods.rest
    along: Scalars = before - before[layout.segment_offsets[:-1]][layout.rod_of_segment]
    ribbons, knots = [], curvature_knots(rods, unit)
    for r, ribbon in enumerate(document["ribbons"]):
        own = slice(layout.offsets[r], layout.offsets[r + 1])
        length = rods.rest[layout.segment_offsets[r] : layout.segment_offsets[r + 1]].sum()
        shape = {"points": points[own].tolist(), "normals": normals[own].tolist()}
        bend = {"curvature": knots[r]} if knots[r] else {}
        straight = {key: value for key, value in ribbon.items() if key != "curvature"}
        ribbons.append(straight | {"length": float(length * unit)} | shape | bend)
    crossings: list[dict[str, Any]] = []
    for contact in crossings_at_rest(contacts):
        x = int(np.flatnonzero(contacts.group == contact)[0])
        pair, share = contacts.segments[contact], contacts.places[contact]
        ends = layout.ends[pair]
        both = points[ends[:, 0]] + share[:, None] * (points[ends[:, 1]] - points[ends[:, 0]])
        cosine = abs(float(rods.tangents[pair[0]] @ rods.tangents[pair[1]]))
        names, over = layout.rod_of_segment[pair].tolist(), int(contacts.over[contact])
        of_group = [document["crossings"][y] for y in np.flatnonzero(contacts.group == contact)]
        changed = {
            "id": len(crossings),
            "designed": _designed(of_group, names),
            "ribbons": names,
            "arclength": ((along[pair] + share * rods.rest[pair]) * unit).tolist(),
            "point": both.mean(axis=0).tolist(),
            "angle_deg": float(np.degrees(np.arccos(min(cosine, 1.0)))),
            "over": names[over],
            "over_index": over,
        }
        if forces is not None:
            changed |= forces.of_contact(contact, unit**2 / rods.material.young)
        # What was relaxed before had other forces.
        woven = {key: v for key, v in document["crossings"][x].items() if key not in ("force", "fasten")}
        crossings.append(woven | changed)
    return {**document, "ribbons": ribbons, "crossings": crossings}


def crossings_at_rest(contacts: Contacts) -> dict[int, int]:
    """Number of each contact among the crossings of ``relaxed.json``, by contact and in their order.

    A contact comes at the place of the first crossing that it stands for. A crossing of a segment with itself
    has no contact.
    """
    known, first = np.unique(contacts.group, return_index=True)
    order = known[np.argsort(first)]
    return {int(contact): number for number, contact in enumerate(order[order >= 0])}


def _designed(group: Sequence[Mapping[str, Any]], ribbons: Sequence[int]) -> list[float]:
    """Where a contact is in the design: at the middle one of the crossings that it stands for.

    Parameters
    ----------
    group : crossings of the design of the same two ribbons
    ribbons : of the contact, in its order
    """
    places = []
    for each in group:
        # What is relaxed again was designed where the first document says.
        pair, at = list(each["ribbons"]), list(each.get("designed", each["arclength"]))
        places.append(at if pair == list(ribbons) else at[::-1])
    places.sort()
    return places[(len(places) - 1) // 2]


def _curve(ribbon: Mapping[str, Any]) -> FlatCurve | None:
    """How a ribbon's strip is cut; None if it is straight."""
    knots = tuple((float(at), float(bend)) for at, bend in ribbon.get("curvature", ()))
    return FlatCurve(knots, float(ribbon["length"]), bool(ribbon["closed"])) if knots else None


def _line(ribbon: Mapping[str, Any]) -> tuple[Vectors, Vectors, float]:
    """Points and normals of a ribbon, and its length."""
    points, normals = (np.asarray(ribbon[key], dtype=np.float64) for key in ("points", "normals"))
    if points.ndim != 2 or points.shape[1] != 3 or normals.shape != points.shape:
        raise ValueError(f"points of shape {points.shape} and normals of shape {normals.shape} do not fit")
    whole = np.concatenate([points, points[:1]]) if ribbon["closed"] else points
    return points, normals, float(np.linalg.norm(np.diff(whole, axis=0), axis=1).sum())
