"""Weaves of many meshes, and a table of them (Section 6). An interrupted sweep goes on where it stopped.

Each mesh is woven into a temporary folder, and its files are then moved to a folder of their own. The file
that is moved last is ``sweep.json``. It holds the digest of all that the weave depends on and the sha256 of
every file. A mesh is woven again if that digest has changed, or one of its files has.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import asdict, dataclass, replace
from functools import cache, partial
from pathlib import Path
from typing import Any

from geoweave.checkout import PACKAGE, package_version
from geoweave.errors import GeoweaveError
from geoweave.files import OutputError, check_writable, sha256_of, text_job, written_together
from geoweave.pipeline.design import weave_file
from geoweave.pipeline.request import WeaveRequest
from geoweave.pipeline.source import MeshSource, names_a_data_set
from geoweave.pipeline.sweep_table import TABLES, Row, table_texts
from geoweave.pipeline.weave_folder import listed_files, write_texts
from geoweave.pipeline.workers import on_cluster, on_this_machine

__all__ = ["Job", "folder_names", "jobs_of", "sweep", "weave_one"]

RECORD = "sweep.json"
"""Name of the record that says, in the folder of a mesh, what it was woven from."""

FORMAT, VERSION = "geoweave-sweep", 1
"""What a record says that it is."""

UNRELATED = frozenset({"viz"})
"""Rooms that change no weave."""

LEFTOVER = ".weaving-"
"""How the names of folders begin in which work is under way."""

LEFTOVER_AGE = 86_400.0
"""Seconds after which such a folder is taken for one of a sweep that was killed."""

_ALONE = threading.Lock()
"""A process weaves one mesh at a time: while a file is read, warnings of the whole process are held back."""


@dataclass(frozen=True)
class Job:
    """One mesh to be woven, wherever that happens."""

    mesh: str
    """As it was asked for."""
    source: MeshSource
    """With the whole path of the file."""
    request: WeaveRequest
    key: str
    """Digest of everything that the weave depends on."""
    code: str
    """Digest of the package's source, which a worker elsewhere must have too; "" on this machine."""
    name: str
    """Name of its folder."""
    folder: str
    """Whole path of the temporary folder that it is woven into."""


def sweep(
    sources: Sequence[MeshSource],
    request: WeaveRequest,
    folder: Path,
    *,
    jobs: int = 1,
    dask: str | None = None,
    callback: Callable[[Row, int], None] | None = None,
) -> tuple[Row, ...]:
    """Weave many meshes into ``folder/<name of the mesh>/`` and write a table of them.

    Parameters
    ----------
    sources : the meshes; one that is named twice is woven once
    request : what each weave is to be like
    folder : it is made if it is not there, in a folder that is
    jobs : processes on this machine
    dask : address of a Dask scheduler, in place of them; its workers must see the folder and the files
    callback : called with each row as it is ready, and the number of all

    Returns
    -------
    The rows in the order of the meshes. A mesh that fails is a row, and stops no other.

    Raises
    ------
    OutputError
        If the folder or a table cannot be written.
    PoolError
        If there is no such cluster.
    """
    folder = folder.resolve()
    new = not folder.exists()
    for name in TABLES if not new else ():
        check_writable(folder / name)
    if new:
        check_writable(folder)
        folder.mkdir()
    _drop_leftovers(folder)
    work = Path(tempfile.mkdtemp(prefix=LEFTOVER, dir=folder))
    try:
        todo = jobs_of(sources, request, work, code="" if dask is None else source_digest())
        rows = _rows(todo, folder, jobs, dask, callback)
        write_texts(table_texts(rows), folder)
        return rows
    finally:
        shutil.rmtree(work, ignore_errors=True)
        if new:
            with suppress(OSError):
                folder.rmdir()  # if nothing came of it


