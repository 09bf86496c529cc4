"""The notebooks as pages that are read in a browser without a network: ``make site`` writes ``build/site``.

Nothing is executed: text, code and the stored outputs of ``notebooks/``, one page each, the documents for
makers and readers, an index with thumbnails and a search, and the claims of the paper beside our numbers.
"""

from __future__ import annotations

import argparse
import ast
import base64
import html
import io
import json
import re
import shutil
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from PIL import Image

from geoweave.artifact import claims, notebooks
from geoweave.artifact.site_docs import DOCUMENTS, Document, addresses, documents
from geoweave.artifact.site_font import NOTICE, characters, math_font
from geoweave.artifact.site_text import code_html, code_style, plain, text_html
from geoweave.checkout import PACKAGE, repository
from geoweave.errors import GeoweaveError
from geoweave.files import OutputError
from geoweave.wording import counted

__all__ = ["Page", "build", "main", "page_of"]

THUMBNAIL = 640
"""Pixels across a thumbnail."""


class Page(NamedTuple):
    """A notebook as HTML."""

    name: str
    title: str
    """Without elements."""
    heading: str
    """With its mathematics."""
    question: str
    """The first paragraph."""
    body: str
    pictures: dict[str, bytes]
    """PNG files by name, and pages with a view to be turned."""


def build(root: Path, target: Path) -> list[Path]:
    """Write the pages of a checkout's notebooks into a folder. The whole folder is replaced.

    Parameters
    ----------
    root : the checkout
    target : the folder; its parent is made if it is not there

    Raises
    ------
    NotebookError
        If a notebook cannot be read, or an equation in it cannot be converted.
    ClaimError
        If the list of claims does not fit the tables under ``figures/``.
    OutputError
        If the folder exists and is not an earlier site.
    """
    if (
        target.exists()
        and not (target / "site.css").is_file()
        and (target.is_file() or any(target.iterdir()))
    ):
        raise OutputError(f"{target}: is there and is no earlier site; name another folder")
    names = notebooks.names(root)
    known = addresses(names)
    pages = [page_of(notebooks.read(notebooks.path_of(root, name)), name, known) for name in names]
    papers = documents(root, names)
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{target.name}.", dir=target.parent) as scratch:
        fresh = Path(scratch) / "site"
        (fresh / "images").mkdir(parents=True)
        style = (PACKAGE / "artifact" / "site.css").read_text(encoding="utf-8")
        _write(fresh / "site.css", f"/* {NOTICE} */\n{style}\n{code_style()}\n")
        (fresh / "math.woff").write_bytes(
            math_font(characters([page.body for page in pages] + [paper.body for paper in papers]))
        )
        for before, page, after in zip([None, *pages[:-1]], pages, [*pages[1:], None], strict=True):
            for name, data in page.pictures.items():
                (fresh / "images" / name).write_bytes(data)
            _write(fresh / f"{page.name}.html", _framed(page.title, _article(page, before, after)))
        for paper in papers:
            for name, path in paper.pictures.items():
                shutil.copyfile(path, fresh / "images" / name)
            _write(fresh / f"{paper.name}.html", _framed(paper.title, _document(paper)))
        cards = "\n".join(_card(root, page, fresh) for page in pages)
        table = _claims(root, frozenset(names))
        _write(fresh / "index.html", _framed(TITLE, _index(cards, table, papers)))
        _write(fresh / "search.js", _search([*pages, *papers]))
        if target.exists():
            shutil.rmtree(target)
        fresh.rename(target)
    return sorted(path for path in target.rglob("*") if path.is_file())


def page_of(notebook: Any, name: str, known: Mapping[str, str] | None = None) -> Page:
    """A notebook as HTML, from what is stored in it; ``known`` are pages that its links may lead to.

    Raises
    ------
    NotebookError
        If an equation cannot be converted.
    """
    parts: list[str] = []
    pictures: dict[str, bytes] = {}
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts.append(f'<section class="text">\n{text_html(cell.source, known)}</section>')
        elif cell.cell_type == "code":
            lines = len(cell.source.splitlines())
            label = "parameters" if "parameters" in cell.metadata.get("tags", []) else "code"
            parts.append(
                f'<details class="code"><summary>{label}, {lines} line{"s" * (lines != 1)}</summary>\n'
                f"{code_html(cell.source)}</details>"
            )
            parts += [_output(output, name, pictures) for output in cell.outputs]
    heading = re.search(r"<h1[^>]*>(.*?)</h1>", "\n".join(parts), re.S)
    question = re.search(
        r"</h1>\s*<p>(?:<strong>The question\.</strong>\s*)?(.*?)</p>", "\n".join(parts), re.S
    )
    shown = heading[1] if heading else html.escape(name)
    return Page(
        name, plain(shown), shown, question[1] if question else "", "\n".join(filter(None, parts)), pictures
    )


