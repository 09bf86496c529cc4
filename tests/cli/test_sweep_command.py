"""The sweep as a user runs it: on this machine, on a Dask cluster, interrupted, killed, and run again."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import click
import pytest
from clusters import cluster

from geoweave.cli import main, sweep_command
from geoweave.meshing.write import write_mesh
from geoweave.models import shapes

QUICK = ("--faces", "300", "--scale", "0.5", "--no-relax")


@pytest.fixture
def meshes(tmp_path: Path) -> list[str]:
    for name, faces in (("one", 300), ("two", 320), ("three", 340)):
        write_mesh(shapes.cone(faces=faces), tmp_path / f"{name}.obj")
    return [str(tmp_path / f"{name}.obj") for name in ("one", "two", "three")]


def run(capfd: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    status = main.main(["sweep", *map(str, arguments)])
    return status, *capfd.readouterr()


def woven(folder: Path) -> dict[str, bytes]:
    """What a sweep leaves but for its records, which hold times."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and path.name != "sweep.json"
    }


def test_the_command_line_offers_the_command() -> None:
    assert main.commands.get_command(click.Context(main.commands), "sweep") is sweep_command.sweep


def test_many_meshes_one_of_which_fails(
    tmp_path: Path, meshes: list[str], capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "bad.off").write_text("OFF\n")
    out = tmp_path / "out"
    asked = [meshes[0], tmp_path / "bad.off", meshes[1], "-o", out, *QUICK]
    status, text, err = run(capfd, *asked, "--jobs", 2)
    assert (status, err) == (1, "")
    assert text.splitlines()[0] == "3 meshes: 2 done, 1 failed"
    assert "failed: " in text
    status, text, err = run(capfd, *asked, "--json")
    assert (status, err) == (1, "")
    result = json.loads(text)
    assert {key: result[key] for key in ("meshes", "done", "kept", "failed")} == {
        "meshes": 3,
        "done": 0,
        "kept": 2,
        "failed": 1,
    }
    assert [each["state"] for each in result["results"]] == ["kept", "failed", "kept"]
    assert "bad.off" in result["results"][1]["problem"]
    assert result["results"][0]["result"]["ribbons"] > 0
    assert all(Path(table).is_file() for table in result["tables"])
    # without the mesh that fails the status says so, and the words that all was there
    status, text, _ = run(capfd, meshes[0], meshes[1], "-o", out, *QUICK)
    assert status == 0
    assert text.splitlines()[0] == "2 meshes: 2 kept"
    assert "kept: mesh, options and version are the same" in text


