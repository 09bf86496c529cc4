import hashlib
import os
import stat
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from geoweave.files import (
    Job,
    OutputError,
    check_writable,
    checked_folder,
    printable,
    recovered,
    replacing,
    sha256_of,
    text_job,
    written_together,
)


def contents(folder):
    return {path.name: path.read_text() for path in folder.iterdir() if path.is_file()}


def write_half(target, error):
    with replacing(target) as temporary:
        temporary.write_text("half")
        raise error


def test_a_file_appears_whole(tmp_path):
    target = tmp_path / "out.npz"
    with replacing(target) as temporary:
        assert temporary.parent == tmp_path
        assert temporary.suffix == ".npz"
        temporary.write_text("half")
        assert not target.exists()
        temporary.write_text("whole")
    assert contents(tmp_path) == {"out.npz": "whole"}


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit, MemoryError])
def test_an_interrupted_write_leaves_what_was_there(tmp_path, error):
    target = tmp_path / "out.txt"
    target.write_text("old")
    with pytest.raises(error):
        write_half(target, error())
    assert contents(tmp_path) == {"out.txt": "old"}


def test_permissions_and_links_stay(tmp_path):
    real, link = tmp_path / "real.txt", tmp_path / "link.txt"
    real.write_text("old")
    real.chmod(0o640)
    link.symlink_to(real)
    with replacing(link) as temporary:
        temporary.write_text("new")
    assert link.is_symlink()
    assert real.read_text() == "new"
    assert stat.S_IMODE(real.stat().st_mode) == 0o640


def test_places_that_cannot_be_written_are_refused_before_the_work(tmp_path):
    (tmp_path / "file").write_text("")
    os.mkfifo(tmp_path / "pipe")
    for path, message in (
        (tmp_path, "is a folder; name a file in it"),
        (tmp_path / "none" / "out.npz", "there is no folder"),
        (tmp_path / "file" / "out.npz", "there is no folder"),
        (tmp_path / "pipe", "not a regular file"),
    ):
        with pytest.raises(OutputError, match=message):
            check_writable(path)
        with pytest.raises(OutputError, match=message), replacing(path):
            raise AssertionError("the work must not begin")
    assert sorted(os.listdir(tmp_path)) == ["file", "pipe"]


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="a file system that nobody can write to")
def test_a_folder_that_only_seems_writable_is_refused():
    # the superuser has every permission there, and still nothing can be made
    for path in ("/proc/out.npz", "/proc/x"):
        with pytest.raises(OutputError, match=r"is not writable .*; choose another place"):
            check_writable(path)
    with pytest.raises(OutputError, match="is not writable"):
        checked_folder("/proc/x")
    with pytest.raises(OutputError, match="is not writable"):
        checked_folder("/proc/self")


def test_names_that_no_file_can_have_are_refused(tmp_path):
    with pytest.raises(OutputError, match="has no name"):
        check_writable("")
    with pytest.raises(OutputError, match="has no name"):
        checked_folder("")
    for check in (check_writable, checked_folder):
        with pytest.raises(OutputError, match="File name too long"):
            check(tmp_path / ("x" * 300))
    assert not list(tmp_path.iterdir())


def test_a_full_disk_is_one_sentence(tmp_path):
    target = tmp_path / "out.npz"
    with pytest.raises(OutputError, match=r"out\.npz: cannot be written \(No space left on device\)"):
        write_half(target, OSError(28, "No space left on device"))
    assert contents(tmp_path) == {}


def test_an_error_about_another_file_is_left_alone(tmp_path):
    with pytest.raises(FileNotFoundError), replacing(tmp_path / "out.npz"):
        (tmp_path / "input.txt").read_text()
    assert contents(tmp_path) == {}


