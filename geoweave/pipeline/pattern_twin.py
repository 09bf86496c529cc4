"""From a ``pattern.json`` to its twin: the strips put together in simulation, and compared with the weave."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geoweave.documents import read_json
from geoweave.errors import FieldError
from geoweave.files import checked_folder
from geoweave.pipeline.source import Say, about, silent, timed
from geoweave.pipeline.verdict import other_shape, rebuilt_reasons, surface_reasons
from geoweave.pipeline.weave_folder import (
    earlier_report,
    listed_files,
    text_jobs,
    write_reported,
    write_texts,
)

if TYPE_CHECKING:
    from geoweave.fabrication import Pattern
    from geoweave.rods import Step
    from geoweave.twin import Likeness, Twin

__all__ = ["TwinOfFile", "twin_file"]

BESIDE = {"woven": "relaxed.json", "designed": "weave.json"}
"""Weaves that a twin is compared with, where they lie beside the pattern."""


SHEET = re.compile(r"(?P<stem>.*)-\d\d+")
"""The name of one of several sheets of a drawing."""


@dataclass(frozen=True, eq=False)
class TwinOfFile:
    """The twin of a pattern, and how far it is from the weaves beside it."""

    path: Path
    """Of the pattern."""
    twin: Twin
    likeness: dict[str, Likeness]
    """By "woven" (as relaxed) and "designed"; only those that lie beside the pattern."""
    genus_designed: int | None
    """Of the surface that the weave was designed on; None if no design lies beside the pattern."""
    openings_designed: int | None
    """At which ribbons of the design end; None if no design lies beside the pattern, or it does not say."""
    seconds: dict[str, float]
    files: dict[str, Path]

    @property
    def closes_as_designed(self) -> bool:
        """Whether the strips have the genus and openings of the design; true if there is none."""
        net = self.twin.surface
        return not surface_reasons(net, self.genus_designed, self.openings_designed)

    @property
    def reasons(self) -> tuple[str, ...]:
        """Why the object does not come back from its strips; nothing if it does."""
        return rebuilt_reasons(self.twin, self.target, self.genus_designed, self.openings_designed)

    @property
    def also(self) -> str:
        """What is to be said of another shape in which the strips can rest; "" if none is known."""
        return other_shape(self.twin)

    @property
    def target(self) -> Likeness | None:
        """The comparison that decides: with the weave that the strips are of.

        If no report beside the pattern says which one that is, it is the weave as relaxed, if there is one.
        """
        return next(iter(self.likeness.values()), None)

    @property
    def target_name(self) -> str | None:
        """The file of the weave that decides."""
        return next((BESIDE[what] for what in self.likeness), None)

    def document(self) -> dict[str, Any]:
        """All numbers, as ``geoweave twin --json`` prints them."""
        return {
            "pattern": str(self.path),
            "ribbons": len(self.twin.pattern.strips),
            "crossings": len(self.twin.pattern.ribbons),
            **twin_numbers(self.twin, self.likeness),
            "genus_designed": self.genus_designed,
            "openings_designed": self.openings_designed,
            "closes_as_designed": self.closes_as_designed,
            "reasons": list(self.reasons),
            "seconds": {key: round(value, 4) for key, value in self.seconds.items()},
            "files": [str(path) for path in self.files.values()],
        }


def twin_file(
    source: str | os.PathLike[str],
    folder: str | os.PathLike[str] | None = None,
    *,
    anyway: bool = False,
    callback: Say | None = None,
) -> TwinOfFile:
    """Put a pattern together in simulation, compare it with the weaves beside it, and write ``twin.json``.

    The twin is made of the strips alone; ``relaxed.json`` and ``weave.json`` are only compared with it.

    Parameters
    ----------
    source : a folder of a weave, a ``pattern.json``, or a ``pattern.svg``, on which the strips are measured
        (`geoweave.fabrication.pattern_of_svg`); one of several sheets stands for all of them. In a folder
        with both the JSON is taken
    folder : for ``twin.json``; that of the pattern if not given
    anyway : put together also a pattern that contradicts itself
    callback : called with one line of progress at a time

    Raises
    ------
    FieldError
        If there is no pattern, or it contradicts itself.
    OutputError
        If the file cannot be written.
    """
    path, say = Path(source), callback or silent
    path = _inside(path) if path.is_dir() else path
    target = checked_folder(path.parent if folder is None else folder)
    seconds: dict[str, float] = {}
    with timed(seconds, "read"):
        pattern, hoops = _read(path)
        beside = _beside(path, hoops)
    with about(str(path)):
        twin, likeness = put_together(pattern, beside, seconds, say, anyway=anyway)
    with timed(seconds, "write"):
        files = _write(path, target, twin, likeness)
    seconds["total"] = sum(seconds.values())
    genus, openings = _designed(beside.get("designed"))
    return TwinOfFile(path, twin, likeness, genus, openings, seconds, files)


def _designed(weave: Mapping[str, Any] | None) -> tuple[int | None, int | None]:
    """Genus of the surface of a design, and number of its openings at which ribbons end."""
    from geoweave.fabrication import pattern_of
    from geoweave.twin import openings_of

    if weave is None:
        return None, None
    return weave["surface"]["genus"], openings_of(pattern_of(weave))


def _beside(path: Path, hoops: float) -> dict[str, Mapping[str, Any]]:
    """The weaves that lie beside a pattern, with hoops if it has some; first the one that decides."""
    from geoweave.fabrication import hooped
    from geoweave.rods import read_weave

    found: dict[str, Mapping[str, Any]] = {
        what: read_weave(path.with_name(BESIDE[what]))
        for what in _wanted(path)
        if path.with_name(BESIDE[what]).is_file()
    }
    if not hoops or "designed" not in found:
        return found
    with about(str(path.parent)):
        both = hooped(found["designed"], found.get("woven"), hoops)
    return {what: both[BESIDE[what]] for what in found}


def _wanted(path: Path) -> list[str]:
    """What a pattern is compared with, first the weave that its strips are of: that one decides."""
    strips = earlier_report(path.parent).get("strips")
    of = strips.get("of") if isinstance(strips, dict) else None
    return sorted(BESIDE, key=lambda what: BESIDE[what] != of)


def twin_numbers(twin: Twin, likeness: Mapping[str, Likeness]) -> dict[str, Any]:
    """What is said of a twin itself, and of its distance from the weaves that it was compared with."""
    target = next(iter(likeness.values()), None)
    return {
        **twin.metrics(),
        **{what: likeness[what].document() if what in likeness else None for what in BESIDE},
        "comes_back": None if target is None else target.comes_back,
    }


def put_together(
    pattern: Pattern,
    beside: Mapping[str, Any],
    seconds: dict[str, float],
    say: Say,
    *,
    anyway: bool = False,
) -> tuple[Twin, dict[str, Likeness]]:
    """Put a pattern together, and its mirror image too where the strips do not tell them apart.

    The twin is made of the strips alone. Where it comes to rest in another shape than the weave, the strips
    are also laid where the weave is. If they keep its shape, and with less energy, that is their twin.

    Parameters
    ----------
    pattern : the strips
    beside : weaves to compare with, by "woven" (at rest) or "designed"
    seconds : the time of each stage is entered here
    say : called with one line of progress at a time
    anyway : put together also a pattern that contradicts itself
    """
    say("putting the strips together")
    twin = _twin(pattern, anyway, say)
    seconds |= twin.seconds
    with timed(seconds, "compare"):
        likeness = _compared(twin, beside)
    if likeness and not twin.side_known:
        # The strips allow two mirror images; the one that is nearer to the weave is the one that was meant.
        say("putting the mirror image together")
        image = _twin(pattern, anyway, say, mirrored=True)
        other = _compared(image, beside)
        seconds |= {key: seconds[key] + more for key, more in image.seconds.items()}
        if next(iter(other.values())).ribbons.rms < next(iter(likeness.values())).ribbons.rms:
            twin, likeness = image, other
    if likeness and not next(iter(likeness.values())).comes_back:
        return _begun_at_weave(twin, likeness, beside, seconds, say)
    return twin, likeness


def _begun_at_weave(
    twin: Twin, likeness: dict[str, Likeness], beside: Mapping[str, Any], seconds: dict[str, float], say: Say
) -> tuple[Twin, dict[str, Likeness]]:
    """Begin again where the weave is that decides; what comes back so with less energy is the object."""
    from geoweave.twin import begun_at

    what = next(iter(likeness))
    say("putting the strips together where the weave has them")
    other = begun_at(twin, beside[what], BESIDE[what])
    if other is None:
        return twin, likeness
    seconds |= other.seconds
    found = _compared(other, beside)
    return (other, found) if found[what].comes_back else (twin, likeness)


def _twin(pattern: Pattern, anyway: bool, say: Say, *, mirrored: bool = False) -> Twin:
    from geoweave.twin import assembled

    def told(step: Step) -> None:
        say(f"relaxing: step {step.number}, forces balance to {step.gradient:.1g}")

    return assembled(pattern, anyway=anyway, mirrored=mirrored, callback=told)


def _compared(twin: Twin, beside: Mapping[str, Any]) -> dict[str, Likeness]:
    """How far a twin is from each of the weaves."""
    return {what: twin.compared(document, BESIDE[what]) for what, document in beside.items()}


def _write(path: Path, folder: Path, twin: Twin, likeness: Mapping[str, Likeness]) -> dict[str, Path]:
    """Write the twin; beside its own pattern the report says of it too, and lists it."""
    said = twin_numbers(twin, likeness)
    document = twin.document(next(iter(likeness.values()), None))
    document["metrics"]["twin"] = said
    texts = {"twin.json": json.dumps(document, allow_nan=False) + "\n"}
    listed = listed_files(folder)
    if path.name in listed and folder.samefile(path.parent):
        # What the report lists, the next weave into this folder takes away.
        return write_reported(text_jobs(texts), earlier_report(folder) | {"twin": said}, folder, kept=listed)
    return write_texts(texts, folder)


def _inside(folder: Path) -> Path:
    """The file of a folder that a pattern is read from."""
    drawings = sorted(folder.glob("pattern*.svg"))
    plain = folder / "pattern.json"
    return drawings[0] if drawings and not plain.is_file() else plain


def _sheets(path: Path) -> list[Path]:
    """All sheets of a drawing."""
    found = SHEET.fullmatch(path.stem)
    if found is None:
        return [path]
    others = path.parent.glob(f"*{path.suffix}")
    of = {each: SHEET.fullmatch(each.stem) for each in others}
    return sorted(each for each, name in of.items() if name is not None and name["stem"] == found["stem"])


def _read(path: Path) -> tuple[Pattern, float]:
    """Read a pattern, and what its strips keep beyond hoops, or say in one sentence why not."""
    from geoweave.fabrication import Pattern, pattern_of_svg

    if path.suffix.lower() == ".svg":
        with about(str(path.parent)):
            drawn = pattern_of_svg(_sheets(path))
        return drawn.pattern, drawn.hoops
    document = read_json(path, FieldError, "make one with 'geoweave weave --formats pattern'")
    making = document.get("making")
    hoops = making.get("hoops", 0.0) if isinstance(making, Mapping) else 0.0
    if not (isinstance(hoops, int | float) and 0 <= hoops < math.inf):
        raise FieldError(f"{path}: its making has hoops of {hoops!r}; give 0 mm or more")
    return Pattern.from_document(document, str(path)), float(hoops)
