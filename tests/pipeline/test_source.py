"""A mesh is read by the name of a file or of a data set, remeshed if asked, and every step is timed."""

from pathlib import Path

import pytest
from meshfiles import sphere, write

from geoweave.errors import FieldError, GeoweaveError, MeshError
from geoweave.pipeline.source import MeshSource, about, prepared_surface, read_surface, source_of, timed


def test_a_name_stands_for_a_mesh_as_it_is() -> None:
    assert source_of("bunny") == MeshSource("bunny", None, 0, False, "keep")
    assert source_of(Path("a") / "b.obj").name == str(Path("a") / "b.obj")
    source = MeshSource("bunny", seed=3)
    assert source_of(source) is source


def test_a_mesh_is_read_and_remeshed(tmp_path: Path) -> None:
    ball = str(write(tmp_path, "ball", "off", *sphere(3)))
    seconds: dict[str, float] = {}
    said: list[str] = []
    assert prepared_surface(MeshSource(ball), seconds, said.append).mesh.n_faces == 512
    assert list(seconds) == ["read"]
    fewer = prepared_surface(MeshSource(ball, faces=200), seconds, said.append)
    assert abs(fewer.mesh.n_faces - 200) <= 20
    assert list(seconds) == ["read", "remesh"]
    assert said[-1] == f"remeshing {ball} to 200 triangles"


def test_stages_are_timed() -> None:
    seconds: dict[str, float] = {}
    with timed(seconds, "stage"):
        pass
    assert 0 <= seconds["stage"] < 1


def test_what_a_method_says_is_about_a_file() -> None:
    with pytest.raises(FieldError, match=r"^a\.obj: ask for more$"), about("a.obj"):
        raise FieldError("ask for more")
    with pytest.raises(MeshError, match=r"^a\.obj: no faces$"), about("a.obj"):
        raise MeshError("a.obj: no faces")
    with pytest.raises(GeoweaveError, match=r"^something else$"), about("a.obj"):
        raise GeoweaveError("something else")


def test_a_name_that_is_neither_file_nor_data_set() -> None:
    with pytest.raises(MeshError, match="neither a file nor a data set"):
        read_surface(MeshSource("nothing"), lambda text: None)
