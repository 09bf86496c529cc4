"""Files that appear whole or not at all."""

from __future__ import annotations

import hashlib
import os
import secrets
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from os import PathLike
from pathlib import Path

from geoweave.errors import GeoweaveError

__all__ = [
    "Job",
    "OutputError",
    "check_output",
    "check_writable",
    "checked_folder",
    "chosen",
    "replacing",
    "sha256_of",
    "written_together",
]


LONGEST_STEM = 80
"""Letters of a file's name that its temporary name begins with; a name may have 255 bytes."""

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
    target = Path(path)
    check_writable(target)
    # through a link, so that the link stays and the file it points to is replaced
    final = target.resolve() if target.is_symlink() else target
    temporary = final.with_name(f".{final.stem[:LONGEST_STEM]}.{secrets.token_hex(4)}{final.suffix}")
    try:
        yield temporary
        _keep_permissions(final, temporary)
        os.replace(temporary, final)
    except OSError as error:
        # an error about some other file is not ours to explain
        if error.filename is not None and Path(os.fsdecode(error.filename)) not in (temporary, final):
            raise
        reason = error.strerror or str(error)
        raise OutputError(f"{target}: cannot be written ({reason}); choose another place with -o") from error
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

    Parameters
    ----------
    jobs : by the name of each file, what writes it to a path that it is given
    folder : it is made if it is not there, in a folder that is
    stale : sha256 of files of an earlier run by their names: those that are not written now are removed, but
        not one that has been changed since
    index : name of one more file, and what writes it when it is given the sha256 of all others

    Raises
    ------
    OutputError
        If a file cannot be written there.
    """
    target = Path(folder)
    new = not target.exists()
    if new:
        check_writable(target)
        target.mkdir()
    try:
        # Every file is written under a temporary name before the first of them takes its place.
        with ExitStack() as stack:
            digests = {}
            # Leaving the stack, what was entered first is renamed last: the index lists only what is there.
            last = stack.enter_context(replacing(target / index[0])) if index is not None else None
            for name, job in jobs.items():
                temporary = stack.enter_context(replacing(target / name))
                job(temporary)
                digests[name] = sha256_of(temporary) if index is not None else ""
            if index is not None and last is not None:
                index[1](last, digests)
        _remove(target, {name: each for name, each in (stale or {}).items() if name not in jobs})
    except BaseException:
        if new:
            with suppress(OSError):
                target.rmdir()
        raise
    names = [*jobs, *([index[0]] if index is not None else [])]
    return {name: target / name for name in names}


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
    """Return the formats of these names, each once, in their own order; a refusal lists others too.

    Raises
    ------
    OutputError
        If there is no such format.
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
        If the folder is missing or not writable, or ``path`` is a folder or no regular file.
    """
    target = Path(path)
    folder = target.parent
    if target.is_dir():
        raise OutputError(f"{target}: is a folder; name a file in it")
    if target.exists() and not target.is_file():
        raise OutputError(f"{target}: is not a regular file; name another one")
    if not folder.is_dir():
        raise OutputError(f"{target}: there is no folder {folder}; make it first")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OutputError(f"{target}: the folder {folder} is not writable; choose another place")


def check_output(output: str | PathLike[str], source: str | PathLike[str]) -> None:
    """Refuse a file that cannot be written, or that is the input, before any work is done for it.

    Raises
    ------
    OutputError
        If it is one of them.
    """
    check_writable(output)
    if os.path.exists(output) and os.path.exists(source) and os.path.samefile(output, source):
        raise OutputError(f"{os.fspath(output)}: is the input; name another file")


def checked_folder(output: str | PathLike[str]) -> Path:
    """Return a folder for results, or refuse it before any work is done for it; it is not made here.

    Raises
    ------
    OutputError
        If it can neither be made nor written to.
    """
    folder = Path(output)
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
