"""The files that a weave is written to, all of them or none."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geoweave.files import Job, chosen, text_job, written_together

if TYPE_CHECKING:
    from geoweave.rods import Relaxed, RodFile
    from geoweave.weave import Inspection, Weave

__all__ = [
    "DESIGN",
    "DESIGN_FILE",
    "FORMATS",
    "REPORT",
    "check_formats",
    "earlier_report",
    "listed_files",
    "rod_file",
    "text_jobs",
    "write_reported",
    "write_texts",
    "write_weave",
]

REPORT = "report.json"
DESIGN_FILE = "design.npz"
DESIGN = ("weave.json", "weave.rod", DESIGN_FILE)
"""Files of a weave as it was designed, whatever shape it takes at rest."""

FORMATS = {
    "json": "weave.json and report.json, which are always written",
    "rod": "weave.rod, the ribbons as elastic rods for RibbonSim",
    "design": "design.npz, from which 'geoweave edit' goes on without designing again",
}
"""What a weave can be written as."""


def check_formats(names: Iterable[str], others: Iterable[str] = ()) -> tuple[str, ...]:
    """Return the formats of these names, each once, in the order of `FORMATS`; a refusal lists others too.

    Raises
    ------
    OutputError
        If there is no such format.
    """
    return chosen(names, FORMATS, "weave", others)


def rod_file(weave: Weave) -> RodFile:
    """Return a weave as elastic rods in the unit of the weave (`geoweave.rods.from_ribbons`).

    Young's modulus and density are the defaults of the rods; the file does not say which ribbon lies above.
    """
    from geoweave.rods import file_of_rods, rods_of_ribbons

    place, unit = weave.placement.undo, weave.placement.scale
    rods = rods_of_ribbons(weave.ribbons, weave.interlacing.over, weave.width, weave.thickness)
    content = file_of_rods(rods)
    sized = (
        replace(rod, centerline=place(rod.centerline), widths=unit * rod.widths, color=int(weave.families[r]))
        for r, rod in enumerate(content.rods)
    )
    return replace(content, rods=tuple(sized), thickness=unit * content.thickness)


def write_weave(
    weave: Weave,
    folder: str | PathLike[str],
    formats: Iterable[str] = (),
    report: Inspection | None = None,
    relaxed: Relaxed | None = None,
    more: Mapping[str, Job] | None = None,
    about: Mapping[str, Any] | None = None,
) -> dict[str, Path]:
    """Write ``weave.json``, ``report.json`` and what else is asked for, all together or not at all.

    What an earlier run wrote there and this one does not is removed, so that nothing contradicts the weave.

    Parameters
    ----------
    weave : the weave
    folder : where to; it is made if it is not there, in a folder that is
    formats : names from `FORMATS`
    report : what `inspected` found; it is called if not given
    relaxed : the weave relaxed: ``relaxed.json`` is written too, and the report says how it rests
    more : what writes other files of this weave
    about : what else the report says, such as what is measured on the strips

    Returns
    -------
    dict
        Path of each file by its name.

    Raises
    ------
    OutputError
        If a format is unknown or a file cannot be written there.
    RodError
        If a rod cannot be made of a ribbon.
    """
    from geoweave.weave import inspected

    wanted = check_formats(formats)
    said = (report or inspected(weave)).document()
    texts = {"weave.json": json.dumps(weave.document(), allow_nan=False) + "\n"}
    if relaxed is not None:
        texts["relaxed.json"] = json.dumps(relaxed.document(), allow_nan=False) + "\n"
        said |= {"relax": relaxed.metrics(), "fasten": relaxed.fasten()}
    said |= dict(about or {})
    if "rod" in wanted:
        from geoweave.rods import rod_text

        texts["weave.rod"] = rod_text(rod_file(weave))
    jobs = text_jobs(texts)
    if "design" in wanted:
        from geoweave.pipeline.design_file import design_job

        jobs[DESIGN_FILE] = design_job(weave)
    return write_reported(jobs | dict(more or {}), said, folder)


def write_reported(
    jobs: Mapping[str, Job],
    report: Mapping[str, Any],
    folder: str | PathLike[str],
    kept: Collection[str] = (),
) -> dict[str, Path]:
    """Write files, and a ``report.json`` that lists them with their sha256, in place of an earlier run.

    Parameters
    ----------
    jobs : by the name of each file, what writes it
    report : what else the report says
    folder : it is made if it is not there, in a folder that is
    kept : names of files of the earlier run that stay. Its others are removed if they are not written now,
        but not one that somebody has changed, nor any that its report does not list

    Raises
    ------
    OutputError
        If a file cannot be written there.
    """
    before = listed_files(folder)
    stay = {name: digest for name, digest in before.items() if name in kept}

    def index(path: Path, digests: dict[str, str]) -> None:
        said = {**report, "files": stay | digests}
        text_job(json.dumps(said, indent=1, allow_nan=False) + "\n")(path)

    stale = {name: digest for name, digest in before.items() if name not in kept}
    return written_together(jobs, folder, stale=stale, index=(REPORT, index))


def earlier_report(folder: str | PathLike[str]) -> dict[str, Any]:
    """The report of an earlier run into a folder, {} if there is none that can be read."""
    try:
        report = json.loads((Path(folder) / REPORT).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return report if isinstance(report, dict) else {}


def listed_files(folder: str | PathLike[str]) -> dict[str, str]:
    """The sha256 of each file that the report of an earlier run lists."""
    listed = earlier_report(folder).get("files")
    if not isinstance(listed, dict):
        return {}
    # A name with a folder in it is none of ours.
    return {name: str(digest) for name, digest in listed.items() if name == Path(name).name}


def write_texts(texts: Mapping[str, str], folder: str | PathLike[str]) -> dict[str, Path]:
    """Write files of text into a folder, all of them or none; returns the path of each by its name.

    Raises
    ------
    OutputError
        If a file cannot be written there.
    """
    return written_together(text_jobs(texts), folder)


def text_jobs(texts: Mapping[str, str]) -> dict[str, Job]:
    """What writes each of these texts."""
    return {name: text_job(text) for name, text in texts.items()}
