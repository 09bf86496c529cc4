import numpy as np
import pytest
from meshfiles import encode, octahedron

from geoweave.errors import MeshError
from geoweave.meshing.ply import read_ply


@pytest.mark.parametrize("kind", ["ply", "ply-little", "ply-big"])
def test_every_byte_order_keeps_every_digit(kind):
    points, faces = octahedron()
    points = points * np.pi + 1e6 / 3
    raw = read_ply(encode(kind, points, faces))
    np.testing.assert_array_equal(raw.vertices, points)
    np.testing.assert_array_equal(raw.faces, faces)


def binary(order):
    """A square and a triangle, with colours, a second list per face, and an element in between."""
    name = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    header = (
        f"ply\nformat {name} 1.0\nelement vertex 5\nproperty uchar red\nproperty float y\nproperty float x\n"
        "property float z\nelement note 2\nproperty list ushort char words\nelement face 2\n"
        "property list uchar float uv\nproperty list int uint vertex_index\n"
        "property short material\nend_header\n"
    ).encode()
    vertices = np.zeros(5, dtype=[("red", "u1"), ("p", order + "f4", 3)])
    vertices["p"][:, 1] = [0, 1, 1, 0, 2]
    vertices["p"][:, 0] = [0, 0, 1, 1, 0]

    def number(kind, *values):
        return np.array(values, dtype=order + kind).tobytes()

    notes = number("u2", 3) + b"abc" + number("u2", 0)
    first = b"\x01" + number("f4", 0.5) + number("i4", 4) + number("u4", 0, 1, 2, 3) + number("i2", 7)
    second = b"\x00" + number("i4", 3) + number("u4", 1, 4, 2) + number("i2", 8)
    return header, vertices.tobytes() + notes + first + second


@pytest.mark.parametrize("order", ["<", ">"])
def test_mixed_polygons_and_other_properties(order):
    raw = read_ply(b"".join(binary(order)))
    assert raw.faces.tolist() == [[0, 1, 2], [0, 2, 3], [1, 4, 2]]
    assert raw.vertices.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]]


def test_mixed_polygons_as_text():
    text = b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    text += b"element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    text += b"0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 2 1 0\n"
    assert read_ply(text).faces.tolist() == [[0, 1, 2], [0, 2, 3], [2, 1, 0]]
    assert read_ply(text.replace(b"\n", b"\r\n")).faces.tolist() == [[0, 1, 2], [0, 2, 3], [2, 1, 0]]


@pytest.mark.parametrize("cut", range(1, 60, 4))
@pytest.mark.parametrize("order", ["<", ">"])
def test_a_file_cut_anywhere_is_refused(order, cut):
    header, body = binary(order)
    with pytest.raises(MeshError, match="cut short"):
        read_ply(header + body[:-cut])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (b"format ascii 1.0\n", b"", "names no format"),
        (b"format ascii", b"format morse", "line 2 of its header"),
        (b"property double x", b"property quad x", "line 5 of its header"),
        (b"property double z", b"property double w", "lack x, y or z"),
        (b"element vertex 6", b"element vertex -6", "line 4 of its header"),
        (b"vertex_indices", b"corners", "no list 'vertex_indices'"),
        (b"element face", b"element tristrips", "triangle strips"),
        (b"\n3 0", b"\n2 0", "fewer than three"),
        (b"\n3 0", b"\n3 0.5", "not a whole number"),
        (b"\n3 0", b"\n3 nan", "not a whole number"),
        (b"\n3 0", b"\nthree 0", "not a number"),
        (b"\n3 0", b"\nnan 0", "cut short"),
        (b"end_header", b"", "PLY header"),
        (b"vertex 6", b"vertex 7", "cut short"),
        (b"vertex 6", b"vertex 600000000000", "cut short"),
    ],
)
def test_refusals(old, new, message):
    data = encode("ply", *octahedron())
    assert old in data
    with pytest.raises(MeshError, match=message):
        read_ply(data.replace(old, new, 1))
