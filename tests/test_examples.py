"""Every function that a reader meets shows its use, and every example runs as it stands."""

from __future__ import annotations

import ast
import doctest
import importlib
import inspect
import os
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import geoweave as gw
from geoweave import viz
from geoweave.models import datasets, shapes

PACKAGE = Path(gw.__file__).resolve().parent
WITH_EXAMPLES = sorted(path for path in PACKAGE.rglob("*.py") if ">>> " in path.read_text(encoding="utf-8"))
READERS_MEET = (gw, gw.fabrication, gw.models, viz, datasets, shapes)
"""The modules whose public functions a reader of a notebook or of the README calls."""

RUNNER = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)


def module_of(path: Path) -> ModuleType:
    name = ".".join(("geoweave", *path.relative_to(PACKAGE).with_suffix("").parts))
    return importlib.import_module(name.removesuffix(".__init__"))


def public_functions(module: ModuleType) -> dict[str, object]:
    names = getattr(module, "__all__", None) or vars(module)
    found = {name: getattr(module, name) for name in names if not name.startswith("_")}
    return {
        f"{module.__name__}.{name}": each
        for name, each in found.items()
        if inspect.isfunction(each) and each.__module__.startswith("geoweave")
    }


@pytest.mark.parametrize("path", WITH_EXAMPLES, ids=lambda path: path.relative_to(PACKAGE).as_posix())
def test_examples_run_as_they_stand(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    finder = doctest.DocTestFinder(exclude_empty=True)
    said: list[str] = []
    count = 0
    for test in finder.find(module_of(path), globs={"gw": gw, "np": np, "viz": viz, "os": os}):
        count += len(test.examples)
        RUNNER.run(test, out=said.append)
    assert count
    assert not said, "".join(said)
    assert not list(tmp_path.iterdir()), "an example leaves files behind"


@pytest.mark.parametrize("module", READERS_MEET, ids=lambda module: module.__name__)
def test_every_function_that_a_reader_meets_shows_its_use(module: ModuleType) -> None:
    functions = public_functions(module)
    assert functions
    without = sorted(name for name, each in functions.items() if ">>> " not in (inspect.getdoc(each) or ""))
    assert not without


@pytest.mark.parametrize("path", WITH_EXAMPLES, ids=lambda path: path.relative_to(PACKAGE).as_posix())
def test_examples_stand_under_their_heading(path: Path) -> None:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    kinds = ast.Module | ast.ClassDef | ast.FunctionDef
    texts = [ast.get_docstring(node) or "" for node in ast.walk(tree) if isinstance(node, kinds)]
    # Without a heading, examples are read as part of the section before them.
    divided = [text for text in texts if ">>> " in text and "\n----" in text]
    assert not [text for text in divided if "\nExamples\n--------\n" not in text]
