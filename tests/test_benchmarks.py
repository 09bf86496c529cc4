"""Every benchmark imports, so that a rename leaves none behind; the one of imports measures what it says."""

from __future__ import annotations

import importlib
from pathlib import Path

import pytest

from benchmarks import imports, nesting

FOLDER = Path(imports.__file__).parent


@pytest.mark.parametrize("name", sorted(path.stem for path in FOLDER.glob("*.py")))
def test_every_benchmark_imports(name: str) -> None:
    module = importlib.import_module(f"benchmarks.{name}")
    assert module.__doc__


def test_starting_is_measured_against_numpy() -> None:
    rows = imports.measured(rounds=1)
    assert [row["command"] for row in rows] == list(imports.COMMANDS)
    assert rows[0]["multiple"] == 1.0
    for row in rows[1:]:
        assert row["multiple"] == row["seconds"] / rows[0]["seconds"] > 0
        assert row["allowed"] == imports.ALLOWED[row["command"]]


def test_rows_that_no_laying_can_do_without() -> None:
    """Known answers: long pieces have rows of their own, and what is left of them is used."""
    assert nesting.least_rows([6.0, 6.0, 6.0, 4.0], 10.0) == 3
    assert nesting.least_rows([6.0] * 28, 10.0) == 28
    assert nesting.least_rows([3.0] * 7, 10.0) == 3  # 2.1 rows by length
    assert nesting.least_rows([7.0, 7.0, 4.0, 4.0, 4.0], 10.0) == 4
    assert nesting.least_rows([], 10.0) == 0
