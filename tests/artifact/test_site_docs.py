"""Documents on the site: which are there, and where their links lead."""

from __future__ import annotations

import re
from pathlib import Path

from geoweave.artifact.site_docs import DOCUMENTS, addresses, documents
from geoweave.checkout import repository

ROOT = repository()


def test_every_document_for_a_reader_has_a_page() -> None:
    there = {path.relative_to(ROOT).as_posix() for path in (ROOT / "docs").glob("*.md")}
    assert there | {"DEVIATIONS.md"} <= set(addresses([]))
    assert all((ROOT / file).is_file() for file in DOCUMENTS.values())


def test_pictures_of_a_document_are_files_of_the_checkout() -> None:
    found = {each.name: each for each in documents(ROOT, [])}
    assert list(found) == list(DOCUMENTS)
    making = found["making"]
    assert making.title
    assert set(re.findall(r'src="images/(.*?)"', making.body)) == set(making.pictures)
    assert all(path.is_file() for path in making.pictures.values())


def test_what_is_not_there_has_no_page(tmp_path: Path) -> None:
    (tmp_path / "DEVIATIONS.md").write_text("# Where we differ\n\nSee [making](docs/making.md#sheets).")
    (one,) = documents(tmp_path, [])
    assert (one.name, one.title, one.pictures) == ("deviations", "Where we differ", {})
    assert 'href="making.html#sheets"' in one.body
