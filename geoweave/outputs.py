"""The files that a weave is written to, all of them or none."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from os import PathLike
from pathlib import Path

from geoweave.inspection import Inspection, inspected
from geoweave.output import chosen, written_together
from geoweave.relaxed import Relaxed
from geoweave.ribbon_rods import file_of_rods, rods_of_ribbons
from geoweave.rodfiles import RodFile, rod_text
from geoweave.woven import Weave

__all__ = ["FORMATS", "check_formats", "rod_file", "write_texts", "write_weave"]

FORMATS = {
    "json": "weave.json and report.json, which are always written",
    "rod": "weave.rod, the ribbons as elastic rods for RibbonSim",
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
    """Return a weave as elastic rods in the unit of the weave (`geoweave.ribbon_rods`).

    Young's modulus and density are the defaults of the rods; the file does not say which ribbon lies above.
    """
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
) -> dict[str, Path]:
    """Write ``weave.json``, ``report.json`` and what else is asked for, all together or not at all.

    Parameters
    ----------
    weave : the weave
    folder : where to; it is made if it is not there, in a folder that is
    formats : names from `FORMATS`
    report : what `inspected` found; it is called if not given
    relaxed : the weave relaxed: ``relaxed.json`` is written too, and the report says how it rests

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
    wanted = check_formats(formats)
    said = (report or inspected(weave)).document()
    texts = {"weave.json": json.dumps(weave.document(), allow_nan=False) + "\n"}
    if relaxed is not None:
        texts["relaxed.json"] = json.dumps(relaxed.document(), allow_nan=False) + "\n"
        said |= {"relax": relaxed.metrics()}
    texts["report.json"] = json.dumps(said, indent=1, allow_nan=False) + "\n"
    if "rod" in wanted:
        texts["weave.rod"] = rod_text(rod_file(weave))
    return write_texts(texts, folder)


def write_texts(texts: Mapping[str, str], folder: str | PathLike[str]) -> dict[str, Path]:
    """Write files of text into a folder, all of them or none; returns the path of each by its name.

    Raises
    ------
    OutputError
        If a file cannot be written there.
    """
    jobs = {name: partial(_write_text, text=text) for name, text in texts.items()}
    return written_together(jobs, folder)


def _write_text(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8", newline="\n")
