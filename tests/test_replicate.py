"""The script of the Graphics Replicability Stamp: it passes on the committed numbers, and on no others."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from geoweave.artifact.execution import Outcome

ROOT = Path(__file__).resolve().parent.parent
SCRIPT = ROOT / "scripts" / "replicate.sh"


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> ModuleType:
    """The program, in a checkout of one notebook and its committed table; drawing is taken to work."""
    spec = importlib.util.spec_from_file_location("replicate", ROOT / "scripts" / "replicate.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    (tmp_path / "figures").mkdir()
    (tmp_path / "notebooks").mkdir()
    shutil.copy(ROOT / "figures" / "fig07_sphere.csv", tmp_path / "figures")
    shutil.copy(ROOT / "notebooks" / "fig07_sphere.ipynb", tmp_path / "notebooks")
    monkeypatch.setattr(module, "ROOT", tmp_path)
    monkeypatch.setattr(module, "interrupt_once", lambda: None)
    monkeypatch.setattr(module.doctor, "require_rendering", lambda: None)
    return module


def giving(module: ModuleType, text: str, problem: str = "") -> Any:
    """An execution that publishes a table with a text."""

    def execute(root: Path, name: str, profile: str, folder: Path, *_: object) -> Outcome:
        assert (root, name, profile) == (module.ROOT, "fig07_sphere", "default")
        (folder / "figures").mkdir()
        (folder / "figures" / f"{name}.csv").write_text(text)
        return Outcome(problem, 41.0)

    return execute


def test_the_committed_numbers_pass(
    script: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT / "figures" / "fig07_sphere.csv").read_text()
    monkeypatch.setattr(script, "execute", giving(script, text))
    for _ in range(2):  # a second run takes the place of the first
        assert script.main() == 0
    out = capsys.readouterr().out
    assert "PASS: no number(s) differ; 41 s" in out
    assert str(script.ROOT / "build" / "replicate" / "figures" / "fig07_sphere.png") in out
    assert [path.name for path in (script.ROOT / "build").iterdir()] == ["replicate"]


def test_other_numbers_and_a_notebook_that_stops_fail(
    script: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (ROOT / "figures" / "fig07_sphere.csv").read_text()
    ours = next(line for line in text.splitlines() if line.startswith("ours,"))
    worse = ours.replace(ours.split(",")[1], "2.5")
    monkeypatch.setattr(script, "execute", giving(script, text.replace(ours, worse)))
    assert script.main() == 1
    out = capsys.readouterr().out
    assert "differs: ours: degrees from great circles 2.5, committed 0.640247" in out
    assert "FAIL: 1 number(s) differ" in out
    monkeypatch.setattr(script, "execute", giving(script, text, "cell In[4]: AssertionError"))
    assert script.main() == 1
    assert "FAIL: the notebook stopped: cell In[4]: AssertionError" in capsys.readouterr().out


def test_what_counts_as_a_difference(script: ModuleType) -> None:
    committed = script.table(ROOT / "figures" / "fig07_sphere.csv")
    assert not script.differences(committed, committed)
    assert script.differences(committed, committed[:-1])
    assert script.differences(committed, [{"method": row["method"]} for row in committed])
    for row, column, factor, same in (
        (3, "total curl", 1.02, True),
        (3, "total curl", 1.05, False),
        (3, "singularities", 2.0, False),
        (2, "total curl", 1.3, True),
        (2, "total curl", 2.0, False),
        (0, "angle", float("nan"), False),
    ):
        other = [dict(each) for each in committed]
        other[row][column] = str(float(other[row][column]) * factor)
        assert (not script.differences(committed, other)) is same, (row, column, factor)


def test_the_script_takes_no_parameters_and_calls_make(tmp_path: Path) -> None:
    assert os.access(SCRIPT, os.X_OK)
    called = tmp_path / "make"
    called.write_text('#!/bin/sh\necho "$PWD: make $*"\nexit 7\n')
    called.chmod(0o755)
    environment = {**os.environ, "PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(
        [str(SCRIPT)], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (7, f"{ROOT}: make --no-print-directory replicate\n")
    recipe = subprocess.run(
        ["make", "-n", "replicate"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    assert "scripts/replicate.py" in recipe


def test_the_columns_are_those_of_the_figure(script: ModuleType) -> None:
    committed = script.table(ROOT / "figures" / "fig07_sphere.csv")
    assert list(committed[0]) == ["method", *script.WORDS]
    assert set(script.ANY_OF_MANY) < {row["method"] for row in committed}


def test_no_two_cells_of_the_table_touch(script: ModuleType) -> None:
    committed = script.table(ROOT / "figures" / "fig07_sphere.csv")
    here = [dict(row) for row in committed]
    for row in here:
        row["method"] = "a method of a very long name, longer than any of the four"
        row["total curl"] = "-1.2345678e-123"
    lines = script.side_by_side(committed, here)
    assert len(lines) == 1 + len(committed) * len(script.WORDS)
    assert len({len(line) for line in lines}) == 1
    for line, row in zip(lines[1 :: len(script.WORDS)], committed, strict=True):
        cells = re.split(r"  +", line)
        assert cells[0] == here[0]["method"]
        assert cells[1] == script.WORDS["angle"]
        assert [float(cell) for cell in cells[2:]] == pytest.approx([float(row["angle"])] * 2, rel=1e-3)
    assert max(map(len, script.side_by_side(committed, committed))) <= 100
