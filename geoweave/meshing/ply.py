"""PLY bytes as arrays: text or binary in either byte order, with polygons of any number of corners."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from geoweave.arrays import Indices, Triangles, Vectors
from geoweave.compiled import compiled
from geoweave.errors import MeshError
from geoweave.meshing.polygons import RawMesh, triangulated

_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "int64": "i8", "uint64": "u8", "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
_Order = Literal["=", "<", ">"]
_BYTE_ORDERS: dict[str, _Order] = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}


class _Property(NamedTuple):
    name: str
    kind: str
    count_kind: str  # empty for a scalar


@dataclass(frozen=True)
class _Element:
    name: str
    rows: int
    properties: tuple[_Property, ...]

    def place(self, *names: str) -> int:
        """Position of the first property that has one of the names, -1 without."""
        return next((k for k, one in enumerate(self.properties) if one.name in names), -1)


def read_ply(data: bytes) -> RawMesh:
    """Read the vertices and the faces of a PLY file; other elements and properties are left out."""
    order, elements, body = _read_header(data)
    source = _Tokens(data[body:]) if order == "=" else _Bytes(data[body:], order)
    vertices, corners, counts = None, np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
    strips: list[Triangles] = []
    for element in elements:
        source.require(element)
        if element.name == "vertex":
            vertices = source.points(element)
        elif element.name == "face":
            corners, counts = source.polygons(element)
        elif element.name == "tristrips" and element.rows:
            strips.append(_strip_triangles(*source.polygons(element)))
        else:
            source.skip(element)
    if vertices is None:
        raise MeshError("its header announces no vertices")
    if (counts < 3).any():
        raise MeshError(f"face {int(np.flatnonzero(counts < 3)[0])} has fewer than three vertices")
    return RawMesh(vertices, np.concatenate([triangulated(vertices, corners, counts), *strips]))


def _strip_triangles(corners: Indices, counts: Indices) -> Triangles:
    """Triangles of strips: three corners in a row each, every second one turned; -1 begins a new strip."""
    ends = np.zeros(len(corners) + 1, dtype=bool)
    ends[np.cumsum(counts)] = True
    strip = np.cumsum(ends[:-1] | (corners == -1))
    # The place in its own strip decides which way a triangle turns.
    begin = np.searchsorted(strip, strip) + (corners[np.searchsorted(strip, strip)] == -1)
    place = np.arange(len(corners)) - begin
    a, b, c = corners[:-2], corners[1:-1], corners[2:]
    whole = (strip[:-2] == strip[2:]) & (a != -1)
    turned = place[:-2] % 2 == 1
    triangles = np.stack([np.where(turned, b, a), np.where(turned, a, b), c], axis=1)[whole]
    return triangles[(triangles != np.roll(triangles, 1, axis=1)).all(axis=1)]


def _read_header(data: bytes) -> tuple[_Order, list[_Element], int]:
    """Byte order ("=" for text), elements, and where the data begin."""
    last = re.search(rb"[\r\n]end_header[ \t]*(\r\n|\n|\r|$)", data)
    if not data.startswith(b"ply") or last is None:
        raise MeshError("it does not begin with a PLY header from 'ply' to 'end_header'")
    end, body = last.start(), last.end()
    if last[1] == b"\r\n" and not data.startswith(b"ply\r\n"):
        body -= 1  # lines end with a carriage return alone; the next byte belongs to the data
    if not last[1]:
        raise MeshError("it ends with its header")
    order: _Order | None = None
    elements: list[_Element] = []
    for number, line in enumerate(data[:end].decode("latin-1").splitlines(), start=1):
        words = line.split()
        try:
            match words:
                case ["format", name, *_]:
                    order = _BYTE_ORDERS[name]
                case ["element", name, count]:
                    if int(count) < 0:
                        raise ValueError
                    elements.append(_Element(name, int(count), ()))
                case ["property", "list", count_kind, kind, name]:
                    elements[-1] = _extended(elements[-1], _Property(name, _TYPES[kind], _TYPES[count_kind]))
                case ["property", kind, name]:
                    elements[-1] = _extended(elements[-1], _Property(name, _TYPES[kind], ""))
        except (KeyError, IndexError, ValueError) as error:
            raise MeshError(f"line {number} of its header is not understood") from error
    if order is None:
        raise MeshError("its header names no format")
    return order, elements, body


def _extended(element: _Element, one: _Property) -> _Element:
    return _Element(element.name, element.rows, (*element.properties, one))


class _Tokens:
    """The data of a text file as one row of numbers."""

    unit = "numbers"

    def __init__(self, body: bytes) -> None:
        try:
            self.units: NDArray[Any] = np.array(body.split(), dtype=np.float64)
        except ValueError as error:
            raise MeshError("its data hold a word that is not a number") from error
        self.at = 0

    def sizes(self, one: _Property) -> tuple[int, int]:
        """Units that the count of a list (0 for a scalar) and one value take."""
        return (1 if one.count_kind else 0), 1

    def decode(self, place: Indices, kind: str) -> NDArray[Any]:
        """Values of the given kind that begin at the given units."""
        return self.units[place]

    @property
    def big_endian(self) -> bool:
        """Whether the first unit of a count weighs most."""
        return False

    def require(self, element: _Element) -> None:
        """Refuse an element whose rows cannot fit into what is left, before anything is allocated."""
        sizes = [self.sizes(one) for one in element.properties]
        least = element.rows * sum(count or value for count, value in sizes)
        if least > len(self.units) - self.at:
            raise MeshError(
                f"it announces {element.rows} of '{element.name}', which need {least} {self.unit}, "
                f"but {len(self.units) - self.at} are left (cut short)"
            )

    def points(self, element: _Element) -> Vectors:
        """(V, 3) coordinates of the vertex element, and step over it."""
        columns = [element.place(axis) for axis in "xyz"]
        if min(columns) < 0 or any(one.count_kind for one in element.properties):
            raise MeshError("its vertices lack x, y or z")
        sizes = [self.sizes(one)[1] for one in element.properties]
        offsets = np.cumsum([0, *sizes])
        first = self.at + np.arange(element.rows, dtype=np.int64) * int(offsets[-1])
        self.at += element.rows * int(offsets[-1])
        values = [self.decode(first + int(offsets[k]), element.properties[k].kind) for k in columns]
        return np.stack(values, axis=1).astype(np.float64)

    def polygons(self, element: _Element) -> tuple[Indices, Indices]:
        """Vertices of all faces one after another, and how many each face has; steps over the element."""
        wanted = element.place("vertex_indices", "vertex_index")
        if element.rows == 0:
            return np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64)
        if wanted < 0 or not element.properties[wanted].count_kind:
            raise MeshError("its faces have no list 'vertex_indices'")
        starts, counts = self.scan(element, wanted)
        one = element.properties[wanted]
        size = self.sizes(one)[1]
        step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        values = self.decode(np.repeat(starts, counts) + size * step, one.kind)
        if not (np.abs(values) < 2.0**53).all() or (values != np.floor(values)).any():
            raise MeshError("a face names a vertex by something that is not a whole number")
        return values.astype(np.int64), counts

    def skip(self, element: _Element) -> None:
        """Step over an element."""
        if element.rows and element.properties:
            self.scan(element, -1)

    def scan(self, element: _Element, wanted: int) -> tuple[Indices, Indices]:
        """Where the wanted list of each row begins and how long it is; steps over the element."""
        sizes = np.array([self.sizes(one) for one in element.properties], dtype=np.int64)
        starts, counts, self.at = _scan_rows(
            self.units, self.at, element.rows, sizes, wanted, self.big_endian
        )
        if self.at < 0:
            raise MeshError(f"it ends inside the element '{element.name}' (cut short)")
        return starts, counts


class _Bytes(_Tokens):
    """The data of a binary file."""

    unit = "bytes"

    def __init__(self, body: bytes, order: Literal["<", ">"]) -> None:
        self.units = np.frombuffer(body, dtype=np.uint8)
        self.order: Literal["<", ">"] = order
        self.at = 0

    def sizes(self, one: _Property) -> tuple[int, int]:
        """Bytes that the count of a list (0 for a scalar) and one value take."""
        return (np.dtype(one.count_kind).itemsize if one.count_kind else 0), np.dtype(one.kind).itemsize

    def decode(self, place: Indices, kind: str) -> NDArray[Any]:
        """Values of the given kind that begin at the given bytes."""
        size = np.dtype(kind).itemsize
        gathered: NDArray[Any] = self.units[place[:, None] + np.arange(size)].reshape(-1)
        return gathered.view(np.dtype(kind).newbyteorder(self.order))

    @property
    def big_endian(self) -> bool:
        """Whether the first byte of a count weighs most."""
        return self.order == ">"


@compiled
def _scan_rows(
    units: NDArray[Any], at: int, rows: int, sizes: Indices, wanted: int, big_endian: bool
) -> tuple[Indices, Indices, int]:
    """Walk over rows, each of which says how long its lists are; the position is -1 if the data end early.

    Return where the wanted list of each row begins, how long it is, and the position after the last row.
    """
    starts, counts = np.zeros(rows, dtype=np.int64), np.zeros(rows, dtype=np.int64)
    for row in range(rows):
        for k in range(len(sizes)):
            count_size, size = sizes[k]
            if at + count_size > len(units):
                return starts, counts, -1
            count = 1.0 if count_size == 0 else 0.0
            for byte in range(count_size):
                place = count_size - 1 - byte if big_endian else byte
                count += float(units[at + byte]) * 256.0**place
            at += count_size
            if not 0.0 <= count <= (len(units) - at) / size:
                return starts, counts, -1
            if k == wanted:
                starts[row], counts[row] = at, int(count)
            at += int(count) * size
    return starts, counts, at