def _output(output: Any, name: str, pictures: dict[str, bytes]) -> str:
    """A stored output: a picture, or text in a box that can be scrolled."""
    if output.output_type == "stream":
        return _printed(output.text)
    if output.output_type == "error":
        return _printed("\n".join(re.sub(r"\x1b\[[\d;]*m", "", line) for line in output.traceback))
    data = output.get("data", {})
    said = str(data.get("text/plain", ""))
    if "image/png" not in data:
        return _view(data.get("text/html", ""), name, pictures) or _printed(said)
    png = base64.b64decode(data["image/png"])
    file = f"{name}-{sum(each.endswith('.png') for each in pictures) + 1}.png"
    pictures[file] = png
    width, height = Image.open(io.BytesIO(png)).size
    alt = html.escape(_alt(said), quote=True)
    return (
        f'<figure><a href="images/{file}"><img src="images/{file}" alt="{alt}" width="{width}" '
        f'height="{height}" loading="lazy"></a></figure>'
    )


def _view(markup: str, name: str, pictures: dict[str, bytes]) -> str:
    """A view to be turned, as a page of its own that is loaded when it is scrolled to; "" for other HTML."""
    found = re.match(r'<iframe srcdoc="([^"]*)" title="([^"]*)"', markup)
    if not found:
        return ""
    file = f"{name}-view-{sum(each.endswith('.html') for each in pictures) + 1}.html"
    pictures[file] = html.unescape(found[1]).encode("utf-8")
    frame = f'<iframe class="view" src="images/{file}" title="{found[2]}" loading="lazy"></iframe>'
    return f"<figure>{frame}</figure>"


def _printed(text: str) -> str:
    return f'<pre class="out" tabindex="0">{html.escape(text.rstrip())}</pre>' if text.strip() else ""


def _alt(said: str) -> str:
    """What a picture shows: the words in ``Picture('...')``."""
    found = re.fullmatch(r"Picture\((.*)\)", said, re.S)
    try:
        return str(ast.literal_eval(found[1])) if found else ""
    except (ValueError, SyntaxError):
        return ""


def _framed(title: str, body: str) -> str:
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html.escape(title)}</title>\n"
        f'<link rel="stylesheet" href="site.css">\n</head>\n<body>\n{body}\n</body>\n</html>\n'
    )


def _article(page: Page, before: Page | None, after: Page | None) -> str:
    def way(other: Page | None, label: str, side: str) -> str:
        return (
            f'<a class="{side}" href="{other.name}.html" title="{html.escape(other.title, quote=True)}">'
            f"{label}</a>"
            if other
            else f'<span class="{side}"></span>'
        )

    bar = (
        f'<nav>{way(before, "Before", "before")}<a href="index.html">All figures</a>'
        f"{way(after, 'Next', 'after')}</nav>"
    )
    source = f'<p class="source">notebooks/{page.name}.ipynb</p>'
    return f"{bar}\n<main>\n{page.body}\n{source}\n</main>\n{bar}"


def _document(paper: Document) -> str:
    bar = '<nav><a href="index.html">All figures</a></nav>'
    source = f'<p class="source">{DOCUMENTS[paper.name]}</p>'
    return f'{bar}\n<main>\n<section class="text">\n{paper.body}</section>\n{source}\n</main>\n{bar}'


def _search(pages: Sequence[Page | Document]) -> str:
    """The script of the search: the words of all pages, and how they are looked for."""
    words = [
        {"address": f"{page.name}.html", "title": page.title, "text": _words(page.body)} for page in pages
    ]
    script = (PACKAGE / "artifact" / "site_search.js").read_text(encoding="utf-8")
    return f"const PAGES = {json.dumps(words, ensure_ascii=False, separators=(',', ':'))};\n{script}"


def _words(body: str) -> str:
    """What a reader sees of a page in one line, without its code."""
    read = re.sub(r"<details.*?</details>", " ", body, flags=re.S)
    return " ".join(plain(re.sub(r"<(?!/?(?:m\w+|code|em|strong|a|span)\b)", " <", read)).split())


