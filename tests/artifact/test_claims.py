from __future__ import annotations

from pathlib import Path

import pytest

from geoweave.artifact import figures
from geoweave.artifact.claims import ClaimError, ours, read, table
from geoweave.errors import GeoweaveError

ENTRY = """
[[claim]]
id = "fast"
section = "4.1"
says = "it is | fast"
test = ["tests/claims/test_a.py::test_b", "notebooks/fig01_c.ipynb"]
paper = "3 s"
figure = "fig01_c"
where = { model = "cow" }
ours = "{seconds:.1f} s for {model}"
"""
PLAIN = '[[claim]]\nid = "so"\nsection = "3"\nsays = "so"\ntest = "tests/test_a.py::test_so"\n'


def checkout(tmp_path: Path, entries: str) -> Path:
    (tmp_path / "tests" / "claims").mkdir(parents=True)
    (tmp_path / "figures").mkdir()
    (tmp_path / "tests" / "claims" / "claims.toml").write_text(entries)
    (tmp_path / "figures" / "fig01_c.csv").write_text("model,seconds\ncow,2.04\npig,slow\ncow,4\n")
    return tmp_path


def test_entries_are_read_and_numbers_filled_in(tmp_path):
    root = checkout(tmp_path, ENTRY + PLAIN)
    first, second = read(root)
    assert first.tests == ("tests/claims/test_a.py::test_b", "notebooks/fig01_c.ipynb")
    assert second.tests == ("tests/test_a.py::test_so",)
    assert ours(root, first) == "2.0 s for cow, 4.0 s for cow"
    assert ours(root, second) == ""


def test_the_table_shows_every_claim(tmp_path):
    lines = table(checkout(tmp_path, ENTRY + PLAIN))
    assert lines[0].startswith("All 2 claims")
    assert lines[-2] == (
        "| 4.1 | it is \\| fast | 3 s | 2.0 s for cow, 4.0 s for cow | "
        "[test_a](../tests/claims/test_a.py), [fig01_c](../notebooks/fig01_c.ipynb) |"
    )
    assert len(lines) == 6


def test_it_is_written_between_its_marks(tmp_path):
    root = checkout(tmp_path, ENTRY)
    page = root / "docs" / "results.md"
    page.parent.mkdir()
    page.write_text("before\n" + figures.CLAIMS[0] + "\nold\n" + figures.CLAIMS[1] + "\nafter\n")
    figures.report_claims(root)
    once = page.read_text()
    figures.report_claims(root)
    assert page.read_text() == once
    assert once.startswith("before\n")
    assert once.endswith(figures.CLAIMS[1] + "\nafter\n")
    assert "2.0 s for cow" in once
    assert "old" not in once
    page.write_text("no marks")
    with pytest.raises(GeoweaveError, match=r"results\.md must hold"):
        figures.report_claims(root)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('id = "fast"', "", "claim 'number 0' has no 'id'"),
        ('says = "it is | fast"', "", "claim 'fast' has no 'says'"),
        ('paper = "3 s"', 'papre = "3 s"', "a 'papre', which means nothing"),
        ('figure = "fig01_c"', "", "needs both 'ours' and 'figure'"),
        ("[[claim]]", "[claim", "holds no list of claims"),
        (ENTRY, ENTRY + ENTRY, "two claims are called 'fast'"),
    ],
)
def test_entries_that_mean_nothing_are_refused(tmp_path, old, new, message):
    with pytest.raises(ClaimError, match=message):
        read(checkout(tmp_path, ENTRY.replace(old, new)))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('figure = "fig01_c"', 'figure = "fig02"', r"fig02\.csv, which is not there"),
        ("{seconds:.1f}", "{hours:.1f}", "a column 'hours'"),
        ("model =", "animal =", "a column 'animal'"),
        ('"cow"', '"hen"', "a row {'model': 'hen'}"),
        ('"cow"', '"pig"', "'slow' in 'seconds' is no number"),
    ],
)
def test_numbers_that_are_not_there_are_refused(tmp_path, old, new, message):
    root = checkout(tmp_path, ENTRY.replace(old, new))
    with pytest.raises(ClaimError, match=message):
        ours(root, read(root)[0])