def test_bad_usage_is_one_line_and_exit_2(
    tmp_path: Path, meshes: list[str], capfd: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    for arguments, words in (
        (("-o", out), "Missing argument 'MESH...'"),
        ((meshes[0],), "-o"),
        ((meshes[0], "-o", out, "--jobs", 0), "--jobs"),
        ((meshes[0], "-o", out, "--jobs", 2, "--dask", "tcp://x:1"), "exclude each other"),
        ((meshes[0], "-o", out, "--ribbons", 9, "--scale", 2), "exclude each other"),
        ((meshes[0], "-o", out, "--formats", "svg"), "--size"),
        ((meshes[0], "-o", out, "--formats", "dwg"), "'dwg'"),
        ((meshes[0], "-o", meshes[1]), "is a file"),
        ((meshes[0], "-o", out / "deeper"), "there is no folder"),
    ):
        status, text, err = run(capfd, *arguments)
        assert (status, text) == (2, "")
        assert err.count("\n") == 1
        assert words in err
    assert not out.exists()


def test_dask_that_is_missing_is_said_before_anything_is_done(
    tmp_path: Path, meshes: list[str], capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    status, text, err = run(capfd, meshes[0], "-o", tmp_path / "out", "--dask", "tcp://127.0.0.1:1")
    assert (status, text) == (2, "")
    assert "pip install 'geoweave[dask]'" in err
    assert not (tmp_path / "out").exists()


def test_a_cluster_gives_the_same_files(
    tmp_path: Path, meshes: list[str], capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "bad.off").write_text("OFF\n")
    asked = [*meshes[:2], tmp_path / "bad.off", *QUICK, "--json"]
    (tmp_path / "dask").mkdir()
    with cluster(tmp_path / "dask") as address:
        status, text, _ = run(capfd, *asked, "-o", tmp_path / "there", "--dask", address)
        there = json.loads(text)
        assert status == 1
        assert (there["done"], there["failed"]) == (2, 1)
        # what is there is kept, wherever it was woven
        status, text, _ = run(capfd, *asked, "-o", tmp_path / "there", "--dask", address)
        assert json.loads(text)["kept"] == 2
    assert json.loads(run(capfd, *asked, "-o", tmp_path / "there")[1])["kept"] == 2
    run(capfd, *asked, "-o", tmp_path / "here")
    assert woven(tmp_path / "here") == woven(tmp_path / "there")
    assert sorted(path.name for path in (tmp_path / "there").iterdir()) == [
        "one",
        "table.csv",
        "table.md",
        "two",
    ]


def heeds_interrupts() -> None:
    """A shell starts what runs in its background with interrupts ignored, and a child inherits that."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_what_was_woven_before_an_interruption_is_kept(
    tmp_path: Path, meshes: list[str], capfd: pytest.CaptureFixture[str], ending: signal.Signals
) -> None:
    out, held = tmp_path / "out", tmp_path / "two.obj"
    mesh = held.read_bytes()
    held.unlink()
    os.mkfifo(held)  # the sweep reads a mesh twice, for its digest and to weave it: we answer once
    command = [sys.executable, "-m", "geoweave", "sweep", *meshes, "-o", str(out), *QUICK]
    child = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=heeds_interrupts,
    )  # fmt: skip
    held.write_bytes(mesh)
    while not (out / "one" / "sweep.json").exists():
        assert child.poll() is None
        time.sleep(0.01)
    if ending == signal.SIGKILL:
        os.killpg(child.pid, ending)
    else:
        child.send_signal(ending)
    text, err = child.communicate()
    held.unlink()
    held.write_bytes(mesh)
    assert text == ""
    if ending != signal.SIGKILL:
        assert (child.returncode, err) == (130, "geoweave: interrupted; no file was left half-written\n")
        assert not list(out.glob(".*"))
    assert not (out / "table.csv").exists()
    for folder in out.glob("[a-z]*"):
        assert sorted(path.name for path in folder.iterdir()) == ["report.json", "sweep.json", "weave.json"]
    before = len(list(out.glob("[a-z]*")))
    first = (out / "one" / "weave.json").read_bytes()
    assert before == 1
    status, text, err = run(capfd, *meshes, "-o", out, *QUICK, "--json")
    result = json.loads(text)
    assert (status, err, result["kept"], result["done"]) == (0, "", before, 3 - before)
    assert sorted(path.name for path in out.glob("[a-z]*")) == [
        "one",
        "table.csv",
        "table.md",
        "three",
        "two",
    ]
    assert (out / "one" / "weave.json").read_bytes() == first


def test_a_size_brings_the_same_files_as_for_one_weave(
    tmp_path: Path, meshes: list[str], capfd: pytest.CaptureFixture[str]
) -> None:
    asked = (*QUICK, "--size", "120", "--json")
    status, text, _ = run(capfd, meshes[0], "-o", tmp_path / "many", *asked)
    assert status == 0
    (one,) = json.loads(text)["results"]
    assert main.main(["weave", meshes[0], "-o", str(tmp_path / "single"), *asked]) == 0
    single = json.loads(capfd.readouterr().out)
    names = [{Path(file).name for file in each["files"]} for each in (one["result"], single)]
    assert names[0] == names[1] == {"weave.json", "report.json", "guide.html"}
    assert woven(tmp_path / "many" / "one") == woven(tmp_path / "single")
