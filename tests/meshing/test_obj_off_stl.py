import numpy as np
import pytest
from meshfiles import encode, octahedron

from geoweave.errors import MeshError
from geoweave.meshing.obj_off_stl import read_obj, read_off, read_stl


@pytest.mark.parametrize(("kind", "reader"), [("obj", read_obj), ("off", read_off)])
def test_text_formats_keep_every_digit(kind, reader):
    points, faces = octahedron()
    points = points * np.pi + 1e6 / 3
    raw = reader(encode(kind, points, faces))
    np.testing.assert_array_equal(raw.vertices, points)
    np.testing.assert_array_equal(raw.faces, faces)


@pytest.mark.parametrize("kind", ["stl", "stl-text"])
def test_stl_has_three_vertices_per_triangle(kind):
    points, faces = octahedron()
    raw = read_stl(encode(kind, points, faces))
    np.testing.assert_array_equal(raw.vertices[raw.faces], points[faces])
    assert len(raw.vertices) == 3 * len(faces)


def test_a_binary_stl_may_begin_with_solid():
    data = b"solid of a program that does not care" + encode("stl", *octahedron())[37:]
    assert len(read_stl(data).faces) == 8


def test_obj_relative_indices_count_from_their_own_line():
    text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf -3 -2 -1\n"
    assert read_obj(text).faces.tolist() == [[0, 1, 2], [3, 4, 5]]


def test_obj_texture_normals_comments_continuation_and_line_ends():
    text = (
        b"# made by hand\r\nmtllib nothing.mtl\r\nv 0 0 0 0.5 0.5 0.5\r\nv 1 0 0 # second\r\nv 1 1 0\r\n"
        b"v 0 1 0\r\nvt 0 0\r\nvt 1 1\r\nvn 0 0 1\r\nusemtl red\r\nf 1/1/1 2/2/1 3/1/1\r\nusemtl blue\r\n"
        b"f 1//1 3//1 \\\r\n 4//1\r\nl 1 2\r\n"
    )
    raw = read_obj(text)
    # texture seams and materials leave the surface in one piece
    assert raw.faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert raw.vertices.shape == (4, 3)


def test_off_with_counts_on_the_first_line_comments_and_colours():
    text = b"COFF 4 2 0 # counts\n\n0 0 0 255 0 0 255\n1 0 0 1 1 1 1\n1 1 0 1 1 1 1\n# rest\n0 1 0 1 1 1 1\n"
    text += b"4 0 1 2 3 9 9 9\n3 0 1 3\n"
    raw = read_off(text)
    assert raw.faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 3]]
    assert raw.vertices[3].tolist() == [0, 1, 0]


