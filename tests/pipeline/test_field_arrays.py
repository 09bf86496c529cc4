"""What a field and a foliation of a file are, is theirs by the functions that find them."""

from pathlib import Path

import numpy as np
import pytest
from meshfiles import sphere, write

from geoweave.errors import MeshError
from geoweave.fields.face_field import total_curl
from geoweave.files import OutputError
from geoweave.pipeline.field_arrays import field_file, foliate_file
from geoweave.pipeline.source import MeshSource


@pytest.fixture
def ball(tmp_path: Path) -> str:
    return str(write(tmp_path, "ball", "off", *sphere(3)))


def test_a_field_and_its_file(ball: str, tmp_path: Path) -> None:
    said: list[str] = []
    found = field_file(Path(ball), tmp_path / "field.npz", callback=said.append)
    numbers = found.document()
    assert numbers["total_curl"]["after"] == total_curl(found.solve.field)
    assert numbers["output"] == str(tmp_path / "field.npz")
    assert "scale" not in numbers
    assert said[0] == f"reading {ball}"
    assert any(text.startswith("Algorithm 1: step 1, ") for text in said)
    with np.load(tmp_path / "field.npz") as arrays:
        np.testing.assert_array_equal(arrays["field"], found.solve.field.ambient)
        assert "theta_jump" not in arrays


def test_a_foliation_is_sharpened_further(ball: str) -> None:
    found = foliate_file(MeshSource(ball, faces=800), scale=0.8)
    assert found.foliation is not None
    assert found.document()["scale"] == 0.8
    assert found.document()["s_min"] == found.foliation.s_min > 0
    assert found.solve.steps[-1].smoothness > 0
    plain = field_file(MeshSource(ball, faces=800))
    assert found.solve.steps[-1].smoothness != plain.solve.steps[-1].smoothness


def test_what_is_refused_names_the_file(ball: str, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="is the input"):
        field_file(ball, ball)
    with pytest.raises(MeshError, match=r"nothing\.obj"):
        field_file(tmp_path / "nothing.obj")
