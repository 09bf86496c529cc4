"""A weave is written whole or not at all, and its rods are the ribbons."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from geoweave.files import OutputError, sha256_of
from geoweave.models import shapes
from geoweave.pipeline.weave_folder import FORMATS, check_formats, listed_files, rod_file, write_weave
from geoweave.rods.rod_file import read_rods
from geoweave.weave.design import weave_pattern
from geoweave.weave.passages import Passages
from geoweave.weave.weave import Weave


@cache
def pattern() -> Weave:
    return weave_pattern(shapes.torus(faces=1500), scale=0.6).sized(200.0, width=5.0, thickness=0.4)


def test_every_file_is_there(tmp_path: Path) -> None:
    files = write_weave(pattern(), tmp_path / "new", ["rod", "design"])
    assert sorted(files) == sorted(path.name for path in (tmp_path / "new").iterdir())
    assert sorted(files) == ["design.npz", "report.json", "weave.json", "weave.rod"]
    assert json.loads(files["weave.json"].read_text()) == json.loads(json.dumps(pattern().document()))
    assert json.loads(files["report.json"].read_text())["counts"]["loose_end"] == 0
    first = {name: path.read_bytes() for name, path in files.items()}
    again = write_weave(pattern(), tmp_path / "new", FORMATS)
    assert {name: path.read_bytes() for name, path in again.items()} == first
    assert sorted(write_weave(pattern(), tmp_path / "plain")) == ["report.json", "weave.json"]


def test_rods_are_the_ribbons_in_the_unit_of_the_weave(tmp_path: Path) -> None:
    weave = pattern()
    content = read_rods(write_weave(weave, tmp_path / "x", ["rod"])["weave.rod"])
    curves, unit = weave.ribbons.curves, weave.placement.scale
    assert content.thickness == pytest.approx(0.4)
    assert [rod.closed for rod in content.rods] == curves.closed.tolist()
    for rod, length in zip(content.rods, unit * curves.lengths, strict=True):
        np.testing.assert_allclose(rod.widths, 5.0)
        assert rod.lengths.sum() == pytest.approx(length, rel=0.02)  # chords of equal pieces
    assert [rod.color for rod in content.rods] == weave.families.tolist()
    placed, met = content.placed(), weave.ribbons.crossings
    assert isinstance(placed, Passages)
    assert len(placed) <= len(met)
    # the two places of a contact lie on each other, but for the chords
    for one in content.crossings:
        ends = []
        for rod, segment, share in zip(one.rods, one.segments, one.places, strict=True):
            line = content.rods[rod].centerline
            ends.append((1 - share) * line[segment] + share * line[(segment + 1) % len(line)])
        assert np.linalg.norm(ends[0] - ends[1]) < 0.05 * unit * weave.ribbons.spacing


def test_nothing_is_left_where_writing_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write = Path.write_text

    def full(path: Path, *text: str, **options: str) -> int:
        if text[0].startswith("-217"):
            raise OSError(28, "No space left on device")
        return write(path, *text, **options)

    old = write_weave(pattern(), tmp_path / "old")
    before = {name: path.read_bytes() for name, path in old.items()}
    monkeypatch.setattr(Path, "write_text", full)
    for folder in ("old", "new"):
        with pytest.raises(OutputError, match=r"weave.rod: cannot be written .No space left"):
            write_weave(pattern().sized(100.0), tmp_path / folder, ["rod"])
    assert not (tmp_path / "new").exists()
    assert {path.name: path.read_bytes() for path in (tmp_path / "old").iterdir()} == before


def test_what_cannot_be_written(tmp_path: Path) -> None:
    assert check_formats(["ROD ", "json", "rod"]) == ("json", "rod")
    with pytest.raises(OutputError, match="no format 'dwg' for a weave; the formats are json, rod"):
        write_weave(pattern(), tmp_path / "x", ["dwg"])
    with pytest.raises(OutputError, match="there is no folder"):
        write_weave(pattern(), tmp_path / "no" / "where")
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="file"):
        write_weave(pattern(), tmp_path / "file")
    assert rod_file(pattern()).young > 0


def test_a_later_run_leaves_nothing_that_contradicts_it(tmp_path: Path) -> None:
    def write_both(path: Path) -> None:
        path.write_text("a pattern")

    first = write_weave(
        pattern(), tmp_path, ["rod"], more={"pattern.svg": write_both, "guide.html": write_both}
    )
    assert list(first) == ["weave.json", "weave.rod", "pattern.svg", "guide.html", "report.json"]
    listed = listed_files(tmp_path)
    assert listed == {name: sha256_of(path) for name, path in first.items() if name != "report.json"}
    (tmp_path / "guide.html").write_text("with my notes")
    (tmp_path / "photo.jpg").write_text("mine")
    (tmp_path / "pattern.dxf").write_text("mine too, though geoweave has a file of that name")
    write_weave(pattern().sized(100.0), tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "guide.html",
        "pattern.dxf",
        "photo.jpg",
        "report.json",
        "weave.json",
    ]
    assert list(listed_files(tmp_path)) == ["weave.json"]


@pytest.mark.parametrize(
    "report",
    ["", "[]", "{}", '{"files": 3}', '{"files": ["weave.json"]}', '{"files": {"../away": "%s", "": "x"}}'],
)
def test_a_report_that_lists_nonsense_does_no_harm(tmp_path: Path, report: str) -> None:
    away = tmp_path / "away"
    away.write_text("x")
    folder = tmp_path / "in"
    folder.mkdir()
    (folder / "report.json").write_text(report.replace("%s", sha256_of(away)))
    assert "../away" not in listed_files(folder)
    write_weave(pattern(), folder)
    assert away.read_text() == "x"
    assert sorted(path.name for path in folder.iterdir()) == ["report.json", "weave.json"]
