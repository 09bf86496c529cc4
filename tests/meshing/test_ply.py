import numpy as np
import pytest
from meshfiles import encode, octahedron

from geoweave.errors import MeshError
from geoweave.meshing.ply import read_ply
from geoweave.meshing.prepare import prepare_arrays
from geoweave.meshing.report import RepairReport


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
    text += b"0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n3 3 2 1\n"
    assert read_ply(text).faces.tolist() == [[0, 1, 2], [0, 2, 3], [3, 2, 1]]
    assert read_ply(text.replace(b"\n", b"\r\n")).faces.tolist() == [[0, 1, 2], [0, 2, 3], [3, 2, 1]]


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


def strip_file(*rows):
    text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
    text += f"element tristrips {len(rows)}\nproperty list int int vertex_indices\nend_header\n"
    text += "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
    return (text + "".join(f"{len(row)} {' '.join(map(str, row))}\n" for row in rows)).encode()


@pytest.mark.parametrize(
    "rows",
    [
        [[0, 2, 1, 3, 0, 2]],
        [[0, 2, 1, 3], [1, 3, 0, 2]],
        [[0, 2, 1, 3, -1, 1, 3, 0, 2]],
        [[-1, 0, 2, 1, 3, -1, -1, 1, 3, 0, 2, -1]],
    ],
)
def test_triangle_strips_turn_every_second_triangle(rows):
    """A tetrahedron as one strip or two, separated by rows or by -1; all faces look outwards."""
    raw = read_ply(strip_file(*rows))
    assert len(raw.faces) == 4
    assert np.linalg.det(raw.vertices[raw.faces] - 0.25).sum() / 6 == pytest.approx(1 / 6)
    assert prepare_arrays(raw.vertices, raw.faces).report.as_dict() == RepairReport().as_dict()


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
@pytest.mark.parametrize("kind", ["ply", "ply-little"])
def test_header_lines_end_in_any_way(kind, end):
    points, faces = octahedron()
    points = points + 1e-30 * 0x0A  # binary data of any bytes follow
    head, mark, body = encode(kind, points, faces).partition(b"end_header\n")
    raw = read_ply((head + mark).replace(b"\n", end) + (body.replace(b"\n", end) if kind == "ply" else body))
    assert raw.faces.tolist() == faces.tolist()


def test_a_lone_carriage_return_before_data_that_begin_with_a_line_feed():
    header = b"ply\rformat binary_little_endian 1.0\relement vertex 1\rproperty uchar x\rproperty uchar y\r"
    header += b"property uchar z\rend_header\r"
    assert read_ply(header + b"\n\x01\x02").vertices.tolist() == [[10, 1, 2]]


def test_a_comment_may_name_the_end_of_the_header():
    data = encode("ply", *octahedron()).replace(b"ply\n", b"ply\ncomment before end_header\n", 1)
    assert len(read_ply(data).faces) == 8
