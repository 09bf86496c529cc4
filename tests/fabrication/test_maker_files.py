"""All files or none, the same each time, and clear words where it does not go."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from laidflat import circles, flat, patterns

from geoweave.errors import FieldError
from geoweave.fabrication.bench import Bench
from geoweave.fabrication.glb import glb_bytes
from geoweave.fabrication.maker_files import FORMATS, check_formats, write
from geoweave.fabrication.nesting import Stock
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.pieces import Making
from geoweave.files import OutputError

ALL = {
    "pattern.json",
    "cutlist.csv",
    "pattern.svg",
    "pattern.dxf",
    "pattern-a4.pdf",
    "pattern-letter.pdf",
    "weave.glb",
    "guide.html",
}


def test_everything_is_written_and_again_the_same(tmp_path: Path) -> None:
    files = [write(patterns()["circles"], tmp_path / name, weave=circles()) for name in ("one", "two")]
    assert set(files[0]) == ALL == {path.name for path in (tmp_path / "one").iterdir()}
    for name in ALL:
        assert files[0][name].read_bytes() == files[1][name].read_bytes()


def test_pattern_json_is_read_back_with_its_order(tmp_path: Path) -> None:
    files = write(patterns()["flat"], tmp_path, ["pattern"], bench=Bench(Making(overlap=9.0)))
    assert list(files) == ["pattern.json"]
    content = json.loads(files["pattern.json"].read_text(encoding="utf-8"))
    pattern = Pattern.from_document(content)
    assert pattern.document() == patterns()["flat"].document()
    assert content["making"] == {
        **vars(Making()),
        "overlap": 9.0,
    }
    assert sorted(step["strip"] for step in content["assembly"]) == list(range(12))
    assert sorted(x for step in content["assembly"] for x in step["crossings"]) == list(
        range(len(pattern.at))
    )


def test_several_sheets_are_several_files(tmp_path: Path) -> None:
    bench = Bench(stock=Stock(220.0, 40.0))
    names = sorted(write(patterns()["circles"], tmp_path, ["svg", "dxf"], bench=bench))
    count = len(names) // 2
    assert count > 1
    assert names == sorted(f"pattern-{k:02d}.{kind}" for k in range(1, count + 1) for kind in ("svg", "dxf"))
    assert f"sheet 1 of {count}" in (tmp_path / "pattern-01.svg").read_text(encoding="utf-8")


def test_the_object_is_shown_at_rest_where_the_pattern_is_of_the_weave_at_rest(tmp_path: Path) -> None:
    rest = flat()
    for ribbon in rest["ribbons"]:
        ribbon["points"] = [[x, y, z + 2.0] for x, y, z in ribbon["points"]]
    for given, shown in ((None, flat()), (rest, rest)):
        files = write(patterns()["flat"], tmp_path, ["glb"], weave=flat(), rest=given)
        assert files["weave.glb"].read_bytes() == glb_bytes(shown, Bench().paper_colours.families)


def test_formats_come_once_and_in_order() -> None:
    assert check_formats([" PDF", "svg", "pdf", "csv"]) == ("csv", "svg", "pdf")
    assert set(check_formats(FORMATS)) == set(FORMATS)


def test_refusals_leave_nothing_behind(tmp_path: Path) -> None:
    pattern = patterns()["flat"]
    with pytest.raises(OutputError, match="no format 'stl'"):
        write(pattern, tmp_path / "new", ["stl"])
    with pytest.raises(OutputError, match="no format is asked for"):
        write(pattern, tmp_path / "new", [])
    with pytest.raises(OutputError, match="GLB needs the weave"):
        write(pattern, tmp_path / "new", ["glb"])
    with pytest.raises(FieldError, match="too short for pieces"):
        write(pattern, tmp_path / "new", ["svg"], bench=Bench(stock=Stock(40.0)))
    with pytest.raises(FieldError, match="is not a geoweave-weave"):
        write(pattern, tmp_path / "new", ["csv", "glb"], weave={"format": "other"})
    with pytest.raises(OutputError, match="there is no folder"):
        write(pattern, tmp_path / "away" / "new", ["csv"])
    assert list(tmp_path.iterdir()) == []
    write(pattern, tmp_path, ["csv"])
    before = (tmp_path / "cutlist.csv").read_bytes()
    (tmp_path / "pattern.json").mkdir()
    with pytest.raises(OutputError, match="is a folder"):
        write(pattern, tmp_path, ["pattern", "csv"], bench=Bench(stock_length=300.0))
    assert (tmp_path / "cutlist.csv").read_bytes() == before
    assert flat()["units"] == "mm"
