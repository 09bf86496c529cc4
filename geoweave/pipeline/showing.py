"""A page to look at a weave and to change it, from the folder that it was written to: ``geoweave show``."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geoweave.errors import FieldError
from geoweave.files import check_writable, printable, replacing, text_job
from geoweave.pipeline.source import Say, silent, timed
from geoweave.pipeline.up_in_report import said_up
from geoweave.pipeline.weave_folder import earlier_report, listed_files, write_reported
from geoweave.rods import read_weave

__all__ = ["PAGE", "Shown", "show_folder"]

WEAVE, REST, PAGE = "weave.json", "relaxed.json", "viewer.html"


@dataclass(frozen=True)
class Shown:
    """A page that was written."""

    path: Path
    title: str
    ribbons: int
    crossings: int
    at_rest: bool
    """Whether the page shows the weave at rest beside the design."""
    places: int
    """Hard places that it lists."""
    seconds: dict[str, float]

    def document(self) -> dict[str, Any]:
        """All of it, as ``geoweave show --json`` prints it."""
        return {
            "page": str(self.path),
            "title": self.title,
            "ribbons": self.ribbons,
            "crossings": self.crossings,
            "at_rest": self.at_rest,
            "places": self.places,
            "seconds": {key: round(value, 4) for key, value in self.seconds.items()},
        }


def show_folder(
    folder: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    *,
    up: str | None = None,
    callback: Say | None = None,
) -> Shown:
    """Write one page that shows a weave, as ``geoweave show`` does.

    Parameters
    ----------
    folder : with a ``weave.json``, and its ``relaxed.json`` and ``report.json`` if they are there
    output : path of the page; ``viewer.html`` in the folder if not given
    up : the axis that is up, such as "y" or "-z"; as the report of the weave says if not given
    callback : called with one line of progress at a time

    Raises
    ------
    FieldError
        If there is no weave, or no such axis.
    WeaveFileError
        If a file of it cannot be read.
    OutputError
        If the page cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = gw.pipeline.write_weave(weave, f"{folder}/cone")
    ...     shown = gw.show_folder(f"{folder}/cone")
    ...     shown.path.name, shown.ribbons == len(weave.ribbons), shown.at_rest
    ('viewer.html', True, False)
    """
    from geoweave.fabrication import check_axis, viewer_html

    source, say = Path(folder), callback or silent
    if not (source / WEAVE).is_file():
        raise FieldError(f"{source}: holds no {WEAVE}; make one with 'geoweave weave MESH -o DIR'")
    if output is not None:
        check_writable(output)
    asked = None if up is None else check_axis(up)
    seconds: dict[str, float] = {}
    say("reading the weave")
    with timed(seconds, "read"):
        weave = read_weave(source / WEAVE)
        rest = read_weave(source / REST) if (source / REST).is_file() else None
        report = earlier_report(source)
    title = printable(str(report.get("title") or source.resolve().name))
    say("drawing the page")
    with timed(seconds, "draw"):
        text = viewer_html(weave, rest, report, title, up=asked or said_up(report))
    with timed(seconds, "write"):
        path = _written(text, source, report, output)
    seconds["total"] = sum(seconds.values())
    places = len(report.get("places", ()))
    return Shown(
        path, title, len(weave["ribbons"]), len(weave["crossings"]), rest is not None, places, seconds
    )


def _written(
    text: str, source: Path, report: Mapping[str, Any], output: str | os.PathLike[str] | None
) -> Path:
    """Write the page. In the folder of the weave its report lists it, so that a new weave removes it."""
    if output is None and report:
        kept = tuple(name for name in listed_files(source) if name != PAGE)
        return write_reported({PAGE: text_job(text)}, report, source, kept)[PAGE]
    path = source / PAGE if output is None else Path(output)
    with replacing(path) as temporary:
        text_job(text)(temporary)
    return path