def _rows(
    todo: Sequence[Job | Row],
    folder: Path,
    jobs: int,
    dask: str | None,
    callback: Callable[[Row, int], None] | None,
) -> tuple[Row, ...]:
    rows: dict[int, Row] = {}

    def ready(place: int, row: Row) -> None:
        rows[place] = row
        if callback is not None:
            callback(row, len(todo))

    left: dict[int, Job] = {}
    for place, each in enumerate(todo):
        if isinstance(each, Row):
            ready(place, each)
        elif (kept := _kept(each, folder)) is not None:
            ready(place, kept)
        else:
            left[place] = each
    places, items = list(left), list(left.values())
    if items:
        pool = on_this_machine(weave_one, items, jobs) if dask is None else on_cluster(weave_one, items, dask)
        with closing(pool):  # so that no process goes on when we are interrupted
            for ended in pool:
                job = items[ended.item]
                outcome = {"problem": f"{job.mesh}: {ended.problem}"} if ended.problem else ended.result
                ready(places[ended.item], _settled(job, outcome, folder))
    return tuple(rows[place] for place in range(len(todo)))


def weave_one(job: Job) -> dict[str, Any]:
    """Weave one mesh into its temporary folder, in the process that this is called in.

    Returns
    -------
    The result, or one sentence on what went wrong, with the traceback if it is a fault of ours.
    """
    try:
        if job.code and job.code != source_digest():
            raise GeoweaveError(
                f"{job.mesh}: the worker has another geoweave ({package_version()}); install the same there"
            )
        if not Path(job.folder).parent.is_dir():
            raise GeoweaveError(
                f"{job.mesh}: the worker does not see {Path(job.folder).parent.parent}; "
                "a cluster needs a file system that all its machines share"
            )
        with _ALONE:
            made = weave_file(job.source, job.folder, job.request)
        return {"result": made.document()}
    except GeoweaveError as error:
        return {"problem": " ".join(str(error).replace(job.source.name, job.mesh).split())}
    except MemoryError:
        return {"problem": f"{job.mesh}: not enough memory; ask for fewer triangles with --faces"}
    except Exception as error:
        said = " ".join(f"{type(error).__name__}: {error}".split())
        return {
            "problem": f"{job.mesh}: a fault of geoweave ({said}); please report it",
            "fault": traceback.format_exc(),
        }


def jobs_of(
    sources: Sequence[MeshSource], request: WeaveRequest, work: Path, code: str = ""
) -> list[Job | Row]:
    """Give each mesh its folder and its digest; one that cannot be read at all is a row already."""
    once: dict[str, MeshSource] = {}
    for source in sources:
        once.setdefault(os.path.realpath(_place(source)), source)
    places = [_place(source) for source in once.values()]
    found: list[Job | Row] = []
    for place, source, name in zip(places, once.values(), folder_names(places), strict=True):
        try:
            key = _key(place, source, request)
        except GeoweaveError as error:
            found.append(Row(source.name, name, "failed", " ".join(str(error).split())))
            continue
        there = replace(source, name=place)
        found.append(Job(source.name, there, request, key, code, name, str(work / name)))
    return found


def folder_names(places: Sequence[str]) -> list[str]:
    """Name a folder for each mesh: the file's name without its ending, with more of its path where two agree.

    Names that differ in capitals only count as the same, as file systems take them for the same.
    """
    paths = [Path(place) for place in places]
    names = [_named(path, 0) for path in paths]
    for more in range(1, max((len(path.parts) for path in paths), default=0) + 1):
        seen = [*TABLES, *(name.casefold() for name in names)]
        names = [
            _named(path, more) if seen.count(name.casefold()) > 1 else name
            for path, name in zip(paths, names, strict=True)
        ]
    count: dict[str, int] = {}
    for k, name in enumerate(names):
        same = name.casefold()
        count[same] = count.get(same, 0) + 1
        names[k] = name if count[same] == 1 else f"{name}-{count[same]}"
    return names


def _named(path: Path, more: int) -> str:
    """A file's stem, then with its ending too, then with the folders that it lies in."""
    folders = path.parent.parts[len(path.parent.parts) - more + 1 :] if more > 1 else ()
    words = [*folders, path.stem, path.suffix if more else ""]
    return "-".join(word for word in (word.strip("./\\:") for word in words) if word) or "mesh"


