"""3MF bytes as arrays, in millimetres (3MF Core Specification 1.3, sections 3 and 4).

A 3MF file is a zip archive. One XML document in it lists objects, each a mesh or made of other objects, and
the items to be built. Items and parts of objects are placed by a 4 x 3 matrix M, which maps a row
``(x, y, z, 1)`` to ``(x, y, z, 1) M``. Some programs keep each object in a document of its own (Production
Extension 1.1).
"""

from __future__ import annotations

import io
import zipfile
from dataclasses import dataclass, field
from xml.etree import ElementTree as xml

import numpy as np

from geoweave.arrays import Vectors
from geoweave.errors import MeshError
from geoweave.meshing.polygons import RawMesh

MILLIMETRES = {
    "micron": 1e-3,
    "millimeter": 1.0,
    "centimeter": 10.0,
    "inch": 25.4,
    "foot": 304.8,
    "meter": 1000.0,
}
"""Length of each unit of a 3MF file."""

DEEPEST = 32
"""Objects made of objects, made of objects: at most so many deep. A file that goes on is a circle."""

MOST_BYTES = 2 * 1024**3
"""A document in the archive may have so many bytes unpacked."""

MOST_PLACED = 100_000
"""At most so many objects may be placed: small files can ask for any number."""

MOST_VERTICES = 50_000_000
"""At most so many vertices may be placed."""

_PART = "{http://schemas.microsoft.com/3dmanufacturing/production/2015/06}path"
_RELATION = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"


def read_3mf(data: bytes) -> RawMesh:
    """Read all items that a 3MF file wants built, each where it is placed, in millimetres."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            package = _Package(archive)
            package.add_items()
    except (zipfile.BadZipFile, EOFError, NotImplementedError, RuntimeError) as error:
        raise MeshError("its archive is damaged or cut short") from error
    except xml.ParseError as error:
        raise MeshError(f"its model is no XML ({error})") from error
    if not package.points:
        raise MeshError("it has no item to build")
    unit = package.unit
    note = () if unit == "millimeter" else (f"lengths were converted from {unit} to millimetres",)
    return RawMesh(np.concatenate(package.points), np.concatenate(package.faces), note)


@dataclass
class _Package:
    """The documents of an archive as far as they have been read, and the mesh put together so far."""

    archive: zipfile.ZipFile
    documents: dict[str, xml.Element] = field(default_factory=dict)
    points: list[Vectors] = field(default_factory=list)
    faces: list[np.ndarray] = field(default_factory=list)
    placed: int = 0
    count: int = 0
    unit: str = "millimeter"

    def document(self, path: str) -> xml.Element:
        """The root of a document; read once."""
        path = path.lstrip("/")
        if path not in self.documents:
            try:
                entry = self.archive.getinfo(path)
            except KeyError:
                raise MeshError(f"its part '{path}' is missing") from None
            if entry.file_size > MOST_BYTES:
                raise MeshError(f"its part '{path}' unpacks to more than {MOST_BYTES / 1024**3:.0f} GB")
            text = self.archive.read(entry)
            if b"<!DOCTYPE" in text:
                raise MeshError("its model has a document type, which 3MF forbids")
            self.documents[path] = xml.fromstring(text)
        return self.documents[path]

    def start(self) -> str:
        """The path of the document with the items to build."""
        for relation in self.document("_rels/.rels"):
            if relation.get("Type") == _RELATION:
                return str(relation.get("Target"))
        raise MeshError("it names no 3D model")

    def add_items(self) -> None:
        """Put the items together."""
        path = self.start()
        model = self.document(path)
        self.unit = model.get("unit", "millimeter")
        if self.unit not in MILLIMETRES:
            raise MeshError(f"its unit '{self.unit}' is unknown")
        scale = np.diag([MILLIMETRES[self.unit]] * 3)
        for item in _each(model, "build", "item"):
            self.add(item, path, np.concatenate([scale, np.zeros((1, 3))]), DEEPEST)

    def add(self, reference: xml.Element, path: str, placed: Vectors, depth: int) -> None:
        """Add the object that an item or component names, placed by its own matrix and then by `placed`."""
        self.placed += 1
        if depth == 0:
            raise MeshError("its objects contain each other")
        if self.placed > MOST_PLACED or self.count > MOST_VERTICES:
            raise MeshError(f"it places more than {MOST_PLACED:,} objects or {MOST_VERTICES:,} vertices")
        path = reference.get(_PART, path)
        placed = _matrix(reference) @ placed[:3] + np.concatenate([np.zeros((3, 3)), placed[3:]])
        wanted = reference.get("objectid")
        found = next(
            (one for one in _each(self.document(path), "resources", "object") if one.get("id") == wanted),
            None,
        )
        if found is None:
            raise MeshError(f"its object {wanted} is missing")
        if found.get("type", "model") not in ("model", "surface"):
            return  # a support is not part of the model
        for component in _each(found, "components", "component"):
            self.add(component, path, placed, depth - 1)
        vertices = list(_each(found, "mesh/vertices", "vertex"))
        if not vertices:
            return
        try:
            points = np.array([[v.attrib["x"], v.attrib["y"], v.attrib["z"]] for v in vertices]).astype(
                np.float64
            )
            corners = [
                [t.attrib["v1"], t.attrib["v2"], t.attrib["v3"]]
                for t in _each(found, "mesh/triangles", "triangle")
            ]
            faces = np.array(corners).reshape(-1, 3).astype(np.int64)
        except (KeyError, ValueError, OverflowError) as error:
            raise MeshError(f"a vertex or triangle of its object {wanted} is not understood") from error
        if faces.size and not 0 <= faces.min() <= faces.max() < len(points):
            raise MeshError(f"a triangle of its object {wanted} names a vertex that is not there")
        self.points.append(points @ placed[:3] + placed[3])
        self.faces.append(faces + self.count)
        self.count += len(points)


def _each(parent: xml.Element, folder: str, name: str) -> list[xml.Element]:
    """The elements of a name inside a folder of elements, whatever their namespace."""
    return parent.findall("/".join(f"{{*}}{step}" for step in (*folder.split("/"), name)))


def _matrix(reference: xml.Element) -> Vectors:
    """(4, 3) matrix of a placement; the identity where none is given."""
    text = reference.get("transform")
    if text is None:
        return np.eye(4, 3)
    try:
        return np.array(text.split(), dtype=np.float64).reshape(4, 3)
    except ValueError as error:
        raise MeshError(f"its placement '{text[:40]}' has not 12 numbers") from error
