"""The woven object as GLB: one node per ribbon, with width and thickness, over and under (glTF 2.0)."""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from os import PathLike
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from geoweave.arrays import Vectors
from geoweave.fabrication.colours import FAMILIES
from geoweave.fabrication.flattening import WeaveLike, weave_document
from geoweave.fabrication.up_axes import up_axis
from geoweave.files import replacing
from geoweave.weave import SECTIONS, Body, Centreline, bodies

__all__ = ["Ribbon", "glb_bytes", "ribbon_bodies", "solid_ribbons", "write_glb"]

FLOAT, UNSIGNED_INT = 5126, 5125
"""Kinds of numbers, as glTF 2.0 names them (Section 3.6.2.2)."""

VERTEX_BUFFER, INDEX_BUFFER = 34962, 34963
"""What an array is for, as glTF 2.0 names it (Section 5.11)."""

HALF = 0.5**0.5
"""Sine and cosine of half a right angle."""

UPRIGHT = {
    "z": (-HALF, 0.0, 0.0, HALF),
    "y": (0.0, 0.0, 0.0, 1.0),
    "x": (0.0, 0.0, HALF, HALF),
    "-z": (HALF, 0.0, 0.0, HALF),
    "-y": (1.0, 0.0, 0.0, 0.0),
    "-x": (0.0, 0.0, -HALF, HALF),
}
"""Rotation (x, y, z, w) that turns an axis to y, which is up in glTF."""


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
    path: str | PathLike[str],
    weave: WeaveLike,
    families: Sequence[str] = FAMILIES,
    up: str | None = None,
) -> None:
    """Write the woven object as GLB, whole or not at all.

    Parameters
    ----------
    path : of the file
    weave : a weave, or the contents of ``weave.json`` or ``relaxed.json``
    families : colour of each family, ``#rrggbb``
    up : the axis of the weave that is up; found if not given (`up_axis`)
    """
    data = glb_bytes(weave, families, up)
    with replacing(path) as temporary:
        temporary.write_bytes(data)


def solid_ribbons(weave: WeaveLike, step: float = SECTIONS) -> tuple[Ribbon, ...]:
    """The ribbons of `ribbon_bodies` as triangles with sharp edges.

    Parameters
    ----------
    weave : a weave, or the contents of ``weave.json`` or ``relaxed.json``
    step : distance between cross sections, in widths

    Raises
    ------
    FieldError
        If the document is no weave.
    """
    document = weave_document(weave)
    return tuple(
        _triangles(body, str(about["label"]), int(about["family"]))
        for body, about in zip(ribbon_bodies(document, step), document["ribbons"], strict=True)
    )


def ribbon_bodies(weave: WeaveLike, step: float = SECTIONS) -> tuple[Body, ...]:
    """The ribbons in space, in the unit of the weave.

    Parameters
    ----------
    weave : a weave, or the contents of ``weave.json`` or ``relaxed.json``
    step : distance between cross sections, in widths

    Raises
    ------
    FieldError
        If the document is no weave.

    See Also
    --------
    geoweave.weave.bodies : the same from lines and crossings.
    """
    document = weave_document(weave)
    lines = [
        Centreline(np.array(each["points"]), np.array(each["normals"]), bool(each["closed"]))
        for each in document["ribbons"]
    ]
    # At rest a ribbon is stretched a little: its length in the file is the one that is cut.
    stretch = np.array(
        [line.arclength[-1] / each["length"] for line, each in zip(lines, document["ribbons"], strict=True)]
    )
    met = document["crossings"]
    ribbons = np.array([each["ribbons"] for each in met], dtype=np.int64).reshape(-1, 2)
    cut = np.array([each["arclength"] for each in met], dtype=np.float64).reshape(-1, 2)
    over = np.array([each["over_index"] for each in met], dtype=np.int64)
    width, thickness = float(document["width"]), float(document["thickness"])
    return bodies(lines, ribbons, cut * stretch[ribbons], over, width=width, thickness=thickness, step=step)


