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
    write_weave(cone(), tmp_path / "my-lampshade")
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


def test_links_and_pictures_are_there() -> None:
    targets = re.findall(r"\]\(([^)#]+)\)", TEXT)
    assert sum(target.endswith(".png") for target in targets) >= 3
    for target in targets:
        assert target.startswith("https://") or (ROOT / "docs" / target).exists(), target


def test_every_option_is_described() -> None:
    for option in cut.params:
        for name in getattr(option, "opts", []):
            if name.startswith("--") and name != "--json":
                assert f"`{name}" in TEXT, name


@pytest.mark.parametrize("preset", ["bristol-a4", "veneer-laser", "plotter-roll"])
def test_what_is_exported_comes_back(preset: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """A cone with a hoop, measured on the drawing alone, on all its sheets."""
    write_weave(cone(), tmp_path / "cone")
    folder = tmp_path / preset
    words = ["cut", str(tmp_path / "cone"), "--preset", preset, "--hoops", "9", "--formats", "svg"]
    assert main.main([*words, "-o", str(folder)]) == 0
    capfd.readouterr()
    sheets = sorted(folder.glob("*.svg"))
    assert not (folder / "pattern.json").exists()
    assert main.main(["twin", str(folder if len(sheets) == 1 else sheets[-1]), "--json"]) == 0
    result = json.loads(capfd.readouterr().out)
    assert result["comes_back"] is True
    assert result["ribbons"] == len(cone().ribbons) + 1
    assert result["crossings"] > len(cone().ribbons.crossings) + 6
    assert result["designed"]["crossings"]["mean"] < 0.02
