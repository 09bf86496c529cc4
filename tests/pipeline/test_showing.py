"""A page beside the files of its weave: listed, replaced with them, or written elsewhere."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from laidflat import cone

from geoweave.errors import FieldError, WeaveFileError
from geoweave.files import OutputError
from geoweave.pipeline.showing import show_folder
from geoweave.pipeline.weave_folder import earlier_report, listed_files, write_weave


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_weave(cone(), tmp_path / "cone")
    return tmp_path / "cone"


def test_the_report_lists_the_page_and_is_otherwise_as_it_was(folder: Path) -> None:
    before = earlier_report(folder)
    said: list[str] = []
    shown = show_folder(folder, callback=said.append)
    after = earlier_report(folder)
    assert shown.path == folder / "viewer.html"
    assert said
    assert after.pop("files").keys() - before.pop("files").keys() == {"viewer.html"}
    assert after == before
    assert "<title>cone: the weave</title>" in shown.path.read_text(encoding="utf-8")
    assert shown.document() | {"seconds": {}} == {
        "page": str(shown.path),
        "title": "cone",
        "ribbons": len(cone().ribbons),
        "crossings": len(cone().ribbons.crossings),
        "at_rest": False,
        "places": len(before["places"]),
        "seconds": {},
    }


def test_again_it_is_the_same_page_and_a_new_weave_removes_it(folder: Path) -> None:
    first = show_folder(folder).path.read_bytes()
    assert show_folder(folder).path.read_bytes() == first
    assert list(listed_files(folder)).count("viewer.html") == 1
    write_weave(cone(), folder)
    assert not (folder / "viewer.html").exists()


def test_elsewhere_the_folder_stays_as_it_is(folder: Path, tmp_path: Path) -> None:
    before = (folder / "report.json").read_bytes()
    shown = show_folder(folder, tmp_path / "page.html")
    assert shown.path == tmp_path / "page.html"
    assert (folder / "report.json").read_bytes() == before
    assert not (folder / "viewer.html").exists()
    with pytest.raises(OutputError, match="there is no folder"):
        show_folder(folder, tmp_path / "no" / "page.html")


def test_a_weave_alone_is_enough(folder: Path) -> None:
    (folder / "report.json").unlink()
    shown = show_folder(folder)
    assert (shown.path.name, shown.places) == ("viewer.html", 0)
    assert not (folder / "report.json").exists()


def test_what_is_no_weave_is_refused(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(FieldError, match=r"holds no weave\.json; make one"):
        show_folder(tmp_path)
    other = json.loads((folder / "weave.json").read_text(encoding="utf-8"))
    other["ribbons"][0]["label"] = "Z9"
    (folder / "relaxed.json").write_text(json.dumps(other), encoding="utf-8")
    with pytest.raises(FieldError, match=r"other ribbons than weave\.json"):
        show_folder(folder)
    (folder / "relaxed.json").write_text("{", encoding="utf-8")
    with pytest.raises(WeaveFileError, match=r"relaxed\.json"):
        show_folder(folder)
