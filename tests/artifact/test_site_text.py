"""Mathematics, Markdown and code as HTML."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import nbformat
import pytest

from geoweave.artifact import notebooks
from geoweave.artifact.notebooks import NotebookError
from geoweave.artifact.site_text import code_html, code_style, equation, plain, text_html
from geoweave.checkout import repository

ROOT = repository()
MATHML = {
    "math",
    "mrow",
    "mi",
    "mn",
    "mo",
    "mtext",
    "mspace",
    "msup",
    "msub",
    "msubsup",
    "mfrac",
    "msqrt",
} | {
    *("mover", "munder", "munderover", "mstyle", "mpadded", "mtable", "mtr", "mtd", "mphantom", "mroot"),
}
"""What MathML Core has, of which browsers set everything."""


@pytest.mark.parametrize("name", notebooks.names(ROOT))
def test_every_equation_of_the_notebooks_is_set(name: str) -> None:
    cells = nbformat.read(ROOT / "notebooks" / f"{name}.ipynb", 4).cells
    found = "\n".join(text_html(cell.source) for cell in cells if cell.cell_type == "markdown")
    outside = re.sub(r"<code>.*?</code>|<pre>.*?</pre>", "", found, flags=re.S)
    assert "$" not in outside
    assert "\\" not in plain(outside)
    assert "http://" not in found
    for markup in re.findall(r"<math.*?</math>", found, re.S):
        tree = ElementTree.fromstring(markup)
        assert {element.tag for element in tree.iter()} <= MATHML
        # Browsers know no other variant than this one.
        assert {element.get("mathvariant", "normal") for element in tree.iter()} == {"normal"}
        assert plain(markup)


def test_an_equation_says_what_it_says() -> None:
    tree = ElementTree.fromstring(equation(r"\tfrac12 \|\nabla s\|^2"))
    (fraction,) = tree.iter("mfrac")
    assert [part.text for part in fraction.iter("mn")] == ["1", "2"]
    (power,) = tree.iter("msup")
    assert [part.text for part in power] == ["‖", "2"]
    assert plain(equation(r"\theta = \mathbf w \cdot \mathcal H")) == "θ=𝐰·ℋ"
    assert '<div class="equation"><math display="block">' in equation("a = b", display=True)
    assert '<mpadded height="0.48em">' in equation(r"\hat w^\perp")
    assert "mpadded" not in equation(r"w^\perp")


@pytest.mark.parametrize("bad", [r"\frac{1}", r"\nonsense x", r"{a", r"\begin{cases} a", r"1/\\sqrt3"])
def test_an_equation_that_is_not_understood_is_named(bad: str) -> None:
    with pytest.raises(NotebookError, match=re.escape(f"the equation ${bad}$")):
        text_html(f"Here: ${bad}$")


def test_markup_in_the_text_stays_text() -> None:
    found = text_html('a <script>alert(1)</script> <img src="http://x/y.png"> b')
    assert "<script" not in found
    assert "<img" not in found
    assert "alert(1)" in plain(found)
    with pytest.raises(NotebookError, match="a picture in the text"):
        text_html("![x](picture.png)")


def test_links_lead_to_pages_or_nowhere() -> None:
    text = "[a](fig07_sphere.ipynb) [b](../notebooks/table1.ipynb) [c](../README.md) [d](https://doi.org/1)"
    found = text_html(text, {"notebooks/fig07_sphere.ipynb": "fig07_sphere.html"})
    assert re.findall(r'href="(.*?)"', found) == ["fig07_sphere.html", "https://doi.org/1"]
    assert plain(found) == "a b c d"
    assert found.count("<span>") == found.count("</span>") == 2


def test_links_between_documents_keep_their_place() -> None:
    pages = {"DEVIATIONS.md": "deviations.html", "docs/results.md": "index.html#claims"}
    found = text_html("[a](../DEVIATIONS.md#the-field) [b](results.md#one) [c](#here)", pages, base="docs")
    assert re.findall(r'href="(.*?)"', found) == ["deviations.html#the-field", "index.html#claims", "#here"]


def test_a_document_shows_its_pictures_and_names_its_headings() -> None:
    found = text_html("# One: two\n\n![a page](x/page.png)", pictures={"x/page.png": "images/p.png"})
    assert '<h1 id="one-two">' in found
    assert 'src="images/p.png" alt="a page" loading="lazy"' in found


def test_code_is_coloured_and_unchanged() -> None:
    source = 'mesh = gw.shapes.disk(2)  # "<faces>" & more\nassert mesh.n_faces > 3, "few"'
    found = code_html(source)
    assert plain(found) == source
    classes = set(re.findall(r'<span class="(\w+)">', found))
    assert {"c1", "k", "mi"} <= classes
    assert all(f".highlight .{each} " in code_style() for each in ("c1", "k"))
