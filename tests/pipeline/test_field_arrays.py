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
    assert [scale for scale, _ in found.tried] == [0.8]
    assert found.document()["s_min"] == found.foliation.s_min > 0
    assert found.solve.steps[-1].smoothness > 0
    plain = field_file(MeshSource(ball, faces=800))
    assert found.solve.steps[-1].smoothness != plain.solve.steps[-1].smoothness


def knotted_tube(along: int = 120, around: int = 8, radius: float = 0.3) -> tuple[np.ndarray, np.ndarray]:
    """A tube along the torus knot (3, 2): so long and thin that few level sets go round it."""

    def middle(t: np.ndarray) -> np.ndarray:
        far = 2 + np.cos(3 * t)
        return np.stack([far * np.cos(2 * t), far * np.sin(2 * t), np.sin(3 * t)], axis=1)

    t = np.linspace(0, 2 * np.pi, along, endpoint=False)
    forward = middle(t + 1e-5) - middle(t - 1e-5)
    side = np.cross(forward, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side, axis=1)[:, None]
    up = np.cross(side, forward / np.linalg.norm(forward, axis=1)[:, None])
    angle = np.linspace(0, 2 * np.pi, around, endpoint=False)[None, :, None]
    ring = np.cos(angle) * side[:, None] + np.sin(angle) * up[:, None]
    i, j = np.meshgrid(np.arange(along), np.arange(around), indexing="ij")
    corners = [((i + a) % along) * around + (j + b) % around for a, b in ((0, 0), (0, 1), (1, 1), (1, 0))]
    quads = np.stack(corners, axis=-1).reshape(-1, 4)
    points = (middle(t)[:, None] + radius * ring).reshape(-1, 3)
    return points, np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])


def test_where_level_sets_are_too_few_to_close_more_are_taken(tmp_path: Path) -> None:
    tube = write(tmp_path, "tube", "obj", *knotted_tube())
    found = foliate_file(tube)
    assert [scale for scale, _ in found.tried] == [1.0, 2.0]
    assert found.scale == 2.0
    numbers = found.document()
    assert numbers["scales_tried"][0]["median_deg"] > 5.0
    assert numbers["deviation_deg"]["median"] == numbers["scales_tried"][1]["median_deg"] < 2.5
    # A scale that is asked for is taken as it is.
    asked = foliate_file(tube, scale=1.0)
    assert (asked.scale, asked.tried) == (1.0, found.tried[:1])


def test_what_is_refused_names_the_file(ball: str, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="is the input"):
        field_file(ball, ball)
    with pytest.raises(MeshError, match=r"nothing\.obj"):
        field_file(tmp_path / "nothing.obj")