def _place(source: MeshSource) -> str:
    """The whole path of a mesh's file, or the name of a data set."""
    return source.name if names_a_data_set(source.name) else os.path.abspath(source.name)


def _key(place: str, source: MeshSource, request: WeaveRequest) -> str:
    """Digest of what a weave depends on: the file, how it is read, what is asked for, and this program."""
    facts = {
        "mesh source": {**asdict(source), "name": ""},
        "request": asdict(request),
        "version": package_version(),
        "source": source_digest(),
        "mesh": _content(place, source.name),
    }
    return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()


def _content(place: str, name: str) -> str:
    """Digest of a mesh's file; that of a data set is the one of the registry."""
    from geoweave.models import datasets

    if place in datasets.names():
        return datasets.dataset(place).sha256
    try:
        return hashlib.sha256(Path(place).read_bytes()).hexdigest()
    except OSError as error:
        if isinstance(error, FileNotFoundError | NotADirectoryError):
            raise GeoweaveError(
                f"{name}: there is neither a file nor a data set of that name; check the path"
            ) from None
        raise GeoweaveError(f"{name}: cannot be read ({error.strerror}); check the file") from None


@cache
def source_digest() -> str:
    """Digest of the package's source, so that another state of a checkout is another version.

    Every file of every sub-package counts, but the pictures, which no weave depends on.
    """
    total = hashlib.sha256()
    for path in sorted(PACKAGE.rglob("*")):
        name = path.relative_to(PACKAGE)
        if path.is_file() and "__pycache__" not in name.parts and name.parts[0] not in UNRELATED:
            total.update(name.as_posix().encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()


def _kept(job: Job, folder: Path) -> Row | None:
    """The row of a mesh that is woven already, from the same things, and whose files are whole."""
    target = folder / job.name
    try:
        record = json.loads((target / RECORD).read_text(encoding="utf-8"))
        same = record["key"] == job.key
        whole = all(sha256_of(target / name) == digest for name, digest in record["files"].items())
        result = _told(record["result"], job, target, record["files"])
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    return Row(job.mesh, job.name, "kept", result=result) if same and whole else None


def _settled(job: Job, outcome: Mapping[str, Any], folder: Path) -> Row:
    """Move what was woven to its place, all or nothing; the record says that it is whole."""
    target, made = folder / job.name, Path(job.folder)
    if "result" not in outcome:
        return Row(job.mesh, job.name, "failed", outcome["problem"], None, outcome.get("fault", ""))

    def record(path: Path, digests: dict[str, str]) -> None:
        about = {"format": FORMAT, "version": VERSION, "key": job.key, "files": digests}
        text = json.dumps({**about, "result": outcome["result"]}, indent=1, allow_nan=False) + "\n"
        text_job(text)(path)

    try:
        names = sorted(path.name for path in made.iterdir())
        moves = {name: partial(os.replace, made / name) for name in names}
        written_together(moves, target, stale=listed_files(target), index=(RECORD, record))
    except OSError as error:
        return Row(job.mesh, job.name, "failed", f"{target}: cannot be written ({error.strerror})")
    except OutputError as error:
        return Row(job.mesh, job.name, "failed", str(error))
    return Row(job.mesh, job.name, "done", result=_told(outcome["result"], job, target, names))


def _told(result: Mapping[str, Any], job: Job, target: Path, files: Iterable[str]) -> dict[str, Any]:
    """The result with the names by which people know the mesh and the files."""
    places = {"output": str(target / "weave.json"), "files": [str(target / name) for name in files]}
    return {**result, "mesh": job.mesh, **places}


def _drop_leftovers(folder: Path) -> None:
    """Remove the folders to work in that a killed sweep left behind more than a day ago."""
    for path in folder.glob(f"{LEFTOVER}*"):
        with suppress(OSError):  # another sweep may have removed its own by now
            if time.time() - path.stat().st_mtime > LEFTOVER_AGE:
                shutil.rmtree(path, ignore_errors=True)
