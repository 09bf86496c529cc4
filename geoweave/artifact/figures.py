"""Execute stale notebooks and publish their figures. A run can be resumed and leaves no half-written file.

Each notebook is executed into a temporary folder under ``build/``. Only a complete result is renamed to
``build/notebooks/<profile>/<name>/``. Then its figures are copied to ``figures/``, each by a rename. A result
stores the digest of everything that it depends on. A notebook is executed again exactly when that digest
changes, so an interrupted run continues with the notebooks that were not finished.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import platform
import shutil
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, replace
from pathlib import Path

import nbformat

from geoweave.artifact import claims, doctor, notebooks
from geoweave.artifact.execution import Children, execute, interrupt_once
from geoweave.artifact.notebook_links import write_links
from geoweave.artifact.progress import Progress
from geoweave.artifact.results import Result, summary
from geoweave.checkout import repository
from geoweave.errors import GeoweaveError
from geoweave.files import replacing

UNRELATED = frozenset(
    {
        "__main__.py",
        "cli",
        "viz/probe.py",
        "artifact/claims.py",
        "artifact/crate.py",
        "artifact/notebook_links.py",
        "artifact/progress.py",
        "artifact/replay.py",
        "artifact/results.py",
        "artifact/site.py",
        "artifact/site.css",
        "artifact/site_font.py",
        "artifact/site_text.py",
    }
)
"""Files and folders of the package that no notebook imports: a change in them leaves figures as they are."""

CLAIMS = ("<!-- claims: written by make report -->", "<!-- end of claims -->")
"""The lines of docs/results.md between which the table of claims stands."""

TIMES = ("<!-- times: written by make report -->", "<!-- end of times -->")
"""The lines of REPRODUCING.md between which the table of times stands."""

__all__ = [
    "Result",
    "digest",
    "digests",
    "main",
    "records",
    "refresh",
    "report",
    "report_claims",
    "run",
    "stored_notebooks",
]


def digests(root: Path, names: Sequence[str], profile: str) -> dict[str, str]:
    """`digest` of many notebooks; the package is read once."""
    package = _package_digest(root / "geoweave")
    return {name: digest(root, name, profile, package) for name in names}


def digest(root: Path, name: str, profile: str, package: bytes | None = None) -> str:
    """Digest of everything a notebook's result depends on.

    These are its cells without outputs, the parameters of the profile, the package's source and data, the
    pinned and the installed versions, Python, the platform, and the named meshes that are available. The
    digest of the package can be given, if it is known already.
    """
    notebook = notebooks.read(notebooks.path_of(root, name))
    lock = root / "requirements.lock"
    facts = {
        "cells": [[c.cell_type, c.source, list(c.metadata.get("tags", []))] for c in notebook.cells],
        "profile": profile,
        "parameters": notebooks.profile_values(root, name, profile),
        "lock": lock.read_text(encoding="utf-8") if lock.is_file() else "",
        "versions": {key: value for key, value in doctor.versions().items() if key != "geoweave"},
        "python": platform.python_version(),
        "platform": [platform.system(), platform.machine()],
        # The default profile uses embedded meshes, which are part of the package.
        "data": {} if profile == "default" else doctor.data_states(),
    }
    total = hashlib.sha256(json.dumps(facts, sort_keys=True).encode())
    total.update(_package_digest(root / "geoweave") if package is None else package)
    return total.hexdigest()


def _package_digest(package: Path) -> bytes:
    """Digest of the source and data of a package that notebooks import."""
    total = hashlib.sha256()
    for path in sorted(package.rglob("*")):
        place = path.relative_to(package)
        within = {place.as_posix(), *(folder.as_posix() for folder in place.parents)}
        if path.is_file() and "__pycache__" not in place.parts and not within & UNRELATED:
            total.update(place.as_posix().encode() + b"\0")
            total.update(hashlib.sha256(path.read_bytes()).digest())
    return total.digest()


def run(
    names: Sequence[str] = (),
    profile: str = "default",
    jobs: int = 1,
    root: Path | None = None,
    force: bool = False,
) -> list[Result]:
    """Bring the figures of the named notebooks (all, if none is named) up to date.

    Parameters
    ----------
    names : names of notebooks, without folder and ending
    profile : "default" or "paper"
    jobs : notebooks executed at the same time
    root : the checkout; found from the working directory if not given
    force : also execute notebooks whose results are fresh

    Returns
    -------
    One result for each notebook, in the order of the names. Progress goes to standard error.

    Raises
    ------
    NotebookError
        for an unknown name or profile, or a notebook that breaks the rules; nothing is executed then.
    """
    root = repository() if root is None else root.resolve()
    chosen = list(dict.fromkeys(names)) or notebooks.names(root)
    keys = digests(root, chosen, profile)
    _drop_leftovers(root)
    children = Children()
    order = notebooks.in_turn(chosen, notebooks.times(root), profile, jobs)
    with Progress(len(chosen)) as progress:
        if len(chosen) > 1:
            progress.say(f"{len(chosen)} notebooks, {jobs} at a time; the quickest first, then the longest")
        if not any((root / "geoweave").rglob("*.nbi")):
            progress.say("loops are compiled as they are first needed: about a minute more, this time only")

        def bring(name: str) -> Result:
            result = None if force else _stored(root, name, profile, keys[name])
            if result is None:
                cells = len(notebooks.code_cells(notebooks.read(notebooks.path_of(root, name))))
                progress.start(name, cells)
                result = _execute(root, name, profile, keys[name], children, progress)
            if result.state != "failed":
                _publish(root, result)
            progress.finish(name, result.sentence(), failed=result.state == "failed")
            return result

        with ThreadPoolExecutor(max_workers=max(1, jobs)) as pool:
            tasks = {name: pool.submit(bring, name) for name in order}
            try:
                results = [tasks[name].result() for name in chosen]
            except BaseException:
                children.stop()
                pool.shutdown(cancel_futures=True)
                raise
    _write_catalogues(root)
    return results


def refresh(names: Sequence[str] = (), jobs: int = 1, root: Path | None = None) -> list[Result]:
    """Execute stale notebooks of the default profile, and store all outputs in the checkout's notebooks."""
    root = repository() if root is None else root.resolve()
    write_links(root)
    results = run(names, "default", jobs, root)
    for result in results:
        if result.state == "failed":
            continue
        path = notebooks.path_of(root, result.name)
        executed = notebooks.read(_folder(root, result.name, "default") / "executed.ipynb")
        settled = notebooks.settled(notebooks.read(path), executed)
        _write(path, (nbformat.writes(settled) + "\n").encode())
    return results


