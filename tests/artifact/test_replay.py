"""What make figures has executed is compared with what is committed; the rest is executed again."""

from __future__ import annotations

import json
from pathlib import Path

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook, new_output

from geoweave.artifact import figures, replay


def notebook(number: str, picture: str = "aaaa") -> nbformat.NotebookNode:
    shown = new_output(
        "display_data", data={"image/png": picture, "text/html": f"<b>{number}</b>"}, metadata={}
    )
    untagged = new_output("stream", name="stdout", text=f"rough {number}\n")
    return new_notebook(
        cells=[
            new_markdown_cell("# About", id="title"),
            new_code_cell(
                'profile = "default"', id="p", metadata={"tags": ["parameters"]}, execution_count=1
            ),
            new_code_cell("rough()", id="r", execution_count=2, outputs=[untagged]),
            new_code_cell(
                "table",
                id="t",
                execution_count=3,
                metadata={"tags": [replay.CHECKED]},
                outputs=[new_output("stream", name="stdout", text="curl 7\n"), shown],
            ),
        ]
    )


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """Two notebooks, of which the first was executed from all that there is now."""
    for folder in ("notebooks", "geoweave", "build/notebooks/default/a"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "pyproject.toml").write_text("[project]\nname = 'geoweave'\n")
    for name in ("a", "b"):
        nbformat.write(notebook("1.5"), tmp_path / "notebooks" / f"{name}.ipynb")
    executed(tmp_path, notebook("1.5", picture="bbbb"))
    return tmp_path


def executed(root: Path, outputs: nbformat.NotebookNode) -> None:
    folder = root / "build" / "notebooks" / "default" / "a"
    nbformat.write(outputs, folder / "executed.ipynb")
    record = {"key": figures.digest(root, "a", "default"), "name": "a", "profile": "default"}
    (folder / "record.json").write_text(json.dumps({**record, "state": "fresh", "figures": []}))


def differences(root: Path) -> list[str]:
    return replay.differences(root, "a", figures.stored_notebooks(root, ["a"], "default")["a"])


def test_only_what_was_not_executed_as_it_is_now_is_executed_again(
    checkout: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(replay, "repository", lambda: checkout)
    assert replay.main([]) == 0
    said = capsys.readouterr()
    assert said.out == "notebooks/b.ipynb\n"
    assert said.err.startswith("1 notebooks were executed")
    (checkout / "geoweave" / "changed.py").write_text("pass\n")
    assert replay.main([]) == 0
    assert capsys.readouterr().out == "notebooks/a.ipynb notebooks/b.ipynb\n"


def test_the_package_is_read_once(checkout: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read = []
    monkeypatch.setattr(replay, "repository", lambda: checkout)
    monkeypatch.setattr(figures, "_package_digest", lambda package: read.append(package) or b"")
    assert replay.main([]) == 0
    assert read == [checkout / "geoweave"]


@pytest.mark.parametrize(("number", "differs"), [("1.5", False), ("1.6", True)])
def test_checked_cells_are_compared_and_pictures_are_not(
    checkout: Path, monkeypatch: pytest.MonkeyPatch, number: str, differs: bool
) -> None:
    executed(checkout, notebook(number, picture="cccc"))
    found = differences(checkout)
    assert ["<b>1.6</b>" in sentence for sentence in found] == [True] * differs
    monkeypatch.setattr(replay, "repository", lambda: checkout)
    assert replay.main([]) == int(differs)


def test_a_cell_that_prints_more_or_less_differs(checkout: Path) -> None:
    other = notebook("1.5")
    other.cells[3].outputs = other.cells[3].outputs[:1]
    executed(checkout, other)
    assert len(differences(checkout)) == 1
