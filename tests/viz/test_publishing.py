"""A figure's files: picture, numbers and what they were made from; the same each time."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest
from pictures import ball, circles

from geoweave import viz
from geoweave.errors import RenderError
from geoweave.surface.mesh import TriMesh


def test_publishing_writes_picture_numbers_and_provenance(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("GEOWEAVE_FIGURES", str(tmp_path / "figures"))
    picture = viz.streamline_gallery([viz.Panel("Circles", circles())], width=400)
    table = pd.DataFrame({"model": ["sphere"], "curl": [1.0 / 3.0], "faces": [ball().n_faces]})
    params = {"faces": np.int64(5), "share": 0.1, "models": ("a", "b"), "weights": np.array([1.0, 2.0])}

    def publish(profile: str = "default"):
        return viz.publish(
            "fig99_test", picture, table=table, params=params, inputs={"sphere": ball()}, profile=profile
        )

    assert publish() is picture
    folder = tmp_path / "figures"
    first = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert sorted(first) == ["fig99_test.csv", "fig99_test.json", "fig99_test.png"]
    assert first["fig99_test.csv"] == b"model,curl,faces\nsphere,0.333333,1280\n"
    record = json.loads(first["fig99_test.json"])
    assert record["parameters"] == {"faces": 5, "share": 0.1, "models": ["a", "b"], "weights": [1.0, 2.0]}
    assert record["inputs"]["sphere"]["faces"] == 1280
    assert len(record["inputs"]["sphere"]["sha256"]) == 64
    assert {"geoweave", "numpy", "vtk", "pyvista"} <= record["versions"].keys()
    assert str(tmp_path) not in first["fig99_test.json"].decode()
    publish()
    assert first == {path.name: path.read_bytes() for path in folder.iterdir()}
    publish("paper")
    assert (folder / "paper" / "fig99_test.png").read_bytes() == first["fig99_test.png"]


def test_the_digest_of_a_mesh_depends_on_every_number() -> None:
    moved = ball().vertices.copy()
    moved[0, 0] += 1e-12
    digests = {
        viz.mesh_digest(ball()),
        viz.mesh_digest(TriMesh(moved, ball().faces)),
        viz.mesh_digest(TriMesh(ball().vertices, np.roll(ball().faces, 1, axis=0))),
    }
    assert len(digests) == 3
    assert viz.mesh_digest(TriMesh(ball().vertices, ball().faces)) in digests


def test_a_name_that_is_no_plain_word_is_refused() -> None:
    picture = viz.drop_chart([viz.Drop("Cow", 20.0, 7.0)])
    with pytest.raises(RenderError, match="cannot name a figure"):
        viz.publish("../escape", picture)
