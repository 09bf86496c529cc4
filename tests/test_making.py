"""docs/making.md says what is true, and every command in it runs."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest
from laidflat import cone
from meshfiles import sphere, write

from geoweave.cli import main
from geoweave.cli.cut_command import cut
from geoweave.fabrication.presets import PRESETS
from geoweave.pipeline.weave_folder import write_weave

ROOT = Path(__file__).resolve().parent.parent
TEXT = (ROOT / "docs" / "making.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^geoweave (.*)$", TEXT, re.MULTILINE)


def test_there_are_commands() -> None:
    assert sum(each.startswith("cut ") for each in COMMANDS) >= 4


def test_every_command_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """On a ball of few ribbons in place of a shape of many."""
    monkeypatch.chdir(tmp_path)
    write(tmp_path, "my-shape", "obj", *sphere(3))
    for command in COMMANDS:
        words = shlex.split(command.replace("--ribbons 80", "--ribbons 8 --faces 1000 --no-relax"))
        status = main.main(words)
        out, err = capfd.readouterr()
        assert status == 0 or (words[0] == "twin" and status == 1), (command, out, err)


def test_the_table_of_presets_is_theirs() -> None:
    rows = {
        cells[0].strip(" `"): [cell.strip() for cell in cells[1:]]
        for line in TEXT.splitlines()
        if line.startswith("| `") and len(cells := line.strip("|").split("|")) > 5
    }
    assert list(rows) == list(PRESETS)
    for name, preset in PRESETS.items():
        assert rows[name] == [
            preset.says,
            f"{preset.thickness:g}",
            f"`{preset.sheet}`",
            ", ".join(preset.papers),
            f"{preset.margin:g} / {preset.gap:g}",
            f"{preset.kerf:g}",
            f"{preset.overlap:g}",
            preset.labels,
            f"{preset.density:g}",
            preset.source,
        ]


def test_every_option_is_described() -> None:
    for option in cut.params:
        for name in getattr(option, "opts", []):
            if name.startswith("--") and name != "--json":
                assert f"`{name}" in TEXT, name


def test_a_preset_is_cut_in_three_ways_and_the_twin_comes_back(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    write_weave(cone(), tmp_path / "cone")
    for preset in ("bristol-a4", "veneer-laser", "plotter-roll"):
        folder = tmp_path / preset
        words = [
            "cut",
            str(tmp_path / "cone"),
            "--preset",
            preset,
            "--formats",
            "pattern,svg",
            "-o",
            str(folder),
        ]
        assert main.main(words) == 0
        capfd.readouterr()
        main.main(["twin", str(folder), "--json"])
        assert json.loads(capfd.readouterr().out)["crossings"] == len(cone().document()["crossings"])
