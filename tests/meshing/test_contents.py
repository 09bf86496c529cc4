"""Packed files are unpacked, text is decoded, and what cannot be is refused with its reason."""

import bz2
import gzip
import io
import lzma
import zipfile

import numpy as np
import pytest
from meshfiles import FORMATS, encode, octahedron

from geoweave.errors import MeshError
from geoweave.meshing import contents
from geoweave.meshing.contents import plain_text
from geoweave.meshing.prepare import read_mesh

POINTS, FACES = octahedron()
CODINGS = ["utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32"]


def zipped(**files: bytes) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name.replace("_", "."), data)
    return buffer.getvalue()


@pytest.mark.parametrize("coding", CODINGS)
@pytest.mark.parametrize(
    ("kind", "ending"), [("obj", "obj"), ("off", "off"), ("ply", "ply"), ("stl-text", "stl")]
)
def test_text_of_any_encoding_is_read_whole(kind, ending, coding, tmp_path):
    """A byte order mark in front of the first vertex must not lose it."""
    path = tmp_path / f"mesh.{FORMATS[kind]}"
    path.write_bytes(encode(kind, POINTS, FACES).decode().encode(coding))
    mesh = read_mesh(path).mesh
    assert (mesh.n_vertices, mesh.n_faces) == (6, 8)


def test_binary_data_that_begin_like_a_mark_stay_as_they_are():
    data = b"\xff\xfe" + encode("stl", POINTS, FACES)[2:]
    assert plain_text(data, "solid") == data
    assert plain_text(b"\xef\xbb\xbf\xff", "") == b"\xef\xbb\xbf\xff"


@pytest.mark.parametrize(
    ("ending", "pack"), [("gz", gzip.compress), ("bz2", bz2.compress), ("xz", lzma.compress)]
)
@pytest.mark.parametrize("kind", ["obj", "ply", "stl"])
def test_packed_meshes_are_read(kind, ending, pack, tmp_path):
    path = tmp_path / f"mesh.{kind}.{ending}"
    path.write_bytes(pack(encode(kind, POINTS, FACES)))
    assert read_mesh(path).mesh.n_faces == 8
    path.write_bytes(path.read_bytes()[:-9])
    with pytest.raises(MeshError, match=f"mesh.{kind}.{ending}: .*cut short"):
        read_mesh(path)


def test_a_zip_with_one_mesh_is_read(tmp_path):
    path = tmp_path / "mesh.zip"
    path.write_bytes(zipped(readme_txt=b"hello", mesh_off=encode("off", POINTS, FACES)))
    assert read_mesh(path).mesh.n_faces == 8


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (zipped(readme_txt=b"hello"), "holds no mesh file"),
        (zipped(a_obj=b"", b_stl=b""), r"holds 2 mesh files \(a.obj, b.stl\); unpack the one you want"),
        (zipped(a_obj=b""), "is empty"),
        (zipped(a_obj=encode("obj", POINTS, FACES))[:-30], "damaged or cut short"),
        (b"no archive", "damaged or cut short"),
    ],
)
def test_a_zip_without_one_mesh_is_refused(data, says, tmp_path):
    path = tmp_path / "mesh.zip"
    path.write_bytes(data)
    with pytest.raises(MeshError, match=f"^.*mesh.zip: cannot be read as ZIP: .*{says}"):
        read_mesh(path)


def test_other_packed_files_are_refused_by_their_kind(tmp_path):
    for ending in contents.UNREAD:
        path = tmp_path / f"mesh.{ending}"
        path.write_bytes(b"x")
        with pytest.raises(MeshError, match="unpack it first"):
            read_mesh(path)


def test_a_file_that_unpacks_without_end_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(contents, "MOST_BYTES", 2**20)
    path = tmp_path / "mesh.obj.gz"
    path.write_bytes(gzip.compress(np.zeros(2**21, dtype=np.uint8).tobytes()))
    with pytest.raises(MeshError, match="unpacks to more than"):
        read_mesh(path)
