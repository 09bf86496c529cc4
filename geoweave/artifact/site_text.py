"""Text, mathematics and code of a notebook as HTML that needs no script and no network.

latex2mathml (MIT, 0.1 MB) converts TeX to MathML, which today's browsers display without a script. KaTeX and
MathJax support more of TeX, but their scripts run on every page. With fonts they take 0.6 and more than 1 MB.
"""

from __future__ import annotations

import html
import posixpath
import re
import unicodedata
from collections.abc import Mapping
from functools import cache
from typing import Any
from xml.etree import ElementTree

from latex2mathml.converter import convert
from markdown_it import MarkdownIt
from mdit_py_plugins.anchors import anchors_plugin
from mdit_py_plugins.dollarmath import dollarmath_plugin
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import PythonLexer

from geoweave.artifact.notebook_links import anchor
from geoweave.artifact.notebooks import NotebookError

__all__ = ["code_html", "code_style", "equation", "plain", "text_html"]


def text_html(
    source: str,
    pages: Mapping[str, str] | None = None,
    *,
    base: str = "notebooks",
    pictures: Mapping[str, str] | None = None,
) -> str:
    """Markdown with mathematics between dollars, as HTML.

    Parameters
    ----------
    source : Markdown; HTML in it is shown as text
    pages : addresses of pages by the files of the checkout that they show; links to other files become text
    base : folder of the checkout that relative links start from
    pictures : addresses of pictures by what the text calls them

    Raises
    ------
    NotebookError
        If an equation cannot be converted, or a picture in the text is not among the given ones.
    """
    tokens = _markdown().parse(source)
    for token in tokens:
        _relinked(token.children or [], pages or {}, base, pictures or {})
    return str(_markdown().renderer.render(tokens, _markdown().options, {}))


def equation(tex: str, display: bool = False) -> str:
    """An equation as MathML. One on a line of its own can be scrolled where it is too wide.

    Raises
    ------
    NotebookError
        If it cannot be converted.
    """
    try:
        found = convert(tex.strip(), display="block" if display else "inline")
    except Exception as error:  # the converter raises many kinds of error, some without a common base
        raise NotebookError(f"the equation ${tex}$ cannot be set ({error!r}); write it anew") from error
    if re.search(r"\\\\[a-zA-Z]", tex) and r"\begin" not in tex:
        raise NotebookError(f"the equation ${tex}$ has a doubled backslash, which ends a line; write one")
    bare = re.sub(r"\\.", "", tex)
    found = found.replace(' xmlns="http://www.w3.org/1998/Math/MathML"', "")
    whole = all(len(part) == PARTS.get(part.tag, len(part)) for part in ElementTree.fromstring(found).iter())
    if "\\" in plain(found) or bare.count("{") != bare.count("}") or not whole:
        raise NotebookError(f"the equation ${tex}$ has an unknown command or lacks a part; write it anew")
    found = re.sub(r'<mi mathvariant="([a-z-]+)">([^<]*)</mi>', _lettered, found)
    # As in TeX, a hat on a letter does not raise the letter's exponent.
    found = re.sub(_HAT, r'\1<mpadded height="0.48em">\2</mpadded>', found)
    return f'<div class="equation">{found}</div>' if display else found


PARTS = {"mfrac": 2, "mroot": 2, "msub": 2, "msup": 2, "mover": 2, "munder": 2, "msubsup": 3, "munderover": 3}
"""How many parts elements of MathML have."""

_HAT = (
    r"(<msu(?:p|bsup)>)"
    r"(<mover[^>]*>(?:<mrow>)?<mi>[^<]*</mi>(?:</mrow>)?<mo>[^<]*</mo></mover>)"
)


def _lettered(letters: re.Match[str]) -> str:
    """Replace bold, script and other letters by Unicode characters: browsers dropped ``mathvariant``."""
    if letters[1] == "normal":
        return letters[0]
    prefix = letters[1].replace("-", " ").upper()
    form = re.compile(rf"(MATHEMATICAL )?{prefix} (SMALL|CAPITAL|DIGIT) \w+")
    known = {
        unicodedata.normalize("NFKC", chr(code)): chr(code)
        for code in (*range(0x2100, 0x2150), *range(0x1D400, 0x1D800))
        if form.fullmatch(unicodedata.name(chr(code), ""))
    }
    return f"<mi>{''.join(known.get(each, each) for each in html.unescape(letters[2]))}</mi>"


def plain(markup: str) -> str:
    """The text of a piece of HTML without its elements."""
    return html.unescape(re.sub(r"<[^>]*>", "", markup)).strip()


def code_html(source: str) -> str:
    """Python as HTML with classes for `code_style`."""
    return str(highlight(source, PythonLexer(), _formatter()))


def code_style() -> str:
    """The style sheet of `code_html`."""
    return str(_formatter().get_style_defs(".highlight"))


@cache
def _formatter() -> Any:
    return HtmlFormatter(style="friendly", cssclass="highlight", wrapcode=True)


@cache
def _markdown() -> MarkdownIt:
    markdown = MarkdownIt("commonmark", {"html": False, "typographer": False, "xhtmlOut": False}).enable(
        "table"
    )
    markdown.use(anchors_plugin, max_level=4, slug_func=anchor)
    # Called once for each equation, so that the error names the equation that failed.
    return markdown.use(
        dollarmath_plugin,
        renderer=lambda tex, options: equation(tex, options["display_mode"]),
    )


def _relinked(tokens: list[Any], pages: Mapping[str, str], base: str, pictures: Mapping[str, str]) -> None:
    """Point links to files at their pages; drop links to files that the site does not contain."""
    open_ones: list[Any] = []
    for token in tokens:
        if token.type == "image":
            shown = pictures.get(str(token.attrs["src"]))
            if shown is None:
                raise NotebookError(
                    "a picture in the text of a notebook would be missing here; draw it in a cell"
                )
            token.attrs |= {"src": shown, "loading": "lazy"}
        if token.type == "link_open":
            target = str(token.attrs["href"])
            file, hash_sign, place = target.partition("#")
            page = pages.get(posixpath.normpath(posixpath.join(base, file)))
            if page is not None and file:
                # Where a page stands for the whole of a document, its headings are not on it.
                token.attrs["href"] = (
                    page if "#" in page or page == "index.html" else page + hash_sign + place
                )
            elif not re.match(r"https?://|#", target):
                token.tag, token.attrs = "span", {}
            open_ones.append(token)
        if token.type == "link_close":
            token.tag = open_ones.pop().tag
