"""Pages for readers name nothing that is not there: links, commands, tests, targets of make."""

from __future__ import annotations

import re
import textwrap
from pathlib import Path

import pytest

from geoweave import viz
from geoweave.artifact import notebooks
from geoweave.meshing.write import write_mesh
from geoweave.models import shapes

ROOT = Path(__file__).resolve().parents[1]
PAGES = [
    *("README.md", "REPRODUCING.md", "CONTRIBUTING.md", "notebooks/README.md"),
    *sorted(f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md")),
]
MAKEFILE = (ROOT / "Makefile").read_text(encoding="utf-8")


def read(page: str) -> str:
    return (ROOT / page).read_text(encoding="utf-8")


def anchors(page: Path) -> set[str]:
    """How GitHub names the headings of a page."""
    titles = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_to_files_and_headings(page: str) -> None:
    for link in re.findall(r"\]\(([^)\s]+)\)", read(page)):
        if link.startswith("https://"):
            continue
        file, _, heading = link.partition("#")
        place = (ROOT / page).parent / file if file else ROOT / page
        assert place.exists(), link
        assert not heading or heading in anchors(place), link


@pytest.mark.parametrize("page", PAGES)
def test_commands_exist(page: str) -> None:
    text = read(page)
    for target in re.findall(r"`make ([a-z]+)", text):
        assert re.search(rf"^{target}:", MAKEFILE, re.MULTILINE), target
    for path in re.findall(r"-m pytest (tests/[\w/.]+)|`(scripts/[\w/.]+)", text):
        assert (ROOT / "".join(path)).exists(), path
    for module in re.findall(r"python -m (benchmarks[\w.]*)", text):
        assert (ROOT / module.replace(".", "/")).with_suffix(".py").exists() or module == "benchmarks"


def test_the_reading_order_names_every_notebook_once() -> None:
    read_in_order = re.findall(r"\]\((\w+)\.ipynb\)", read("notebooks/README.md"))
    assert sorted(read_in_order) == sorted(notebooks.names(ROOT))


def test_the_lines_for_your_own_mesh_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (lines,) = re.findall(r"```python\n(.+?)```", read("notebooks/README.md"), re.DOTALL)
    (tmp_path / "notebooks").mkdir()
    write_mesh(shapes.torus(faces=400), tmp_path / "my-shape.obj")
    monkeypatch.chdir(tmp_path / "notebooks")
    shown: list[viz.Picture] = []
    monkeypatch.setattr(viz.Picture, "show", lambda picture: shown.append(picture))
    exec(compile(textwrap.dedent(lines), "notebooks/README.md", "exec"), {})
    assert [picture.pixels.std() > 10 for picture in shown] == [True]
