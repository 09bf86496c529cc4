"""Every link of every notebook leads somewhere, and its last lines are as the checkout has it."""

import re
import shutil
from pathlib import Path

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook

from geoweave.artifact import notebook_links, notebooks
from geoweave.artifact.notebooks import NotebookError

ROOT = Path(__file__).resolve().parents[2]
NAMES = notebooks.names(ROOT)
LINK = re.compile(r"\]\(([^)\s]+)\)")


def headings(path: Path) -> set[str]:
    text = re.sub(r"```.*?```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    return {notebook_links.anchor(line) for line in re.findall(r"^#+ (.*)$", text, re.MULTILINE)}


def dead(text: str, folder: Path) -> list[str]:
    """Links of a text that lead to no file and to no heading; what is elsewhere is not asked."""
    found = []
    for link in LINK.findall(text):
        if link.startswith("https://"):
            continue
        file, _, place = link.partition("#")
        path = folder / file
        if not path.is_file() or (place and place not in headings(path)):
            found.append(link)
    return found


@pytest.mark.parametrize("name", NAMES)
def test_every_link_of_a_notebook_leads_somewhere(name: str) -> None:
    notebook = notebooks.read(ROOT / "notebooks" / f"{name}.ipynb")
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            assert not dead(cell.source, ROOT / "notebooks")


@pytest.mark.parametrize("name", NAMES)
def test_the_last_lines_are_up_to_date(name: str) -> None:
    last = notebooks.read(ROOT / "notebooks" / f"{name}.ipynb").cells[-1]
    assert last.id == notebook_links.CELL
    assert last.source == notebook_links.links(ROOT, name), "make notebooks writes them"


def test_dead_links_are_found(tmp_path: Path) -> None:
    (tmp_path / "page.md").write_text("# A title: here\n```\n# no heading\n```\n")
    text = "[a](page.md) [b](page.md#a-title-here) [c](page.md#no-heading) [d](gone.md) [e](https://x.org/a)"
    assert dead(text, tmp_path) == ["page.md#no-heading", "gone.md"]


def test_the_paper_is_the_one_that_is_cited() -> None:
    assert f"url: {notebook_links.PAPER}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    (tmp_path / "notebooks").mkdir()
    for name in ("fig01_a", "fig02_b", "beyond1_c"):
        cells = [new_markdown_cell(f"# {name}: a [title]", id="m"), new_code_cell("1", id="c")]
        nbformat.write(new_notebook(cells=cells), tmp_path / "notebooks" / f"{name}.ipynb")
    words = (
        '[sections]\nfig01_a = "1"\nfig02_b = "2"\nbeyond1_c = "3"\n[deviations]\nfig02_b = ["one", "two"]\n'
    )
    (tmp_path / "notebooks" / "index.toml").write_text(words)
    (tmp_path / "DEVIATIONS.md").write_text(
        "# D\n## Some rows\n| row | x |\n|---|---|\n| one | 1 |\n| two | 2 |\n"
    )
    return tmp_path


def test_links_are_written_once_and_stay(checkout: Path) -> None:
    assert notebook_links.write_links(checkout) == ["fig01_a", "fig02_b", "beyond1_c"]
    assert notebook_links.write_links(checkout) == []
    first, middle, last = (
        notebooks.read(checkout / "notebooks" / f"{name}.ipynb").cells[-1].source
        for name in ("fig01_a", "fig02_b", "beyond1_c")
    )
    assert "Before: [fig01_a: a title](fig01_a.ipynb). Next: [beyond1_c: a title](beyond1_c.ipynb)." in middle
    assert "`one`, `two` under [Some rows](../DEVIATIONS.md#some-rows)" in middle
    assert "Before" not in first
    assert "Next" not in last
    assert "no row of" in first
    # A notebook that moves changes its neighbours, and nothing is left of what was written before.
    shutil.move(checkout / "notebooks" / "fig02_b.ipynb", checkout / "notebooks" / "gone")
    assert notebook_links.write_links(checkout) == ["fig01_a", "beyond1_c"]
    text = (checkout / "notebooks" / "fig01_a.ipynb").read_text(encoding="utf-8")
    assert "fig02_b" not in text
    assert text.count('"id": "links"') == 1


def test_what_is_not_known_is_said(checkout: Path) -> None:
    words = checkout / "notebooks" / "index.toml"
    words.write_text('[sections]\nfig01_a = "1"\n[deviations]\nfig01_a = ["three"]\n')
    with pytest.raises(NotebookError, match="no row three"):
        notebook_links.links(checkout, "fig01_a")
    with pytest.raises(NotebookError, match="does not have fig02_b"):
        notebook_links.links(checkout, "fig02_b")
