"""The list of claims names what exists, leaves nothing out, and docs/results.md shows all of it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from geoweave.artifact import claims, figures, notebooks

ROOT = Path(__file__).resolve().parents[2]
CLAIMS = claims.read(ROOT)
OWN = Path(__file__).relative_to(ROOT).as_posix()


@pytest.fixture(scope="module")
def collected() -> set[str]:
    """Every test that pytest collects in the files that the claims name, and in this folder."""
    named = {test.partition("::")[0] for claim in CLAIMS for test in claim.tests if "::" in test}
    files = sorted(file for file in named | {"tests/claims"} if (ROOT / file).exists())
    quiet = [
        "--collect-only",
        "-q",
        "-o",
        "addopts=--import-mode=importlib",
        "-p",
        "no:cacheprovider",
        f"--ignore={OWN}",
    ]
    # The workers of a parallel run leave their name in the environment.
    around = {key: value for key, value in os.environ.items() if not key.startswith("PYTEST_")}
    run = subprocess.run(
        [sys.executable, "-m", "pytest", *quiet, *files], cwd=ROOT, env=around, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stdout
    return {line.partition("[")[0] for line in run.stdout.splitlines() if "::" in line}


def test_every_claim_names_tests_and_notebooks_that_exist(collected: set[str]) -> None:
    functions = {test for claim in CLAIMS for test in claim.tests if "::" in test}
    assert sorted(functions - collected) == []
    for claim in CLAIMS:
        for test in claim.tests:
            if "::" not in test:
                notebook = notebooks.read(ROOT / test)
                checked = [
                    cell
                    for cell in notebooks.code_cells(notebook)
                    if "nbval-check-output" in cell.metadata.get("tags", [])
                ]
                assert checked, f"{claim.id}: {test} has no output that is checked"
                assert any("assert" in cell.source for cell in notebooks.code_cells(notebook)), claim.id


def test_every_test_of_a_claim_is_listed(collected: set[str]) -> None:
    here = {test for test in collected if test.startswith("tests/claims/")}
    assert len(here) > 20
    assert sorted(here - {test for claim in CLAIMS for test in claim.tests}) == []


def test_every_figure_of_part_1_is_checked_by_its_notebook() -> None:
    named = {Path(test).stem for claim in CLAIMS for test in claim.tests if test.endswith(".ipynb")}
    assert sorted(set(notebooks.names(ROOT)) - named - {"00_overview"}) == []


@pytest.mark.parametrize("claim", [each for each in CLAIMS if each.figure], ids=lambda each: each.id)
def test_our_numbers_are_in_the_published_tables(claim: claims.Claim) -> None:
    words = claims.ours(ROOT, claim)
    assert any(letter.isdigit() for letter in words)
    assert "{" not in words


def test_the_page_of_results_holds_the_table() -> None:
    text = (ROOT / "docs" / "results.md").read_text(encoding="utf-8")
    begin, end = (text.index(mark) for mark in figures.CLAIMS)
    between = text[begin + len(figures.CLAIMS[0]) + 1 : end]
    assert between == "\n".join(claims.table(ROOT)) + "\n", "run: make report"
