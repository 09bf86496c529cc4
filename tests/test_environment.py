"""pyproject.toml, environment.yml, requirements.lock and the other pages about the project say the same."""

import json
import os
import re
import shutil
import subprocess
import tomllib
from pathlib import Path
from unittest import mock

import nbformat
import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parent.parent
PROJECT_FILE = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = PROJECT_FILE["project"]
ASKED = [
    Requirement(line)
    for line in [
        *PROJECT["dependencies"],
        *(r for extra in PROJECT["optional-dependencies"].values() for r in extra),
    ]
]
PINNED = [
    Requirement(line)
    for line in (ROOT / "requirements.lock").read_text(encoding="utf-8").splitlines()
    if line and not line.startswith("#")
]
PLATFORMS = [
    {"sys_platform": system, "platform_system": name, "platform_machine": machine, "os_name": kind}
    for system, name, machine, kind in (
        ("linux", "Linux", "x86_64", "posix"),
        ("linux", "Linux", "aarch64", "posix"),
        ("darwin", "Darwin", "arm64", "posix"),
        ("win32", "Windows", "AMD64", "nt"),
    )
]
CONDA = yaml.safe_load((ROOT / "environment.yml").read_text(encoding="utf-8"))


def machines() -> list[dict[str, str]]:
    common = {"implementation_name": "cpython", "platform_python_implementation": "CPython", "extra": ""}
    return [
        {**common, **place, "python_version": python, "python_full_version": f"{python}.4"}
        for place in PLATFORMS
        for python in ("3.11", "3.12", "3.13")
    ]


def test_conda_has_the_bounds_of_pyproject() -> None:
    conda = {}
    packages = [line for line in CONDA["dependencies"] if isinstance(line, str)]
    by_pip = next(entry["pip"] for entry in CONDA["dependencies"] if isinstance(entry, dict))
    for line in [*packages, *by_pip]:
        requirement = Requirement(line)
        conda[canonicalize_name(requirement.name)] = str(requirement.specifier)
    assert conda.pop("python") == PROJECT["requires-python"]
    assert conda.pop("pip") == ""
    assert conda == {canonicalize_name(r.name): str(r.specifier) for r in ASKED}


def test_conda_asks_one_channel() -> None:
    assert CONDA["channels"] == ["conda-forge", "nodefaults"]


@pytest.mark.parametrize(
    "machine", machines(), ids=lambda m: f"{m['sys_platform']}-{m['platform_machine']}-{m['python_version']}"
)
def test_the_lock_pins_all_that_is_asked(machine: dict[str, str]) -> None:
    here: dict[str, Requirement] = {}
    for pin in PINNED:
        if pin.marker is None or pin.marker.evaluate(machine):
            assert canonicalize_name(pin.name) not in here, f"{pin.name} is pinned twice"
            here[canonicalize_name(pin.name)] = pin
    for asked in ASKED:
        if asked.marker is None or asked.marker.evaluate(machine):
            (only,) = here[canonicalize_name(asked.name)].specifier
            assert only.operator == "=="
            assert asked.specifier.contains(only.version), f"{asked} against {only}: run make lock"


def test_the_lock_names_no_place() -> None:
    for pin in PINNED:
        assert pin.url is None
    text = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    assert not re.search(r"https?:|file:|--|\s/", text)


def test_jupyterlab_moves_no_pinned_version() -> None:
    """What `make lab` installs beside the pinned packages: the same versions, and JupyterLab as asked for."""
    lines = (ROOT / "requirements-lab.lock").read_text(encoding="utf-8").splitlines()
    lab = [Requirement(line) for line in lines if line and not line.startswith("#")]
    pinned = {(canonicalize_name(pin.name), str(pin.specifier)) for pin in PINNED}
    names = {name for name, _ in pinned}
    for pin in lab:
        assert pin.url is None
        name = canonicalize_name(pin.name)
        assert name not in names or (name, str(pin.specifier)) in pinned, f"{pin}: run make lock"
    (asked,) = map(Requirement, PROJECT_FILE["dependency-groups"]["lab"])
    (found,) = (pin for pin in lab if canonicalize_name(pin.name) == canonicalize_name(asked.name))
    (only,) = found.specifier
    assert asked.specifier.contains(only.version)