@pytest.mark.parametrize(
    ("reader", "text", "message"),
    [
        (read_obj, b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", "line 4: a face names vertex 0"),
        (read_obj, b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4: a face names vertex 4"),
        (read_obj, b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", "line 4: a face names vertex -4"),
        (read_obj, b"v 0 0 0\nv 1 0\nf 1 2 2\n", "line 2: a vertex needs three numbers, not '1 0'"),
        (read_obj, b"v 0 0 0\nv 1 0 x\nf 1 2 2\n", "line 2: a vertex needs three numbers, not '1 0 x'"),
        (read_obj, b"v 0 0 0\nf 1 1.5 1\n", "line 2: a face needs whole numbers"),
        (read_obj, b"v 0 0 0\nf 1 1\n", "line 2: a face needs three vertices"),
        (read_obj, b"f 1 2 3\n", "no vertex lines"),
        (read_off, b"OFF\n2 1 0\n0 0 0\n1 0 0\n", "announces 2 vertices and 1 face"),
        (read_off, b"OFF\n-1 1 0\n0 0 0\n1 0 0\n", "announces -1 vertices"),
        (
            read_off,
            b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1\n",
            "line 6: a face announces 3 vertices and names 2",
        ),
        (read_off, b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "line 6: a face announces 2"),
        (read_off, b"OFF\nvertices\n", "numbers of vertices and faces are missing"),
        (read_off, b"OFF BINARY\n", "binary OFF"),
        (read_off, b"PFF\n3 1 0\n", "does not begin with the word OFF"),
        (read_stl, b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n", "endsolid"),
        (
            read_stl,
            b"solid x\nfacet normal 0 0 1\nvertex 0 0 0\nvertex 1 0 0\nendsolid\n",
            "1 facet, but 2 vertices",
        ),
        (
            read_stl,
            bytes(80) + b"\x02\0\0\0" + bytes(50),
            "announces 2 triangles (184 bytes), but the file has 134",
        ),
        (read_stl, b"short", "shorter than the header"),
    ],
)
def test_refusals_name_the_line(reader, text, message):
    with pytest.raises(MeshError) as caught:
        reader(text)
    assert message in str(caught.value)


CUBE = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n"
SIDES = "4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n"


@pytest.mark.parametrize(
    "text",
    [
        f"OFF\n8 6 12\n{CUBE}{SIDES}",
        f"OFF 8 6 12\n{CUBE}{SIDES}",
        f"OFF8 6 12\n{CUBE}{SIDES}",
        f"off\n8 6 12\n{CUBE}{SIDES}",
        f"Off\n8 6\n{CUBE}{SIDES}",
        f"8 6 12\n{CUBE}{SIDES}",
        f"OFF\n8\n6\n12\n{CUBE}{SIDES}",
        " ".join(f"OFF 8 6 12 {CUBE}{SIDES}".split()),
        "\n".join(f"OFF 8 6 12 {CUBE}{SIDES}".split()),
        f"# made by hand\n\nOFF # a cube\n8 6 12\n{CUBE}{SIDES}",
        f"noff\n8 6 12\n{CUBE}{SIDES}",
    ],
)
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_off_files_in_all_their_dresses(text, end):
    raw = read_off(text.replace("\n", end).encode())
    assert (len(raw.vertices), len(raw.faces)) == (8, 12)
    corners = raw.vertices[raw.faces]
    assert np.linalg.det(corners).sum() / 6 == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (f"4OFF\n8 6 12\n{CUBE}{SIDES}", "4OFF"),
        (f"OFF BINARY\n{CUBE}", "binary OFF"),
        ("OFF\n8 six 12\n", "numbers of vertices and faces are missing"),
        ("OFF", "numbers of vertices and faces are missing"),
        (f"OFF\n8 6 12\n{CUBE}{SIDES}"[:-12], "cut short"),
        (" ".join(f"OFF 8 6 12 {CUBE}{SIDES}".split())[:-4], "cut short"),
        (f"OFF\n8 6 12\n{CUBE}{SIDES}".replace("4 1 2", "4 1 x"), "line 14: .*'1 x 6 5'"),
    ],
)
def test_other_off_files_are_refused_with_their_reason(text, says):
    with pytest.raises(MeshError, match=says):
        read_off(text.encode())


@pytest.mark.parametrize("name", ["facet", "vertex 1 2", "endsolid facet", "my facet normal vertex"])
def test_the_name_of_an_stl_model_may_hold_any_word(name):
    text = encode("stl-text", *octahedron()).decode().splitlines()
    text[0], text[-1] = f"solid {name}", f"endsolid {name}"
    assert len(read_stl("\n".join(text).encode()).faces) == 8


@pytest.mark.parametrize(
    ("change", "faces", "note"),
    [
        (lambda data: data + b"made by hand", 8, "12 bytes were left out after its 8 triangles"),
        (lambda data: data[:80] + b"\x05\0\0\0" + data[84:], 8, "announces 5 triangles; all 8"),
        (lambda data: data[:80] + b"\0\0\0\0" + data[84:], 8, "announces 0 triangles; all 8"),
        (lambda data: data[:80] + b"\xff\xff\xff\xff" + data[84:], 8, "all 8 that it holds"),
    ],
)
def test_a_binary_stl_with_a_wrong_count_or_more_bytes_is_read_with_a_note(change, faces, note):
    raw = read_stl(change(encode("stl", *octahedron())))
    assert len(raw.faces) == faces
    assert len(raw.notes) == 1
    assert note in raw.notes[0]
