"""Messages name one of a thing and many of it rightly: counts stand before their nouns by one function."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import geoweave
from geoweave.wording import counted, plural

PACKAGE = Path(geoweave.__file__).parent

NOUNS = (
    "bytes|cells|components|corners|crossings|edges|ends|faces|facets|families|files|holes|joins|joints|lines|"
    "loops|middles|numbers|objects|openings|pages|pairs|parts|pieces|places|points|ribbons|rods|segments|sheets|"
    "shells|specks|spots|steps|strips|times|triangles|vertices"
)
COUNTED = re.compile(
    rf" (?!of |on |has |have )(?:(?:more|open|such|handle|mesh|boundary) ){{0,2}}(?:{NOUNS})\b"
)
NEVER_ONE = {
    "cli/weave_command.py": {"all_of_them", "found.parts", "on"},  # crossings held, of more than one part
    "fabrication/crossing_order.py": {"len(found)", "places"},  # the line says "one place" for one
    "fabrication/making_limits.py": {"times"},
    "fabrication/strip_layout.py": {"len(sheets)"},  # more than MOST_SHEETS
    "fields/trivial_connection.py": {"degree"},
    "foliation/foliation.py": {"mesh.n_faces", "w.mesh.n_faces"},
    "foliation/level_set_alignment.py": {"field.mesh.n_faces"},
    "meshing/contents.py": {"len(inside)"},  # one file would be read
    "meshing/faults.py": {"mesh.n_components"},
    "meshing/polygons.py": {"n"},  # more than MOST_CORNERS
    "meshing/prepare.py": {"len(one_sided)", "len(component)"},  # a strip takes three
    "pipeline/attempt.py": {"parts"},
    "pipeline/request.py": {"self.strips"},  # a word
    "surface/submesh.py": {"mesh.n_faces"},
    "twin/contradictions.py": {"len(surface.pieces)"},
    "viz/film.py": {"buffer.tell()"},
    "viz/periodic.py": {"circle.mesh.n_faces"},
    "viz/picture.py": {"limit"},
    "weave/cover.py": {"self.degree"},
    "weave/design.py": {"wanted"},  # of more crossings than MOST_CROSSINGS
    "weave/validity.py": {"fewest"},  # two
    "weave/weave_types.py": {"families"},
}
"""Numbers that are more than one where they are said, or of a mesh, of which a message tells no one."""


def slips(text: str) -> Iterator[str]:
    """Every number in an f-string that stands before a plural, as it is in the code."""
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.JoinedStr):
            continue
        for value, words in zip(node.values, node.values[1:], strict=False):
            if not isinstance(value, ast.FormattedValue) or not isinstance(words, ast.Constant):
                continue
            form = "" if value.format_spec is None else ast.unparse(value.format_spec)[2:-1]
            if form in ("", ",", "d") and COUNTED.match(str(words.value)):
                yield ast.unparse(value.value)


def test_no_number_stands_before_a_plural_that_could_be_one() -> None:
    found = {
        f"{name}: {{{said}}}"
        for path in PACKAGE.rglob("*.py")
        for name in [path.relative_to(PACKAGE).as_posix()]
        for said in slips(path.read_text(encoding="utf-8"))
        if said not in NEVER_ONE.get(name, set()) and not said.startswith("counted(") and not said.isupper()
    }
    assert found == set()


@pytest.mark.parametrize(
    ("code", "found"),
    [
        ("f'{n} holes through it'", ["n"]),
        ("f'{len(x):,} open edges'", ["len(x)"]),
        ("f'{share:.0%} of the crossings'", []),
        ("f'{n} mm'", []),
    ],
)
def test_the_search_finds_what_it_is_for(code: str, found: list[str]) -> None:
    assert list(slips(code)) == found


def test_one_and_many() -> None:
    assert (plural("vertex"), plural("boundary loop"), plural("mesh")) == (
        "vertices",
        "boundary loops",
        "meshes",
    )
    assert counted(0, "hole") == "0 holes"
    assert counted(1, "hole", "is are") == "1 hole is"
    assert counted(2_000, "hole", "is are") == "2,000 holes are"