def glb_bytes(weave: WeaveLike, families: Sequence[str] = FAMILIES, up: str | None = None) -> bytes:
    """The file: metres where the weave is in mm, y up, a material per family; same weave, same bytes.

    Parameters
    ----------
    weave : a weave, or the contents of ``weave.json`` or ``relaxed.json``
    families : colour of each family, ``#rrggbb``
    up : the axis of the weave that is up; found if not given (`up_axis`)
    """
    document = weave_document(weave)
    ribbons = solid_ribbons(document)
    used = sorted({ribbon.family for ribbon in ribbons})
    buffers = _Buffers()
    meshes = []
    for ribbon in ribbons:
        primitive = {
            "attributes": {
                "POSITION": buffers.vectors(ribbon.vertices, bounds=True),
                "NORMAL": buffers.vectors(ribbon.normals),
            },
            "indices": buffers.indices(ribbon.triangles),
            "material": used.index(ribbon.family),
        }
        meshes.append({"name": ribbon.label, "primitives": [primitive]})
    nodes: list[dict[str, Any]] = [
        {"name": ribbon.label, "mesh": number} for number, ribbon in enumerate(ribbons)
    ]
    unit = 0.001 if document["units"] == "mm" else 1.0
    turned = {"rotation": list(UPRIGHT[up_axis(document, up)]), "scale": [unit] * 3}
    nodes.append({"name": "weave", "children": list(range(len(ribbons))), **turned})
    content = {
        "asset": {"version": "2.0", "generator": "geoweave"},
        "scene": 0,
        "scenes": [{"nodes": [len(nodes) - 1]}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": [_material(family, families[family % len(families)]) for family in used],
        "accessors": buffers.accessors,
        "bufferViews": buffers.views,
        "buffers": [{"byteLength": len(buffers.data)}],
    }
    text = json.dumps(content, separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % 4)
    data = bytes(buffers.data)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


class _Buffers:
    """The numbers of a GLB, one array after the other, and where each of them is."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []

    def vectors(self, values: Vectors, *, bounds: bool = False) -> int:
        """Add vectors at vertices; their number among the arrays."""
        written = values.astype("<f4")
        about: dict[str, Any] = {"componentType": FLOAT, "count": len(written), "type": "VEC3"}
        if bounds:
            about |= {"min": written.min(axis=0).tolist(), "max": written.max(axis=0).tolist()}
        return self._add(written, VERTEX_BUFFER, about)

    def indices(self, triangles: NDArray[np.int64]) -> int:
        """Add the vertices of triangles; their number among the arrays."""
        written = triangles.astype("<u4").ravel()
        about = {"componentType": UNSIGNED_INT, "count": written.size, "type": "SCALAR"}
        return self._add(written, INDEX_BUFFER, about)

    def _add(self, array: NDArray[Any], target: int, about: dict[str, Any]) -> int:
        data = array.tobytes()
        self.views.append(
            {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), "target": target}
        )
        self.data.extend(data + b"\0" * (-len(data) % 4))
        self.accessors.append({"bufferView": len(self.views) - 1, **about})
        return len(self.accessors) - 1


def _material(family: int, colour: str) -> dict[str, Any]:
    """A matt material; glTF takes linear values, colours are written in sRGB."""
    srgb = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    base = [round(float(each), 6) for each in linear] + [1.0]
    return {
        "name": f"family {family}",
        "pbrMetallicRoughness": {"baseColorFactor": base, "metallicFactor": 0.0, "roughnessFactor": 0.75},
    }


def _triangles(body: Body, label: str, family: int) -> Ribbon:
    """Two triangles for each quadrilateral of a body, with sharp edges; open ends are shut."""
    side, up, ahead = body.side, body.up, body.ahead
    count = len(body.at)
    vertices, normals, triangles = [], [], []
    corners = body.corners.swapaxes(0, 1)
    for k, normal in enumerate((-up, side, up, -side)):
        first, base = np.arange(count - 1), 2 * count * k
        vertices += [corners[k], corners[(k + 1) % 4]]
        normals += [normal, normal]
        a, b, c, d = base + first, base + count + first, base + count + first + 1, base + first + 1
        triangles += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    if not body.closed:
        for end, sign in ((0, -1.0), (count - 1, 1.0)):
            base = sum(len(each) for each in vertices)
            vertices.append(np.array([corner[end] for corner in corners]))
            normals.append(np.tile(sign * ahead[end], (4, 1)))
            turn = np.array([[0, 2, 1], [0, 3, 2]]) if sign < 0 else np.array([[0, 1, 2], [0, 2, 3]])
            triangles.append(base + turn)
    return Ribbon(
        label,
        family,
        np.concatenate(vertices),
        np.concatenate(normals),
        np.concatenate(triangles).astype(np.int64),
    )
