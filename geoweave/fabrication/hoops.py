"""A hoop for each opening: a strip that goes round it once, and holds the ends of the ribbons there.

Ribbons that are cut off by the boundary of a surface end on it exactly. So the hoop of an opening has the
length of the boundary, and a ribbon meets it where it ends. The hoop is woven like a ribbon: it lies over
those that lie under at their last crossing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from geoweave.arrays import Scalars, Vectors
from geoweave.errors import FieldError

__all__ = ["HOOP", "hooped"]

HOOP = "H"
"""Letter of the hoops, unless a family of ribbons has it."""

NEAR = 0.1
"""A ribbon that ends no farther from an opening than so many widths ends on it."""

LEAST = 0.5
"""Strips reach so many widths beyond the middle of a hoop, or more: to its edge."""


SHALLOWEST = 1.0
"""Ribbons that run along an opening are taken to meet its hoop at this angle, degrees."""

LEAN = 0.5
"""Cosine of the largest angle by which a hoop leans away from the surface."""


class End(NamedTuple):
    """The end of a ribbon on an opening."""

    ribbon: int
    last: bool
    """Whether it is the end of the ribbon, not its start."""
    opening: int
    at: float
    """Where on the opening, from its first point on."""
    turn: float
    """From the ribbon to the hoop, degrees, left is positive. An opening has the surface on its left, so it
    is positive where a ribbon ends, and negative where one starts."""


def hooped(
    weave: Mapping[str, Any], rest: Mapping[str, Any] | None, allowance: float
) -> dict[str, Mapping[str, Any]]:
    """Add a hoop for each opening to a weave, and make its ribbons longer there.

    Parameters
    ----------
    weave : the contents of a ``weave.json`` in mm
    rest : those of its ``relaxed.json``, if there is one. A hoop there goes through the ends of the ribbons
        at rest, and has the length that it has in the design
    allowance : what ribbons have beyond the middle of a hoop, mm

    Returns
    -------
    dict
        Both by the names of their files. Hoops are ribbons with ``"hoop": true``, after all others; their
        crossings come after all others too.

    Raises
    ------
    FieldError
        If there is no opening, or the strips do not reach to the edge of a hoop.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=100.0)
    >>> document = gw.fabrication.hooped(weave.document(), None, 10.0)["weave.json"]
    >>> hoop = document["ribbons"][-1]
    >>> hoop["label"], hoop["closed"], hoop["hoop"]
    ('H1', True, True)
    >>> rim = weave.mesh.boundary_loops[0]
    >>> step = np.diff(weave.mesh.vertices[np.append(rim, rim[0])], axis=0) * weave.placement.scale
    >>> bool(np.isclose(hoop["length"], np.linalg.norm(step, axis=1).sum()))  # mm
    True
    """
    openings = weave["surface"].get("openings") if isinstance(weave.get("surface"), Mapping) else None
    if openings is None:
        raise FieldError("weave.json does not say where the openings are; weave it again for hoops")
    if not openings:
        raise FieldError("the surface has no opening that a hoop could close; leave --hoops out")
    least = LEAST * float(weave["width"])
    if allowance < least:
        raise FieldError(
            f"strips that end {allowance:g} mm beyond the middle of a hoop do not reach its edge; give "
            f"--hoops {np.ceil(10 * least) / 10:g} or more"
        )
    bare = [(_array(each["points"]), _array(each["normals"])) for each in openings]
    loops = [(points, hoop_normals(points, normals)) for points, normals in bare]
    ends = _ends(weave, bare)
    empty = [k for k in range(len(loops)) if not any(each.opening == k for each in ends)]
    if len(empty) == len(loops):
        raise FieldError("no ribbon ends at an opening, so a hoop would hold nothing; leave --hoops out")
    found: dict[str, Mapping[str, Any]] = {"weave.json": _with(weave, loops, loops, ends, allowance)}
    if rest is not None:
        moved = []
        for k, (points, normals) in enumerate(loops):
            own = [each for each in ends if each.opening == k]
            there = _at_rest(points, own, weave, rest) if own else points
            moved.append((there, hoop_normals(there, normals)))
        found["relaxed.json"] = _with(rest, loops, moved, ends, allowance)
    return found


def hoop_normals(points: Vectors, normals: Vectors) -> Vectors:
    """(N, 3) normals of a straight strip along a closed line: it stands on the plane that fits the line best.

    A boundary bends within its surface, which a straight strip cannot. It leans away from the surface
    instead and stands upright, as the ring of a lampshade does. Where the surface itself lies in that plane,
    it cannot lean so far, and the normals are those of the surface.

    Parameters
    ----------
    points, normals : (N, 3) of the line, and of the surface from each point to the next
    """
    centred = points - points.mean(axis=0)
    axis = np.linalg.svd(centred, full_matrices=False)[2][2]
    ahead = np.roll(points, -1, axis=0) - points
    ahead /= np.maximum(np.linalg.norm(ahead, axis=1), 1e-300)[:, None]
    across = np.cross(ahead, axis)
    size = np.linalg.norm(across, axis=1)
    across /= np.maximum(size, 1e-300)[:, None]
    agree = (across * normals).sum(axis=1)
    across *= np.sign(agree.sum()) or 1.0
    leans = np.abs(agree.mean()) >= LEAN and size.min() > LEAN
    return np.asarray(across if leans else normals)


def _array(values: Any) -> NDArray[np.float64]:
    return np.array(values, dtype=np.float64).reshape(-1, 3)


def _along(points: Vectors) -> Scalars:
    """(N + 1,) arc length at the points of a closed line, and once round."""
    steps = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _ends(weave: Mapping[str, Any], loops: Sequence[tuple[Vectors, Vectors]]) -> list[End]:
    """The ends of open ribbons that lie on an opening."""
    near = NEAR * float(weave["width"])
    found = []
    for r, ribbon in enumerate(weave["ribbons"]):
        if ribbon["closed"]:
            continue
        for last in (False, True):
            place, beyond = _array(ribbon["points"][-2:] if last else ribbon["points"][1::-1])[::-1]
            off, at, k = min((*_nearest(points, place), k) for k, (points, _) in enumerate(loops))
            if off <= near:
                heading = place - beyond if last else beyond - place
                turn = _turn(heading, *loops[k], at)
                found.append(End(r, last, k, at, turn if last else -turn))
    return found


def _turn(heading: NDArray[np.float64], points: Vectors, normals: Vectors, at: float) -> float:
    """Angle between a direction and a closed line at a place of it, degrees, in the plane of the surface."""
    k = int(np.searchsorted(_along(points), at, side="right")) - 1
    ahead, up = points[(k + 1) % len(points)] - points[k], normals[k]
    one, other = (way - (way @ up) * up for way in (heading, ahead))
    angle = np.degrees(np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other))
    return float(np.clip(angle, SHALLOWEST, 180.0 - SHALLOWEST))


def _nearest(points: Vectors, place: NDArray[np.float64]) -> tuple[float, float]:
    """Distance of a place from a closed line, and where on it the nearest point is."""
    ahead = np.roll(points, -1, axis=0) - points
    share = ((place - points) * ahead).sum(axis=1) / np.maximum((ahead**2).sum(axis=1), 1e-300)
    share = np.clip(share, 0.0, 1.0)
    off = np.linalg.norm(points + share[:, None] * ahead - place, axis=1)
    k = int(np.argmin(off))
    at = _along(points)
    return float(off[k]), float((at[k] + share[k] * (at[k + 1] - at[k])) % at[-1])


def _at_rest(
    points: Vectors, ends: Sequence[End], weave: Mapping[str, Any], rest: Mapping[str, Any]
) -> Vectors:
    """An opening at rest: moved as the ends of its ribbons are, and in between as its neighbours are."""
    order = sorted(ends, key=lambda each: each.at)
    where = np.array([each.at for each in order])
    shift = np.array(
        [
            np.subtract(*(_array(each["ribbons"][end.ribbon]["points"])[-end.last] for each in (rest, weave)))
            for end in order
        ]
    )
    at = _along(points)
    moved = [np.interp(at[:-1], where, shift[:, axis], period=at[-1]) for axis in range(3)]
    return points + np.stack(moved, axis=1)


def _with(
    document: Mapping[str, Any],
    loops: Sequence[tuple[Vectors, Vectors]],
    places: Sequence[tuple[Vectors, Vectors]],
    ends: Sequence[End],
    allowance: float,
) -> Mapping[str, Any]:
    """A weave with hoops; loops are the openings of the design, places where they are in this document."""
    count = len(document["ribbons"])
    family = 1 + max((int(each["family"]) for each in document["ribbons"]), default=-1)
    letter = chr(ord(HOOP) + max(family - (ord(HOOP) - ord("A")), 0))
    longer = {(each.ribbon, each.last) for each in ends}
    ribbons = [
        _longer(ribbon, *(allowance if (r, last) in longer else 0.0 for last in (False, True)))
        for r, ribbon in enumerate(document["ribbons"])
    ]
    shift = [allowance if (r, False) in longer else 0.0 for r in range(count)]
    crossings = [
        each | {"arclength": [s + shift[r] for r, s in zip(each["ribbons"], each["arclength"], strict=True)]}
        for each in document["crossings"]
    ]
    over = _last_over(document)
    numbers: dict[int, int] = {}
    for k, ((points, normals), (design, _)) in enumerate(zip(places, loops, strict=True)):
        own = sorted((each for each in ends if each.opening == k), key=lambda each: each.at)
        if not own:
            continue
        numbers[k] = len(numbers) + 1
        hoop = len(ribbons)
        ribbons.append(
            {
                "id": hoop,
                "label": f"{letter}{numbers[k]}",
                "family": family,
                "closed": True,
                "hoop": True,
                "length": float(_along(design)[-1]),
                "points": points.tolist(),
                "normals": normals.tolist(),
            }
        )
        for number, end in enumerate(own):
            ribbon = document["ribbons"][end.ribbon]
            along = shift[end.ribbon] + (float(ribbon["length"]) if end.last else 0.0)
            # The ribbon is under the hoop where it was over before; without a crossing, under every other.
            under = over.get((end.ribbon, end.last), number % 2 == 0)
            crossings.append(
                {
                    "id": len(crossings),
                    "ribbons": [end.ribbon, hoop],
                    "arclength": [along, end.at],
                    "point": list(ribbon["points"][-1 if end.last else 0]),
                    "turn_deg": end.turn,
                    "over": hoop if under else end.ribbon,
                    "over_index": int(under),
                }
            )
    return {**document, "ribbons": ribbons, "crossings": crossings}


def _last_over(document: Mapping[str, Any]) -> dict[tuple[int, bool], bool]:
    """Whether each ribbon lies above at its first (False) and its last crossing (True)."""
    met: dict[int, list[tuple[float, bool]]] = {}
    for each in document["crossings"]:
        for side in (0, 1):
            above = each["over_index"] == side
            met.setdefault(each["ribbons"][side], []).append((each["arclength"][side], above))
    found = {}
    for ribbon, along in met.items():
        found[ribbon, False], found[ribbon, True] = min(along)[1], max(along)[1]
    return found


def _longer(ribbon: Mapping[str, Any], before: float, after: float) -> Mapping[str, Any]:
    """A ribbon that goes on straight at its ends."""
    if not (before or after):
        return ribbon
    points, normals = _array(ribbon["points"]), _array(ribbon["normals"])
    # At rest a line is a little longer or shorter than what is cut.
    share = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum()) / float(ribbon["length"])
    if before:
        ahead = points[0] - points[1]
        points = np.concatenate([[points[0] + share * before * ahead / np.linalg.norm(ahead)], points])
        normals = np.concatenate([normals[:1], normals])
    if after:
        ahead = points[-1] - points[-2]
        points = np.concatenate([points, [points[-1] + share * after * ahead / np.linalg.norm(ahead)]])
        normals = np.concatenate([normals, normals[-1:]])
    found = {**ribbon, "length": float(ribbon["length"]) + before + after}
    if ribbon.get("curvature"):
        found["curvature"] = [[at + before, bend] for at, bend in ribbon["curvature"]]
    return found | {"points": points.tolist(), "normals": normals.tolist()}
