"""What ``viewer.html`` holds: the ribbons as designed and at rest, crossings, hard places, branch points.

The ribbons are those of the GLB (`ribbon_bodies`), packed as in the guide.
"""

from __future__ import annotations

import base64
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from geoweave.arrays import Indices, Scalars, Vectors
from geoweave.fabrication.colours import Colours
from geoweave.fabrication.glb import ribbon_bodies
from geoweave.fabrication.guide_payload import shape
from geoweave.fabrication.up_axes import AXES
from geoweave.weave import Body, design_key

__all__ = ["sideways_bend", "viewer_content"]

BEND = 0.5
"""The largest curvature times width that is told apart; it is written in steps of 1/32767 of this."""


def viewer_content(
    weave: Mapping[str, Any],
    rest: Mapping[str, Any] | None,
    report: Mapping[str, Any],
    title: str,
    colours: Colours,
    up: str = AXES[0],
) -> dict[str, Any]:
    """What the page knows of the weave.

    Parameters
    ----------
    weave : the contents of ``weave.json``
    rest : those of ``relaxed.json``, if the weave was relaxed
    report : those of ``report.json``; may lack anything
    title : of the page
    colours : of the families
    up : the axis that is up, one of `AXES`

    Raises
    ------
    FieldError
        If the weave at rest has other ribbons than the weave.
    """
    ribbons = weave["ribbons"]
    labels = [each["label"] for each in ribbons]
    number = {label: r for r, label in enumerate(labels)}
    states = [_state("designed", "As designed", weave, labels, _designs_alone(weave))]
    if rest is not None:
        states.append(_state("rest", "At rest", rest, labels, _designs_of(weave, rest)))
    return {
        "title": title,
        "key": design_key(weave),
        "up": AXES.index(up),
        "units": weave["units"],
        "width": round(float(weave["width"]), 6),
        "thickness": round(float(weave["thickness"]), 6),
        "symmetry": int(weave.get("symmetry", 6)),
        "families": list(colours.families),
        "strips": [
            [each["label"], each["family"], each["closed"], round(float(each["length"]), 4)]
            for each in ribbons
        ],
        # For each crossing of the design: how far along its two ribbons, and which of them is over.
        "crossings": [
            [*each["ribbons"], *(round(float(s), 5) for s in each["arclength"]), each["over_index"]]
            for each in weave["crossings"]
        ],
        "states": states,
        "kinds": dict(report.get("kinds", {})),
        "places": _places(report.get("places", ()), weave, rest, number),
        "singularities": [
            [*(round(float(x), 6) for x in each["point"]), each["index"]]
            for each in weave.get("surface", {}).get("singularities", ())
        ],
        "verdict": report.get("verdict"),
    }


def _state(
    name: str, says: str, document: Mapping[str, Any], labels: Sequence[str], designs: Sequence[Indices]
) -> dict[str, Any]:
    """The ribbons and crossings of one of the two shapes."""
    lengths = np.array([each["length"] for each in document["ribbons"]])
    crossings = []
    for each, design in zip(document["crossings"], designs, strict=True):
        pair = each["ribbons"]
        shares = np.array(each["arclength"]) / lengths[pair]
        crossings.append(
            [
                *pair,
                *(round(float(share), 6) for share in shares),
                each["over_index"],
                round(float(each["angle_deg"]), 2) if "angle_deg" in each else None,
                design.tolist(),
            ]
        )
    bends = np.concatenate([sideways_bend(body) for body in ribbon_bodies(document)])
    steps = np.rint(32767 / BEND * np.clip(bends * float(document["width"]), -BEND, BEND)).astype("<i2")
    known = [each.get("force") for each in document["crossings"]]
    forces = [round(float(np.hypot(f["separation"], f["sliding"])), 9) if f else None for f in known]
    return {
        "name": name,
        "says": says,
        # How strongly each crossing is held at rest, for a Young's modulus of 1, as far as it is known.
        "force": forces if any(each is not None for each in forces) else None,
        "fasten": [x for x, each in enumerate(document["crossings"]) if each.get("fasten")],
        "shape": shape(document, labels),
        "crossings": crossings,
        "bend": {"unit": BEND / 32767, "steps": base64.b64encode(steps.tobytes()).decode("ascii")},
    }


