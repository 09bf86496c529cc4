"""``geoweave show``: it writes a page, says what is on it, and opens it where there is a screen."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from laidflat import cone

from geoweave.cli import main, show_command
from geoweave.pipeline.weave_folder import write_weave


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_weave(cone(), tmp_path / "cone")
    return tmp_path / "cone"


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    found: list[str] = []
    monkeypatch.setattr(show_command.click, "launch", lambda url: found.append(url))
    monkeypatch.setattr(show_command.sys, "platform", "linux")
    monkeypatch.setenv("DISPLAY", ":0")
    return found


def test_it_opens_the_page(folder: Path, opened: list[str], capfd: pytest.CaptureFixture[str]) -> None:
    assert main.main(["show", str(folder)]) == 0
    assert opened == [(folder / "viewer.html").resolve().as_uri()]
    out = capfd.readouterr().out
    assert f"{len(cone().ribbons)} ribbons" in out
    assert str(folder / "viewer.html") in out


def test_it_opens_nothing_if_not_asked_to_or_where_there_is_no_screen(
    folder: Path, opened: list[str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    assert main.main(["show", str(folder), "--no-open"]) == 0
    monkeypatch.delenv("DISPLAY")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert main.main(["show", str(folder)]) == 0
    assert opened == []


def test_json_and_another_place(folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "page.html"
    assert main.main(["show", str(folder), "-o", str(page), "--no-open", "--json"]) == 0
    found = json.loads(capfd.readouterr().out)
    assert found["page"] == str(page)
    assert found["crossings"] == len(cone().ribbons.crossings)
    assert page.is_file()


def test_what_is_no_weave_is_refused(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main.main(["show", str(tmp_path), "--no-open"]) == 2
    assert "holds no weave.json" in capfd.readouterr().err
    assert main.main(["show", str(tmp_path / "none")]) == 2
