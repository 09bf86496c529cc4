"""Ribbons laid flat: from a weave in space to the strips that are cut (Section 5.4).

A ribbon that follows a geodesic is straight when it is laid flat. How far a ribbon is from that is said by
`bow_and_turning`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Protocol, TypeAlias

import numpy as np

from geoweave.arrays import Vectors, parallel_transport
from geoweave.errors import FieldError
from geoweave.fabrication.crossing_order import reordered_crossings
from geoweave.fabrication.marks import assigned
from geoweave.fabrication.pattern import Pattern, Strip, openings_said
from geoweave.weave import FLOATING, WEAVE_FORMAT, WEAVE_VERSION, FlatCurve

__all__ = ["FREE_END", "WeaveLike", "bow_and_turning", "free_end", "pattern_of", "trimmed", "weave_document"]

FREE_END = 4.0
"""An open strip that is made keeps so many widths beyond its outermost crossings.

That is about the spacing of a triaxial weave. It leaves what a maker needs to fasten the end, and takes away
what would hang from an opening.
"""


class HasDocument(Protocol):
    """A `Weave`, or a `Relaxed`: what can say how its ``weave.json`` or ``relaxed.json`` reads."""

    def document(self) -> dict[str, Any]:
        """The contents of the file."""


WeaveLike: TypeAlias = HasDocument | Mapping[str, Any]
"""A weave, a weave at rest, or the contents of its file."""


def weave_document(weave: WeaveLike, name: str = "weave.json") -> Mapping[str, Any]:
    """The contents of ``weave.json`` or ``relaxed.json`` of a weave.

    Parameters
    ----------
    weave : a `Weave`, a `Relaxed`, or these contents themselves
    name : what a document is called in a refusal

    Raises
    ------
    FieldError
        If the document is no weave.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=100.0)
    >>> gw.fabrication.weave_document(weave)["units"]
    'mm'
    >>> gw.fabrication.weave_document({"format": "other"}, "other.json")
    Traceback (most recent call last):
    geoweave.errors.FieldError: other.json: is not a geoweave-weave of version 1; ...
    """
    document = weave if isinstance(weave, Mapping) else weave.document()
    if document.get("format") != WEAVE_FORMAT or document.get("version") != WEAVE_VERSION:
        raise FieldError(
            f"{name}: is not a {WEAVE_FORMAT} of version {WEAVE_VERSION}; write it with 'geoweave weave'"
        )
    return document


def free_end(weave: WeaveLike) -> float:
    """How much a strip keeps beyond its outermost crossings unless something else is asked for.

    Parameters
    ----------
    weave : a weave, or the contents of ``weave.json`` or ``relaxed.json``

    Returns
    -------
    float
        Four widths of a ribbon, in the unit of the weave.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6)
    >>> round(gw.fabrication.free_end(weave.sized(size=100.0, width=3.0)), 6)  # mm
    12.0
    """
    return FREE_END * float(weave_document(weave)["width"])


def pattern_of(weave: WeaveLike, name: str = "weave.json", *, end: float = math.inf) -> Pattern:
    """Lay the ribbons of a weave flat.

    A ribbon that follows a geodesic is straight when it is laid flat (Section 5.4), so its strip keeps the
    ribbon's length and the places of its crossings. A ribbon with ``curvature`` is cut curved. The angle of
    a crossing is measured between the two segments that cross, about the mean of their normals.

    Parameters
    ----------
    weave : a weave in mm, as designed or at rest, or the contents of ``weave.json`` or ``relaxed.json``
    name : what a document is called in a refusal
    end : what an open strip keeps beyond its outermost crossings, mm; everything if not given. A strip
        without a crossing stays as long as its ribbon

    Raises
    ------
    FieldError
        If the weave is not in mm, the document is no weave, or the end is negative.

    Examples
    --------
    >>> import geoweave as gw
    >>> cone = gw.shapes.cone(faces=400)
    >>> weave = gw.weave_pattern(cone, ribbons=6).sized(size=100.0)
    >>> pattern = gw.fabrication.pattern_of(weave)
    >>> len(pattern.strips) == len(weave.ribbons)
    True
    >>> bool(abs(pattern.strips[0].length - weave.document()["ribbons"][0]["length"]) < 1e-9)  # mm
    True
    """
    document = weave_document(weave, name)
    if not end >= 0:
        raise FieldError(f"a strip keeps 0 mm or more beyond its outermost crossings, not {end}")
    if document.get("units") != "mm":
        raise FieldError(
            f"{name}: a pattern needs lengths in mm; give the object a size ('--size', 'Weave.sized')"
        )
    try:
        ends = _beyond(document, end)
        return _flattened(trimmed(document, ends), ends)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise FieldError(f"{name}: an entry of the weave is missing or wrong ({error!r})") from error


def trimmed(document: Mapping[str, Any], ends: Sequence[tuple[float, float]]) -> Mapping[str, Any]:
    """The same weave with something cut away of its ribbons.

    Parameters
    ----------
    document : the contents of ``weave.json`` or ``relaxed.json``
    ends : for each ribbon the lengths before its first end and after its last one that are cut away, such as
        `Strip.trimmed` of a pattern; nothing of a closed one

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=100.0)
    >>> pattern = gw.fabrication.pattern_of(weave, end=5.0)  # mm
    >>> shorter = gw.fabrication.trimmed(weave.document(), [strip.trimmed for strip in pattern.strips])
    >>> gw.fabrication.pattern_of(shorter).strips[0].length == pattern.strips[0].length
    True
    """
    if not any(before or after for before, after in ends):
        return document
    ribbons = [
        _shorter(ribbon, *each) if each[0] or each[1] else ribbon
        for ribbon, each in zip(document["ribbons"], ends, strict=True)
    ]
    crossings = [
        each
        | {"arclength": [s - ends[r][0] for r, s in zip(each["ribbons"], each["arclength"], strict=True)]}
        for each in document["crossings"]
    ]
    return {**document, "ribbons": ribbons, "crossings": crossings}


def _shorter(ribbon: Mapping[str, Any], before: float, after: float) -> dict[str, Any]:
    """A ribbon without what is before and after two of its places."""
    points, normals = (np.array(ribbon[key], dtype=np.float64) for key in ("points", "normals"))
    at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    # The length of the file is that of what is cut; at rest the line is a little longer or shorter.
    share = at[-1] / ribbon["length"]
    low, high = share * before, at[-1] - share * after
    kept = np.flatnonzero((at > low) & (at < high))
    where = np.concatenate([[low], at[kept], [high]])
    line = np.stack([np.interp(where, at, points[:, axis]) for axis in range(3)], axis=1)
    # A normal belongs to the segment that starts at its point.
    first = int(np.searchsorted(at, low, side="right")) - 1
    last = kept[-1] if len(kept) else first
    up = normals[np.concatenate([[first], kept, [last]])]
    length = float(ribbon["length"]) - before - after
    found = {**ribbon, "length": length, "points": line.tolist(), "normals": up.tolist()}
    if ribbon.get("curvature"):
        whole = FlatCurve(ribbon["curvature"], float(ribbon["length"]))
        found["curvature"] = [list(each) for each in whole.part(before, length).knots]
    return found


def _beyond(document: Mapping[str, Any], end: float) -> list[tuple[float, float]]:
    """What of each ribbon lies farther than an end beyond its outermost crossings, at both ends."""
    ribbons = document["ribbons"]
    outermost = [(math.inf, -math.inf)] * len(ribbons)
    for each in document["crossings"]:
        for r, s in zip(each["ribbons"], each["arclength"], strict=True):
            first, last = outermost[r]
            outermost[r] = (min(first, s), max(last, s))
    return [
        (0.0, 0.0)
        if ribbon["closed"] or last < first
        else (max(first - end, 0.0), max(float(ribbon["length"]) - last - end, 0.0))
        for ribbon, (first, last) in zip(ribbons, outermost, strict=True)
    ]


def _flattened(document: Mapping[str, Any], ends: Sequence[tuple[float, float]]) -> Pattern:
    strips, headings, ups, starts = [], [], [], []
    for each, cut in zip(document["ribbons"], ends, strict=True):
        points, normals = (np.array(each[key], dtype=np.float64) for key in ("points", "normals"))
        closed = bool(each["closed"])
        knots = tuple((float(at), float(bend)) for at, bend in each.get("curvature", ()))
        length = float(each["length"])
        curve = FlatCurve(knots, length, closed) if knots else None
        bow, turning = bow_and_turning(points, normals, closed, curve)
        label, family, ends_at = str(each["label"]), int(each["family"]), openings_said(each)
        hoop = bool(each.get("hoop", False))
        strips.append(Strip(label, family, closed, length, bow, turning, cut, knots, ends_at, hoop))
        ahead = np.diff(points, axis=0, append=points[:1] if closed else points[-1:])
        steps = np.linalg.norm(ahead, axis=1)
        if not closed:
            ahead[-1] = ahead[-2]
        headings.append(ahead)
        ups.append(normals)
        starts.append(np.cumsum(steps) - steps)
    met = document["crossings"]
    ribbons = np.array([each["ribbons"] for each in met], dtype=np.int64).reshape(-1, 2)
    at = np.array([each["arclength"] for each in met], dtype=np.float64).reshape(-1, 2)
    over = np.array([each["over_index"] for each in met], dtype=np.int64)
    angle = np.empty(len(met))
    for x, (pair, where) in enumerate(zip(ribbons.tolist(), at.tolist(), strict=True)):
        if "turn_deg" in met[x]:
            # Where a ribbon leaves the surface, the side to which it does is known without measuring.
            angle[x] = float(met[x]["turn_deg"])
            continue
        place = [
            min(max(int(np.searchsorted(starts[r], s, side="right")) - 1, 0), len(starts[r]) - 1)
            for r, s in zip(pair, where, strict=True)
        ]
        one, other = (headings[r][k] for r, k in zip(pair, place, strict=True))
        up = ups[pair[0]][place[0]] + ups[pair[1]][place[1]]
        up = up / np.linalg.norm(up)
        one, other = one - (one @ up) * up, other - (other @ up) * up
        angle[x] = np.degrees(np.arctan2(up @ np.cross(one, other), one @ other))
    closed_ones = np.array([strip.closed for strip in strips], dtype=bool)
    mark, again = assigned(ribbons, at, closed_ones)
    return Pattern(
        tuple(strips),
        float(document["width"]),
        float(document["thickness"]),
        ribbons,
        at,
        angle,
        over,
        mark,
        again,
        reordered_crossings(document),
        document.get("metrics", {}).get("pattern", {}).get("name") in FLOATING,
    )


def bow_and_turning(
    points: Vectors, normals: Vectors, closed: bool, curve: FlatCurve | None = None
) -> tuple[float, float]:
    """How far a ribbon on a surface is from its strip, laid flat with its geodesic curvature.

    At each point the plane of the next segment is turned into that of the one before, about their common
    line; what the direction then turns by is the geodesic curvature that a straight strip neglects. Of a
    strip that is cut curved, what it turns by itself is taken off.

    Parameters
    ----------
    points : (P, 3) the centreline; a closed one does not repeat its first point
    normals : (P, 3) unit normal of the surface along the segment from each point to the next
    closed : whether a last segment leads back
    curve : the strip as it is cut; straight if not given

    Returns
    -------
    tuple
        Largest distance of the flat centreline from the straight line between its ends, in the unit of the
        points, and the range of its direction, degrees.
    """
    ahead = np.diff(points, axis=0, append=points[:1]) if closed else np.diff(points, axis=0)
    up = normals[: len(ahead)]
    steps = np.linalg.norm(ahead, axis=1)
    kept = steps > 1e-12 * steps.sum()
    ahead, up, steps = ahead[kept], up[kept], steps[kept]
    before, after = up[:-1], up[1:]
    unfolded = parallel_transport(after, before, ahead[1:])
    left = np.cross(before, ahead[:-1])
    turned = np.arctan2((left * unfolded).sum(axis=1), (ahead[:-1] * unfolded).sum(axis=1))
    heading = np.concatenate([[0.0], np.cumsum(turned)])
    if curve is not None:
        middle = (np.cumsum(steps) - 0.5 * steps) * (curve.length / steps.sum())
        heading -= curve.heading(middle) - curve.heading(middle[:1])
    flat = np.concatenate([[0.0], np.cumsum(steps * np.exp(1j * heading))])
    along = flat[-1] / abs(flat[-1]) if abs(flat[-1]) > 0 else 1.0
    return float(np.abs((flat / along).imag).max()), float(np.degrees(np.ptp(heading)))