def _card(root: Path, page: Page, fresh: Path) -> str:
    """A notebook on the index: its first figure, its heading, its question."""
    picture = next((data for name, data in page.pictures.items() if name.endswith(".png")), None)
    drawn = [root / "figures" / f"{name}.png" for name in _published(root, page.name)]
    source: Any = next((path for path in drawn if path.is_file()), picture and io.BytesIO(picture))
    shown = ""
    if source:
        with Image.open(source) as image:
            small = image.convert("RGB")
        small.thumbnail((THUMBNAIL, THUMBNAIL), Image.Resampling.LANCZOS)
        file = f"{page.name}-small.jpg"
        small.save(fresh / "images" / file, quality=85, optimize=True)
        width, height = small.size
        shown = f'<img src="images/{file}" alt="" width="{width}" height="{height}" loading="lazy">'
    return (
        f'<li><a href="{page.name}.html"><div class="picture">{shown}</div>'
        f"<h2>{page.heading}</h2></a>\n<p>{page.question}</p></li>"
    )


def _published(root: Path, name: str) -> list[str]:
    return notebooks.published(notebooks.read(notebooks.path_of(root, name)))


def _claims(root: Path, known: frozenset[str]) -> str:
    """All claims as a table; a notebook that checks one is a link."""
    rows = []
    for claim in claims.read(root):
        checks = [_check(test, known) for test in dict.fromkeys(t.partition("::")[0] for t in claim.tests)]
        cells = [
            html.escape(each) for each in (claim.section, claim.says, claim.paper, claims.ours(root, claim))
        ]
        labels = ("section", "claim", "paper", "here", "checked by")
        rows.append(
            "<tr>"
            + "".join(
                f'<td data-label="{label}">{cell}</td>'
                for label, cell in zip(labels, [*cells, ", ".join(checks)], strict=True)
            )
            + "</tr>"
        )
    head = "".join(f"<th>{each}</th>" for each in ("section", "claim", "paper", "here", "checked by"))
    return f"<table><thead><tr>{head}</tr></thead>\n<tbody>\n" + "\n".join(rows) + "\n</tbody></table>"


def _check(file: str, known: frozenset[str]) -> str:
    stem = Path(file).stem
    return f'<a href="{stem}.html">{stem}</a>' if stem in known else f"<code>{html.escape(stem)}</code>"


TITLE = "Weaving Geodesic Foliations, reproduced"


DESCRIBED = {
    "making": "from a mesh to strips in your hands: materials, sheets, the guide",
    "commands": "every command and its options",
    "python": "the same, step by step",
    "deviations": "where the paper is silent or departed from, and what we tried",
    "reproducing": "times, memory, what may differ",
    "replicability": "what an examiner asks, line by line",
}
"""What the index says of each document."""


def _index(cards: str, table: str, papers: Sequence[Document]) -> str:
    listed = "\n".join(
        f'<li><a href="{paper.name}.html">{html.escape(paper.title)}</a>: {DESCRIBED[paper.name]}</li>'
        for paper in papers
    )
    return f"""<header>
<h1>{TITLE}</h1>
<p>Every figure and number of <em>Weaving Geodesic Foliations</em> (Vekhter, Zhuo, Gil Fandino, Huang,
Vouga; ACM TOG 38(4):34, SIGGRAPH 2019, <a href="https://doi.org/10.1145/3306346.3323043">doi
10.1145/3306346.3323043</a>) that can be computed, computed again. Each page is a notebook: the question, the
equation, the picture, what to see in it, what the paper says, what we measured.
<a href="#claims">All claims, paper and ours</a>.</p>
<ul class="documents">
{listed}
</ul>
<form role="search" hidden><label for="search">Search</label>
<input id="search" type="search" autocomplete="off" placeholder="cut locus, veneer, Table 1">
<span id="said" role="status"></span></form>
</header>
<main class="wide">
<ul id="found"></ul>
<ul class="cards">
{cards}
</ul>
<h2 id="claims">Claim by claim</h2>
<p>Numbers are read from the tables that the notebooks write.</p>
<div class="claims">
{table}
</div>
</main>
<footer><p>Written by <code>make site</code> from the outputs stored in the notebooks. Code under the MIT
licence, text and figures under CC BY 4.0.</p></footer>
<script src="search.js"></script>"""


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")


def main(arguments: Sequence[str] | None = None) -> int:
    """What the Makefile calls; status 2 if the pages cannot be written."""
    parser = argparse.ArgumentParser(prog="python -m geoweave.artifact.site", description=__doc__)
    parser.add_argument("-o", "--output", type=Path, help="the folder (build/site)")
    options = parser.parse_args(arguments)
    try:
        root = repository()
        target = options.output or root / "build" / "site"
        written = build(root, target)
    except GeoweaveError as error:
        print(f"geoweave: {error}", file=sys.stderr)
        return 2
    size = sum(path.stat().st_size for path in written) / 1e6
    print(f"{target / 'index.html'}: {counted(len(written), 'file')}, {size:.1f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
