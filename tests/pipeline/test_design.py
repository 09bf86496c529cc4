"""From a mesh file to woven files by a call: the files of the command, and values for what was made."""

import dataclasses
import json
from pathlib import Path

import pytest

from geoweave.cli import main
from geoweave.files import OutputError
from geoweave.meshing.write import write_mesh
from geoweave.models import shapes
from geoweave.pipeline.design import weave_file
from geoweave.pipeline.request import WeaveRequest
from geoweave.pipeline.source import MeshSource

REQUEST = WeaveRequest(scale=0.5, relax=False)


@pytest.fixture
def cone(tmp_path: Path) -> MeshSource:
    write_mesh(shapes.cone(faces=300), tmp_path / "cone.obj")
    return MeshSource(str(tmp_path / "cone.obj"), faces=300)


def test_the_call_and_the_command_do_the_same(
    cone: MeshSource, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    request = dataclasses.replace(REQUEST, size=150.0, formats=("pattern", "svg"))
    made = weave_file(cone, tmp_path / "call", request)
    command = ["weave", cone.name, "--faces", "300", "--scale", "0.5", "--no-relax", "--size", "150"]
    more = ["--formats", "pattern,svg", "-o", str(tmp_path / "command"), "--json"]
    assert main.main([*command, *more]) == 0
    said = json.loads(capfd.readouterr().out)
    names = sorted(path.name for path in (tmp_path / "call").iterdir())
    assert names == ["pattern.json", "pattern.svg", "report.json", "weave.json"] == sorted(made.files)
    for name in names:
        assert (tmp_path / "call" / name).read_bytes() == (tmp_path / "command" / name).read_bytes()
    mine = made.document()
    for key in ("seconds", "output", "files"):
        del mine[key], said[key]
    assert mine == said


def test_values_are_those_of_the_files(cone: MeshSource, tmp_path: Path) -> None:
    said: list[str] = []
    made = weave_file(cone, tmp_path / "woven", WeaveRequest(ribbons=8, size=150.0), callback=said.append)
    assert made.relaxed is not None
    assert made.strips is not None
    assert made.strips_of in {"relaxed.json", "weave.json"}
    lies = json.loads((tmp_path / "woven" / made.strips_of).read_text())
    lengths = [ribbon["length"] for ribbon in lies["ribbons"]]
    assert [strip.length for strip in made.strips.strips] == pytest.approx(lengths, abs=1e-3)
    assert made.left_out == {}
    assert any(text.startswith("sliding: step") for text in said)
    assert any(text.startswith("relaxing: step") for text in said)
    assert made.seconds["total"] == pytest.approx(
        sum(value for key, value in made.seconds.items() if key != "total")
    )


def test_a_folder_that_cannot_be_used_is_refused_before_the_work(cone: MeshSource, tmp_path: Path) -> None:
    said: list[str] = []
    with pytest.raises(OutputError, match="is a file"):
        weave_file(cone, cone.name, REQUEST, callback=said.append)
    with pytest.raises(OutputError, match="there is no folder"):
        weave_file(cone, tmp_path / "no" / "where", REQUEST, callback=said.append)
    assert said == []