def records(root: Path) -> list[Result]:
    """The results stored in ``build/``, in reading order, the default profile first."""
    found = []
    for profile in notebooks.PROFILES:
        for name in notebooks.names(root):
            file = _folder(root, name, profile) / "record.json"
            if file.is_file():
                found.append(_read_record(file)[1])
    return found


def report(root: Path | None = None) -> int:
    """Write times and memory of ``build/`` into REPRODUCING.md, and times into the index of the figures.

    A notebook that was not executed here keeps its row.

    Returns
    -------
    int
        How many rows were measured here.

    Raises
    ------
    GeoweaveError
        if nothing has been executed, or if the lines that mark the table are gone.
    """
    root = repository() if root is None else root.resolve()
    rows = records(root)
    if not rows:
        raise GeoweaveError("nothing has been executed here: run 'make figures' first")
    taken = notebooks.times(root)
    taken |= {(r.name, r.profile): (f"{r.seconds:.0f}", f"{r.peak_mb:.0f}") for r in rows}
    table = ["| notebook | profile | seconds | peak memory, MB |", "|---|---|---:|---:|"]
    for profile in notebooks.PROFILES:
        for name in notebooks.names(root):
            if (name, profile) in taken:
                table.append("| " + " | ".join((name, profile, *taken[name, profile])) + " |")
    versions = doctor.versions()
    packages = ", ".join(f"{name} {versions[name]}" for name in ("numpy", "scipy", "vtk", "pyvista"))
    machine = f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores"
    table += ["", f"Measured on {machine}, Python {platform.python_version()}, {packages}."]
    _insert(root / "REPRODUCING.md", TIMES, table)
    _write_catalogues(root)
    return len(rows)


def report_claims(root: Path | None = None) -> None:
    """Write the table of claims, paper beside ours, into docs/results.md.

    Raises
    ------
    GeoweaveError
        if a claim cannot be read, or if the lines that mark the table are gone.
    """
    root = repository() if root is None else root.resolve()
    _insert(root / "docs" / "results.md", CLAIMS, claims.table(root))


def _write_catalogues(root: Path) -> None:
    """Write what lists all figures: the index for readers, the research object for machines."""
    _write(root / "figures" / "INDEX.md", notebooks.figures_index(root).encode())
    from geoweave.artifact import crate  # it needs numpy, which nothing else here does

    _write(root / crate.FILE, crate.text(root).encode())


def _insert(page: Path, marks: tuple[str, str], lines: Sequence[str]) -> None:
    """Put lines between the two that mark their place on a page."""
    text = page.read_text(encoding="utf-8")
    begin, end = (text.find(mark) for mark in marks)
    if begin < 0 or end < begin:
        raise GeoweaveError(f"{page.name} must hold the lines '{marks[0]}' and '{marks[1]}'")
    new = text[:begin] + marks[0] + "\n" + "\n".join(lines) + "\n" + text[end:]
    _write(page, new.encode())


def _folder(root: Path, name: str, profile: str) -> Path:
    return root / "build" / "notebooks" / profile / name


def _read_record(file: Path) -> tuple[str, Result]:
    record = json.loads(file.read_text())
    key = record.pop("key")
    return key, replace(Result(**record), figures=tuple(record["figures"]))


