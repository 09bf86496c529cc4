"""OBJ, OFF and STL bytes as arrays, strictly: what is cut short or misspelt is refused with its line.

These readers exist because a mesh that is silently different from its file is worse than an error: general
readers accept an OFF file that ends early, take OBJ's vertex 0 for the first one, count OBJ's relative
indices from the end of the file, and split vertices where texture coordinates change.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from geoweave.arrays import Indices, Triangles, Vectors
from geoweave.errors import MeshError

_STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


class RawMesh(NamedTuple):
    """What a file says: ``vertices`` (V, 3) and ``faces`` (F, 3), unchecked; F = 0 for a point cloud."""

    vertices: Vectors
    faces: Triangles


def fan_triangles(corners: Indices, counts: Indices) -> Triangles:
    """Cut polygons into triangles that share the polygon's first corner.

    ``corners`` holds the vertices of all polygons one after another, ``counts`` (P,) how many each has.
    """
    counts = np.asarray(counts, dtype=np.int64)
    pieces = np.maximum(counts - 2, 0)
    start = np.repeat(np.cumsum(counts) - counts, pieces)
    step = np.arange(pieces.sum()) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    return np.stack([corners[start], corners[start + step + 1], corners[start + step + 2]], axis=1)


def read_obj(data: bytes) -> RawMesh:
    """Read the vertices and polygons of a Wavefront OBJ file; texture, normals and groups are left out."""
    text = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n").replace(b"\\\n", b"  ")
    text = re.sub(rb"#[^\n]*", b"", text)
    points = list(re.finditer(rb"^[ \t]*v[ \t]+(.*)$", text, re.MULTILINE))
    polygons = list(re.finditer(rb"^[ \t]*f[ \t]+(.*)$", text, re.MULTILINE))
    if not points:
        raise MeshError("it has no vertex lines ('v x y z')")
    rows = [match[1].split()[:3] for match in points]
    vertices = _coordinates(rows, lambda row: _line(text, points[row].start()))
    if not polygons:
        return RawMesh(vertices, np.empty((0, 3), dtype=np.int64))

    names = [re.sub(rb"/\S*", b"", match[1]).split() for match in polygons]
    counts = np.array([len(name) for name in names], dtype=np.int64)
    if (counts < 3).any():
        line = _line(text, polygons[int(np.flatnonzero(counts < 3)[0])].start())
        raise MeshError(f"line {line}: a face needs three vertices or more")
    corners = _integers(names, lambda row: _line(text, polygons[row].start()))
    seen = np.searchsorted([match.start() for match in points], [match.start() for match in polygons])
    before = np.repeat(seen, counts)  # a relative index counts back from the last vertex above its line
    index = np.where(corners > 0, corners - 1, before + corners)
    wrong = (corners == 0) | (index < 0) | (index >= len(vertices))
    if wrong.any():
        first = int(np.flatnonzero(wrong)[0])
        row = int(np.repeat(np.arange(len(counts)), counts)[first])
        line = _line(text, polygons[row].start())
        raise MeshError(
            f"line {line}: a face names vertex {corners[first]}, but the file has vertices 1..{len(vertices)}"
        )
    return RawMesh(vertices, fan_triangles(index, counts))


def read_off(data: bytes) -> RawMesh:
    """Read an OFF file, also with normals, colours or texture coordinates (NOFF, COFF, STOFF), as text."""
    lines = re.sub(rb"#[^\r\n]*", b"", data).splitlines()
    numbered = [(number, line) for number, line in enumerate(lines, start=1) if line.strip()]
    head = re.match(rb"\s*(?:ST)?C?N?OFF\b(.*)", numbered[0][1]) if numbered else None
    if head is None:
        raise MeshError("it does not begin with the word OFF")
    if head[1].strip().upper().startswith(b"BINARY"):
        raise MeshError("it is a binary OFF file; save it as text, or as PLY")
    body = [(numbered[0][0], head[1]), *numbered[1:]] if head[1].strip() else numbered[1:]
    try:
        n_vertices, n_faces = (int(word) for word in body[0][1].split()[:2])
    except (IndexError, ValueError) as error:
        raise MeshError("the numbers of vertices and faces are missing after the word OFF") from error
    if n_vertices < 0 or n_faces < 0 or len(body) < 1 + n_vertices + n_faces:
        raise MeshError(
            f"it announces {n_vertices} vertices and {n_faces} faces, but has {len(body) - 1} lines "
            "for them (cut short)"
        )
    points, polygons = body[1 : 1 + n_vertices], body[1 + n_vertices : 1 + n_vertices + n_faces]
    vertices = _coordinates([line.split()[:3] for _, line in points], lambda row: points[row][0])

    words = [line.split() for _, line in polygons]
    counts = _integers([word[:1] for word in words], lambda row: polygons[row][0])
    present = np.array([len(word) - 1 for word in words], dtype=np.int64)
    if (counts < 3).any() or (present < counts).any():
        row = int(np.flatnonzero((counts < 3) | (present < counts))[0])
        raise MeshError(
            f"line {polygons[row][0]}: a face announces {counts[row]} vertices and names {present[row]}, "
            "and it needs three or more"
        )
    names = [word[1 : 1 + count] for word, count in zip(words, counts.tolist(), strict=True)]
    corners = _integers(names, lambda row: polygons[row][0])
    return RawMesh(vertices, fan_triangles(corners, counts))


def read_stl(data: bytes) -> RawMesh:
    """Read an STL file, binary or text: three vertices per triangle, none shared."""
    announced = int.from_bytes(data[80:84], "little") if len(data) >= 84 else -1
    expected = 84 + announced * _STL_TRIANGLE.itemsize
    # a binary file may begin with the word "solid" too, so its length decides
    if announced >= 0 and len(data) == expected:
        return _separate(np.frombuffer(data, _STL_TRIANGLE, offset=84)["corners"].astype(np.float64))
    text = data.lower()
    if text.lstrip().startswith(b"solid") and b"facet" in text:
        return _read_stl_text(text)
    if announced < 0:
        raise MeshError("it is shorter than the header of an STL file")
    raise MeshError(
        f"its header announces {announced} triangles ({expected} bytes), but the file has {len(data)} bytes"
    )


def _read_stl_text(text: bytes) -> RawMesh:
    if b"endsolid" not in text[text.rfind(b"facet") :]:
        raise MeshError("it ends before the line 'endsolid' (cut short)")
    rows = [words.split() for words in re.findall(rb"\bvertex\b([^\r\n]*)", text)]
    facets = len(re.findall(rb"\bfacet\s+normal\b", text))
    if len(rows) != 3 * facets:
        raise MeshError(f"it has {facets} facets, but {len(rows)} vertices instead of {3 * facets}")
    places = [match.start() for match in re.finditer(rb"\bvertex\b", text)]
    return _separate(_coordinates(rows, lambda row: _line(text, places[row])).reshape(-1, 3, 3))


def _separate(corners: Vectors) -> RawMesh:
    vertices = corners.reshape(-1, 3)
    return RawMesh(vertices, np.arange(len(vertices), dtype=np.int64).reshape(-1, 3))


def _line(text: bytes, position: int) -> int:
    return text.count(b"\n", 0, position) + 1


def _coordinates(rows: list[list[bytes]], line_of: Callable[[int], int]) -> Vectors:
    if not rows:
        return np.empty((0, 3))
    try:
        return np.array(rows, dtype=np.float64).reshape(-1, 3)
    except ValueError:
        for row, words in enumerate(rows):
            if len(words) != 3 or not all(map(_is_number, words)):
                raise MeshError(
                    f"line {line_of(row)}: a vertex needs three numbers, not {_quoted(words)}"
                ) from None
        raise


def _integers(rows: list[list[bytes]], line_of: Callable[[int], int]) -> Indices:
    words = [word for row in rows for word in row]
    try:
        return np.array([int(word) for word in words], dtype=np.int64)
    except (ValueError, OverflowError):
        for row, names in enumerate(rows):
            if not all(re.fullmatch(rb"[+-]?\d{1,18}", name) for name in names):
                raise MeshError(
                    f"line {line_of(row)}: a face needs whole numbers, not {_quoted(names)}"
                ) from None
        raise


def _is_number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _quoted(words: list[bytes]) -> str:
    text = b" ".join(words).decode("utf-8", "replace")[:40]
    return "'" + "".join(letter if letter.isprintable() else "?" for letter in text) + "'"
