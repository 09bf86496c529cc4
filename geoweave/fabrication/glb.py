"""The woven object as GLB: one node per ribbon, with width and thickness, over and under (glTF 2.0)."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from geoweave.arrays import Scalars, Vectors
from geoweave.errors import FieldError
from geoweave.fabrication.colours import FAMILIES
from geoweave.files import replacing

if TYPE_CHECKING:
    from geoweave.weave import Weave

__all__ = ["Course", "Ribbon", "courses", "glb_bytes", "solid_ribbons", "write_glb"]

CLEAR = 1.4
"""Distance of the middles of two ribbons where they cross, in thicknesses; the surface bends under them."""


class Course(NamedTuple):
    """The way of a ribbon in space, over and under the others; a closed one ends where it begins."""

    label: str
    family: int
    closed: bool
    at: Scalars
    """(P,) where on the ribbon its cross sections are."""
    centre: Vectors
    """(P, 3) their middles, in the unit of the weave."""
    side: Vectors
    """(P, 3) unit, to the left."""
    up: Vectors
    """(P, 3) unit, outwards."""
    ahead: Vectors
    """(P, 3) unit, along the line that the ribbon follows on the surface."""


class Ribbon(NamedTuple):
    """A ribbon as triangles."""

    label: str
    family: int
    vertices: Vectors
    """(V, 3) in the unit of the weave."""
    normals: Vectors
    """(V, 3) unit, outwards."""
    triangles: NDArray[np.int64]
    """(T, 3), counter-clockwise seen from outside."""


def write_glb(
    path: str | PathLike[str], weave: Weave | Mapping[str, Any], families: Sequence[str] = FAMILIES
) -> None:
    """Write the woven object as GLB, whole or not at all."""
    data = glb_bytes(weave, families)
    with replacing(path) as temporary:
        temporary.write_bytes(data)


def solid_ribbons(weave: Weave | Mapping[str, Any], step: float = 0.25) -> tuple[Ribbon, ...]:
    """Give every ribbon its width and thickness, and as much up or down at each crossing as it takes.

    Parameters
    ----------
    weave : a weave, or the contents of ``weave.json`` or ``relaxed.json``
    step : between cross sections, in widths

    Raises
    ------
    FieldError
        If the document is no weave.
    """
    document = weave if isinstance(weave, Mapping) else weave.document()
    found = courses(document, step)
    width, thickness = float(document["width"]), float(document["thickness"])
    return tuple(_tube(each, width, thickness) for each in found)


def courses(weave: Weave | Mapping[str, Any], step: float = 0.25) -> tuple[Course, ...]:
    """Follow every ribbon, as far up or down at each crossing as it takes to lie clear of the other one.

    On a surface, where ribbons go through each other, that is half a thickness and a little; at rest they lie
    a thickness apart already.

    Parameters
    ----------
    weave : a weave, or the contents of ``weave.json`` or ``relaxed.json``
    step : between cross sections, in widths

    Raises
    ------
    FieldError
        If the document is no weave.
    """
    document = weave if isinstance(weave, Mapping) else weave.document()
    if document.get("format") != "geoweave-weave":
        raise FieldError("weave.json: is not a geoweave-weave; write it with 'geoweave weave'")
    width, clear = float(document["width"]), CLEAR * float(document["thickness"])
    lines = [_Line.of(ribbon) for ribbon in document["ribbons"]]
    lifts: list[list[tuple[float, float]]] = [[] for _ in lines]
    for each in document["crossings"]:
        pair = [lines[r] for r in each["ribbons"]]
        where = [line.at[-1] * s / line.length for line, s in zip(pair, each["arclength"], strict=True)]
        up = sum(line.normal(s) for line, s in zip(pair, where, strict=True))
        apart = pair[0].point(where[0]) - pair[1].point(where[1])
        # A weave at rest has its ribbons over each other already; what is there is not lifted again.
        sign = 1 if each["over_index"] == 0 else -1
        there = sign * float(apart @ up) / max(float(np.linalg.norm(up)), 1e-12)
        lift = 0.5 * sign * max(clear - there, 0.0)
        for r, s, way in zip(each["ribbons"], where, (1, -1), strict=True):
            lifts[r].append((s, way * lift))
    return tuple(
        _course(line, sorted(lift), width, step * width) for line, lift in zip(lines, lifts, strict=True)
    )


def glb_bytes(weave: Weave | Mapping[str, Any], families: Sequence[str] = FAMILIES) -> bytes:
    """The file: metres where the weave is in mm, y up, a material per family; same weave, same bytes."""
    document = weave if isinstance(weave, Mapping) else weave.document()
    ribbons = solid_ribbons(document)
    blob = bytearray()
    views: list[dict[str, Any]] = []
    accessors: list[dict[str, Any]] = []

    def put(array: NDArray[Any], target: int, **more: Any) -> int:
        data = array.tobytes()
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(data), "target": target})
        blob.extend(data + b"\0" * (-len(data) % 4))
        accessors.append({"bufferView": len(views) - 1, **more})
        return len(accessors) - 1

    meshes, nodes = [], []
    used = sorted({ribbon.family for ribbon in ribbons})
    for ribbon in ribbons:
        points = ribbon.vertices.astype("<f4")
        kinds = {"componentType": 5126, "count": len(points), "type": "VEC3"}
        position = put(
            points, 34962, **kinds, min=points.min(axis=0).tolist(), max=points.max(axis=0).tolist()
        )
        normal = put(ribbon.normals.astype("<f4"), 34962, **kinds)
        order = put(
            ribbon.triangles.astype("<u4").ravel(),
            34963,
            componentType=5125,
            count=ribbon.triangles.size,
            type="SCALAR",
        )
        meshes.append(
            {
                "name": ribbon.label,
                "primitives": [
                    {
                        "attributes": {"POSITION": position, "NORMAL": normal},
                        "indices": order,
                        "material": used.index(ribbon.family),
                    }
                ],
            }
        )
        nodes.append({"name": ribbon.label, "mesh": len(meshes) - 1})
    unit = 0.001 if document["units"] == "mm" else 1.0
    # glTF has y up, the surfaces have z up.
    turned = {"rotation": [-float(np.sqrt(0.5)), 0.0, 0.0, float(np.sqrt(0.5))], "scale": [unit] * 3}
    nodes.append({"name": "weave", "children": list(range(len(ribbons))), **turned})
    content = {
        "asset": {"version": "2.0", "generator": "geoweave"},
        "scene": 0,
        "scenes": [{"nodes": [len(nodes) - 1]}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": [_material(family, families[family % len(families)]) for family in used],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(blob)}],
    }
    text = json.dumps(content, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(blob), b"BIN\0") + blob
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _material(family: int, colour: str) -> dict[str, Any]:
    """A matt material; glTF takes linear values, colours are written in sRGB."""
    srgb = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    base = [round(float(each), 6) for each in linear] + [1.0]
    return {
        "name": f"family {family}",
        "pbrMetallicRoughness": {"baseColorFactor": base, "metallicFactor": 0.0, "roughnessFactor": 0.75},
    }


class _Line(NamedTuple):
    """A ribbon as it is read; a closed one ends where it begins."""

    label: str
    family: int
    closed: bool
    length: float
    """As the file says: at rest it may differ from that of the line by what is stretched."""
    at: Scalars
    points: Vectors
    normals: Vectors

    @classmethod
    def of(cls, ribbon: Mapping[str, Any]) -> _Line:
        points, normals = (np.array(ribbon[key], dtype=np.float64) for key in ("points", "normals"))
        closed = bool(ribbon["closed"])
        if closed:
            points, normals = np.concatenate([points, points[:1]]), np.concatenate([normals, normals[:1]])
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        at = np.concatenate([[0.0], np.cumsum(steps)])
        about = str(ribbon["label"]), int(ribbon["family"]), closed, float(ribbon["length"])
        return cls(*about, at, points, normals)

    def point(self, s: float) -> Vectors:
        """(3,) the point at a length along the line."""
        return np.array([np.interp(s, self.at, self.points[:, axis]) for axis in range(3)])

    def normal(self, s: float) -> Vectors:
        """(3,) the normal of the segment there."""
        segment = int(np.searchsorted(self.at, s, side="right")) - 1
        return np.asarray(self.normals[min(max(segment, 0), len(self.at) - 2)])


def _course(line: _Line, lift: list[tuple[float, float]], width: float, step: float) -> Course:
    at, points, normals, closed = line.at, line.points, line.normals, line.closed
    even = np.linspace(0.0, at[-1], max(round(at[-1] / step), 2) + 1)
    # A cross section at every crossing, as heights peak there.
    met = np.array([s for s, _ in lift if 0.1 * step < s < at[-1] - 0.1 * step])
    if len(met):
        nearest = np.abs(even[:, None] - met).min(axis=1)
        nearest[[0, -1]] = np.inf
        even = even[nearest > 0.25 * step]
    where = np.unique(np.concatenate([even, met]))
    centre = np.stack([np.interp(where, at, points[:, axis]) for axis in range(3)], axis=1)
    up = _mean_normals(where, at, normals[:-1], 0.5 * width, closed)
    ahead = np.gradient(centre, axis=0)
    if closed:
        ahead[0] = ahead[-1] = centre[1] - centre[-2]
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    up -= (up * ahead).sum(axis=1, keepdims=True) * ahead
    up /= np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-12)
    side = np.cross(up, ahead)
    height = _heights(where, lift, at[-1], width, closed)
    lifted = centre + height[:, None] * up
    return Course(line.label, line.family, closed, where, lifted, side, up, ahead)


def _mean_normals(where: Scalars, at: Scalars, normals: Vectors, reach: float, closed: bool) -> Vectors:
    """Mean of the normals of the segments within reach, so that a ribbon does not rattle over the faces."""
    steps = np.diff(at)
    if closed:
        normals, steps = np.tile(normals, (3, 1)), np.tile(steps, 3)
        where = where + at[-1]
    along = np.concatenate([[0.0], np.cumsum(steps)])
    summed = np.concatenate([np.zeros((1, 3)), np.cumsum(steps[:, None] * normals, axis=0)])
    low, high = (np.clip(where + way * reach, 0.0, along[-1]) for way in (-1, 1))
    return np.stack(
        [np.interp(high, along, summed[:, k]) - np.interp(low, along, summed[:, k]) for k in range(3)], axis=1
    )


def _heights(
    where: Scalars, lift: list[tuple[float, float]], length: float, width: float, closed: bool
) -> Scalars:
    """Height above the surface: even across the width of a crossing, monotone from one to the next."""
    if not lift:
        return np.zeros(len(where))
    place, first = np.unique([s for s, _ in lift], return_index=True)
    value = np.array([h for _, h in lift])[first]
    if closed:
        place = np.concatenate([place - length, place, place + length])
        value = np.tile(value, 3)
    gaps = np.diff(place, prepend=-np.inf, append=np.inf)
    reach = np.minimum(0.5 * width, 0.4 * np.minimum(gaps[:-1], gaps[1:]))
    knots = np.stack([place - reach, place + reach], axis=1).ravel()
    heights = PchipInterpolator(knots, np.repeat(value, 2))(np.clip(where, knots[0], knots[-1]))
    return np.asarray(heights)


def _tube(course: Course, width: float, thickness: float) -> Ribbon:
    """A rectangle swept along a line, with sharp edges; ends that are not joined are shut."""
    centre, side, up, ahead = course.centre, course.side, course.up, course.ahead
    count = len(centre)
    vertices, normals, triangles = [], [], []
    corners = [centre + a * 0.5 * width * side + b * 0.5 * thickness * up for a, b in _ROUND]
    for k, normal in enumerate((-up, side, up, -side)):
        first, base = np.arange(count - 1), 2 * count * k
        vertices += [corners[k], corners[(k + 1) % 4]]
        normals += [normal, normal]
        a, b, c, d = base + first, base + count + first, base + count + first + 1, base + first + 1
        triangles += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    if not course.closed:
        for end, sign in ((0, -1.0), (count - 1, 1.0)):
            base = sum(len(each) for each in vertices)
            vertices.append(np.array([corner[end] for corner in corners]))
            normals.append(np.tile(sign * ahead[end], (4, 1)))
            turn = np.array([[0, 2, 1], [0, 3, 2]]) if sign < 0 else np.array([[0, 1, 2], [0, 2, 3]])
            triangles.append(base + turn)
    return Ribbon(
        course.label,
        course.family,
        np.concatenate(vertices),
        np.concatenate(normals),
        np.concatenate(triangles).astype(np.int64),
    )


_ROUND = ((-1, -1), (1, -1), (1, 1), (-1, 1))
