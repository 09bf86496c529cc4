import json
import logging
import os
import struct
import subprocess
import sys

import numpy as np
import pytest
from meshfiles import FORMATS, encode, hostile, octahedron, sphere, write

from geoweave.errors import MeshError
from geoweave.meshing.prepare import read_mesh
from geoweave.meshing.read import read_arrays, shown


@pytest.mark.parametrize("kind", FORMATS)
def test_every_format_gives_the_same_triangles(kind, tmp_path):
    points, faces = octahedron()
    raw = read_arrays(write(tmp_path, "mesh", kind, points, faces))
    np.testing.assert_array_equal(raw.vertices[raw.faces], points[faces])


def glb(points, faces, placements):
    """A binary glTF file of one mesh, placed several times."""
    corners, indices = points.astype("<f4").tobytes(), faces.astype("<u4").tobytes()
    scene = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(placements)))}],
        "nodes": [{"mesh": 0, "translation": list(place)} for place in placements],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(corners) + len(indices)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": len(corners)},
            {"buffer": 0, "byteOffset": len(corners), "byteLength": len(indices)},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": faces.size, "type": "SCALAR"},
        ],
    }
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    body = corners + indices
    chunks = (
        struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(body), 0x004E4942) + body
    )
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def test_a_scene_of_another_format_is_laid_out_in_space(tmp_path):
    points, faces = octahedron()
    path = tmp_path / "two.glb"
    path.write_bytes(glb(points, faces, [(0, 0, 0), (5, 0, 0)]))
    raw = read_arrays(path)
    assert len(raw.faces) == 16
    places = raw.vertices[raw.faces].reshape(2, 24, 3).mean(axis=1)
    np.testing.assert_allclose(sorted(places.tolist()), [[0, 0, 0], [5, 0, 0]], atol=1e-6)
    assert read_mesh(path).mesh.n_components == 2


def test_whatever_a_reader_raises_prints_or_logs_becomes_one_sentence(tmp_path, monkeypatch, capfd):
    import trimesh

    path = tmp_path / "mesh.glb"
    path.write_bytes(b"glTF")

    def fails(error):
        def load(*_, **__):
            print("noise")
            print("noise", file=sys.stderr)
            logging.getLogger("trimesh").error("noise")
            raise error

        return load

    errors = (ValueError("two\nlines"), IndexError(), MemoryError("x" * 500), RecursionError(), SystemExit(1))
    for error in errors:
        monkeypatch.setattr(trimesh, "load_scene", fails(error))
        with pytest.raises(MeshError, match="cannot be read as GLB") as caught:
            read_arrays(path)
        assert len(str(caught.value).splitlines()) == 1
        assert len(str(caught.value)) < 250 + len(str(path))
    monkeypatch.setattr(trimesh, "load_scene", fails(KeyboardInterrupt()))
    with pytest.raises(KeyboardInterrupt):
        read_arrays(path)
    assert capfd.readouterr() == ("", "")


def test_hostile_files_each_give_one_sentence(tmp_path):
    cases = hostile(tmp_path)
    assert len(cases) > 70
    for label, (path, word) in cases.items():
        with pytest.raises(MeshError) as caught:
            read_mesh(path)
        text = str(caught.value)
        assert text.startswith(f"{path}: "), label
        assert word in text, (label, text)
        assert ";" in text, (label, "names no remedy", text)
        assert len(text.splitlines()) == 1, label


def test_a_pipe_a_device_and_a_link_to_itself(tmp_path):
    pipe = tmp_path / "pipe.obj"
    os.mkfifo(pipe)
    device = tmp_path / "null.obj"
    device.symlink_to("/dev/null")
    for path in (pipe, device):
        with pytest.raises(MeshError, match="not a regular file"):
            read_arrays(path)
    loop = tmp_path / "loop.obj"
    loop.symlink_to(loop)
    with pytest.raises(MeshError, match="cannot be opened"):
        read_arrays(loop)


def test_names_of_any_kind(tmp_path):
    points, faces = octahedron()
    for name in (
        "with space.obj",
        "Größe – 形.off",
        "~tilde.obj",
        "{brace}.off",
        "http:x.obj",
        "UPPER.OBJ",
        "a.b.stl",
    ):
        kind = name.rsplit(".", 1)[1].lower()
        (tmp_path / name).write_bytes(encode(kind, points, faces))
        assert len(read_arrays(tmp_path / name).faces) == 8
    link = tmp_path / "link.obj"
    link.symlink_to("UPPER.OBJ")
    assert len(read_arrays(link).faces) == 8


def test_a_name_is_shown_on_one_line():
    assert shown("a\nb\x1b[31m\udc80.obj") == "a?b?[31m?.obj"
    with pytest.raises(MeshError, match=r"^a\?b.obj: there is no such file"):
        read_arrays("a\nb.obj")
    with pytest.raises(MeshError, match="no such file"):
        read_arrays("a\0b.obj")


