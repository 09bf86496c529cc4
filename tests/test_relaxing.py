"""``geoweave relax`` on a weave and on rods."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import pytest

from geoweave import cli, shapes
from geoweave.outputs import write_weave
from geoweave.rodfiles import read_rods
from geoweave.weave import weave_pattern
from geoweave.woven import Weave


@cache
def weave() -> Weave:
    return weave_pattern(shapes.sphere(600), ribbons=10).sized(80.0)


@pytest.mark.parametrize("name", ["weave.json", "weave.rod"])
def test_a_file_is_relaxed(name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    write_weave(weave(), tmp_path / "in", ["rod"])
    output = tmp_path / "out"
    assert cli.main(["relax", str(tmp_path / "in" / name), "-o", str(output), "--json"]) == 0
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
        assert cli.main(["relax", str(output / "relaxed.json"), "-o", str(tmp_path / "again")]) == 0
        assert "at rest" in capfd.readouterr().out


def test_what_cannot_be_relaxed(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "bad.rod").write_text("-217 2 x")
    (tmp_path / "bad.json").write_text("{}")
    for name, words in (("bad.rod", "bad.rod"), ("bad.json", "not a weave"), ("none.json", "none.json")):
        assert cli.main(["relax", str(tmp_path / name), "-o", str(tmp_path / "out")]) == 2
        assert words in capfd.readouterr().err
    assert not (tmp_path / "out").exists()
