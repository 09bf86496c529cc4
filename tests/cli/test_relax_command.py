"""``geoweave relax`` on a weave and on rods."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import pytest

from geoweave.cli import main
from geoweave.models import shapes
from geoweave.pipeline.weave_folder import write_weave
from geoweave.rods.rod_file import read_rods
from geoweave.weave.design import weave_pattern
from geoweave.weave.weave import Weave


@cache
def weave() -> Weave:
    return weave_pattern(shapes.sphere(600), ribbons=16).sized(80.0)


@pytest.mark.parametrize("name", ["weave.json", "weave.rod"])
def test_a_file_is_relaxed(name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    write_weave(weave(), tmp_path / "in", ["rod"])
    output = tmp_path / "out"
    assert main.main(["relax", str(tmp_path / "in" / name), "-o", str(output), "--json"]) == 0
    result = json.loads(capfd.readouterr().out)
    assert result["converged"]
    assert result["rods"] == len(weave().ribbons)
    assert result["energy_after"] < result["energy_before"]
    assert result["from_start"]["largest"] < 0.1
    written = sorted(path.name for path in output.iterdir())
    if name == "weave.rod":
        assert written == ["relaxed.rod", "report.json"]
        assert len(read_rods(output / "relaxed.rod").rods) == result["rods"]
    else:
        assert written == ["relaxed.json", "report.json"]
        relaxed = json.loads((output / "relaxed.json").read_text())
        assert len(relaxed["crossings"]) == result["contacts"]
        assert relaxed["metrics"]["relax"]["converged"]
        # what was relaxed is a weave again
        assert main.main(["relax", str(output / "relaxed.json"), "-o", str(tmp_path / "again")]) == 0
        assert "at rest" in capfd.readouterr().out


def test_beside_its_design_what_was_cut_to_another_shape_goes(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    def cut(path: Path) -> None:
        path.write_text("cut to other lengths")

    write_weave(weave(), tmp_path, ["rod"], more={"pattern.svg": cut})
    before = json.loads((tmp_path / "report.json").read_text())
    # what `geoweave twin` found of the pattern that is going
    (tmp_path / "report.json").write_text(json.dumps(before | {"twin": {"comes_back": True}}))
    design = {name: (tmp_path / name).read_bytes() for name in ("weave.json", "weave.rod")}
    assert main.main(["relax", str(tmp_path / "weave.json"), "-o", str(tmp_path), "--json"]) == 0
    result = json.loads(capfd.readouterr().out)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "relaxed.json",
        "report.json",
        "weave.json",
        "weave.rod",
    ]
    assert {name: (tmp_path / name).read_bytes() for name in design} == design
    after = json.loads((tmp_path / "report.json").read_text())
    assert after["places"] == before["places"]
    assert "twin" not in after
    assert after["relax"]["energy_after"] == result["energy_after"]
    assert set(after["files"]) == {"weave.json", "weave.rod", "relaxed.json"}
    # a weave that is not the one that lies there
    other = tmp_path.parent / f"{tmp_path.name}-other"
    write_weave(weave().sized(40.0), other)
    whole = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert main.main(["relax", str(other / "weave.json"), "-o", str(tmp_path)]) == 2
    assert "holds another weave (weave.json); name another folder" in capfd.readouterr().err
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == whole


def test_what_cannot_be_relaxed(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "bad.rod").write_text("-217 2 x")
    (tmp_path / "bad.json").write_text("{}")
    for name, words in (("bad.rod", "bad.rod"), ("bad.json", "not a weave"), ("none.json", "none.json")):
        assert main.main(["relax", str(tmp_path / name), "-o", str(tmp_path / "out")]) == 2
        assert words in capfd.readouterr().err
    assert not (tmp_path / "out").exists()


def test_rods_that_cannot_be_relaxed_are_told_with_their_file(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "point.rod"
    bar = "3 0  0 0 0  1 0 0  {}  0 0 1  0 0 1  0.1 0.1"
    # A rod that goes forth and back again is nothing once the fold is merged.
    path.write_text(f"1 0 0.01 1e6 1\n{bar.format('1e-300 0 0')}\n")
    assert main.main(["relax", str(path), "-o", str(tmp_path / "out")]) == 2
    said = capfd.readouterr().err
    assert str(path) in said
    assert "leave it out" in said
    assert not (tmp_path / "out" / "relaxed.rod").exists()


def test_what_was_repaired_is_said(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "lean.rod"
    bar = "3 0  0 0 0  1 0 0  2 0 0  0 0 1  0 0.2 1.5  0.1 0.1"
    path.write_text(f"1 0 0.01 1e6 1\n{bar}\n")
    assert main.main(["relax", str(path), "-o", str(tmp_path / "out"), "--json"]) == 0
    assert json.loads(capfd.readouterr().out)["repairs"] == [
        "directors made unit vectors square to their segments: 1"
    ]