def _stored(root: Path, name: str, profile: str, key: str) -> Result | None:
    """The stored result, if its digest is the same and no file is missing."""
    folder = _folder(root, name, profile)
    if not (folder / "record.json").is_file():
        return None
    made_from, result = _read_record(folder / "record.json")
    whole = all((folder / "figures" / figure).is_file() for figure in result.figures)
    return result if made_from == key and whole else None


def stored_notebooks(root: Path, names: Sequence[str], profile: str) -> dict[str, Path]:
    """The executed notebooks in ``build/`` that were executed from all that there is now."""
    found = {}
    for name, key in digests(root, names, profile).items():
        executed = _folder(root, name, profile) / "executed.ipynb"
        if _stored(root, name, profile, key) is not None and executed.is_file():
            found[name] = executed
    return found


def _drop_leftovers(root: Path) -> None:
    """Remove the temporary folders that a killed run left behind more than a day ago."""
    for path in (root / "build").glob("running-*"):
        if time.time() - path.stat().st_mtime > 86_400:
            shutil.rmtree(path, ignore_errors=True)


def _execute(root: Path, name: str, profile: str, key: str, children: Children, progress: Progress) -> Result:
    """Execute one notebook. Keep a complete result under its name, and a failed notebook for inspection."""
    kept = _folder(root, name, profile).with_name(f"{name}.failed.ipynb")
    kept.parent.mkdir(parents=True, exist_ok=True)
    kept.unlink(missing_ok=True)
    folder = Path(tempfile.mkdtemp(prefix="running-", dir=root / "build"))
    try:
        outcome = execute(root, name, profile, folder, children, lambda cells: progress.advance(name, cells))
        published = folder / "figures"
        figures = sorted(p.relative_to(published).as_posix() for p in published.rglob("*") if p.is_file())
        problem = outcome.problem or _misplaced(figures, profile)
        if problem:
            if (folder / "executed.ipynb").is_file():
                (folder / "executed.ipynb").replace(kept)
                problem += f" (as far as it came: {kept.relative_to(root).as_posix()})"
            return Result(name, profile, "failed", problem=problem)
        result = Result(name, profile, "fresh", outcome.seconds, outcome.peak_mb, tuple(figures))
        (folder / "record.json").write_text(json.dumps({"key": key, **asdict(result)}, indent=1) + "\n")
        shutil.rmtree(folder / "ipython", ignore_errors=True)
        shutil.rmtree(_folder(root, name, profile), ignore_errors=True)
        folder.rename(_folder(root, name, profile))
        return replace(result, state="done")
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _misplaced(figures: Sequence[str], profile: str) -> str:
    """A sentence on files published into the folder of another profile, "" if there are none."""
    prefix = "" if profile == "default" else f"{profile}/"
    strays = [f for f in figures if f != prefix + f.rpartition("/")[2]]
    if not strays:
        return ""
    return f"{', '.join(strays)} published in profile {profile}: give the profile to publish"


def _publish(root: Path, result: Result) -> None:
    staged = _folder(root, result.name, result.profile) / "figures"
    for figure in result.figures:
        _write(root / "figures" / figure, (staged / figure).read_bytes())


def _write(path: Path, content: bytes) -> None:
    """Write a file by a rename, but do nothing if it has this content already."""
    if path.is_file() and path.read_bytes() == content:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as temporary:
        temporary.write_bytes(content)


def main(arguments: Sequence[str] | None = None) -> int:
    """What the Makefile calls; status 1 if a notebook failed, 2 if the request is not valid here."""
    parser = argparse.ArgumentParser(prog="python -m geoweave.artifact.figures")
    commands = parser.add_subparsers(dest="command", required=True)
    figures = commands.add_parser("figures", help="write figures/ from the notebooks that are stale")
    stored = commands.add_parser("refresh", help="store fresh outputs in notebooks/")
    commands.add_parser("report", help="write the claims into docs/results.md, times into REPRODUCING.md")
    for command in (figures, stored):
        command.add_argument("names", nargs="*")
        command.add_argument("--jobs", type=int, default=1)
    figures.add_argument("--profile", choices=notebooks.PROFILES, default="default")
    figures.add_argument("--force", action="store_true", help="execute also what is up to date")
    options = parser.parse_args(arguments)
    interrupt_once()
    started = time.perf_counter()
    try:
        if options.command == "report":
            report_claims()
            report()
            return 0
        if options.command == "figures":
            results = run(options.names, options.profile, options.jobs, force=options.force)
        else:
            results = refresh(options.names, options.jobs)
    except GeoweaveError as error:
        print(f"geoweave: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("geoweave: interrupted; the same command goes on where this one stopped", file=sys.stderr)
        return 130
    profile = getattr(options, "profile", "default")
    print(summary(results, profile, time.perf_counter() - started), file=sys.stderr)
    return 1 if any(result.state == "failed" for result in results) else 0


if __name__ == "__main__":
    sys.exit(main())
