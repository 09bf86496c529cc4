"""Strips drawn anew from a folder that a weave was written to, without weaving again."""

from __future__ import annotations

import json
import math
import os
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geoweave.documents import read_json
from geoweave.errors import FieldError
from geoweave.files import Job, OutputError, checked_folder, printable
from geoweave.pipeline.cut_request import CutRequest
from geoweave.pipeline.source import Say, about, silent, timed
from geoweave.pipeline.strips import CutStrips, strips_of
from geoweave.pipeline.up_in_report import said_up
from geoweave.pipeline.weave_folder import REPORT, earlier_report, write_reported

if TYPE_CHECKING:
    from geoweave.fabrication import StripLayout

__all__ = ["CutFiles", "cut_folder"]

WEAVE, REST = "weave.json", "relaxed.json"
OF_STRIPS = ("pattern", "cutlist", "guide", "weave.glb")
"""How the names of files begin that are written from strips."""

WOVEN = ("weave.json", "relaxed.json", "weave.rod", "design.npz")
"""Files of a weave that cutting leaves as they are."""

DEFAULT = ("pattern", "csv", "svg", "pdf")
"""What is written where the folder holds no file of strips."""


@dataclass(frozen=True, eq=False)
class CutFiles:
    """Strips that were drawn anew, and the files that they were written to."""

    folder: Path
    """Of the weave."""
    request: CutRequest
    cut: CutStrips
    """The strips, and what is measured on them."""
    layout: StripLayout
    """The strips as they lie on sheets and pages."""
    files: dict[str, Path]
    """Path of each file by its name."""
    seconds: dict[str, float]
    thickness_at_rest: float | None = None
    """Thickness for which the lengths at rest were found, mm, if the strips are thicker or thinner."""

    def document(self) -> dict[str, Any]:
        """All numbers, as ``geoweave cut --json`` prints them."""
        from geoweave.fabrication import layout_numbers

        return {
            "folder": str(self.folder),
            "request": self.request.document(),
            "strips_of": self.cut.source,
            "slipped": self.cut.slipped,
            "thickness_at_rest": self.thickness_at_rest,
            "assembly": self.layout.assembly,
            **layout_numbers(self.layout),
            "seconds": {key: round(value, 4) for key, value in self.seconds.items()},
            "files": [str(path) for path in self.files.values()],
        }


def cut_folder(
    folder: str | os.PathLike[str],
    output: str | os.PathLike[str] | None = None,
    request: CutRequest | None = None,
    *,
    callback: Say | None = None,
) -> CutFiles:
    """Draw the strips of a weave anew, as ``geoweave cut`` does.

    Parameters
    ----------
    folder : with a ``weave.json`` in mm, and the ``relaxed.json`` of the weave at rest if there is one
    output : where to; the same folder if not given. Another folder gets copies of both files, so that it is
        whole and can be cut again
    request : how the strips are cut; all as by default if not given
    callback : called with one line of progress at a time

    Raises
    ------
    FieldError
        If there is no weave in mm, or the strips cannot be made as asked for; the text says which number
        would work.
    OutputError
        If a file cannot be written, or there is no such format.

    Examples
    --------
    >>> import tempfile
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=100.0)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = gw.pipeline.write_weave(weave, f"{folder}/cone")
    ...     made = gw.cut_folder(f"{folder}/cone", request=gw.CutRequest(sheet="a4", formats=("svg",)))
    ...     sorted(name for name in made.files)
    ['pattern.svg', 'report.json']
    """
    from geoweave.fabrication import check_formats, files_of, hooped, layout_for

    source, wish, say = Path(folder), request or CutRequest(), callback or silent
    target = source if output is None else checked_folder(output)
    seconds: dict[str, float] = {}
    with timed(seconds, "read"):
        documents = _read(source, wish)
    before = earlier_report(source)
    formats = check_formats(wish.formats or _held(before))
    say("laying the ribbons flat")
    with timed(seconds, "strips"):
        if wish.hoops:
            with about(str(source)):
                documents = hooped(documents[WEAVE], documents.get(REST), wish.hoops)
        cut = strips_of(documents[WEAVE], documents.get(REST), wish.end)
    say("drawing the strips")
    with timed(seconds, "draw"):
        title = printable(str(before.get("title") or source.resolve().name))
        bench = wish.bench(title, said_up(before))
        laid = layout_for(cut.pattern, formats, bench=bench, weave=documents[WEAVE], rest=cut.space)
        jobs = files_of(laid, formats)
    say("writing")
    with timed(seconds, "write"):
        files = _write(target, source, jobs, before, cut, laid, wish)
    seconds["total"] = sum(seconds.values())
    return CutFiles(source, wish, cut, laid, files, seconds, _other_thickness(before, cut))


