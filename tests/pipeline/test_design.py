"""From a mesh file to woven files by a call: the files of the command, and values for what was made."""

import dataclasses
import json
from pathlib import Path

import pytest

from geoweave.cli import main
from geoweave.fabrication import Making, Pattern, bill_of, pieces_of
from geoweave.files import OutputError
from geoweave.meshing.write import write_mesh
from geoweave.models import shapes
from geoweave.pipeline.design import weave_file
from geoweave.pipeline.design_file import read_design
from geoweave.pipeline.request import WeaveRequest
from geoweave.pipeline.source import MeshSource
from geoweave.weave import Edits, WeaveType, design_key, edited

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


@pytest.mark.parametrize("pattern", ["plain", "twill", "basket"])
def test_every_pattern_goes_from_the_mesh_to_the_files(tmp_path: Path, pattern: WeaveType) -> None:
    """Over and under of the weave are those of the strips, at rest too; a float is no fault of a twill."""
    write_mesh(shapes.sphere(faces=1200), tmp_path / "ball.obj")
    source = MeshSource(str(tmp_path / "ball.obj"), faces=1200)
    request = WeaveRequest(pattern=pattern, ribbons=10, size=150.0, formats=("pattern", "svg", "design"))
    made = weave_file(source, tmp_path / "woven", request)
    report = json.loads((tmp_path / "woven" / "report.json").read_text())
    turns = made.weave.interlacing
    assert report["pattern"] == turns.document()
    assert (turns.pattern, request.symmetry, report["violations"]) == (pattern, 4, [])
    assert made.strips is not None
    assert made.verdict is not None
    assert made.verdict.word in {"make it", "make it, but"}  # the twin of the strips comes back
    woven = json.loads((tmp_path / "woven" / "weave.json").read_text())
    assert made.strips.over.tolist() == [each["over_index"] for each in woven["crossings"]]
    assert made.strips.floating is (pattern != "plain")
    assert Pattern.from_document(made.strips.document()).floating is made.strips.floating
    reasons = bill_of(made.strips, pieces_of(made.strips, Making()), Making()).reasons
    assert not any("changes sides" in reason for reason in reasons)
    if pattern == "plain":
        assert 0.9 < turns.met == turns.alternation == turns.met_bound
    else:
        assert 0.85 < turns.met <= turns.met_bound
        assert turns.alternation < 0.65
    again = read_design(tmp_path / "woven" / "design.npz").interlacing
    assert again.document() == turns.document()
    name = made.weave.names[0]
    less = edited(made.weave, Edits(design_key(made.weave.document()), drop=(name,)))
    assert less.interlacing.pattern == pattern
