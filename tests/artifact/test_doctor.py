"""The doctor tells a working renderer from a crash, a hang, an error or an empty picture."""

import json
import platform
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from geoweave.artifact import doctor
from geoweave.checkout import repository
from geoweave.errors import RenderError
from geoweave.models import datasets

CRASH = ("-c", "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)")
HANG = ("-c", "import time; time.sleep(60)")
ERROR = ("-c", "raise ImportError('libGL.so.1: cannot open shared object file')")
EMPTY = ("-c", """print('{"window": "W", "renderer": "R", "red": 0.0, "seconds": 0.1}')""")


def test_the_probe_draws_here() -> None:
    outcome = doctor.require_rendering()
    assert outcome.works
    assert outcome.window.endswith("RenderWindow")
    assert outcome.problem == outcome.remedy == ""


@pytest.mark.parametrize(
    ("probe", "says"),
    [
        (CRASH, r"would crash \(signal 11\)"),
        (HANG, "would hang"),
        (ERROR, "ImportError: libGL.so.1"),
        (EMPTY, "empty picture"),
    ],
    ids=["crash", "hang", "error", "empty"],
)
def test_a_failure_is_an_answer(probe: tuple[str, ...], says: str) -> None:
    outcome = doctor.try_rendering(timeout=1.0 if probe == HANG else 300.0, probe=probe)
    assert not outcome.works
    assert outcome.remedy
    assert re.search(says, outcome.problem)


if platform.system() == "Linux":

    @pytest.fixture
    def no_egl(monkeypatch: pytest.MonkeyPatch) -> None:
        """A machine on which VTK finds no EGL driver: there it dies by SIGSEGV."""
        monkeypatch.setenv("__EGL_VENDOR_LIBRARY_DIRS", "/nonexistent")
        monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

    @pytest.mark.usefixtures("no_egl")
    def test_without_egl_it_stops_with_the_line_to_run() -> None:
        with pytest.raises(RenderError, match="sudo apt-get install libegl1 libgl1-mesa-dri"):
            doctor.require_rendering()

    @pytest.mark.usefixtures("no_egl")
    def test_the_makefile_stops_there(capsys: pytest.CaptureFixture[str]) -> None:
        assert doctor.main(["--rendering"]) == 1
        said = capsys.readouterr()
        assert said.out == ""
        assert said.err.count("\n") == 1
        assert doctor.APT_LINE in said.err


def test_silent_where_all_is_well(capsys: pytest.CaptureFixture[str]) -> None:
    assert doctor.main(["--rendering"]) == 0
    assert capsys.readouterr() == ("", "")


def test_one_json_object(capsys: pytest.CaptureFixture[str]) -> None:
    assert doctor.main(["--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["rendering"]["works"] is True
    assert told["versions"]["numpy"].split(".")[0] >= "2"
    assert told["python"] == platform.python_version()


def test_for_a_person(capsys: pytest.CaptureFixture[str]) -> None:
    assert doctor.main([]) == 0
    text = capsys.readouterr().out
    for word in ("rendering  vtk", "solver     SuperLU", "package    numpy"):
        assert word in text


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "PACKAGES", ("numpy", "no-such-distribution", "papermill"))
    assert doctor.versions()["no-such-distribution"] == ""
    assert "no-such-distribution  not installed" in doctor.examine().as_text()


def test_what_executes_notebooks_is_in_the_extra_that_is_named() -> None:
    project = tomllib.loads((repository() / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extra = {line.split(">=")[0] for line in project["optional-dependencies"]["notebooks"]}
    assert set(doctor.NOTEBOOKS) <= extra
    assert not set(doctor.NOTEBOOKS) & {line.split(">=")[0] for line in project["dependencies"]}
    doctor.require_notebooks()


def test_data_sets_are_told_apart(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(datasets, "_cache", lambda: tmp_path / "empty")
    monkeypatch.delenv(datasets.VARIABLE, raising=False)
    states = doctor.data_states()
    assert {states["spot"], states["armadillo"]} == {"embedded"}
    assert {states["cow"], states["fertility"], states["rocker-arm"]} == {"fetchable"}
    assert any("geoweave fetch" in line for line in doctor.examine().advice)
    monkeypatch.setattr(datasets, "available", lambda name: name == "cow")
    assert doctor.data_states()["cow"] == "available"
    assert doctor.data_states()["spot"] == "damaged"


def test_a_wrong_data_folder_is_advice_not_a_crash(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(datasets.VARIABLE, "/nonexistent")
    diagnosis = doctor.examine()
    assert diagnosis.data == {}
    assert any("/nonexistent" in line for line in diagnosis.advice)


def test_the_doctor_imports_no_renderer() -> None:
    code = (
        "import sys, geoweave.artifact.doctor;"
        "print({'pyvista', 'vtkmodules', 'matplotlib'} & set(sys.modules))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert out.strip() == "set()"
