"""A sweep keeps what is whole and current, weaves the rest again, and touches nothing that is not its own."""

from __future__ import annotations

import csv
import json
import os
from dataclasses import replace
from pathlib import Path

import pytest

from geoweave.files import OutputError
from geoweave.meshing.write import write_mesh
from geoweave.models import shapes
from geoweave.pipeline import batch as engine
from geoweave.pipeline.batch import folder_names, sweep
from geoweave.pipeline.request import WeaveRequest
from geoweave.pipeline.source import MeshSource
from geoweave.pipeline.sweep_table import Row

REQUEST = WeaveRequest(scale=0.5, relax=False)


@pytest.fixture
def cones(tmp_path: Path) -> list[MeshSource]:
    """Two cones that weave in half a second."""
    found = []
    for name, faces in (("blunt", 300), ("sharp", 340)):
        write_mesh(shapes.cone(faces=faces), tmp_path / f"{name}.obj")
        found.append(MeshSource(str(tmp_path / f"{name}.obj"), faces))
    return found


def states(rows: tuple[Row, ...]) -> list[str]:
    return [row.state for row in rows]


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_the_digest_of_the_source_sees_every_sub_package(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def digest() -> str:
        engine.source_digest.cache_clear()
        return engine.source_digest()

    with monkeypatch.context() as patched:
        patched.setattr(engine, "PACKAGE", tmp_path)
        for name in ("fields/geodesic.py", "fabrication/guide.js", "data/bunny.npz"):
            before = digest()
            (tmp_path / name).parent.mkdir()
            (tmp_path / name).write_text("new")
            assert digest() != before
        before = digest()
        (tmp_path / "viz").mkdir()
        (tmp_path / "viz" / "scene.py").write_text("a picture changes no weave")
        assert digest() == before
    engine.source_digest.cache_clear()


def test_what_is_whole_and_current_is_kept(tmp_path: Path, cones: list[MeshSource]) -> None:
    out = tmp_path / "out"
    seen: list[tuple[Row, int]] = []
    rows = sweep(cones, REQUEST, out, callback=lambda *what: seen.append(what))
    assert states(rows) == ["done", "done"]
    assert seen == [(row, 2) for row in rows]
    assert sorted(path.name for path in out.iterdir()) == ["blunt", "sharp", "table.csv", "table.md"]
    assert sorted(path.name for path in (out / "blunt").iterdir()) == [
        "report.json",
        "sweep.json",
        "weave.json",
    ]
    weave = json.loads((out / "sharp" / "weave.json").read_text())
    assert rows[1].result["ribbons"] == len(weave["ribbons"]) > 0
    assert rows[1].result["output"] == str(out / "sharp" / "weave.json")
    assert rows[1].result["mesh"] == cones[1].name

    first = contents(out)
    again = sweep(cones, REQUEST, out)
    assert states(again) == ["kept", "kept"]
    assert contents(out) == first
    assert [row.result for row in again] == [row.result for row in rows]

    # a file that is not what it was, one that is gone, and a record that is cut short
    (out / "blunt" / "weave.json").write_text("{}")
    assert states(sweep(cones, REQUEST, out)) == ["done", "kept"]
    (out / "sharp" / "report.json").unlink()
    assert states(sweep(cones, REQUEST, out)) == ["kept", "done"]
    record = out / "sharp" / "sweep.json"
    record.write_bytes(record.read_bytes()[:300])
    assert states(sweep(cones, REQUEST, out)) == ["kept", "done"]
    same = contents(out)
    assert {name for name in first if same[name] != first[name]} <= {"blunt/sweep.json", "sharp/sweep.json"}


def test_another_mesh_option_or_version_is_woven_again(
    tmp_path: Path, cones: list[MeshSource], monkeypatch: pytest.MonkeyPatch
) -> None:
    out, cone = tmp_path / "out", cones[0]
    sweep([cone], REQUEST, out)

    def kept(source: MeshSource, request: WeaveRequest = REQUEST) -> bool:
        (job,) = engine.jobs_of([source], request, tmp_path / "work")
        return engine._kept(job, out) is not None

    assert kept(cone)
    for other in ({"seed": 3}, {"faces": 310}, {"repair": True}, {"components": "largest"}):
        assert not kept(replace(cone, **other))
    for other in (
        {"symmetry": 4},
        {"phase": "free"},
        {"scale": 0.4},
        {"size": 100.0},
        {"width": 0.1},
        {"thickness": 0.1},
        {"formats": ("json", "rod")},
        {"relax": True},
    ):
        assert not kept(cone, replace(REQUEST, **other))
    for fact in ("package_version", "source_digest"):
        with monkeypatch.context() as patched:
            patched.setattr(engine, fact, lambda: "another")
            assert not kept(cone)
    # the same mesh from another place is the same mesh, until its file changes
    moved = tmp_path / "elsewhere"
    moved.mkdir()
    os.replace(cone.name, moved / "blunt.obj")
    there = replace(cone, name=str(moved / "blunt.obj"))
    assert kept(there)
    (moved / "blunt.obj").write_bytes((moved / "blunt.obj").read_bytes() + b"# a comment\n")
    assert not kept(there)
    assert states(sweep([there], replace(REQUEST, scale=0.45), out)) == ["done"]
    assert kept(there, replace(REQUEST, scale=0.45))
    assert not kept(there)


def test_files_of_an_earlier_sweep_go_and_others_stay(tmp_path: Path, cones: list[MeshSource]) -> None:
    out, only = tmp_path / "out", cones[:1]
    sweep(only, replace(REQUEST, formats=("json", "rod")), out)
    folder = out / "blunt"
    assert (folder / "weave.rod").is_file()
    (folder / "notes.txt").write_text("mine")
    sweep(only, REQUEST, out)
    assert sorted(path.name for path in folder.iterdir()) == [
        "notes.txt",
        "report.json",
        "sweep.json",
        "weave.json",
    ]


def test_a_mesh_that_fails_stops_no_other(tmp_path: Path, cones: list[MeshSource]) -> None:
    (tmp_path / "bad.obj").write_text("v 0 0 0\nf 1 2 3\n")
    bad = replace(cones[0], name=str(tmp_path / "bad.obj"))
    gone = replace(cones[0], name=str(tmp_path / "gone.obj"))
    out = tmp_path / "out"
    rows = sweep([bad, gone, cones[0]], REQUEST, out, jobs=2)
    assert states(rows) == ["failed", "failed", "done"]
    assert rows[0].problem.startswith(f"{bad.name}: ")
    assert "vertex 2" in rows[0].problem
    assert "neither a file nor a data set" in rows[1].problem
    assert sorted(path.name for path in out.iterdir()) == ["blunt", "table.csv", "table.md"]
    with (out / "table.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    assert [row["problem"] for row in table] == [rows[0].problem, rows[1].problem, ""]
    assert table[2]["ribbons"] == str(rows[2].result["ribbons"])
    assert table[0]["ribbons"] == ""


def test_a_fault_of_ours_is_a_row_with_its_traceback(
    tmp_path: Path, cones: list[MeshSource], monkeypatch: pytest.MonkeyPatch
) -> None:
    (job,) = engine.jobs_of(cones[:1], REQUEST, tmp_path / "work")
    (tmp_path / "work").mkdir()

    def broken(*_: object) -> None:
        raise ZeroDivisionError("a fault")

    monkeypatch.setattr(engine, "weave_file", broken)
    outcome = engine.weave_one(job)
    assert outcome["problem"] == (
        f"{cones[0].name}: a fault of geoweave (ZeroDivisionError: a fault); please report it"
    )
    assert "in broken" in outcome["fault"]

    def exhausted(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr(engine, "weave_file", exhausted)
    assert "not enough memory" in engine.weave_one(job)["problem"]


def test_workers_that_cannot_do_it_say_so(tmp_path: Path, cones: list[MeshSource]) -> None:
    (job,) = engine.jobs_of(cones[:1], REQUEST, tmp_path / "nowhere" / "work", code=engine.source_digest())
    assert f"does not see {tmp_path / 'nowhere'}" in engine.weave_one(job)["problem"]
    assert "another geoweave" in engine.weave_one(replace(job, code="an older one"))["problem"]


def test_folders_are_named_after_meshes() -> None:
    assert folder_names(["/a/bunny.obj", "/a/ring.off", "spot"]) == ["bunny", "ring", "spot"]
    assert folder_names(["/a/bunny.obj", "/a/bunny.off", "bunny"]) == ["bunny-obj", "bunny-off", "bunny"]
    assert folder_names(["/x/a/bunny.obj", "/x/b/bunny.obj"]) == ["a-bunny-obj", "b-bunny-obj"]
    assert folder_names(["/a/x/m.obj", "/b/x/m.obj"]) == ["a-x-m-obj", "b-x-m-obj"]
    # neither the tables' names, nor names that differ in capitals only, nor none at all
    assert folder_names(["/a/table.csv.obj", "/a/.obj"]) == ["table.csv-obj", "obj"]
    odd = folder_names(["/a/Bunny.obj", "/a/bunny.obj", "/b-c/m.obj", "/b/c-m.obj", "/c/m.obj"])
    assert len({name.casefold() for name in odd}) == 5


def test_a_mesh_that_is_named_twice_is_woven_once(tmp_path: Path, cones: list[MeshSource]) -> None:
    (tmp_path / "link.obj").symlink_to(tmp_path / "blunt.obj")
    twice = [cones[0], replace(cones[0], name=str(tmp_path / "link.obj")), cones[1], cones[0]]
    jobs = engine.jobs_of(twice, REQUEST, tmp_path / "work")
    assert [job.name for job in jobs] == ["blunt", "sharp"]
    assert [job.name for job in engine.jobs_of(twice[1:2], REQUEST, tmp_path / "work")] == ["link"]


def test_nothing_is_left_where_nothing_can_be_written(tmp_path: Path, cones: list[MeshSource]) -> None:
    with pytest.raises(OutputError, match="there is no folder"):
        sweep(cones, REQUEST, tmp_path / "no" / "where")
    (tmp_path / "out" / "table.csv").mkdir(parents=True)
    with pytest.raises(OutputError, match="is a folder"):
        sweep(cones, REQUEST, tmp_path / "out")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["table.csv"]