def test_what_lists_the_files_is_moved_last(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    moved = []
    replace = os.replace

    def recorded(source: Any, target: Any) -> None:
        moved.append(Path(target).name)
        replace(source, target)

    (tmp_path / "list").write_text("what was there before")
    monkeypatch.setattr(os, "replace", recorded)
    jobs = {name: text_job("x") for name in ("a", "b")}
    written_together(jobs, tmp_path, index=("list", lambda path, digests: path.write_text("a b")))
    assert moved[-3:] == ["a", "b", "list"]


WRITER = """
import os, sys
from pathlib import Path
from geoweave.files import text_job, written_together

moves = 0

def held(move, source, target):
    # one move is made; before the next one the test is told, and holds this process until it kills it
    global moves
    if Path(source).parent.name == "files" or Path(source).name == "files":
        moves += 1
        if moves == int(sys.argv[2]):
            print("between", flush=True)
            sys.stdin.read()
    move(source, target)

replace, rename = os.replace, os.rename
os.replace = lambda source, target: held(replace, source, target)
os.rename = lambda source, target: held(rename, source, target)
jobs = {name: text_job(f"new {name}") for name in ("a", "b")}
index = ("list", lambda path, digests: path.write_text("new " + " ".join(digests)))
written_together(jobs, sys.argv[1], stale={"c": sys.argv[3]}, index=index)
"""


def killed(folder: Path, move: int, stale: str = "") -> None:
    """Write two files and their index into a folder, in a process that is killed before a move."""
    command = [sys.executable, "-c", WRITER, str(folder), str(move), stale]
    child = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    assert child.stdout.readline() == "between\n"
    # while it lives nobody takes its files away
    before = sorted(folder.parent.rglob("*"))
    recovered(folder)
    assert sorted(folder.parent.rglob("*")) == before
    child.kill()
    child.communicate()


@pytest.mark.parametrize("move", [1, 2, 3])
def test_what_a_killed_run_had_begun_to_move_is_finished(tmp_path: Path, move: int) -> None:
    folder = tmp_path / "there"
    folder.mkdir()
    for name in ("a", "b", "c", "list", "mine"):
        (folder / name).write_text("old")
    killed(folder, move, sha256_of(folder / "c"))
    assert not (folder / "list").exists()  # what lists the files never contradicts them
    recovered(folder)
    assert contents(folder) == {"a": "new a", "b": "new b", "list": "new a b", "mine": "old"}
    assert [path.name for path in tmp_path.iterdir()] == ["there"]
    assert not [path for path in folder.iterdir() if path.is_dir()]


def test_of_a_killed_run_a_new_folder_holds_nothing_at_all(tmp_path: Path) -> None:
    folder = tmp_path / "new"
    killed(folder, 1)
    assert not folder.exists()
    assert len(list(tmp_path.iterdir())) == 1
    written_together({"a": text_job("mine")}, folder)
    assert [path.name for path in tmp_path.iterdir()] == ["new"]
    assert contents(folder) == {"a": "mine"}


def test_what_was_left_before_the_first_move_is_cleared(tmp_path: Path) -> None:
    left = tmp_path / ".geoweave-0123abcd"
    (left / "files").mkdir(parents=True)
    (left / "lock").write_text("")
    (left / "files" / "a").write_text("half")
    written_together({"b": text_job("whole")}, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["b"]
    # a file by itself too, and nothing that only looks like one of ours
    for name in (".out.0123abcd.txt", ".out.mine.txt", "out.0123abcd.txt"):
        (tmp_path / name).write_text("")
    with replacing(tmp_path / "out.txt") as temporary:
        temporary.write_text("whole")
        with replacing(tmp_path / "out.txt") as second:  # as another process would: the first one lives
            second.write_text("second")
        assert temporary.read_text() == "whole"
    assert sorted(contents(tmp_path)) == [".out.mine.txt", "b", "out.0123abcd.txt", "out.txt"]


def test_an_interruption_between_moves_is_obeyed_after_them(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    replace = os.replace
    once = [KeyboardInterrupt()]

    def interrupted(source: Any, target: Any) -> None:
        if Path(target).name == "b" and once:
            raise once.pop()
        replace(source, target)

    monkeypatch.setattr(os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        written_together({name: text_job(name) for name in ("a", "b")}, tmp_path)
    assert contents(tmp_path) == {"a": "a", "b": "b"}
    assert len(list(tmp_path.iterdir())) == 2


def test_names_that_are_not_utf8_can_be_written_down() -> None:
    assert printable("M\u00f6bius") == "M\u00f6bius"
    assert printable(os.fsdecode(b"M\xf6bius")).encode() == "M\ufffdbius".encode()


def test_files_of_an_earlier_run_go_unless_they_were_changed(tmp_path: Path) -> None:
    def writing(text: str) -> Job:
        return lambda path: path.write_text(text)

    listed: dict[str, str] = {}

    def index(path: Path, digests: dict[str, str]) -> None:
        listed.update(digests)
        path.write_text(" ".join(digests))

    jobs = {name: writing(name) for name in ("a", "b", "c")}
    files = written_together(jobs, tmp_path, index=("list", index))
    assert list(files) == ["a", "b", "c", "list"]
    assert files["list"].read_text() == "a b c"
    assert listed == {name: sha256_of(tmp_path / name) for name in ("a", "b", "c")}
    assert listed["a"] == hashlib.sha256(b"a").hexdigest()
    (tmp_path / "c").write_text("mine now")
    (tmp_path / "foreign").write_text("x")
    stale = listed | {"never there": "0"}
    # nothing goes when something cannot be written
    with pytest.raises(ZeroDivisionError):
        written_together({"a": lambda path: 1 / 0}, tmp_path, stale=stale)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "b", "c", "foreign", "list"]
    written_together({"a": writing("new")}, tmp_path, stale=stale)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a", "c", "foreign", "list"]
    assert (tmp_path / "a").read_text() == "new"
    assert (tmp_path / "c").read_text() == "mine now"