@pytest.mark.skipif(shutil.which("make") is None, reason="needs make")
def test_jupyterlab_does_not_write_over_the_committed_figures() -> None:
    recipe = subprocess.run(
        ["make", "-n", "lab", "LABFLAGS=--no-browser"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    assert "requirements-lab.lock" in recipe
    assert f'GEOWEAVE_FIGURES="{ROOT}/build/lab/figures"' in recipe
    assert "-m jupyterlab" in recipe
    assert "--no-browser" in recipe


def test_every_way_to_start_installs_what_drawing_needs() -> None:
    """Container, Binder, dev container: the libraries of graphics_library.sh, and the pinned .venv."""
    script = (ROOT / "scripts" / "graphics_library.sh").read_text(encoding="utf-8")
    (packages,) = re.findall(r'^PACKAGES="(.+)"$', script, re.MULTILINE)
    container = json.loads((ROOT / ".devcontainer" / "devcontainer.json").read_text(encoding="utf-8"))
    docker = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    binder = (ROOT / "binder" / "apt.txt").read_text(encoding="utf-8").split()
    for package in packages.split():
        assert package in binder
        assert package in docker
        assert package in container["onCreateCommand"]
    post = ROOT / "binder" / "postBuild"
    assert os.access(post, os.X_OK)
    for text in (docker, post.read_text(encoding="utf-8"), container["postCreateCommand"]):
        assert "make .venv/.complete" in text
    assert "make figures && make test" in docker
    assert (ROOT / "binder" / "runtime.txt").read_text(encoding="utf-8").strip() == "python-3.11"


def test_the_notebook_for_colab_installs_this_package_and_runs_a_figure() -> None:
    notebook = nbformat.read(ROOT / "binder" / "colab.ipynb", as_version=4)
    nbformat.validate(notebook)
    install, weave, figure = (cell.source for cell in notebook.cells if cell.cell_type == "code")
    script = (ROOT / "scripts" / "graphics_library.sh").read_text(encoding="utf-8")
    (packages,) = re.findall(r'^PACKAGES="(.+)"$', script, re.MULTILINE)
    assert packages in install
    (folder,) = re.findall(r"git clone .* (\w+)$", install, re.MULTILINE)
    assert f"./{folder} " in install
    # what has to be set before anything is drawn is what the kernels of Binder get
    for name in re.findall(
        r"--env (VTK\w+) (\w+)", (ROOT / "binder" / "postBuild").read_text(encoding="utf-8")
    ):
        assert '{}="{}"'.format(*name) in weave
    assert weave.index("os.environ") < weave.index("import geoweave")
    (path,) = re.findall(rf"%run {folder}/(\S+)", figure)
    assert (ROOT / path).is_file()
    names: dict[str, object] = {}
    with mock.patch.dict(os.environ):
        exec(compile(weave, "colab", "exec"), names)
    assert len(names["woven"].ribbons) > 20  # type: ignore[attr-defined]


def test_ci_runs_the_readme_command() -> None:
    script = ROOT / ".ci" / "run"
    assert os.access(script, os.X_OK)
    assert "exec make test" in script.read_text(encoding="utf-8")
    assert "make test" in (ROOT / "README.md").read_text(encoding="utf-8")
    workflow = yaml.safe_load((ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8"))
    steps = "\n".join(step.get("run", "") for step in workflow["jobs"]["reproduce"]["steps"])
    for needed in (".ci/run", "make figures", "libegl1", "libgl1-mesa-dri", "git diff --exit-code"):
        assert needed in steps


def test_make_alone_lists_its_targets() -> None:
    out = subprocess.run(
        ["make", "--no-print-directory"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    for target in ("help", "figures", "notebooks", "lab", "test", "lint", "bench", "lock", "clean"):
        assert re.search(rf"^ +{target} +\w", out, re.MULTILINE), target


def test_the_citation_is_of_this_version() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert citation["version"] == PROJECT["version"]
    assert citation["license"] == PROJECT["license"]
    assert citation["preferred-citation"]["doi"] == "10.1145/3306346.3323043"
    assert f"## {PROJECT['version']}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