def _other_thickness(report: Mapping[str, Any], cut: CutStrips) -> float | None:
    """The thickness for which a weave was relaxed, if its strips are cut a tenth thicker or thinner."""
    found = report.get("thickness")
    if cut.space is None or not isinstance(found, int | float) or not 0 < found < math.inf:
        return None
    return float(found) if abs(math.log(cut.pattern.thickness / found)) > math.log(1.1) else None


def _read(folder: Path, wish: CutRequest) -> dict[str, Mapping[str, Any]]:
    """The weave, and the weave at rest if there is one, with another width and thickness if asked for."""
    from geoweave.fabrication import weave_document

    if not (folder / WEAVE).is_file():
        raise FieldError(f"{folder}: holds no {WEAVE}; make one with 'geoweave weave MESH --size MM -o DIR'")
    found: dict[str, Mapping[str, Any]] = {}
    for name in (WEAVE, REST):
        if not (folder / name).is_file():
            continue
        read = read_json(folder / name, FieldError, "make one with 'geoweave weave'")
        document = dict(weave_document(read, str(folder / name)))
        if document.get("units") != "mm":
            raise FieldError(f"{folder / name}: is not in mm; weave it again with --size MM")
        for key in ("width", "thickness"):
            value = getattr(wish, key)
            if value is None and key == "thickness" and wish.preset is not None:
                value = wish.setting(key)
            document[key] = document.get(key) if value is None else value
            if not (isinstance(document[key], int | float) and 0 < document[key] < math.inf):
                raise FieldError(f"{folder / name}: its {key} is {document[key]}; it must be positive")
        if document["thickness"] > document["width"]:
            raise FieldError(
                f"strips {document['width']:g} mm wide cannot be {document['thickness']:g} mm thick; take a "
                f"--width above {document['thickness']:g} or a --thickness below {document['width']:g}"
            )
        found[name] = document
    return found


def _held(report: Mapping[str, Any]) -> tuple[str, ...]:
    """The formats of strips of the files that a report lists."""
    listed = report.get("files")
    names = list(listed) if isinstance(listed, dict) else []
    held = {
        "pattern": "pattern.json" in names,
        "csv": "cutlist.csv" in names,
        "glb": "weave.glb" in names,
        "guide": "guide.html" in names,
    }
    for kind in ("svg", "dxf", "pdf"):
        held[kind] = any(name.startswith("pattern") and name.endswith(f".{kind}") for name in names)
    return tuple(name for name, there in held.items() if there) or DEFAULT


def _write(
    target: Path,
    source: Path,
    jobs: dict[str, Job],
    before: Mapping[str, Any],
    cut: CutStrips,
    laid: StripLayout,
    wish: CutRequest,
) -> dict[str, Path]:
    """Write the files in place of those of strips that are there, and say so in the report."""
    from geoweave.fabrication import layout_numbers

    report = dict(before)
    strips = cut.document()
    same = report.get("strips") == json.loads(json.dumps(strips))
    if not same:
        # Both were said of other strips than these.
        report.pop("verdict", None)
        report.pop("twin", None)
    if wish.up is not None:
        report["up"] = {"axis": laid.bench.up, "by": "request"}
    report |= {
        "strips": strips,
        "assembly": laid.assembly,
        "cut": {"request": wish.document(), **layout_numbers(laid)},
    }
    kept: tuple[str, ...] = ()
    if target.exists() and target.samefile(source):
        listed = before.get("files") if isinstance(before.get("files"), dict) else {}
        kept = tuple(name for name in listed or {} if not name.startswith(OF_STRIPS))
        if not same:
            kept = tuple(name for name in kept if name != "twin.json")
        if not before and (target / REPORT).exists():
            raise OutputError(f"{target / REPORT}: cannot be read; move it away, or give another folder")
    else:
        for name in WOVEN:
            if (source / name).is_file():
                jobs = {name: partial(shutil.copyfile, source / name), **jobs}
    return write_reported(jobs, report, target, kept)
