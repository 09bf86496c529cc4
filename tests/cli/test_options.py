"""What the commands share."""

import json

import pytest

from geoweave.cli import options


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


def test_progress_is_silent_without_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    with options.status() as say:
        say("working")
    assert capsys.readouterr() == ("", "")


def test_times_for_people() -> None:
    assert options.seconds_text({"read": 0.123, "total": 12.0}) == "read 0.12, total 12.00"
