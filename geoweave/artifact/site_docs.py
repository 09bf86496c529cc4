"""The documents of the checkout that the site shows beside the notebooks, and where their links lead."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from geoweave.artifact.site_text import plain, text_html

__all__ = ["DOCUMENTS", "Document", "addresses", "documents"]

DOCUMENTS = {
    "making": "docs/making.md",
    "commands": "docs/commands.md",
    "python": "docs/python.md",
    "deviations": "DEVIATIONS.md",
    "reproducing": "REPRODUCING.md",
    "replicability": "docs/replicability.md",
}
"""Pages, and the documents that they show."""

ELSEWHERE = {
    "README.md": "index.html",
    "notebooks/README.md": "index.html",
    "figures/INDEX.md": "index.html",
    "docs/results.md": "index.html#claims",
}
"""Documents that the index stands for."""


class Document(NamedTuple):
    """A document as HTML."""

    name: str
    title: str
    body: str
    pictures: dict[str, Path]
    """Files by their name on the site."""


def addresses(names: Iterable[str]) -> dict[str, str]:
    """Pages of the site by the files of the checkout that they show.

    Parameters
    ----------
    names : of notebooks

    Examples
    --------
    >>> from geoweave.artifact.site_docs import addresses
    >>> addresses(["table1"])["notebooks/table1.ipynb"], addresses([])["docs/making.md"]
    ('table1.html', 'making.html')
    """
    found = {f"notebooks/{name}.ipynb": f"{name}.html" for name in names}
    return found | {file: f"{name}.html" for name, file in DOCUMENTS.items()} | ELSEWHERE


def documents(root: Path, names: Iterable[str]) -> list[Document]:
    """All of them that the checkout has, as HTML.

    Raises
    ------
    NotebookError
        If an equation cannot be converted.
    """
    known, found = addresses(names), []
    for name, file in DOCUMENTS.items():
        if not (root / file).is_file():
            continue
        source = (root / file).read_text(encoding="utf-8")
        base = posixpath.dirname(file)
        pictures = {each: f"images/{name}-{posixpath.basename(each)}" for each in _pictures(source)}
        body = text_html(source, known, base=base, pictures=pictures)
        heading = re.search(r"<h1[^>]*>(.*?)</h1>", body, re.S)
        places = {posixpath.basename(shown): root / base / each for each, shown in pictures.items()}
        found.append(Document(name, plain(heading[1]) if heading else name, body, places))
    return found


def _pictures(source: str) -> list[str]:
    """Files that Markdown shows as pictures."""
    return re.findall(r"!\[[^\]]*\]\(([^)\s]+)\)", source)
