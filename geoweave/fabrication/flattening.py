"""Ribbons laid flat: from a weave in space to the strips that are cut (Section 5.4).

A ribbon that follows a geodesic is straight when it is laid flat. How far a ribbon is from that is said by
`bow_and_turning`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, TypeAlias

import numpy as np

from geoweave.arrays import Vectors, parallel_transport
from geoweave.errors import FieldError
from geoweave.fabrication.marks import assigned
from geoweave.fabrication.pattern import Pattern, Strip
from geoweave.weave import WEAVE_FORMAT, WEAVE_VERSION

__all__ = ["WeaveLike", "bow_and_turning", "pattern_of", "weave_document"]


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
    """
    document = weave if isinstance(weave, Mapping) else weave.document()
    if document.get("format") != WEAVE_FORMAT or document.get("version") != WEAVE_VERSION:
        raise FieldError(
            f"{name}: is not a {WEAVE_FORMAT} of version {WEAVE_VERSION}; write it with 'geoweave weave'"
        )
    return document


def pattern_of(weave: WeaveLike, name: str = "weave.json") -> Pattern:
    """Lay the ribbons of a weave flat.

    A ribbon that follows a geodesic is straight when it is laid flat (Section 5.4), so its strip keeps the
    ribbon's length and the places of its crossings. The angle of a crossing is measured between the two
    segments that cross, about the mean of their normals.

    Parameters
    ----------
    weave : a weave in mm, as designed or at rest, or the contents of ``weave.json`` or ``relaxed.json``
    name : what a document is called in a refusal

    Raises
    ------
    FieldError
        If the weave is not in mm, or the document is no weave.

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
    if document.get("units") != "mm":
        raise FieldError(
            f"{name}: a pattern needs lengths in mm; give the object a size ('--size', 'Weave.sized')"
        )
    try:
        return _flattened(document)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise FieldError(f"{name}: an entry of the weave is missing or wrong ({error!r})") from error


def _flattened(document: Mapping[str, Any]) -> Pattern:
    strips, headings, ups, starts = [], [], [], []
    for each in document["ribbons"]:
        points, normals = (np.array(each[key], dtype=np.float64) for key in ("points", "normals"))
        closed = bool(each["closed"])
        bow, turning = bow_and_turning(points, normals, closed)
        strips.append(
            Strip(str(each["label"]), int(each["family"]), closed, float(each["length"]), bow, turning)
        )
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
    )


def bow_and_turning(points: Vectors, normals: Vectors, closed: bool) -> tuple[float, float]:
    """How far a ribbon on a surface is from a straight strip, laid flat with its geodesic curvature.

    At each point the plane of the next segment is turned into that of the one before, about their common
    line; what the direction then turns by is the geodesic curvature that a straight strip neglects.

    Parameters
    ----------
    points : (P, 3) the centreline; a closed one does not repeat its first point
    normals : (P, 3) unit normal of the surface along the segment from each point to the next
    closed : whether a last segment leads back

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
    flat = np.concatenate([[0.0], np.cumsum(steps * np.exp(1j * heading))])
    along = flat[-1] / abs(flat[-1]) if abs(flat[-1]) > 0 else 1.0
    return float(np.abs((flat / along).imag).max()), float(np.degrees(np.ptp(heading)))
