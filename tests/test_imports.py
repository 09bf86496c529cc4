"""Starting loads next to nothing: lists of all that may be loaded beside the standard library."""

from __future__ import annotations

import subprocess
import sys

import pytest

LOADED = """
import sys
before = set(sys.modules)
{program}
tops = {{name.split(".")[0] for name in set(sys.modules) - before}}
print("loaded:", *sorted(tops - set(sys.stdlib_module_names)))
"""
COMMAND = "from geoweave.cli.main import main; main({arguments})"
SLOW = {"importlib.metadata", "tomllib", "traceback", "rich", "inspect", "multiprocessing", "asyncio"}
"""Modules, some of the standard library, that only some commands need."""


def printed(program: str) -> list[str]:
    """Words of the last line that a program prints in a new process."""
    command = [sys.executable, "-c", program]
    out = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return out.splitlines()[-1].split()


def loaded(program: str) -> set[str]:
    """Packages that a program loads in a new process."""
    return set(printed(LOADED.format(program=program))[1:])


@pytest.mark.parametrize(
    ("program", "allowed"),
    [
        ("import geoweave", {"geoweave", "lazy_loader"}),
        ("import geoweave.viz", {"geoweave", "lazy_loader"}),
        ("import geoweave.artifact.doctor", {"geoweave", "lazy_loader"}),
        (COMMAND.format(arguments=["--version"]), {"geoweave", "lazy_loader", "click"}),
        (COMMAND.format(arguments=["--help"]), {"geoweave", "lazy_loader", "click"}),
        (COMMAND.format(arguments=["weave", "--help"]), {"geoweave", "lazy_loader", "click"}),
        (COMMAND.format(arguments=["info", "bunny"]), {"geoweave", "lazy_loader", "click", "numpy"}),
    ],
)
def test_what_is_loaded(program: str, allowed: set[str]) -> None:
    assert loaded(program) <= allowed
    assert "geoweave" in loaded(program)


@pytest.mark.parametrize("module", ["doctor", "figures"])
def test_what_looks_after_the_figures_draws_and_solves_nothing(module: str) -> None:
    program = f"import sys, geoweave.artifact.{module}; print('loaded:', *sys.modules)"
    names = printed(program)
    assert f"geoweave.artifact.{module}" in names
    heavy = {"numpy", "scipy", "numba", "pandas", "matplotlib", "pyvista", "vtk"}
    assert not {name for name in names if name.split(".")[0] in heavy or name.startswith("geoweave.viz.")}


def slow(modules: str) -> list[str]:
    """Which of the slow modules are there after these have been imported."""
    return printed(f"import sys, {modules}; print('slow:', *sorted({SLOW!r} & set(sys.modules)))")


def test_the_command_itself_waits_with_what_is_slow() -> None:
    assert slow("geoweave.cli.main") == slow("click, lazy_loader")
    assert "importlib.metadata" in slow("importlib.metadata")


def test_the_list_sees_what_is_loaded() -> None:
    assert {"numpy", "click"} <= loaded("import numpy, click")
