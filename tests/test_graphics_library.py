"""The library that draws without a screen is looked for, named or installed before anything large is."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
SCRIPT = ROOT / "scripts" / "graphics_library.sh"
THERE = "\tlibEGL.so.1 (libc6,x86-64) => /lib/x86_64-linux-gnu/libEGL.so.1"
SHELL = shutil.which("sh") or "/bin/sh"


def tried(
    folder: Path, *, libraries: str, user: int, apt: bool = True, system: str = "Linux"
) -> tuple[int, str, list[str]]:
    """Run the script where these programs are all that there are: status, message, calls of apt-get."""
    programs = {
        "uname": f"echo {system}",
        "id": f"echo {user}",
        "ldconfig": f"printf '%s\\n' '{libraries}'",
    }
    if apt:
        programs["apt-get"] = f'echo "$@" >> {folder}/calls'
    for name, body in programs.items():
        file = folder / name
        file.write_text(f"#!{SHELL}\n{body}\n")
        file.chmod(0o755)
    # without the folders of the system, whose own apt-get must not be found
    script = folder / "script.sh"
    script.write_text(SCRIPT.read_text().replace(":/sbin:/usr/sbin", ""))
    done = subprocess.run(
        [SHELL, str(script)],
        env={"PATH": str(folder)}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    calls = folder / "calls"
    return done.returncode, done.stderr, calls.read_text().splitlines() if calls.exists() else []


def test_where_the_library_is_nothing_is_said(tmp_path: Path) -> None:
    assert tried(tmp_path, libraries=THERE, user=0) == (0, "", [])


def test_root_gets_it_installed(tmp_path: Path) -> None:
    status, said, calls = tried(tmp_path, libraries="libm.so.6", user=0)
    assert status == 0
    assert said == (
        "geoweave: drawing without a screen needs a library; installing libegl1 libgl1-mesa-dri\n"
    )
    assert calls == ["update", "install --yes --no-install-recommends libegl1 libgl1-mesa-dri"]


def test_anyone_else_is_told_the_line_to_run(tmp_path: Path) -> None:
    status, said, calls = tried(tmp_path, libraries="libm.so.6", user=1000)
    assert (status, calls) == (1, [])
    assert said.endswith("run: sudo apt-get install libegl1 libgl1-mesa-dri\n")


def test_other_systems(tmp_path: Path) -> None:
    status, said, _ = tried(tmp_path, libraries="libm.so.6", user=0, apt=False)
    assert status == 1
    assert "libEGL.so.1" in said
    assert tried(tmp_path, libraries="", user=0, system="Darwin") == (0, "", [])


@pytest.mark.skipif(shutil.which("make") is None, reason="needs make")
def test_make_asks_before_it_installs_anything(tmp_path: Path) -> None:
    """A checkout whose library is missing stops before it makes the virtual environment."""
    (tmp_path / "scripts").mkdir()
    for name in ("Makefile", "requirements.lock", "pyproject.toml"):
        shutil.copy(ROOT / name, tmp_path / name)
    (tmp_path / "scripts" / SCRIPT.name).write_text("echo the library is missing >&2; exit 1\n")
    environment = {key: value for key, value in os.environ.items() if not key.startswith("MAKE")}
    done = subprocess.run(
        ["make", "-C", str(tmp_path), "figures"],
        env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode != 0
    assert "the library is missing" in done.stderr
    assert not (tmp_path / ".venv").exists()
