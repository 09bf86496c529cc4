"""What works on this machine (rendering, solver, data, versions) and what to install.

This module never imports a renderer: where the graphics library is missing, VTK ends its process by a signal,
and the child ``python -m geoweave.viz.probe`` is the process that it may end.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import os
import platform
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass

from geoweave.errors import DataError, GeoweaveError, RenderError

PACKAGES = (
    "geoweave",
    "numpy",
    "scipy",
    "numba",
    "pymetis",
    "pandas",
    "trimesh",
    "matplotlib",
    "vtk",
    "pyvista",
    "papermill",
    "nbval",
)
"""Distributions whose versions matter to the figures."""

NOTEBOOKS = ("ipykernel", "nbformat", "papermill")
"""Distributions that execute notebooks; they come with the extra of that name, not with the package alone."""

APT_LINE = "sudo apt-get install libegl1 libgl1-mesa-dri"
"""What a Debian or Ubuntu machine needs for VTK to draw without a screen."""

PROBE = ("-m", "geoweave.viz.probe")

__all__ = [
    "APT_LINE",
    "NOTEBOOKS",
    "PACKAGES",
    "Diagnosis",
    "Rendering",
    "data_states",
    "examine",
    "main",
    "rendering_environment",
    "require_notebooks",
    "require_rendering",
    "try_rendering",
    "versions",
]


@dataclass(frozen=True)
class Rendering:
    """The outcome of drawing one triangle off-screen in a child process.

    Attributes
    ----------
    works : whether a picture came back with the triangle in it
    window : VTK's class of render window, "" where none came to be
    renderer : the driver's own name, such as "llvmpipe (...)"
    seconds : time of drawing
    problem : what went wrong, "" where nothing did
    remedy : what to run, "" where nothing is needed
    """

    works: bool
    window: str = ""
    renderer: str = ""
    seconds: float = 0.0
    problem: str = ""
    remedy: str = ""


@dataclass(frozen=True)
class Diagnosis:
    """Everything ``geoweave doctor`` says.

    Attributes
    ----------
    python, platform : of this process
    versions : distribution name -> version, "" where it is not installed
    rendering : see :class:`Rendering`
    ordering : the elimination order that factorisations will use
    data : data set name -> "embedded", "available", "fetchable" or "damaged"
    advice : one line for each thing worth installing
    """

    python: str
    platform: str
    versions: Mapping[str, str]
    rendering: Rendering
    ordering: str
    data: Mapping[str, str]
    advice: tuple[str, ...]

    def as_dict(self) -> dict[str, object]:
        """The same as plain values, ready for json."""
        return asdict(self)

    def as_text(self) -> str:
        """The same for a person to read."""
        drawing = self.rendering
        says = f"{drawing.window}, {drawing.renderer}, {drawing.seconds:.1f} s" if drawing.works else "FAILS"
        lines = [f"python     {self.python} on {self.platform}", f"rendering  {says}"]
        if drawing.problem:
            lines.append(f"           {drawing.problem}")
        lines.append(f"solver     {self.ordering}")
        for state in sorted(set(self.data.values())):
            lines.append(f"data       {state}: {', '.join(n for n, s in self.data.items() if s == state)}")
        width = max(len(name) for name in self.versions)
        for name, version in self.versions.items():
            lines.append(f"package    {name:{width}}  {version or 'not installed'}")
        lines.extend(f"to do      {line}" for line in self.advice)
        return "\n".join(lines)


def rendering_environment() -> dict[str, str]:
    """The environment in which every process that draws should run: off-screen, through EGL on Linux."""
    environment = {**os.environ, "PYVISTA_OFF_SCREEN": "true"}
    if platform.system() == "Linux":
        environment.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    return environment


def _remedy() -> str:
    if platform.system() == "Linux":
        return f"run: {APT_LINE}"
    return "run it from a session with a graphical desktop, or update the graphics driver"


def try_rendering(timeout: float = 120.0, probe: Sequence[str] = PROBE) -> Rendering:
    """Draw one triangle in a child process; a crash or a hang there is an answer, never an accident here.

    Parameters
    ----------
    timeout : seconds after which the child counts as hanging
    probe : what the child runs, as arguments of this Python
    """
    command = [sys.executable, *probe]
    try:
        child = subprocess.run(
            command, capture_output=True, text=True, timeout=timeout, env=rendering_environment(), check=False
        )
    except subprocess.TimeoutExpired:
        return Rendering(
            False, problem=f"rendering would hang (no picture in {timeout:g} s)", remedy=_remedy()
        )
    if child.returncode < 0:
        problem = f"rendering would crash (signal {-child.returncode}): VTK finds no EGL or no driver for it"
        return Rendering(False, problem=problem, remedy=_remedy())
    if child.returncode > 0:
        last = (child.stderr.strip().splitlines() or ["no message"])[-1]
        return Rendering(False, problem=f"rendering fails: {last}", remedy=_remedy())
    found = json.loads(child.stdout.splitlines()[-1])
    if found["red"] < 0.05:
        problem = f"rendering by {found['renderer'] or found['window']} gives an empty picture"
        return Rendering(False, found["window"], found["renderer"], found["seconds"], problem, _remedy())
    return Rendering(True, found["window"], found["renderer"], found["seconds"])


def require_rendering() -> Rendering:
    """Try rendering, and stop with the line to run where it does not work.

    Raises
    ------
    RenderError
        if the child crashed, hung, failed, or drew nothing.
    """
    outcome = try_rendering()
    if not outcome.works:
        raise RenderError(f"{outcome.problem}; {outcome.remedy}")
    return outcome


def require_notebooks() -> None:
    """Stop with the line to run where packages are missing that execute notebooks.

    Raises
    ------
    GeoweaveError
        if one is not installed, as after ``pip install geoweave`` without the extra.
    """
    missing = []
    for name in NOTEBOOKS:
        try:
            importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            missing.append(name)
    if missing:
        raise GeoweaveError(
            f"figures are made by notebooks, and what executes them is not installed ({', '.join(missing)}); "
            "run: pip install 'geoweave[notebooks]'"
        )


def versions() -> dict[str, str]:
    """Versions of the distributions in :data:`PACKAGES`, "" where one is not installed."""
    found = {}
    for name in PACKAGES:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = ""
    return found


def data_states() -> dict[str, str]:
    """What can be had of each registered mesh.

    Returns
    -------
    name -> "embedded" (in the package), "available" (cached, or in GEOWEAVE_DATA_DIR), "fetchable" (known
    by address and sha256, not on this machine), or "damaged" (embedded, but missing or changed)

    Raises
    ------
    DataError
        if GEOWEAVE_DATA_DIR names no folder.
    """
    from geoweave.models import datasets

    states = {}
    for name in datasets.names():
        here = datasets.available(name)
        if datasets.dataset(name).embedded:
            states[name] = "embedded" if here else "damaged"
        else:
            states[name] = "available" if here else "fetchable"
    return states


def examine() -> Diagnosis:
    """Look at everything; takes about two seconds, most of it rendering."""
    rendering = try_rendering()
    installed = versions()
    advice = []
    try:
        data = data_states()
    except DataError as error:
        data = {}
        advice.append(str(error))
    if not rendering.works:
        advice.append(rendering.remedy)
    from geoweave.sparse import factorization

    if factorization.HAS_METIS:
        ordering = "SuperLU, ordered by METIS nested dissection"
    else:
        ordering = "SuperLU, ordered by minimum degree (slower on large meshes)"
        advice.append(
            "for faster factorisations: pip install pymetis (Linux, macOS), or the pymetis of conda-forge"
        )
    if "damaged" in data.values():
        advice.append(
            "the embedded meshes are not all whole: restore geoweave/data from git, or install again"
        )
    fetchable = [name for name, state in data.items() if state == "fetchable"]
    if fetchable:
        advice.append(f"for PROFILE=paper: geoweave fetch {' '.join(fetchable)}")
    if not installed["papermill"]:
        advice.append("to make the figures: pip install 'geoweave[notebooks]'")
    return Diagnosis(
        python=platform.python_version(),
        platform=f"{platform.system()} {platform.machine()}",
        versions=installed,
        rendering=rendering,
        ordering=ordering,
        data=data,
        advice=tuple(advice),
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the diagnosis, or with ``--rendering`` only what would stop a notebook; 1 if rendering fails."""
    parser = argparse.ArgumentParser(prog="python -m geoweave.artifact.doctor")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--rendering", action="store_true", help="say nothing unless rendering fails")
    options = parser.parse_args(arguments)
    if options.rendering:
        try:
            require_rendering()
        except RenderError as error:
            print(f"geoweave: {error}", file=sys.stderr)
            return 1
        return 0
    diagnosis = examine()
    print(json.dumps(diagnosis.as_dict(), indent=2) if options.json else diagnosis.as_text())
    return 0 if diagnosis.rendering.works else 1


if __name__ == "__main__":
    sys.exit(main())