def mutated(data, rng):
    data = bytearray(data)
    for _ in range(rng.integers(1, 6)):
        at = int(rng.integers(0, max(1, len(data))))
        match int(rng.integers(0, 4)):
            case 0:
                data[at : at + 1] = bytes([rng.integers(0, 256)])
            case 1:
                del data[at : at + int(rng.integers(1, 40))]
            case 2:
                words = [b"0", b"-", b"\n", b"nan", b"e99", b" ", b"\0", b"999999999", b"1e999", b"/"]
                data[at:at] = words[rng.integers(0, len(words))]
            case 3:
                del data[at : at + (10**9 if rng.random() < 0.3 else 1)]
    return bytes(data)


@pytest.mark.parametrize("kind", FORMATS)
def test_damaged_files_are_read_or_refused(kind, tmp_path):
    rng = np.random.default_rng(sum(kind.encode()))
    whole = encode(kind, *sphere(1))
    path = tmp_path / f"mesh.{FORMATS[kind]}"
    refused = []
    for _ in range(150):
        path.write_bytes(mutated(whole, rng))
        try:
            mesh = read_mesh(path).mesh
        except MeshError as error:
            refused.append(str(error))
        else:
            assert np.isfinite(mesh.face_areas).all()
    assert all(text.startswith(f"{path}: ") and len(text.splitlines()) == 1 for text in refused)
    assert 30 < len(refused) < 150


@pytest.mark.parametrize("source", ["bunny", "mesh.obj", "mesh.off"])
def test_a_closed_mesh_is_read_without_the_heavy_libraries(source, tmp_path):
    """They take longer to load than such a mesh takes to read."""
    if source != "bunny":
        write(tmp_path, "mesh", source.removeprefix("mesh."), *octahedron())
    code = (
        "import sys; from geoweave.cli.main import main\n"
        f"try: main(['info', {source!r}])\n"
        "except SystemExit as done: assert not done.code\n"
        "print(sorted({'numba', 'pooch', 'scipy', 'trimesh', 'numpy.f2py'} & set(sys.modules)))"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert run.stdout.splitlines()[-1] == "[]"


def prism(kind):
    """A prism over a U of area 5 and girth 12, height 2: its caps are polygons of eight corners."""
    ring = [(0, 0), (3, 0), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2), (0, 2)]
    points = [(x, y, z) for z in (0, 2) for x, y in ring]
    faces = [list(range(7, -1, -1)), list(range(8, 16))]
    faces += [[k, (k + 1) % 8, 8 + (k + 1) % 8, 8 + k] for k in range(8)]
    rows = [" ".join(map(str, point)) for point in points]
    if kind == "obj":
        rows = [f"v {row}" for row in rows] + ["f " + " ".join(str(k + 1) for k in face) for face in faces]
        return "\n".join(rows) + "\n"
    polygons = [f"{len(face)} " + " ".join(map(str, face)) for face in faces]
    if kind == "off":
        return "\n".join(["OFF", f"{len(points)} {len(faces)} 0", *rows, *polygons, ""])
    head = ["ply", "format ascii 1.0", f"element vertex {len(points)}"]
    head += [*(f"property float {axis}" for axis in "xyz"), f"element face {len(faces)}"]
    return "\n".join([*head, "property list uchar int vertex_indices", "end_header", *rows, *polygons, ""])


@pytest.mark.parametrize("kind", ["obj", "off", "ply"])
def test_a_solid_with_concave_caps_keeps_its_area(kind, tmp_path):
    """A fan of the caps would cover the gap of the U too."""
    path = tmp_path / f"prism.{kind}"
    path.write_text(prism(kind))
    prepared = read_mesh(path)
    assert prepared.mesh.face_areas.sum() == pytest.approx(2 * 5 + 2 * 12)
    assert (prepared.mesh.genus, prepared.mesh.boundary_loops) == (0, ())
    assert prepared.report.sentences() == []


@pytest.mark.parametrize("name", ["KHR_draco_mesh_compression", "EXT_meshopt_compression"])
@pytest.mark.parametrize("kind", ["glb", "gltf"])
def test_compressed_gltf_is_refused_by_its_name(kind, name, tmp_path):
    path = tmp_path / f"mesh.{kind}"
    data = glb(*octahedron(), [(0, 0, 0)])
    path.write_bytes(data.replace(b'"2.0"}', b'"2.0"},"extensionsRequired":["' + name.encode() + b'"]', 1))
    with pytest.raises(
        MeshError, match=rf"mesh.{kind}: .*compressed \({name}\); export it without compression"
    ):
        read_mesh(path)
