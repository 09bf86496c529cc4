"""The pattern that a maker works from: flat strips and what is marked on them (Section 5.4).

A ribbon that follows a geodesic is straight when it is laid flat, so a strip is a length, a width and the
places of its crossings. It may also be cut curved (`Strip.curvature`). A strip is seen from the side that the
normals of the surface point to, its first end to the left; angles and curvatures turn to the left.
``pattern.json`` holds no coordinate in space.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from geoweave import documents
from geoweave.arrays import Indices, Scalars, frozen
from geoweave.errors import FieldError
from geoweave.fabrication.crossing_order import Reordered
from geoweave.fabrication.marks import MARKS
from geoweave.weave import FlatCurve, check_curvature

__all__ = ["FORMAT", "VERSION", "Passage", "Pattern", "Strip", "openings_said"]

FORMAT, VERSION = "geoweave-pattern", 1
"""What the first lines of ``pattern.json`` say."""


SHAPE = documents.entries(
    {"floating": documents.flag()},
    width=documents.number(above=0),
    thickness=documents.number(above=0),
    strips=documents.each(
        documents.entries(
            {
                "curvature": documents.each(documents.each(documents.number(), 2)),
                "hoop": documents.flag(),
                "openings": documents.each(documents.whole(-1), 2),
            },
            label=documents.text(),
            family=documents.whole(most=1_000_000),
            closed=documents.flag(),
            length=documents.number(above=0),
            bow=documents.number(),
            turning_deg=documents.number(),
        )
    ),
    crossings=documents.each(
        documents.entries(
            strips=documents.each(documents.whole(), 2),
            at=documents.each(documents.number(), 2),
            angle_deg=documents.number(),
            over=documents.whole(0, 1),
            mark=documents.text(*MARKS),
            round=documents.whole(),
        )
    ),
)
"""What is read of a ``pattern.json``."""


class Strip(NamedTuple):
    """One ribbon, laid flat."""

    label: str
    """Its name: family and number."""
    family: int
    """From 0."""
    closed: bool
    """Whether its ends are joined."""
    length: float
    """Of the centreline, mm; once round for a closed one."""
    bow: float
    """How far its centreline, laid flat with its geodesic curvature, leaves the straight strip, mm."""
    turning: float
    """By how much its direction, laid flat so, varies along it, degrees."""
    trimmed: tuple[float, float] = (0.0, 0.0)
    """What was cut away of the ribbon before its first end and after its last one, mm."""
    curvature: tuple[tuple[float, float], ...] = ()
    """Places along it, mm, and the curvature with which it is cut there, 1/mm, left is positive; linear in
    between. Nothing for a straight strip."""
    openings: tuple[int, int] | None = None
    """Opening of the object, from 0, at which its first and its last end lie, -1 for an end elsewhere; None
    if it is not said, as in files of earlier versions."""
    hoop: bool = False
    """Whether it is the hoop of an opening, no ribbon of the weave."""

    @property
    def curve(self) -> FlatCurve | None:
        """Its centreline on the sheet; None for a straight strip."""
        return FlatCurve(self.curvature, self.length, self.closed) if self.curvature else None


class Passage(NamedTuple):
    """A crossing as one strip sees it."""

    crossing: int
    """The crossing, from 0."""
    side: int
    """0 or 1: which of the two strips of the crossing this one is."""
    at: float
    """Where on the strip, mm from its first end."""
    partner: int
    """The other strip; the same one where a strip crosses itself."""
    over: bool
    """Whether this strip lies above."""
    angle: float
    """From the direction of this strip to that of the partner, degrees in (-180, 180], left is positive."""
    mark: int
    """Index into `MARKS`."""
    label: str
    """What is written beside the mark: name of the partner, and the round if there is more than one."""


@dataclass(frozen=True, eq=False)
class Pattern:
    """Flat strips and their crossings, in mm.

    Attributes
    ----------
    strips : the ribbons
    width, thickness : of a ribbon, mm
    ribbons : (C, 2) the two strips of each crossing
    at : (C, 2) where on each of them, mm from its first end
    angle : (C,) from the direction of the first strip to that of the second, degrees in (-180, 180]
    over : (C,) which of the two lies above, 0 or 1
    mark : (C,) index into `MARKS`
    round : (C,) 0 unless the two strips cross more often than there are marks
    reordered : where crossings follow each other in another order than in the design; nobody could weave such
        strips as they were designed, so they are not written, and their file does not say it
    floating : whether strips are meant to pass over two others in a row, as in a twill and a basket

    Raises
    ------
    FieldError
        If a crossing names a strip that is not there, lies beyond its end, or two crossings of the same two
        strips have the same mark.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=6).sized(size=100.0)
    >>> pattern = gw.fabrication.pattern_of(weave)
    >>> places = [each.at for each in pattern.passages[0]]  # mm from the first end of the first strip
    >>> places == sorted(places) and 0 <= places[0] <= places[-1] <= pattern.strips[0].length
    True
    >>> again = gw.fabrication.Pattern.from_document(pattern.document())
    >>> again.document() == pattern.document()
    True
    """

    strips: tuple[Strip, ...]
    width: float
    thickness: float
    ribbons: Indices
    at: NDArray[np.float64]
    angle: Scalars
    over: Indices
    mark: Indices
    round: Indices
    reordered: tuple[Reordered, ...] = ()
    floating: bool = False

    def __post_init__(self) -> None:
        for name in ("width", "thickness"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise FieldError(f"the {name} of the strips must be a positive number of mm, not {value}")
        for field in fields(self):
            if isinstance(value := getattr(self, field.name), np.ndarray):
                frozen(value)
        if self.ribbons.shape != self.at.shape or self.ribbons.shape != (len(self.angle), 2):
            raise FieldError(
                f"crossings are (C, 2) strips and (C, 2) places, not {self.ribbons.shape} and {self.at.shape}"
            )
        if len(self.ribbons) and not 0 <= self.ribbons.min() <= self.ribbons.max() < len(self.strips):
            raise FieldError(f"a crossing names a strip that is not one of the {len(self.strips)}")
        lengths = np.array([strip.length for strip in self.strips])
        outside = (self.at < -1e-6) | (self.at > lengths[self.ribbons] + 1e-6) | ~np.isfinite(self.at)
        if outside.any():
            x, side = (int(each) for each in np.argwhere(outside)[0])
            strip = self.strips[self.ribbons[x, side]]
            raise FieldError(
                f"crossing {x} is {self.at[x, side]:.6g} mm along {strip.label}, "
                f"which is {strip.length:.6g} mm long"
            )
        for strip in self.strips:
            try:
                check_curvature(strip.curvature, self.width, f"the curvature of strip {strip.label}")
            except ValueError as error:
                raise FieldError(f"{error}; cut it less curved or narrower") from error
        keys = np.column_stack([np.sort(self.ribbons, axis=1), self.mark, self.round])
        if len(np.unique(keys, axis=0)) < len(keys):
            raise FieldError("two crossings of the same two strips have the same mark")

    @cached_property
    def passages(self) -> tuple[tuple[Passage, ...], ...]:
        """Crossings of each strip in the order in which they come on it."""
        found: list[list[Passage]] = [[] for _ in self.strips]
        for flat in np.lexsort((self.at.ravel(), self.ribbons.ravel())).tolist():
            x, side = divmod(flat, 2)
            partner = int(self.ribbons[x, 1 - side])
            again = f"/{self.round[x] + 1}" if self.round[x] else ""
            found[self.ribbons[x, side]].append(
                Passage(
                    x,
                    side,
                    float(self.at[x, side]),
                    partner,
                    bool(self.over[x] == side),
                    _within(-float(self.angle[x]) if side else float(self.angle[x])),
                    int(self.mark[x]),
                    self.strips[partner].label + again,
                )
            )
        return tuple(tuple(each) for each in found)

    def document(self) -> dict[str, Any]:
        """The contents of ``pattern.json``; lengths to a tenth of a micrometre, angles to 1e-4 degrees."""
        return {
            "format": FORMAT,
            "version": VERSION,
            "units": "mm",
            "width": round(self.width, 4),
            "thickness": round(self.thickness, 4),
            "marks": list(MARKS),
            **({"floating": True} if self.floating else {}),
            "strips": [
                {
                    "id": r,
                    "label": strip.label,
                    "family": strip.family,
                    "closed": strip.closed,
                    "length": round(strip.length, 4),
                    "bow": round(strip.bow, 4),
                    "turning_deg": round(strip.turning, 4),
                    "trimmed": [round(each, 4) for each in strip.trimmed],
                    **({"curvature": _rounded(strip.curvature)} if strip.curvature else {}),
                    **({} if strip.openings is None else {"openings": list(strip.openings)}),
                    **({"hoop": True} if strip.hoop else {}),
                    "crossings": [
                        {
                            "crossing": each.crossing,
                            "side": each.side,
                            "at": round(each.at, 4),
                            "partner": each.partner,
                            "label": each.label,
                            "mark": MARKS[each.mark],
                            "over": each.over,
                            "angle_deg": round(each.angle, 4),
                        }
                        for each in self.passages[r]
                    ],
                }
                for r, strip in enumerate(self.strips)
            ],
            "crossings": [
                {
                    "id": x,
                    "strips": self.ribbons[x].tolist(),
                    "at": [round(each, 4) for each in self.at[x].tolist()],
                    "angle_deg": round(float(self.angle[x]), 4),
                    "over": int(self.over[x]),
                    "mark": MARKS[self.mark[x]],
                    "round": int(self.round[x]),
                }
                for x in range(len(self.ribbons))
            ],
        }

    @classmethod
    def from_document(cls, document: Mapping[str, Any], name: str = "pattern.json") -> Pattern:
        """Read what `document` wrote.

        Raises
        ------
        FieldError
            If it is no pattern, or holds something that no pattern has.
        """
        if document.get("format") != FORMAT or document.get("version") != VERSION:
            raise FieldError(f"{name}: is not a {FORMAT} of version {VERSION}; write it anew")
        try:
            SHAPE(document, "")
            strips = tuple(
                Strip(
                    str(each["label"]),
                    int(each["family"]),
                    bool(each["closed"]),
                    float(each["length"]),
                    float(each["bow"]),
                    float(each["turning_deg"]),
                    _two(each.get("trimmed", (0.0, 0.0))),
                    tuple(_two(pair) for pair in each.get("curvature", ())),
                    openings_said(each),
                    bool(each.get("hoop", False)),
                )
                for each in document["strips"]
            )
            met = document["crossings"]
            return cls(
                strips,
                float(document["width"]),
                float(document["thickness"]),
                np.array([each["strips"] for each in met], dtype=np.int64).reshape(-1, 2),
                np.array([each["at"] for each in met], dtype=np.float64).reshape(-1, 2),
                np.array([each["angle_deg"] for each in met], dtype=np.float64),
                np.array([each["over"] for each in met], dtype=np.int64),
                np.array([MARKS.index(each["mark"]) for each in met], dtype=np.int64),
                np.array([each["round"] for each in met], dtype=np.int64),
                floating=bool(document.get("floating", False)),
            )
        except (KeyError, TypeError, ValueError, FieldError) as error:
            raise FieldError(f"{name}: an entry of the pattern is missing or wrong ({error})") from error


def _rounded(knots: Sequence[tuple[float, float]]) -> list[list[float]]:
    """Places to a tenth of a micrometre, curvatures to what turns a metre by a micrometre."""
    return [[round(at, 4), round(bend, 9)] for at, bend in knots]


def openings_said(strip: Mapping[str, Any]) -> tuple[int, int] | None:
    """Openings at which the ends of a strip, or of a ribbon, lie, if its file says so."""
    if "openings" not in strip:
        return None
    one, other = strip["openings"]
    return int(one), int(other)


def _two(values: Sequence[float]) -> tuple[float, float]:
    """Two numbers, as a tuple."""
    one, other = values
    return float(one), float(other)


def _within(degrees: float) -> float:
    """The same angle in (-180, 180]."""
    return 180.0 - (180.0 - degrees) % 360.0
