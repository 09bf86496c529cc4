"""A folder is cut anew; the command's options are tested in tests/cli/test_cut_command.py."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from laidflat import cone

from geoweave.fabrication.pattern import Pattern
from geoweave.pipeline.cut_request import CutRequest
from geoweave.pipeline.cutting import cut_folder
from geoweave.pipeline.strips import strips_of
from geoweave.pipeline.weave_folder import write_weave
from geoweave.rods.weave_at_rest import relaxed_weave


def test_the_strips_are_those_at_rest_as_weave_cuts_them(tmp_path: Path) -> None:
    rest = relaxed_weave(cone())
    write_weave(cone(), tmp_path / "woven", relaxed=rest)
    made = cut_folder(tmp_path / "woven", tmp_path / "cut", CutRequest(formats=("pattern",)))
    wanted = strips_of(cone(), rest)
    assert made.cut.source == wanted.source == "relaxed.json"
    pattern = Pattern.from_document(json.loads(made.files["pattern.json"].read_text()))
    assert pattern.document() == wanted.pattern.document()


def test_another_folder_is_whole_and_is_cut_again(tmp_path: Path) -> None:
    write_weave(cone(), tmp_path / "woven", relaxed=relaxed_weave(cone()))
    wish = CutRequest(formats=("pattern", "svg"), width=3.0, title="cone")
    cut_folder(tmp_path / "woven", tmp_path / "one", wish)
    cut_folder(tmp_path / "one", tmp_path / "two", wish)
    names = {path.name for path in (tmp_path / "one").iterdir()}
    assert {"weave.json", "relaxed.json", "report.json", "pattern.json", "pattern.svg"} == names
    for name in names - {"report.json"}:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()


def test_a_design_is_copied_byte_by_byte(tmp_path: Path) -> None:
    """It is no text, as the other files of a weave are."""
    write_weave(cone(), tmp_path / "woven", ("json", "design"))
    cut_folder(tmp_path / "woven", tmp_path / "cut", CutRequest(formats=("csv",)))
    files = [tmp_path / folder / "design.npz" for folder in ("woven", "cut")]
    assert files[0].read_bytes() == files[1].read_bytes()


def test_a_verdict_on_other_strips_does_not_stay(tmp_path: Path) -> None:
    about = {"verdict": {"word": "make it"}, "strips": strips_of(cone(), None).document()}
    write_weave(cone(), tmp_path / "woven", about=about)
    for width, stays in ((None, True), (3.0, False)):
        made = cut_folder(tmp_path / "woven", tmp_path / f"{width}", CutRequest(width=width))
        report = json.loads(made.files["report.json"].read_text())
        assert ("verdict" in report) == stays
        assert report["cut"]["smallest_text_mm"] is None or report["cut"]["smallest_text_mm"] >= 1.8


def test_strips_of_another_thickness_than_at_rest_are_told(tmp_path: Path) -> None:
    """The lengths at rest are those of strips as thick as they were woven."""
    write_weave(cone(), tmp_path / "woven", relaxed=relaxed_weave(cone()))
    woven = cone().thickness * cone().placement.scale
    for factor, told in ((1.0, None), (1.05, None), (1.5, woven), (0.5, woven)):
        wish = CutRequest(thickness=factor * woven, formats=("csv",))
        made = cut_folder(tmp_path / "woven", tmp_path / f"cut{factor}", wish)
        assert made.document()["thickness_at_rest"] == (None if told is None else pytest.approx(told))
    write_weave(cone(), tmp_path / "designed")
    made = cut_folder(tmp_path / "designed", request=CutRequest(thickness=2 * woven, formats=("csv",)))
    assert made.thickness_at_rest is None
