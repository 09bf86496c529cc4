"""OBJ, OFF and STL bytes as arrays; a file that is cut short or misspelt is refused with its line.

These readers exist because a mesh that silently differs from its file is worse than an error. A general
reader leaves out the faces that a cut OFF file lacks, takes OBJ's vertex 0 for another, counts OBJ's relative
indices from the end of the file, and splits vertices where texture coordinates change.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from itertools import chain, islice
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from geoweave.arrays import Indices, Triangles, Vectors
from geoweave.errors import MeshError

_POINT = re.compile(rb"^[ \t]*v(?!\S)(.*)$", re.MULTILINE)
_POLYGON = re.compile(rb"^[ \t]*f(?!\S)(.*)$", re.MULTILINE)
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
    points, polygons = _POINT.findall(text), _POLYGON.findall(text)
    if not points:
        raise MeshError("it has no vertex lines ('v x y z')")
    rows = [words.split()[:3] for words in points]
    vertices = _coordinates(rows, lambda row: _line_of_match(_POINT, text, row))
    if not polygons:
        return RawMesh(vertices, np.empty((0, 3), dtype=np.int64))

    body = b"\n".join(polygons)
    names = [words.split() for words in re.sub(rb"/\S*", b"", body).split(b"\n")]
    counts = np.array([len(name) for name in names], dtype=np.int64)
    if (counts < 3).any():
        line = _line_of_match(_POLYGON, text, int(np.flatnonzero(counts < 3)[0]))
        raise MeshError(f"line {line}: a face needs three vertices or more")
    corners = _integers(names, lambda row: _line_of_match(_POLYGON, text, row))
    index = corners - 1
    if (corners < 0).any():
        # a relative index counts back from the last vertex above its line
        starts = [np.array([match.start() for match in one.finditer(text)]) for one in (_POINT, _POLYGON)]
        above = np.repeat(np.searchsorted(starts[0], starts[1]), counts)
        index = np.where(corners < 0, above + corners, index)
    wrong = (corners == 0) | (index < 0) | (index >= len(vertices))
    if wrong.any():
        first = int(np.flatnonzero(wrong)[0])
        line = _line_of_match(_POLYGON, text, int(np.repeat(np.arange(len(counts)), counts)[first]))
        raise MeshError(
            f"line {line}: a face names vertex {corners[first]}, but the file has vertices 1..{len(vertices)}"
        )
    # The format announces no counts. What shows that a file was cut short is a last line without an end
    # together with vertices that no face uses.
    unused = len(vertices) - len(np.unique(index))
    if not text.endswith(b"\n") and unused > 0.05 * len(vertices):
        raise MeshError(
            f"it seems cut short: its last line has no end, and {unused} of {len(vertices)} vertices "
            "belong to no face; get the whole file, or end the last line if it is meant so"
        )
    return RawMesh(vertices, fan_triangles(index, counts))


def read_off(data: bytes) -> RawMesh:
    """Read an OFF file, also with normals, colours or texture coordinates (NOFF, COFF, STOFF), as text."""
    lines = re.sub(rb"#[^\r\n]*", b"", data).splitlines()
    rows = [words for words in map(bytes.split, lines) if words]
    head = re.match(rb"(?:ST)?C?N?OFF\b", rows[0][0]) if rows else None
    if head is None:
        raise MeshError("it does not begin with the word OFF")
    if rows[0][1:] and rows[0][1].upper() == b"BINARY":
        raise MeshError("it is a binary OFF file; save it as text, or as PLY")
    first = 1 if len(rows[0]) == 1 else 0  # the counts may follow on the same line
    try:
        n_vertices, n_faces = (int(word) for word in rows[first][1 - first :][:2])
    except (IndexError, ValueError) as error:
        raise MeshError("the numbers of vertices and faces are missing after the word OFF") from error
    body = rows[first + 1 :]
    if n_vertices < 0 or n_faces < 0 or len(body) < n_vertices + n_faces:
        raise MeshError(
            f"it announces {n_vertices} vertices and {n_faces} faces, but has {len(body)} lines "
            "for them (cut short)"
        )
    points, polygons = body[:n_vertices], body[n_vertices : n_vertices + n_faces]

    def line_of(row: int) -> int:
        return [number for number, line in enumerate(lines, start=1) if line.strip()][first + 1 + row]

    vertices = _coordinates([words[:3] for words in points], line_of)
    counts = _integers([words[:1] for words in polygons], lambda row: line_of(n_vertices + row))
    present = np.array([len(words) - 1 for words in polygons], dtype=np.int64)
    if (counts < 3).any() or (present < counts).any():
        row = int(np.flatnonzero((counts < 3) | (present < counts))[0])
        raise MeshError(
            f"line {line_of(n_vertices + row)}: a face announces {counts[row]} vertices and names "
            f"{present[row]}, and it needs three or more"
        )
    names = [words[1 : 1 + count] for words, count in zip(polygons, counts.tolist(), strict=True)]
    corners = _integers(names, lambda row: line_of(n_vertices + row))
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


def _line_of_match(pattern: re.Pattern[bytes], text: bytes, row: int) -> int:
    return _line(text, next(islice(pattern.finditer(text), row, None)).start())


def _coordinates(rows: list[list[bytes]], line_of: Callable[[int], int]) -> Vectors:
    words = list(chain.from_iterable(rows))
    numbers = _parsed(words, np.float64)
    if numbers is not None and all(len(row) == 3 for row in rows):
        return numbers.reshape(-1, 3)
    row = next(k for k, row in enumerate(rows) if len(row) != 3 or _parsed(row, np.float64) is None)
    raise MeshError(f"line {line_of(row)}: a vertex needs three numbers, not {_quoted(rows[row])}")


def _integers(rows: list[list[bytes]], line_of: Callable[[int], int]) -> Indices:
    words = list(chain.from_iterable(rows))
    numbers = _parsed(words, np.int64)
    if numbers is not None:
        return numbers
    row = next(k for k, row in enumerate(rows) if _parsed(row, np.int64) is None)
    raise MeshError(f"line {line_of(row)}: a face needs whole numbers, not {_quoted(rows[row])}")


def _parsed(words: list[bytes], kind: type[np.generic]) -> NDArray[Any] | None:
    """One number per word, or None if a word is no number of this kind."""
    with warnings.catch_warnings():
        # numpy stops at the first word that is no number, and only warns about it
        warnings.simplefilter("error", DeprecationWarning)
        try:
            numbers = np.fromstring(b" ".join(words), dtype=kind, sep=" ")
        except (DeprecationWarning, ValueError):
            return None
    return numbers if len(numbers) == len(words) else None


def _quoted(words: list[bytes]) -> str:
    text = b" ".join(words).decode("utf-8", "replace")[:40]
    return "'" + "".join(letter if letter.isprintable() else "?" for letter in text) + "'"
