"""The twin of a pattern file: the numbers are those of the twin, compared with what lies beside it."""

import json
from pathlib import Path

import pytest
from twinned import pattern, twin, woven

from geoweave.errors import FieldError
from geoweave.pipeline.pattern_twin import twin_file


def test_a_pattern_is_compared_with_what_lies_beside_it(tmp_path: Path) -> None:
    (tmp_path / "pattern.json").write_text(json.dumps(pattern("cone").document()))
    alone = twin_file(tmp_path)
    assert (alone.target, alone.genus_designed, alone.document()["comes_back"]) == (None, None, None)
    (tmp_path / "relaxed.json").write_text(json.dumps(woven("cone").relaxed))
    (tmp_path / "weave.json").write_text(json.dumps(woven("cone").designed))
    made = twin_file(tmp_path / "pattern.json", tmp_path / "other")
    assert made.target is made.likeness["woven"]
    assert made.genus_designed == woven("cone").genus == 0
    expected = twin("cone").compared(woven("cone").relaxed)
    assert made.target.crossings.largest == pytest.approx(expected.crossings.largest)
    assert json.loads((tmp_path / "other" / "twin.json").read_text())["metrics"]["twin"]["comes_back"]


def test_the_weave_that_the_strips_are_of_decides(tmp_path: Path) -> None:
    (tmp_path / "pattern.json").write_text(json.dumps(pattern("cone", "designed").document()))
    (tmp_path / "relaxed.json").write_text(json.dumps(woven("cone").relaxed))
    (tmp_path / "weave.json").write_text(json.dumps(woven("cone").designed))
    for of, what in (("weave.json", "designed"), ("relaxed.json", "woven")):
        (tmp_path / "report.json").write_text(json.dumps({"strips": {"of": of}}))
        made = twin_file(tmp_path, tmp_path / "other")
        assert made.target is made.likeness[what]
        assert made.target_name == of


def test_what_is_no_pattern_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FieldError, match="cannot be read"):
        twin_file(tmp_path)
