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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geoweave.arrays import Indices, Vectors
from geoweave.errors import MeshError
from geoweave.meshing.polygons import RawMesh, triangulated
from geoweave.wording import counted

_POINT = re.compile(rb"^[ \t]*v(?!\S)(.*)$", re.MULTILINE)
_POLYGON = re.compile(rb"^[ \t]*f(?!\S)(.*)$", re.MULTILINE)
_OFF_WORD = re.compile(rb"\s*(?:ST|st)?[Cc]?(?:N|n(?=off))?(4n?|n)?(?:OFF|off|Off)")
_STL_SOLID = re.compile(
    rb"^([ \t]*(?:end)?solid\b)((?:(?!\bfacet\s+normal\s+(?:[-+.\d]|nan|inf))[^\n])*)", re.MULTILINE
)
_STL_MOST = 2**31
"""A count above this was never filled in."""

_STL_NAME = 80
"""Bytes of the header of a binary STL file before the count."""

_STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_obj(data: bytes) -> RawMesh:
    """Read the vertices and polygons of a Wavefront OBJ file; texture, normals and groups are left out."""
    text = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n").replace(b"\\\n", b"  ")
    text = _without_comments(text)
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
            f"it seems cut short: its last line has no end, and {unused:,} of "
            f"{counted(len(vertices), 'vertex')} "
            "belong to no face; get the whole file, or end the last line if it is meant so"
        )
    return RawMesh(vertices, triangulated(vertices, index, counts))


def read_off(data: bytes) -> RawMesh:
    """Read an OFF file, also with normals, colours or texture coordinates (NOFF, COFF, STOFF), as text.

    Each vertex and each face has a line of its own. A file without such extras may instead break its lines
    anywhere. The word OFF may be missing, written small, or followed by the counts at once.
    """
    # ModelNet's files have the counts directly behind the word.
    text = _OFF_WORD.sub(lambda word: word[0] + b" ", _without_comments(data), count=1)
    lines = enumerate(text.splitlines(), start=1)
    rows = [(number, words) for number, line in lines if (words := line.split())]
    flow = _after_the_word_off(list(chain.from_iterable(words for _, words in rows)))
    counts = _parsed(flow[:2], np.int64)
    if counts is None or len(counts) < 2:
        raise MeshError("the numbers of vertices and faces are missing after the word OFF")
    n_vertices, n_faces = counts.tolist()
    if n_vertices < 0 or n_faces < 0:
        raise MeshError(f"it announces {counted(n_vertices, 'vertex')} and {counted(n_faces, 'face')}")
    alone = len(rows[0][1]) == 1  # the word stands on a line of its own
    try:
        return _off_by_lines(rows[2 if alone else 1 :], n_vertices, n_faces)
    except MeshError:
        free = _off_as_a_flow(flow, n_vertices, n_faces)
        if free is None:
            raise
        return free


def _after_the_word_off(words: list[bytes]) -> list[bytes]:
    """The words of an OFF file behind its first one, which may be missing; refuse other kinds of OFF."""
    word = _OFF_WORD.fullmatch(words[0]) if words else None
    if word is None:
        if _parsed(words[:1], np.int64) is not None and words:
            return words
        raise MeshError("it does not begin with the word OFF")
    if word[1]:
        raise MeshError(
            "its vertices have another number of coordinates than three (4OFF, nOFF); save it as OFF"
        )
    if words[1:] and words[1].upper() == b"BINARY":
        raise MeshError("it is a binary OFF file; save it as text, or as PLY")
    return words[1:]


def _off_by_lines(body: list[tuple[int, list[bytes]]], n_vertices: int, n_faces: int) -> RawMesh:
    """Read a line for each vertex and each face; what follows on a line (normals, colours) is left out."""
    if len(body) < n_vertices + n_faces:
        raise MeshError(
            f"it announces {counted(n_vertices, 'vertex')} and {counted(n_faces, 'face')}, but has "
            f"{counted(len(body), 'line')} "
            "for them (cut short)"
        )
    points, polygons = body[:n_vertices], body[n_vertices : n_vertices + n_faces]
    vertices = _coordinates([words[:3] for _, words in points], lambda row: points[row][0])
    counts = _integers([words[:1] for _, words in polygons], lambda row: polygons[row][0])
    present = np.array([len(words) - 1 for _, words in polygons], dtype=np.int64)
    if (counts < 3).any() or (present < counts).any():
        row = int(np.flatnonzero((counts < 3) | (present < counts))[0])
        raise MeshError(
            f"line {polygons[row][0]}: a face announces {counted(counts[row], 'vertex')} and names "
            f"{present[row]}, and it needs three or more"
        )
    names = [words[1 : 1 + count] for (_, words), count in zip(polygons, counts.tolist(), strict=True)]
    corners = _integers(names, lambda row: polygons[row][0])
    return RawMesh(vertices, triangulated(vertices, corners, counts))


