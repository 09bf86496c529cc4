"""Everything a maker takes to the bench, written together or not at all (Section 5.4)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from geoweave.fabrication.bench import Bench, media_of
from geoweave.fabrication.flattening import WeaveLike, weave_document
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.strip_layout import StripLayout
from geoweave.files import Job, OutputError, chosen, written_together

__all__ = ["FORMATS", "check_formats", "files_of", "jobs_of", "layout_for", "write"]

FORMATS = {
    "pattern": "pattern.json, flat strips, crossings and the order of assembly",
    "csv": "cutlist.csv, lengths and stock",
    "svg": "pattern.svg, sheets in true millimetres with the layers of a laser cutter",
    "dxf": "pattern.dxf, the same as DXF R2010",
    "pdf": "pattern-a4.pdf and the same for other papers, pages at true scale",
    "glb": "weave.glb, the woven object",
    "guide": "guide.html, a page that shows how to put it together",
}
"""What a pattern can be written as."""


def check_formats(names: Iterable[str]) -> tuple[str, ...]:
    """Return the formats of these names, each once, in the order of `FORMATS`.

    Raises
    ------
    OutputError
        If there is no such format.

    Examples
    --------
    >>> gw.fabrication.check_formats(["PDF", "svg", "pdf"])
    ('svg', 'pdf')
    """
    return chosen(names, FORMATS, "pattern")


def write(
    pattern: Pattern,
    folder: str | PathLike[str],
    formats: Iterable[str] = tuple(FORMATS),
    *,
    bench: Bench | None = None,
    weave: WeaveLike | None = None,
    rest: Mapping[str, Any] | None = None,
) -> dict[str, Path]:
    """Write a pattern, all files together or none.

    Parameters
    ----------
    pattern : the pattern
    folder : where to; it is made if it is not there, in a folder that is
    formats : names from `FORMATS`
    bench : how it is made
    weave : the weave the pattern is of, or the contents of its ``weave.json``; needed for the GLB and the
        guide only, as a pattern does not know where its ribbons are
    rest : the contents of ``relaxed.json`` if the pattern is of the weave at rest; GLB and guide then show it

    Returns
    -------
    dict
        Path of each file by its name.

    Raises
    ------
    OutputError
        If a format is unknown, GLB or guide are asked for without a weave, or a file cannot be written there.
    FieldError
        If strips do not fit on the sheets or cannot be made as asked for, or the weave is not
        that of the pattern.

    Examples
    --------
    >>> import tempfile
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=100.0)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     list(gw.fabrication.write(gw.fabrication.pattern_of(weave), folder, ["csv", "svg"]))
    ['cutlist.csv', 'pattern.svg']

    See Also
    --------
    geoweave.fabrication.layout : one file of a weave, in the format of its ending.
    """
    if not (wanted := check_formats(formats)):
        raise OutputError(f"no format is asked for; the formats are {', '.join(FORMATS)}")
    return written_together(jobs_of(pattern, wanted, bench=bench, weave=weave, rest=rest), folder)


def jobs_of(
    pattern: Pattern,
    formats: Iterable[str],
    *,
    bench: Bench | None = None,
    weave: WeaveLike | None = None,
    rest: Mapping[str, Any] | None = None,
) -> dict[str, Job]:
    """What writes each file of a pattern; everything that may be refused is refused here.

    Parameters and errors are those of `write`, and so is the order of the files.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=100.0)
    >>> list(gw.fabrication.jobs_of(gw.fabrication.pattern_of(weave), ["csv", "pdf"]))
    ['cutlist.csv', 'pattern-a4.pdf', 'pattern-letter.pdf']
    """
    return files_of(layout_for(pattern, formats, bench=bench, weave=weave, rest=rest), formats)


def layout_for(
    pattern: Pattern,
    formats: Iterable[str],
    *,
    bench: Bench | None = None,
    weave: WeaveLike | None = None,
    rest: Mapping[str, Any] | None = None,
) -> StripLayout:
    """The layout that files of some formats are written from: one cutting of the strips for all of them.

    Parameters and errors are those of `write`.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=300.0)
    >>> pattern = gw.fabrication.pattern_of(weave)
    >>> gw.fabrication.layout_for(pattern, ["svg", "pdf"]).media
    ('sheet', 'a4', 'letter')
    """
    wanted = check_formats(formats)
    for name, what in (("glb", "GLB"), ("guide", "guide")):
        if name in wanted and weave is None:
            raise OutputError(
                f"the {what} needs the weave itself, as a pattern has no places in space; leave '{name}' out"
            )
    stands = rest if rest is not None else weave
    space = None if stands is None else weave_document(stands)
    how = bench or Bench()
    return StripLayout(pattern, how, space, media_of(wanted, how.papers))


def files_of(laid: StripLayout, formats: Iterable[str]) -> dict[str, Job]:
    """What writes each file of a layout; everything that may be refused is refused here.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=100.0)
    >>> list(gw.fabrication.files_of(gw.fabrication.layout(weave), ["svg", "dxf"]))
    ['pattern.svg', 'pattern.dxf']
    """
    jobs: dict[str, Job] = {}
    for name in check_formats(formats):
        if name == "pdf":
            for paper in laid.bench.papers:
                jobs |= laid.pdf_files(f"pattern-{paper}", paper)
        else:
            jobs |= laid.files(*_NAMES[name])
    return jobs


_NAMES = {
    "pattern": (".json", "pattern"),
    "csv": (".csv", "cutlist"),
    "svg": (".svg", "pattern"),
    "dxf": (".dxf", "pattern"),
    "glb": (".glb", "weave"),
    "guide": (".html", "guide"),
}
"""Ending and stem of the files of each format; pages have the name of their paper too."""
