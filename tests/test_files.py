import hashlib
import os
import stat
from pathlib import Path
from typing import Any

import pytest

from geoweave.files import Job, OutputError, check_writable, replacing, sha256_of, written_together


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


def test_a_folder_without_permission_is_refused(tmp_path, monkeypatch):
    # asked of the system instead of set up, because nothing is forbidden to root
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    with pytest.raises(OutputError, match="is not writable; choose another place"):
        check_writable(tmp_path / "out.npz")


def test_a_full_disk_is_one_sentence(tmp_path):
    target = tmp_path / "out.npz"
    with pytest.raises(OutputError, match=r"out\.npz: cannot be written \(No space left on device\)"):
        write_half(target, OSError(28, "No space left on device"))
    assert contents(tmp_path) == {}


def test_an_error_about_another_file_is_left_alone(tmp_path):
    with pytest.raises(FileNotFoundError), replacing(tmp_path / "out.npz"):
        (tmp_path / "input.txt").read_text()
    assert contents(tmp_path) == {}


def test_what_lists_the_files_is_renamed_last(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    renamed = []
    replace = os.replace

    def recorded(source: Any, target: Any) -> None:
        renamed.append(Path(target).name)
        replace(source, target)

    monkeypatch.setattr(os, "replace", recorded)
    jobs = {name: (lambda path: path.write_text("x")) for name in ("a", "b")}
    written_together(jobs, tmp_path, index=("list", lambda path, digests: path.write_text("a b")))
    assert sorted(renamed) == ["a", "b", "list"]
    assert renamed[-1] == "list"


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