def _off_as_a_flow(words: list[bytes], n_vertices: int, n_faces: int) -> RawMesh | None:
    """Read words broken into lines anywhere; None if they are not just the counts, vertices and faces."""
    body = words[3:]
    if len(words) < 3 or len(body) < 3 * n_vertices + 4 * n_faces:
        return None
    vertices = _parsed(body[: 3 * n_vertices], np.float64)
    rest = _parsed(body[3 * n_vertices :], np.int64)
    if vertices is None or rest is None:
        return None
    starts, counts, at = [], [], 0
    for _ in range(n_faces):
        if at >= len(rest) or not 3 <= rest[at] < len(rest) - at:
            return None
        starts.append(at + 1)
        counts.append(int(rest[at]))
        at += 1 + counts[-1]
    if at != len(rest):
        return None
    chosen = [np.arange(start, start + count) for start, count in zip(starts, counts, strict=True)]
    corners = rest[np.concatenate(chosen)] if chosen else np.zeros(0, dtype=np.int64)
    points = vertices.reshape(-1, 3)
    return RawMesh(points, triangulated(points, corners, np.array(counts, dtype=np.int64)))


def read_stl(data: bytes) -> RawMesh:
    """Read an STL file, binary or text: three vertices per triangle, none shared.

    A binary file may hold more than its header announces. Bytes that make up whole triangles are triangles,
    any others are left out, and a note says so. A file that holds less is cut short, unless its count was
    never filled in.
    """
    size, head = _STL_TRIANGLE.itemsize, 84
    announced = int.from_bytes(data[80:84], "little") if len(data) >= head else -1
    expected = head + announced * size
    # A binary file may begin with the word "solid" too, so its length decides.
    if announced >= 0 and len(data) == expected:
        return _stl_triangles(data, announced)
    text = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n").lower()
    if text.lstrip().startswith(b"solid") and b"facet" in text and b"\x00" not in text[:_STL_NAME]:
        return _read_stl_text(text)
    if announced < 0:
        raise MeshError("it is shorter than the header of an STL file")
    held, left = divmod(len(data) - head, size)
    if left == 0 and (held > announced or announced > _STL_MOST) and held:
        note = f"its header announces {counted(announced, 'triangle')}; all {held:,} that it holds were read"
        return _stl_triangles(data, held, note)
    if 0 < announced <= held:
        left_out = counted(len(data) - expected, "byte", "was were")
        note = f"{left_out} left out after its {counted(announced, 'triangle')}"
        return _stl_triangles(data, announced, note)
    raise MeshError(
        f"its header announces {counted(announced, 'triangle')} ({counted(expected, 'byte')}), but the "
        f"file has {counted(len(data), 'byte')}"
    )


def _stl_triangles(data: bytes, count: int, *notes: str) -> RawMesh:
    """The first triangles of a binary STL file."""
    rows = np.frombuffer(data, _STL_TRIANGLE, count=count, offset=84)
    return _separate(rows["corners"].astype(np.float64), *notes)


def _read_stl_text(text: bytes) -> RawMesh:
    # The name of the model may hold any words; they are blanked, so that places in the text stay.
    body = _STL_SOLID.sub(lambda match: match[1] + b" " * len(match[2]), text)
    if b"endsolid" not in body[body.rfind(b"facet") :]:
        raise MeshError("it ends before the line 'endsolid' (cut short)")
    rows = [words.split() for words in re.findall(rb"\bvertex\b([^\n]*)", body)]
    facets = len(re.findall(rb"\bfacet\s+normal\b", body))
    if len(rows) != 3 * facets:
        raise MeshError(
            f"it has {counted(facets, 'facet')}, but {counted(len(rows), 'vertex')} instead of {3 * facets}"
        )
    places = [match.start() for match in re.finditer(rb"\bvertex\b", body)]
    return _separate(_coordinates(rows, lambda row: _line(text, places[row])).reshape(-1, 3, 3))


def _separate(corners: Vectors, *notes: str) -> RawMesh:
    """Triangles that share no vertex."""
    vertices = corners.reshape(-1, 3)
    return RawMesh(vertices, np.arange(len(vertices), dtype=np.int64).reshape(-1, 3), notes)


def _without_comments(text: bytes) -> bytes:
    return re.sub(rb"#[^\r\n]*", b"", text)


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
