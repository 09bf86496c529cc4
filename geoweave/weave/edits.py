"""Changes that a person makes to a weave: ribbons dropped, crossings flipped, branch points, a direction.

Section 5.2 leaves nothing to choose by hand. The file ``edits.json`` of the viewer does.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from geoweave import documents
from geoweave.arrays import Indices, frozen
from geoweave.curves import Crossings, Curves
from geoweave.documents import read_json
from geoweave.errors import FieldError
from geoweave.surface import connected_components
from geoweave.weave.interlacing import EFFORT, Interlacing, judged, optimal
from geoweave.weave.passages import Passages
from geoweave.weave.ribbons import Ribbons
from geoweave.weave.steering import Point, Singularity, Steering
from geoweave.weave.weave import Units, Weave

__all__ = ["EDITS_FORMAT", "Edits", "Flip", "design_key", "edited", "read_edits"]

EDITS_FORMAT, VERSION = "geoweave-edits", 1
"""What the first lines of ``edits.json`` say."""

AGAIN = "save it again from the page of 'geoweave show'"
"""What to do about a file with a slip in it."""

_POINT = documents.each(documents.number(), 3)

_EDITS = documents.entries(
    format=documents.text(EDITS_FORMAT),
    version=documents.whole(VERSION, VERSION),
    key=documents.text(),
    units=documents.text("mesh", "mm"),
    drop=documents.each(documents.text()),
    flip=documents.each(
        documents.entries(
            crossing=documents.whole(),
            ribbons=documents.each(documents.text(), 2),
            over=documents.whole(0, 1),
        )
    ),
)


class Flip(NamedTuple):
    """A crossing at which the other ribbon is to lie above."""

    crossing: int
    """Its number in ``weave.json``."""
    ribbons: tuple[str, str]
    """Names of its two ribbons."""
    over: int
    """Which of the two is to lie above, 0 or 1."""


@dataclass(frozen=True)
class Edits:
    """What a person changed of a weave; the contents of ``edits.json``.

    Attributes
    ----------
    key : of the weave that the changes are of (`design_key`)
    units : of the points
    drop : names of ribbons that are left out
    flip : crossings at which over and under change
    singularities : all of the RoSy, some of them moved; None leaves them free
    align : a direction or points of a curve that one family follows; None for neither
    """

    key: str
    units: Units = "mesh"
    drop: tuple[str, ...] = ()
    flip: tuple[Flip, ...] = ()
    singularities: tuple[Singularity, ...] | None = None
    align: tuple[Point, ...] | None = None

    def __post_init__(self) -> None:
        """Refuse changes that contradict each other."""
        if self.steers and self.changes:
            raise FieldError(
                "edits that move branch points or give a direction make a new weave, in which the ribbons to "
                "drop and the crossings to flip are not known; apply the two kinds one after the other"
            )

    @property
    def steers(self) -> bool:
        """Whether the weave is to be designed anew."""
        return self.singularities is not None or self.align is not None

    @property
    def changes(self) -> bool:
        """Whether ribbons or crossings of the design change."""
        return bool(self.drop or self.flip)

    def steering(self, before: Steering, unit: float) -> Steering:
        """What is asked of the RoSy, in the coordinates of the mesh.

        Parameters
        ----------
        before : what was asked of it without these changes
        unit : length of the unit of the points in that of the mesh
        """
        asked = before
        if self.singularities is not None:
            moved = tuple(each._replace(position=_scaled(each.position, unit)) for each in self.singularities)
            asked = replace(asked, singularities=moved, merge=0.0)
        if self.align is not None:
            asked = replace(asked, align=tuple(_scaled(each, unit) for each in self.align))
        return asked

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> Edits:
        """Read the contents of ``edits.json``.

        Raises
        ------
        FieldError
            If an entry is missing or is not what it should be.
        """
        singular, align = document.get("singularities"), document.get("align")
        try:
            _EDITS(document, "")
            if singular is not None:
                documents.each(documents.entries(point=_POINT, index=documents.whole(-1000, 1000)))(
                    singular, "singularities"
                )
            if align is not None:
                documents.points()(align, "align")
        except ValueError as error:
            raise FieldError(f"{error}; {AGAIN}") from error
        return cls(
            document["key"],
            document["units"],
            tuple(document["drop"]),
            tuple(
                Flip(each["crossing"], (each["ribbons"][0], each["ribbons"][1]), each["over"])
                for each in document["flip"]
            ),
            None
            if singular is None
            else tuple(Singularity(_point(each["point"]), each["index"]) for each in singular),
            None if align is None else tuple(_point(each) for each in align),
        )

    def document(self) -> dict[str, Any]:
        """The contents of ``edits.json``."""
        return {
            "format": EDITS_FORMAT,
            "version": VERSION,
            "key": self.key,
            "units": self.units,
            "drop": list(self.drop),
            "flip": [
                {"crossing": each.crossing, "ribbons": list(each.ribbons), "over": each.over}
                for each in self.flip
            ],
            "singularities": None
            if self.singularities is None
            else [{"point": list(each.position), "index": each.numerator} for each in self.singularities],
            "align": None if self.align is None else [list(each) for each in self.align],
        }


def read_edits(path: str | PathLike[str]) -> Edits:
    """Read ``edits.json``.

    Raises
    ------
    FieldError
        If the file cannot be read, or holds no edits; the text names the file and the entry.

    Examples
    --------
    >>> gw.weave.read_edits("no such.json")
    Traceback (most recent call last):
    ...
    geoweave.errors.FieldError: no such.json: cannot be read (No such file or directory); ...
    """
    name = Path(path).name
    document = read_json(path, FieldError, AGAIN)
    if document.get("format") != EDITS_FORMAT:
        raise FieldError(f"{name}: holds no edits; {AGAIN}")
    try:
        return Edits.of(document)
    except FieldError as error:
        raise FieldError(f"{name}: {error}") from error


def design_key(document: Mapping[str, Any]) -> str:
    """Sixteen letters that tell designs apart: names of ribbons, and which of them cross in which order.

    Lengths do not enter, so that a weave has the same key at any size and width.

    Parameters
    ----------
    document : the contents of ``weave.json``
    """
    said = [
        [each["label"] for each in document["ribbons"]],
        [[*each["ribbons"], each["over_index"]] for each in document["crossings"]],
    ]
    text = json.dumps(said, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def edited(weave: Weave, edits: Edits, effort: int = EFFORT) -> Weave:
    """Leave ribbons out of a weave and change sides at crossings.

    Without a ribbon others no longer alternate where it was, so over and under are chosen anew then
    (`geoweave.weave.interlacing.optimal`), as near to what they were as can be; of a part of the weave the
    opposite choice is as good. What is flipped is flipped last, and stays so. Ribbons keep their names.

    Parameters
    ----------
    weave : the weave that the changes are of
    edits : the changes; those that ask for another design are passed over
    effort : as for `weave_pattern`

    Raises
    ------
    FieldError
        If the changes are of another weave, or leave no crossing.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)
    >>> key = gw.weave.design_key(weave.document())
    >>> less = gw.weave.edited(weave, gw.weave.Edits(key, drop=(weave.names[0],)))
    >>> less.names == weave.names[1:]
    True
    """
    if design_key(weave.document()) != edits.key:
        raise FieldError(
            "the edits are of another weave than this one; open its page with 'geoweave show' and edit there"
        )
    names = weave.names
    unknown = [name for name in edits.drop if name not in names]
    for each in edits.flip:
        if each.crossing >= len(weave.passages):
            raise FieldError(f"there is no crossing {each.crossing} to flip; {AGAIN}")
        unknown += [name for name in each.ribbons if name not in names]
    if unknown:
        raise FieldError(f"there is no ribbon {unknown[0]} in this weave; {AGAIN}")
    over = weave.interlacing.over.copy()
    for each in edits.flip:
        over[each.crossing] = each.over
    stays = np.array([name not in edits.drop for name in names])
    if stays.all():
        found = judged(weave.passages, over, weave.interlacing.pattern)
        return replace(weave, interlacing=replace(found, bound=weave.interlacing.bound))
    ribbons, kept = _without(weave.ribbons, stays)
    chosen = _nearest(ribbons.passages, weave.interlacing, kept, effort)
    flipped = np.isin(kept, [each.crossing for each in edits.flip])
    if flipped.any():
        found = judged(ribbons.passages, np.where(flipped, over[kept], chosen.over), chosen.pattern)
        chosen = replace(found, bound=chosen.bound)
    return replace(
        weave,
        ribbons=ribbons,
        families=frozen(weave.families[stays]),
        interlacing=chosen,
        kept_names=tuple(name for name, stay in zip(names, stays, strict=True) if stay),
    )


def _without(ribbons: Ribbons, stays: Indices) -> tuple[Ribbons, Indices]:
    """Some of the ribbons with their crossings, and which crossings those are."""
    curves, met = ribbons.curves, ribbons.crossings
    kept = np.flatnonzero(stays[met.curves].all(axis=1))
    if not len(kept):
        raise FieldError("without these ribbons no crossing is left; drop fewer")
    number = np.cumsum(stays) - 1
    lengths = np.diff(curves.offsets)
    before = np.concatenate([[0], np.cumsum(np.where(stays, lengths, 0))])
    shift = curves.offsets[:-1] - before[:-1]
    left = Curves.concatenate(curves.mesh, [curves[r] for r in np.flatnonzero(stays).tolist()])
    some = met.taken(kept)
    crossings = Crossings(
        number[some.curves],
        some.segments - shift[some.curves],
        some.arclength,
        some.points,
        some.faces,
        some.angle,
    )
    return replace(ribbons, curves=left, crossings=crossings, origin=frozen(ribbons.origin[stays])), kept


def _nearest(passages: Passages, given: Interlacing, kept: Indices, effort: int) -> Interlacing:
    """The best over and under, and of choices that are as good the one that changes fewer crossings.

    Sides of all crossings of a part that hangs together can be changed at once: no relation notices.
    """
    best, before = optimal(passages, effort, given.pattern), given.over[kept]
    relations = passages.relations
    part = connected_components(np.stack([relations.first, relations.second], axis=1), len(passages))
    turned = 2 * np.bincount(part, best.over != before) > np.bincount(part)
    return replace(best, over=frozen(np.where(turned[part], 1 - best.over, best.over)))


def _scaled(point: Point, unit: float) -> Point:
    return (point[0] * unit, point[1] * unit, point[2] * unit)


def _point(values: list[float]) -> Point:
    return (float(values[0]), float(values[1]), float(values[2]))
