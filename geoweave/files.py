"""Files that appear whole or not at all."""

from __future__ import annotations

import glob
import hashlib
import json
import os
import secrets
import shutil
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from os import PathLike
from pathlib import Path

from geoweave.errors import GeoweaveError

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

__all__ = [
    "Job",
    "OutputError",
    "check_output",
    "check_writable",
    "checked_folder",
    "chosen",
    "printable",
    "recovered",
    "replacing",
    "sha256_of",
    "text_job",
    "written_together",
]

LONGEST_STEM = 80
"""Letters of a file's name that its temporary name begins with; a name may have 255 bytes."""

STAGING = ".geoweave-"
"""How the names of temporary folders begin, each with the files of one run."""

STAGED, LOCK, JOURNAL = "files", "lock", "moves.json"
"""In such a folder: the files, what is locked while its process lives, and the list of the moves."""

LEFTOVER_AGE = 86_400.0
"""Seconds after which something temporary is left over, where no lock says whether its process lives."""

Job = Callable[[Path], object]
"""Writes a file to the path that it is given."""


class OutputError(GeoweaveError):
    """A file that cannot be written where it was asked for, and what to do about it."""


@contextmanager
def replacing(path: str | PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path in the same folder that takes the place of ``path`` when the block succeeds.

    When the block raises, or is interrupted, the temporary file is removed and ``path`` stays as it was. The
    temporary name keeps the extension, because writers choose their format by it.

    Raises
    ------
    OutputError
        If the folder is missing or not writable, ``path`` is a folder, or the disk is full.

    Examples
    --------
    >>> import tempfile
    >>> from geoweave.files import replacing
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with replacing(f"{folder}/out.txt") as temporary:
    ...         _ = temporary.write_text("whole")
    ...         early = os.path.exists(f"{folder}/out.txt")
    ...     early, os.listdir(folder)
    (False, ['out.txt'])
    """
    check_writable(path)
    target = Path(path)
    # Through a link, so that the link stays and the file that it points to is replaced.
    final = target.resolve() if target.is_symlink() else target
    begin = f".{final.stem[:LONGEST_STEM]}."
    _clear(final.parent, begin, final.suffix)
    temporary = final.with_name(f"{begin}{secrets.token_hex(4)}{final.suffix}")
    try:
        with _alive(temporary):
            yield temporary
        _keep_permissions(final, temporary)
        os.replace(temporary, final)
    except OSError as error:
        # An error about some other file is not ours to explain.
        if error.filename is not None and Path(os.fsdecode(error.filename)) not in (temporary, final):
            raise
        raise _unwritable(target, error) from error
    finally:
        with suppress(OSError):
            temporary.unlink()


def written_together(
    jobs: Mapping[str, Job],
    folder: str | PathLike[str],
    *,
    stale: Mapping[str, str] | None = None,
    index: tuple[str, Callable[[Path, dict[str, str]], object]] | None = None,
) -> dict[str, Path]:
    """Write files into a folder, all of them or none; returns the path of each by its name.

    Everything is written to a temporary folder first. A new folder takes its name in one step. In a folder
    that is there, files are moved one by one after a list of the moves is on the disk: if the program is
    killed between two of them, the next call for this folder (`recovered`) makes the others.

    Parameters
    ----------
    jobs : by the name of each file, what writes it to a path that it is given
    folder : it is made if it is not there, in a folder that is
    stale : sha256 of files of an earlier run by their names: those that are not written now are removed, but
        not one that has been changed since
    index : name of one more file, and what writes it when it is given the sha256 of all others. While files
        are moved there is none, so that an index never lists what is not there

    Raises
    ------
    OutputError
        If a file cannot be written there.
    """
    target = checked_folder(folder)
    new = not target.exists()
    names = [*jobs, *([index[0]] if index is not None else [])]
    for name in names if not new else ():
        _check_place(target / name)
    mark = f"{STAGING}{secrets.token_hex(4)}"
    staging = target.with_name(f"{mark}-{target.name}") if new else target / mark
    written = staging / STAGED
    try:
        staging.mkdir()
        with _alive(staging / LOCK):
            written.mkdir()
            digests = {}
            for name, job in jobs.items():
                _write(job, written / name, target / name)
                digests[name] = sha256_of(written / name) if index is not None else ""
            if index is not None:
                write_index = index[1]
                _write(lambda path: write_index(path, digests), written / index[0], target / index[0])
            if new:
                os.rename(written, target)
            else:
                gone = {name: digest for name, digest in (stale or {}).items() if name not in names}
                _commit(staging, target, names, gone, None if index is None else index[0])
    except OSError as error:
        place = None if error.filename is None else Path(os.fsdecode(error.filename))
        if place is not None and not {staging, target} & {place, *place.parents}:
            raise
        raise _unwritable(target, error) from error
    finally:
        if not (staging / JOURNAL).exists():
            shutil.rmtree(staging, ignore_errors=True)
    return {name: target / name for name in names}


def text_job(text: str) -> Job:
    """What writes this text, in UTF-8."""
    return lambda path: path.write_text(text, encoding="utf-8", newline="\n")


def _write(job: Callable[[Path], object], path: Path, final: Path) -> None:
    """Have a file written; an error about it names the place that it was meant for."""
    try:
        job(path)
        _keep_permissions(final, path)
    except OSError as error:
        if error.filename is not None and Path(os.fsdecode(error.filename)) != path:
            raise
        raise _unwritable(final, error) from error


def _commit(
    staging: Path, target: Path, names: Iterable[str], gone: Mapping[str, str], index: str | None
) -> None:
    """Put a list of the moves on the disk, and make them."""
    plan = {"names": list(names), "gone": dict(gone), "index": index}
    half = staging / f"{JOURNAL}.half"
    with half.open("w", encoding="utf-8") as file:
        json.dump(plan, file)
        file.flush()
        os.fsync(file.fileno())
    os.replace(half, staging / JOURNAL)
    try:
        _move(staging, target)
    except KeyboardInterrupt:
        _move(staging, target)
        raise


def _move(staging: Path, target: Path) -> None:
    """Make the moves that are left of a list; it may be done any number of times."""
    plan = json.loads((staging / JOURNAL).read_text(encoding="utf-8"))
    index = plan["index"]
    if index is not None and (staging / STAGED / index).exists():
        (target / index).unlink(missing_ok=True)
    for name in plan["names"]:  # the index is the last of them
        final, staged = target / name, staging / STAGED / name
        if name == index:
            _remove(target, plan["gone"])
        if staged.exists():
            os.replace(staged, final.resolve() if final.is_symlink() else final)
    _remove(target, plan["gone"])
    (staging / JOURNAL).unlink()


def recovered(folder: str | PathLike[str]) -> Path:
    """Finish what a killed run had begun to move into a folder, and clear what others left; returns it."""
    target = Path(folder)
    _check_name(target)
    beside = glob.escape(target.absolute().name)
    for staging in [*target.glob(f"{STAGING}*"), *target.parent.glob(f"{STAGING}*-{beside}")]:
        if not staging.is_dir() or not _dead(staging / LOCK):
            continue
        with suppress(OSError, ValueError, KeyError, TypeError):
            if (staging / JOURNAL).exists() and target.is_dir():
                _move(staging, target)
            shutil.rmtree(staging, ignore_errors=True)
    return target


def _clear(folder: Path, begin: str, end: str) -> None:
    """Remove the temporary files of runs that were killed."""
    for path in folder.glob(f"{glob.escape(begin)}{'[0-9a-f]' * 8}{glob.escape(end)}"):
        if _dead(path):
            with suppress(OSError):
                path.unlink()


@contextmanager
def _alive(path: Path) -> Iterator[None]:
    """Hold a lock on a new file, so that others see that the process which made it lives."""
    descriptor = os.open(path, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o666)
    try:
        if fcntl:
            with suppress(OSError):  # some network file systems have no locks
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(descriptor)


def _dead(path: Path) -> bool:
    """Whether the process that made a file has ended; where no lock can tell, after a day."""
    try:
        descriptor = os.open(path, os.O_RDONLY)
    except OSError:
        return _old(path.parent)
    try:
        if not fcntl:
            return _old(path)
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return _old(path)
    finally:
        os.close(descriptor)
    return True


def _old(path: Path) -> bool:
    try:
        return time.time() - path.stat().st_mtime > LEFTOVER_AGE
    except OSError:
        return False


def sha256_of(path: Path) -> str:
    """Digest of a file's content."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _remove(folder: Path, digests: Mapping[str, str]) -> None:
    """Remove the files of these names whose content is still what these digests say."""
    for name, digest in digests.items():
        path = folder / name
        if path.is_file() and not path.is_symlink() and sha256_of(path) == digest:
            path.unlink()


def chosen(
    names: Iterable[str], formats: Iterable[str], what: str, others: Iterable[str] = ()
) -> tuple[str, ...]:
    """Return the formats of these names, each once, in their own order.

    A name that is none of them is refused by an `OutputError`, which lists ``others`` too.
    """
    asked, known = [name.strip().lower() for name in names], list(formats)
    for name in asked:
        if name not in known:
            raise OutputError(
                f"there is no format '{name}' for a {what}; the formats are {', '.join([*known, *others])}"
            )
    return tuple(name for name in known if name in asked)


def check_writable(path: str | PathLike[str]) -> None:
    """Refuse a path that cannot be written, before any work is done for it.

    Raises
    ------
    OutputError
        If there is no name, the folder is missing or not writable, or ``path`` is no regular file.

    Examples
    --------
    >>> from geoweave.files import check_writable
    >>> check_writable("no/such/folder/out.npz")
    Traceback (most recent call last):
    geoweave.files.OutputError: no/such/folder/out.npz: there is no folder no/such/folder; make it first
    """
    if not os.fspath(path):
        raise OutputError("the output has no name; give one with -o")
    target = Path(path)
    _check_place(target)
    # Only trying shows it: the superuser has every permission, on a file system that allows nothing too.
    probe = target.parent / f"{STAGING}{secrets.token_hex(4)}"
    try:
        os.close(os.open(probe, os.O_CREAT | os.O_EXCL | os.O_WRONLY))
    except OSError as error:
        raise OutputError(
            f"{target}: the folder {target.parent} is not writable ({error.strerror}); choose another place"
        ) from error
    finally:
        with suppress(OSError):
            probe.unlink()


def _check_place(target: Path) -> None:
    """Refuse a place that is no place for a file, or has a name that no file can have."""
    _check_name(target)
    if target.is_dir():
        raise OutputError(f"{target}: is a folder; name a file in it")
    if target.exists() and not target.is_file():
        raise OutputError(f"{target}: is not a regular file; name another one")
    if not target.parent.is_dir():
        raise OutputError(f"{target}: there is no folder {target.parent}; make it first")


def _check_name(target: Path) -> None:
    try:
        os.lstat(target)
    except (FileNotFoundError, NotADirectoryError):
        pass
    except OSError as error:
        raise OutputError(f"{target}: cannot be written ({error.strerror}); choose another name") from error


def _unwritable(target: Path, error: OSError) -> OutputError:
    reason = error.strerror or str(error)
    return OutputError(f"{target}: cannot be written ({reason}); choose another place with -o")


def printable(name: str | PathLike[str]) -> str:
    """Return the name of a file as text that every file can hold: what is not UTF-8 becomes a mark."""
    return os.fsencode(name).decode("utf-8", "replace")


def check_output(output: str | PathLike[str], source: str | PathLike[str]) -> None:
    """Refuse a file that cannot be written (`check_writable`), or that is the input; raises `OutputError`."""
    check_writable(output)
    if os.path.exists(output) and os.path.exists(source) and os.path.samefile(output, source):
        raise OutputError(f"{os.fspath(output)}: is the input; name another file")


def checked_folder(output: str | PathLike[str]) -> Path:
    """Return a folder for results, or refuse it before any work is done for it; it is not made here.

    What a killed run had begun to move there is moved, and what it left is cleared (`recovered`). A folder
    that can neither be made nor written to is refused by an `OutputError`.
    """
    if not os.fspath(output):
        raise OutputError("the folder for results has no name; give one with -o")
    folder = recovered(output)
    if folder.is_dir():
        check_writable(folder / "weave.json")
    elif folder.exists():
        raise OutputError(f"{os.fspath(output)}: is a file; name a folder")
    else:
        check_writable(folder)
    return folder


def _keep_permissions(final: Path, temporary: Path) -> None:
    if final.exists():
        temporary.chmod(final.stat().st_mode & 0o777)
