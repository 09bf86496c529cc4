"""What the commands share."""

import json

import pytest

from geoweave.cli import options
from geoweave.errors import FieldError, GeoweaveError, MeshError


def test_numbers_for_people() -> None:
    assert options.text_of(1234567) == "1,234,567"
    assert options.text_of(0.123456789) == "0.123457"


def test_tables_line_up(capsys: pytest.CaptureFixture[str]) -> None:
    options.print_table("title", [("a", "1"), ("longer", "")])
    assert capsys.readouterr().out == "title\n  a       1\n  longer\n"


def test_json_has_no_nan(capsys: pytest.CaptureFixture[str]) -> None:
    options.print_json({"a": [1, 2.5]})
    assert json.loads(capsys.readouterr().out) == {"a": [1, 2.5]}
    with pytest.raises(ValueError, match="JSON"):
        options.print_json({"a": float("nan")})


def test_stages_are_timed_and_progress_is_silent_without_a_terminal(
    capsys: pytest.CaptureFixture[str],
) -> None:
    seconds: dict[str, float] = {}
    with options.status() as say, options.timed(seconds, "stage"):
        say("working")
    assert seconds["stage"] >= 0
    assert capsys.readouterr() == ("", "")


def test_what_a_method_says_is_about_a_file() -> None:
    with pytest.raises(FieldError, match=r"^a\.obj: ask for more$"), options.about("a.obj"):
        raise FieldError("ask for more")
    with pytest.raises(MeshError, match=r"^a\.obj: no faces$"), options.about("a.obj"):
        raise MeshError("a.obj: no faces")
    with pytest.raises(GeoweaveError, match=r"^something else$"), options.about("a.obj"):
        raise GeoweaveError("something else")


def test_a_name_that_is_neither_file_nor_data_set() -> None:
    with pytest.raises(MeshError, match="neither a file nor a data set"):
        options.read_surface("nothing", "keep", False, lambda text: None)
