"""3MF files: units, placements, objects made of objects, and what is refused."""

import io
import zipfile

import numpy as np
import pytest
from meshfiles import octahedron

from geoweave.errors import MeshError
from geoweave.meshing.prepare import read_mesh
from geoweave.meshing.threemf import read_3mf

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
PRODUCTION = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06"
RELATION = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"
POINTS, FACES = octahedron()


def solid(number: int) -> str:
    vertices = "".join('<vertex x="{}" y="{}" z="{}"/>'.format(*point) for point in POINTS)
    triangles = "".join('<triangle v1="{}" v2="{}" v3="{}"/>'.format(*face) for face in FACES)
    return (
        f'<object id="{number}" type="model"><mesh><vertices>{vertices}</vertices>'
        f"<triangles>{triangles}</triangles></mesh></object>"
    )


def model(objects: str, items: str, unit: str = "millimeter") -> str:
    return (
        f'<?xml version="1.0"?><model unit="{unit}" xmlns="{CORE}" xmlns:p="{PRODUCTION}">'
        f"<resources>{objects}</resources><build>{items}</build></model>"
    )


def packed(text: str, **others: str) -> bytes:
    buffer = io.BytesIO()
    relations = f'<Relationships><Relationship Type="{RELATION}" Target="/3D/a.model"/></Relationships>'
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr("_rels/.rels", relations)
        archive.writestr("3D/a.model", text)
        for name, other in others.items():
            archive.writestr(f"3D/{name}.model", other)
    return buffer.getvalue()


@pytest.mark.parametrize(("unit", "length"), [("millimeter", 1.0), ("inch", 25.4), ("micron", 1e-3)])
def test_lengths_come_out_in_millimetres(unit, length):
    raw = read_3mf(packed(model(solid(1), '<item objectid="1"/>', unit)))
    assert np.allclose(raw.vertices, length * POINTS)
    assert raw.faces.tolist() == FACES.tolist()
    assert bool(raw.notes) == (unit != "millimeter")


def test_an_item_is_scaled_turned_and_moved():
    """Points are rows: the first nine numbers are the images of the axes, the last three the shift."""
    raw = read_3mf(
        packed(model(solid(1), '<item objectid="1" transform="0 2 0 -2 0 0 0 0 2 10 0 0"/>', "centimeter"))
    )
    x, y, z = POINTS.T
    assert np.allclose(raw.vertices, 10 * np.stack([10 - 2 * y, 2 * x, 2 * z], axis=1))


def test_placements_of_parts_come_before_those_of_the_whole():
    pair = (
        '<object id="2"><components><component objectid="1" transform="1 0 0 0 1 0 0 0 1 5 0 0"/>'
        '<component objectid="1"/></components></object>'
    )
    raw = read_3mf(packed(model(solid(1) + pair, '<item objectid="2" transform="3 0 0 0 3 0 0 0 3 0 0 1"/>')))
    assert np.allclose(raw.vertices, np.concatenate([3 * (POINTS + [5, 0, 0]), 3 * POINTS]) + [0, 0, 1])
    assert len(raw.faces) == 16


def test_a_part_may_stand_in_a_document_of_its_own(tmp_path):
    outer = '<object id="7"><components><component objectid="1" p:path="/3D/b.model"/></components></object>'
    path = tmp_path / "mesh.3mf"
    path.write_bytes(packed(model(outer, '<item objectid="7"/>'), b=model(solid(1), "")))
    assert read_mesh(path).mesh.n_faces == 8


def test_supports_are_left_out():
    support = solid(2).replace('type="model"', 'type="support"')
    raw = read_3mf(packed(model(solid(1) + support, '<item objectid="1"/><item objectid="2"/>')))
    assert len(raw.faces) == 8


CIRCLE = '<object id="1"><components><component objectid="1"/></components></object>'


def twice(number: int) -> str:
    part = f'<component objectid="{number + 1}"/>'
    return f'<object id="{number}"><components>{part}{part}</components></object>'


DOUBLE = "".join(twice(k) for k in range(1, 30))
ITEM = '<item objectid="1"/>'


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (packed(model(solid(1), "")), "no item to build"),
        (packed(model(solid(1), '<item objectid="9"/>')), "object 9 is missing"),
        (packed(model(solid(1), '<item objectid="1"/>', "ell")), "unit 'ell' is unknown"),
        (packed(model(solid(1), '<item objectid="1" transform="1 2"/>')), "has not 12 numbers"),
        (
            packed(model(solid(1).replace('v1="0"', 'v1="99"'), '<item objectid="1"/>')),
            "vertex that is not there",
        ),
        (packed(model(solid(1).replace('x="1.0"', 'x="one"'), '<item objectid="1"/>')), "not understood"),
        (packed(model(CIRCLE, '<item objectid="1"/>')), "contain each other"),
        (packed(model(DOUBLE + solid(30), '<item objectid="1"/>')), "more than 100,000 objects"),
        (packed(model(solid(1), '<item objectid="1"/>')[:-9]), "no XML"),
        (packed('<!DOCTYPE x [<!ENTITY a "b">]>' + model(solid(1), "")[21:]), "document type"),
        (packed(model(solid(1), '<item objectid="1"/>'))[:-40], "damaged or cut short"),
    ],
)
def test_refusals(data, says):
    with pytest.raises(MeshError, match=says):
        read_3mf(data)
