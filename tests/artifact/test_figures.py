"""The runner executes what is stale and nothing else, resumes, and leaves nothing half-written."""

import json
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

from geoweave.artifact import figures
from geoweave.artifact.notebooks import NotebookError
from geoweave.errors import GeoweaveError

ROOT = Path(__file__).resolve().parents[2]

WRITES = """
from geoweave.checkout import figures_folder
folder = figures_folder(profile)
folder.mkdir(parents=True, exist_ok=True)
with (folder / "fig00.csv").open("w") as file:
    _ = file.write(f"faces\\n{faces}\\n")
"""


def write(root: Path, name: str, *cells: str, values: str = "faces = 10") -> None:
    """A notebook of a parameters cell and further code cells."""
    notebook = new_notebook(
        cells=[
            new_markdown_cell(f"# About {name}\n\nprose", id="title"),
            new_code_cell(
                f'{values}\nprofile = "default"', id="parameters", metadata={"tags": ["parameters"]}
            ),
            *(new_code_cell(cell, id=f"cell-{number}") for number, cell in enumerate(cells)),
        ]
    )
    nbformat.write(notebook, root / "notebooks" / f"{name}.ipynb")


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A checkout of its own: the package, an empty folder for notebooks, one for figures."""
    package = tmp_path / "geoweave"
    shutil.copytree(ROOT / "geoweave", package, ignore=shutil.ignore_patterns("__pycache__", "data", "viz"))
    for name in ("notebooks", "figures"):
        (tmp_path / name).mkdir()
    shutil.copy(ROOT / "requirements.lock", tmp_path)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    return tmp_path


def files(root: Path) -> dict[str, bytes]:
    return {
        path.relative_to(root).as_posix(): path.read_bytes()
        for folder in ("figures", "notebooks")
        for path in (root / folder).rglob("*")
        if path.is_file()
    }


def states(results: list[figures.Result]) -> dict[str, str]:
    return {result.name: result.state for result in results}


def test_only_what_is_stale_is_executed_again(checkout: Path) -> None:
    write(checkout, "fig00", WRITES, "1 + 1")
    write(checkout, "other", "'nothing'")
    first = figures.run(root=checkout, jobs=2)
    assert states(first) == {"fig00": "done", "other": "done"}
    assert first[0].figures == ("fig00.csv",)
    assert first[0].seconds > 0
    if sys.platform != "win32":
        assert 20 < first[0].peak_mb < 2000
    before = files(checkout)
    assert before["figures/fig00.csv"] == b"faces\n10\n"

    assert states(figures.run(root=checkout)) == {"fig00": "fresh", "other": "fresh"}
    assert files(checkout) == before

    # A figure that was lost or changed comes back from the stored result, without an execution.
    (checkout / "figures" / "fig00.csv").write_text("edited by hand")
    assert states(figures.run(["fig00"], root=checkout)) == {"fig00": "fresh"}
    assert files(checkout) == before

    write(checkout, "fig00", WRITES, "1 + 1", values="faces = 11")
    assert states(figures.run(root=checkout)) == {"fig00": "done", "other": "fresh"}
    assert (checkout / "figures" / "fig00.csv").read_text() == "faces\n11\n"


def test_the_digest_sees_what_matters_and_nothing_else(checkout: Path) -> None:
    write(checkout, "fig00", WRITES)
    base = figures.digest(checkout, "fig00", "default")
    notebook = nbformat.read(checkout / "notebooks" / "fig00.ipynb", 4)
    notebook.cells[1].execution_count = 7
    nbformat.write(notebook, checkout / "notebooks" / "fig00.ipynb")
    (checkout / "geoweave" / "cli" / "main.py").write_text("# the command draws no figure\n")
    assert figures.digest(checkout, "fig00", "default") == base
    (checkout / "geoweave" / "fields").mkdir(exist_ok=True)
    (checkout / "geoweave" / "fields" / "cli.py").write_text("# a file of that name elsewhere counts\n")
    assert figures.digest(checkout, "fig00", "default") != base
    (checkout / "geoweave" / "fields" / "cli.py").unlink()
    assert figures.digest(checkout, "fig00", "default") == base
    seen = {base, figures.digest(checkout, "fig00", "paper")}
    (checkout / "geoweave" / "new.py").write_text("x = 1\n")
    seen.add(figures.digest(checkout, "fig00", "default"))
    with (checkout / "requirements.lock").open("a") as lock:
        lock.write("new==1.0\n")
    seen.add(figures.digest(checkout, "fig00", "default"))
    write(checkout, "fig00", WRITES, "2")
    seen.add(figures.digest(checkout, "fig00", "default"))
    assert len(seen) == 5


def test_a_failure_says_where_and_leaves_the_figures_alone(
    checkout: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(checkout, "fig00", WRITES)
    figures.run(root=checkout)
    before = files(checkout)["figures/fig00.csv"]
    write(checkout, "fig00", WRITES, 'assert faces == 10, "first\\nthe claim"', values="faces = 12")
    capsys.readouterr()
    (result,) = figures.run(root=checkout)
    assert result.state == "failed"
    assert "cell In[3]" in result.problem
    assert "the claim" in result.problem
    assert "fig00: failed: cell In[3]" in capsys.readouterr().err
    assert files(checkout)["figures/fig00.csv"] == before
    kept = checkout / "build" / "notebooks" / "default" / "fig00.failed.ipynb"
    assert kept.is_file()
    assert not list((checkout / "build").glob("running-*"))

    write(checkout, "fig00", WRITES)
    assert states(figures.run(root=checkout, force=True)) == {"fig00": "done"}
    assert not kept.exists()


def test_a_kernel_that_dies_is_a_failure(checkout: Path) -> None:
    write(checkout, "dies", "import os, signal\nos.kill(os.getpid(), signal.SIGKILL)")
    (result,) = figures.run(root=checkout)
    assert result.state == "failed"
    assert "Kernel died" in result.problem


def test_the_paper_profile_has_its_own_values_and_folder(checkout: Path) -> None:
    write(checkout, "fig00", WRITES)
    (checkout / "notebooks" / "profiles.toml").write_text("[paper.fig00]\nfaces = 99\n")
    (result,) = figures.run(profile="paper", root=checkout)
    assert result.figures == ("paper/fig00.csv",)
    assert (checkout / "figures" / "paper" / "fig00.csv").read_text() == "faces\n99\n"
    assert not (checkout / "figures" / "fig00.csv").exists()

    write(checkout, "fig00", WRITES.replace("figures_folder(profile)", "figures_folder()"))
    (result,) = figures.run(profile="paper", root=checkout)
    assert result.state == "failed"
    assert "fig00.csv published in profile paper" in result.problem


def test_refreshing_twice_gives_the_same_bytes(checkout: Path) -> None:
    write(checkout, "fig00", WRITES, "print('a'); print('b')", "faces + 1")
    figures.refresh(root=checkout)
    once = files(checkout)
    notebook = nbformat.read(checkout / "notebooks" / "fig00.ipynb", 4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code] == [1, 2, 3, 4]
    assert code[-1].outputs[0].data["text/plain"] == "11"
    shutil.rmtree(checkout / "build")
    assert states(figures.refresh(root=checkout)) == {"fig00": "done"}
    assert files(checkout) == once
    assert states(figures.run(root=checkout)) == {"fig00": "fresh"}


def test_an_interruption_leaves_nothing_and_is_resumed(checkout: Path) -> None:
    write(checkout, "a_fast", WRITES)
    write(checkout, "b_slow", "import time", "time.sleep(600)")
    command = [sys.executable, "-m", "geoweave.artifact.figures", "figures"]
    process = subprocess.Popen(command, cwd=checkout, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stderr is not None
        said_before = []
        first = process.stderr.readline()
        while first and "a_fast: done" not in first:
            said_before.append(first)
            first = process.stderr.readline()
        while not list((checkout / "build").glob("running-*/executed.ipynb")):
            assert process.poll() is None
            time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        said = process.communicate()[1]
    finally:
        process.kill()
    assert "[1/2] a_fast: done" in first
    assert said_before[0].startswith("2 notebooks, 1 at a time")
    assert any(
        "loops are compiled" in line for line in said_before
    )  # there is no compiled loop in this checkout
    assert "interrupted" in said
    assert process.returncode == 130
    assert not list((checkout / "build").glob("running-*"))
    assert sorted(files(checkout)) == [
        "figures/fig00.csv",
        "notebooks/a_fast.ipynb",
        "notebooks/b_slow.ipynb",
    ]
    write(checkout, "b_slow", "1")
    assert states(figures.run(root=checkout)) == {"a_fast": "fresh", "b_slow": "done"}


def test_an_unknown_name_starts_nothing(checkout: Path) -> None:
    write(checkout, "fig00", WRITES)
    with pytest.raises(NotebookError, match="there is no notebook 'fig99'; there are: fig00"):
        figures.run(["fig00", "fig99"], root=checkout)
    assert not (checkout / "build").exists()


def test_times_go_into_the_page(checkout: Path) -> None:
    page = checkout / "REPRODUCING.md"
    kept, gone = "| fig01 | default | 7 | 99 |", "| fig02 | default | 8 | 98 |"
    page.write_text(f"before\n{figures.TIMES[0]}\nold\n{kept}\n{gone}\n{figures.TIMES[1]}\nafter\n")
    with pytest.raises(GeoweaveError, match="nothing has been executed"):
        figures.report(checkout)
    write(checkout, "fig00", "1")
    write(checkout, "fig01", "1")
    folder = checkout / "build" / "notebooks" / "default" / "fig00"
    folder.mkdir(parents=True)
    record = {"key": "k", "name": "fig00", "profile": "default", "state": "fresh", "seconds": 12.4}
    record |= {"peak_mb": 345.6, "figures": [], "problem": ""}
    (folder / "record.json").write_text(json.dumps(record))
    assert figures.report(checkout) == 1
    text = page.read_text()
    assert "| fig00 | default | 12 | 346 |" in text
    assert kept in text, "what was not executed here keeps its row"
    assert gone not in text, "a notebook that is gone does not"
    assert (checkout / "figures" / "INDEX.md").is_file()
    assert text.startswith("before\n")
    assert text.endswith("after\n")
    assert "old" not in text


def test_the_page_has_its_place_for_times() -> None:
    text = (ROOT / "REPRODUCING.md").read_text(encoding="utf-8")
    begin, end = (text.find(line) for line in figures.TIMES)
    assert 0 < begin < end