def sideways_bend(body: Body) -> Scalars:
    """(P,) how much a ribbon bends within its own face at each cross section, 1 / length, left is positive.

    The mean over one width to either side. A strip that is cut straight would have none.
    """
    along, length = body.at, float(body.at[-1])
    ahead = body.ahead
    if body.closed:
        ahead = np.concatenate([ahead[:-1], ahead[:-1], ahead])
        along = np.concatenate([along[:-1] - length, along[:-1], along + length])
    low, high = body.at - body.width, body.at + body.width
    if not body.closed:
        low, high = np.maximum(low, 0.0), np.minimum(high, length)
    before, after = (
        np.column_stack([np.interp(at, along, ahead[:, axis]) for axis in range(3)]) for at in (low, high)
    )
    turned = ((after - before) * body.side).sum(axis=1)
    return np.asarray(turned / np.maximum(high - low, 1e-12))


def _designs_alone(weave: Mapping[str, Any]) -> list[Indices]:
    """Every crossing of the design stands for itself."""
    return [np.array([x]) for x in range(len(weave["crossings"]))]


def _designs_of(weave: Mapping[str, Any], rest: Mapping[str, Any]) -> list[Indices]:
    """For each crossing at rest, the crossings of the design that it stands for.

    Each crossing of the design belongs to the nearest one at rest of the same two ribbons; ribbons that pass
    each other several times within a short way are held together once.
    """
    there: dict[tuple[int, ...], list[tuple[int, tuple[float, ...]]]] = defaultdict(list)
    for x, each in enumerate(rest["crossings"]):
        pair, at = _sorted(each["ribbons"], each.get("designed", each["arclength"]))
        there[pair].append((x, at))
    found: list[list[int]] = [[] for _ in rest["crossings"]]
    for x, each in enumerate(weave["crossings"]):
        pair, at = _sorted(each["ribbons"], each["arclength"])
        if there[pair]:
            nearest = min(there[pair], key=lambda other: float(np.abs(np.subtract(other[1], at)).sum()))
            found[nearest[0]].append(x)
    return [np.array(each, dtype=np.int64) for each in found]


def _sorted(ribbons: Sequence[int], at: Sequence[float]) -> tuple[tuple[int, ...], tuple[float, ...]]:
    pairs = sorted(zip(ribbons, at, strict=True))
    return tuple(r for r, _ in pairs), tuple(float(s) for _, s in pairs)


def _places(
    places: Sequence[Mapping[str, Any]],
    weave: Mapping[str, Any],
    rest: Mapping[str, Any] | None,
    number: Mapping[str, int],
) -> list[dict[str, Any]]:
    """Hard places, where they are in each of the shapes: a place on ribbons goes where the ribbons go."""
    found = []
    for each in places:
        ribbons = [number[label] for label in each["ribbons"] if label in number]
        point = np.array(each["point"], dtype=np.float64)
        where = [point]
        if rest is not None:
            moved = [_beside(rest["ribbons"][r], _share(weave["ribbons"][r], point)) for r in ribbons]
            where.append(np.mean(moved, axis=0) if moved else point)
        found.append(
            {
                "kind": each["kind"],
                "ribbons": ribbons,
                "value": round(float(each["value"]), 4),
                "at": [[round(float(x), 5) for x in spot] for spot in where],
            }
        )
    return found


def _share(ribbon: Mapping[str, Any], point: Vectors) -> float:
    """How far along a ribbon the point of it is that is nearest to a place, as a share of its points."""
    line = np.asarray(ribbon["points"])
    nearest = int(np.linalg.norm(line - point, axis=1).argmin())
    along = _along(line)
    return float(along[nearest] / max(along[-1], 1e-12))


def _beside(ribbon: Mapping[str, Any], share: float) -> Vectors:
    """The point of a ribbon at a share of its length."""
    line = np.asarray(ribbon["points"])
    along = _along(line)
    return np.array([np.interp(share * along[-1], along, line[:, axis]) for axis in range(3)])


def _along(line: Vectors) -> Scalars:
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
