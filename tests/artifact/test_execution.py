"""One notebook in a process of its own: what it is given, and how its end is told."""

import json
import signal
import sys
from pathlib import Path

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_notebook

from geoweave.artifact import execution

ROOT = Path(__file__).resolve().parents[2]


def checkout(folder: Path, *cells: str) -> Path:
    """A folder with one notebook, fig00; the package is imported from where the tests run."""
    notebook = new_notebook(
        cells=[
            new_code_cell('profile = "default"', id="p", metadata={"tags": ["parameters"]}),
            *(new_code_cell(cell, id=f"c{number}") for number, cell in enumerate(cells)),
        ]
    )
    (folder / "notebooks").mkdir()
    nbformat.write(notebook, folder / "notebooks" / "fig00.ipynb")
    (folder / "run").mkdir()
    return folder


def test_the_kernel_is_given_its_surroundings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    go = tmp_path / "go"
    names = ("GEOWEAVE_FIGURES", "PYVISTA_OFF_SCREEN", "PYTHONHASHSEED")
    root = checkout(
        tmp_path,
        f"import os, pathlib; print([os.environ[name] for name in {names!r}], pathlib.Path.cwd().name)",
        f"import time, pathlib\nwhile not pathlib.Path({str(go)!r}).exists(): time.sleep(0.05)",
    )
    seen: list[int] = []

    def advance(finished: int) -> None:
        seen.append(finished)
        if finished >= 2:  # the last cell waits until it is known that the others are finished
            go.touch()

    outcome = execution.execute(root, "fig00", "default", root / "run", execution.Children(), advance)
    assert outcome.problem == ""
    assert outcome.seconds > 0
    executed = nbformat.read(root / "run" / "executed.ipynb", 4)
    figures = str(root / "run" / "figures")
    assert executed.cells[1].outputs[0].text.strip() == f"{[figures, 'true', '0']} notebooks"
    assert seen == sorted(seen)
    assert max(seen) >= 2


def test_a_child_that_dies_early_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    root = checkout(tmp_path, "1")
    monkeypatch.setattr(sys, "executable", str(root / "fails"))
    (root / "fails").write_text("#!/bin/sh\necho not a Python >&2\nexit 3\n")
    (root / "fails").chmod(0o755)
    outcome = execution.execute(root, "fig00", "default", root / "run", execution.Children(), lambda n: None)
    assert outcome.problem == "its process ended with status 3 (not a Python)"


def test_stopping_ends_what_runs_and_refuses_more(tmp_path: Path) -> None:
    children = execution.Children()
    sleeper = [sys.executable, "-c", "import time; time.sleep(600)"]
    child = children.start(sleeper, {}, tmp_path / "log.txt")
    children.stop()
    # it ended at the first signal, not by being killed after ten seconds
    assert child.wait() == -signal.SIGTERM
    with pytest.raises(KeyboardInterrupt):
        children.start(sleeper, {}, tmp_path / "log.txt")


def test_counting_finished_cells(tmp_path: Path) -> None:
    file = tmp_path / "executed.ipynb"
    assert execution._cells_done(file) == 0
    done = {"cell_type": "code", "metadata": {"papermill": {"status": "completed"}}}
    waiting = {"cell_type": "code", "metadata": {"papermill": {"status": "pending"}}}
    file.write_text(json.dumps({"cells": [done, {"cell_type": "markdown", "metadata": {}}, done, waiting]}))
    assert execution._cells_done(file) == 2
    file.write_text('{"cells": [')
    assert execution._cells_done(file) == 0
