"""The command is tested as a user runs it, in test_main.py; here, that Python and it say the same."""

import json

import pytest

from geoweave.cli import main
from geoweave.pipeline.source import MeshSource, prepared_surface


def test_it_says_what_was_read(capfd: pytest.CaptureFixture[str]) -> None:
    assert main.main(["info", "spot", "--json"]) == 0
    said = json.loads(capfd.readouterr().out)
    mesh = prepared_surface(MeshSource("spot"), {}, lambda text: None).mesh
    assert (said["vertices"], said["edges"], said["faces"]) == (mesh.n_vertices, mesh.n_edges, mesh.n_faces)
    assert said["area"] == mesh.face_areas.sum()
