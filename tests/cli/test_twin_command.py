"""``geoweave twin``: a folder with a pattern, what is said of it, and what is refused."""

from __future__ import annotations

import json
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from twinned import inner, pattern, woven

from geoweave.cli import main
from geoweave.twin.pattern_surface import surface_of


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder as ``geoweave weave`` leaves it, of the cone."""
    made = tmp_path / "cone"
    made.mkdir()
    (made / "pattern.json").write_text(json.dumps(pattern("cone").document()))
    (made / "weave.json").write_text(json.dumps(woven("cone").designed))
    (made / "relaxed.json").write_text(json.dumps(woven("cone").relaxed))
    return made


def test_a_folder_is_rebuilt_and_compared(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main.main(["twin", str(folder), "--json"]) == 0
    result = json.loads(capfd.readouterr().out)
    assert result["comes_back"] is True
    assert result["woven"]["crossings"]["largest"] < 0.01
    assert result["designed"]["hausdorff"] < 0.05
    assert result["topology"]["genus"] == result["genus_designed"] == 0
    assert result["topology"]["contradictions"] == []
    assert result["files"] == [str(folder / "twin.json")]
    assert json.loads((folder / "twin.json").read_text())["format"] == "geoweave-weave"
    assert main.main(["twin", str(folder)]) == 0
    said = capfd.readouterr().out
    assert "The object comes back: its crossings are 0." in said
    assert "genus 0 with 1 opening, as designed" in said


def test_a_pattern_alone_is_rebuilt(folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    alone = tmp_path / "alone.json"
    alone.write_text((folder / "pattern.json").read_text())
    assert main.main(["twin", str(alone), "-o", str(tmp_path / "out"), "--json"]) == 0
    result = json.loads(capfd.readouterr().out)
    assert result["comes_back"] is None
    assert result["woven"] is None
    # the same twin, wherever the weave that it is compared with
    main.main(["twin", str(folder), "--json"])
    assert result["energy"] == json.loads(capfd.readouterr().out)["energy"]
    assert main.main(["twin", str(alone), "-o", str(tmp_path / "out")]) == 0
    assert "no relaxed.json or weave.json is beside the pattern" in capfd.readouterr().out


def test_the_report_beside_the_pattern_lists_the_twin(
    folder: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    names = ("pattern.json", "weave.json", "relaxed.json")
    digests = {name: sha256((folder / name).read_bytes()).hexdigest() for name in names}
    (folder / "report.json").write_text(json.dumps({"format": "geoweave-report", "files": digests}))
    assert main.main(["twin", str(folder), "--json"]) == 0
    result = json.loads(capfd.readouterr().out)
    report = json.loads((folder / "report.json").read_text())
    twin = sha256((folder / "twin.json").read_bytes()).hexdigest()
    assert report["files"] == digests | {"twin.json": twin}
    assert report["format"] == "geoweave-report"
    assert report["twin"]["woven"] == result["woven"]
    assert all((folder / name).is_file() for name in names)


def test_a_pattern_that_contradicts_itself(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    document = json.loads((folder / "pattern.json").read_text())
    x = inner(surface_of(pattern("cone")))[0]
    document["crossings"][x]["angle_deg"] *= -1
    (folder / "pattern.json").write_text(json.dumps(document))
    assert main.main(["twin", str(folder)]) == 2
    captured = capfd.readouterr()
    assert captured.out == ""
    assert captured.err.startswith(f"geoweave: {folder / 'pattern.json'}: the pattern contradicts itself")
    assert f"crossing {x} of" in captured.err
    assert not (folder / "twin.json").exists()
    assert main.main(["twin", str(folder), "--anyway", "--json"]) == 1
    result = json.loads(capfd.readouterr().out)
    assert result["topology"]["genus"] == 1
    assert result["genus_designed"] == 0
    assert not result["closes_as_designed"]
    assert len(result["topology"]["contradictions"]) == 1
    assert main.main(["twin", str(folder), "--anyway"]) == 1
    said = capfd.readouterr().out
    assert "Do not cut these strips: they close into a surface of genus 1" in said
    assert "comes back" not in said


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "is not JSON"),
        ("[]", "is no JSON object"),
        ("{}", "is not a geoweave-pattern"),
    ],
)
def test_what_is_no_pattern(text: str, words: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "pattern.json").write_text(text)
    assert main.main(["twin", str(tmp_path)]) == 2
    assert words in capfd.readouterr().err
    (tmp_path / "pattern.json").unlink()
    assert main.main(["twin", str(tmp_path)]) == 2
    assert "--formats pattern" in capfd.readouterr().err


def test_an_object_of_another_shape_is_status_1(folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
    other = json.loads((folder / "relaxed.json").read_text())
    for each in [*other["ribbons"], *other["crossings"]]:  # as if the object were four times as high
        for point in each["points"] if "points" in each else [each["point"]]:
            point[2] *= 4.0
    for each in other["ribbons"]:
        each["length"] = float(np.linalg.norm(np.diff(each["points"], axis=0), axis=1).sum())
    (folder / "relaxed.json").write_text(json.dumps(other))
    assert main.main(["twin", str(folder), "--json"]) == 1
    result = json.loads(capfd.readouterr().out)
    assert (result["closes_as_designed"], result["comes_back"]) == (True, False)
    assert "the object has another shape" in result["reasons"][0]
