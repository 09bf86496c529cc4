"""The twin of a woven object: a pattern put together in simulation, from the strips alone (Section 5.4).

The twin is made of what a maker has: the lengths of the strips, where they cross and by which angle, which
lies above, and that the printed side is out. The crossings are placed on the surface that the strips close
into. The strips are laid there as rods that are naturally straight, or as curved as they are cut, and
relaxed (Appendix E). The result is compared with the weave that the pattern was exported from.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from geoweave.arrays import Indices, Scalars, Vectors, frozen
from geoweave.errors import FieldError
from geoweave.fabrication import Pattern, trimmed
from geoweave.rods import (
    FINENESS,
    Distances,
    Equilibrium,
    Rods,
    Springs,
    Step,
    Stepping,
    at_rest,
    relax_rods,
    rigid_fit,
    vertex_normals,
    vertex_weights,
)
from geoweave.surface import closest_points, segment_tree
from geoweave.twin.contradictions import (
    Contradiction,
    check_sound,
    contradiction_sentence,
    contradictions_of,
)
from geoweave.twin.laid_strips import Cut, LaidStrips, laid
from geoweave.twin.pattern_surface import PatternSurface, surface_of
from geoweave.twin.placement import has_outside, net_of, outward, placed
from geoweave.weave import WEAVE_FORMAT, WEAVE_VERSION
from geoweave.wording import counted

__all__ = ["COMES_BACK", "STEPPING", "Likeness", "Twin", "assembled"]

COMES_BACK = 0.05
"""An object has come back if no crossing is farther off than this share of the bounding diagonal."""

STEPPING = Stepping(tolerance=1e-3, most_steps=100)
"""How the twin is relaxed. Shapes are compared to a per cent, so the tolerance can be rough."""

TRYING = Stepping(tolerance=1e-2, most_steps=30)
"""How each start is relaxed at first; the one that reaches the least energy is then relaxed further."""


class Likeness(NamedTuple):
    """How far a twin is from a weave, after the best rigid fit; shares of the weave's bounding diagonal."""

    crossings: Distances
    """From each crossing to where it is in the weave."""
    ribbons: Distances
    """From each place of a ribbon to the same share of its length in the weave."""
    hausdorff: float
    """Hausdorff distance of the centrelines as sets: small where the shape is the same but ribbons slid."""
    diagonal: float
    """Of the bounding box of the weave's ribbons, mm."""
    worst: int
    """The crossing that is farthest from its place."""
    missing: int
    """Crossings of the pattern that the weave does not have."""
    rotation: Vectors
    """(3, 3); the fit is ``points @ rotation.T + shift``."""
    shift: Scalars
    """(3,) mm."""

    @property
    def comes_back(self) -> bool:
        """Whether no crossing is farther from its place than `COMES_BACK`."""
        return self.crossings.largest <= COMES_BACK

    def document(self) -> dict[str, Any]:
        """For reports."""
        return {
            "crossings": vars(self.crossings),
            "ribbons": vars(self.ribbons),
            "hausdorff": self.hausdorff,
            "diagonal": self.diagonal,
            "worst_crossing": self.worst,
            "comes_back": self.comes_back,
        }


@dataclass(frozen=True, eq=False)
class Twin:
    """A pattern put together and left to itself.

    Attributes
    ----------
    surface : the closed surface that the strips are a net of
    placed : (C, 3) where crossings were put before physics, mm
    start : strips laid there
    rest : where the rods came to rest, at bounding radius 1
    tried : energy that each start reached; the least with the printed side out was relaxed further
    seconds : wall-clock seconds of each stage
    alone : if it began where a weave is (`begun_at`), how far the rest of more energy is from that weave to
        which the strips alone lead
    """

    surface: PatternSurface
    placed: Vectors
    start: LaidStrips
    rest: Equilibrium
    tried: tuple[float, ...]
    seconds: dict[str, float]
    alone: Likeness | None = None

    @property
    def pattern(self) -> Pattern:
        """The pattern that it was made from."""
        return self.surface.pattern

    @property
    def rods(self) -> Rods:
        """At rest."""
        return self.rest.rods

    @cached_property
    def points(self) -> Vectors:
        """(V, 3) vertices at rest, mm, about the origin."""
        return frozen(self.rods.points * self.start.unit)

    @cached_property
    def crossings(self) -> Vectors:
        """(C, 3) crossings at rest, mm: half way between their two strips."""
        return frozen(self._at_crossings(self.points))

    @cached_property
    def outward(self) -> float:
        """How clearly the printed side is out, from -1 to 1; near 0 for a saddle, which has no outside."""
        return outward(self.surface, self.crossings)

    @property
    def side_known(self) -> bool:
        """Whether `outward` tells the object from its mirror image; if not, either may be woven."""
        return has_outside(self.surface, self.outward)

    @cached_property
    def contradictions(self) -> tuple[Contradiction, ...]:
        """Where the pattern contradicts itself; nothing if it is sound."""
        return contradictions_of(self.surface)

    def compared(self, document: Mapping[str, Any], name: str = "weave.json") -> Likeness:
        """Put the twin on a weave by the best rigid motion, and measure how far it is off.

        Parameters
        ----------
        document : the contents of ``weave.json`` (as designed) or ``relaxed.json`` (as woven), in mm
        name : what it is called in a refusal

        Raises
        ------
        FieldError
            If it is no weave in mm, or not the one that the pattern was exported from.
        """
        lines, known = self.lines_and_places(document, name)
        layout, rest = self.rods.layout, self.rods.rest
        before = np.cumsum(rest) - rest
        along = before - before[layout.segment_offsets[:-1]][layout.rod_of_segment]
        whole = np.add.reduceat(rest, layout.segment_offsets[:-1])
        goals = np.empty_like(self.points)
        for r, line in enumerate(lines):
            own = slice(layout.segment_offsets[r], layout.segment_offsets[r + 1])
            share = along[own] / whole[r]
            share = share if layout.closed[r] else np.append(share, 1.0)
            at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
            goals[layout.offsets[r] : layout.offsets[r + 1]] = np.column_stack(
                [np.interp(share * at[-1], at, line[:, x]) for x in range(3)]
            )
        weights = vertex_weights(self.rods)
        rotation, shift = rigid_fit(self.points, goals, weights)
        there = self.points @ rotation.T + shift
        everything = np.concatenate(lines)
        diagonal = float(np.linalg.norm(np.ptp(everything, axis=0)))
        targets = np.stack([np.concatenate([line[:-1] for line in lines]),
                            np.concatenate([line[1:] for line in lines])], axis=1)  # fmt: skip
        to = np.linalg.norm(there - closest_points(segment_tree(targets), there)[0], axis=1)
        back = closest_points(segment_tree(there[layout.ends]), everything)[0]
        fro = np.linalg.norm(everything - back, axis=1)
        found = ~np.isnan(known[:, 0])
        off = np.linalg.norm(self._at_crossings(there)[found] - known[found], axis=1)
        return Likeness(
            _sizes(off, np.ones(len(off)), diagonal),
            _sizes(np.linalg.norm(there - goals, axis=1), weights, diagonal),
            float(max(to.max(), fro.max())) / diagonal,
            diagonal,
            int(np.flatnonzero(found)[np.argmax(off)]),
            int((~found).sum()),
            frozen(rotation),
            frozen(shift),
        )

    def metrics(self) -> dict[str, Any]:
        """What the report says of the twin itself: its surface, how it rests, its strain."""
        surface, pattern = self.surface, self.pattern
        strain = self.rods.lengths / self.rods.rest - 1.0
        most = int(np.abs(strain).argmax())
        bow = max(range(len(pattern.strips)), key=lambda r: pattern.strips[r].bow)
        return {
            "topology": {
                "crossings": len(pattern.ribbons),
                "stretches": len(surface.edges),
                "faces": len(surface.faces),
                "euler_characteristic": surface.euler_characteristic,
                "genus": surface.genus,
                "openings": surface.openings,
                "contradictions": [contradiction_sentence(pattern, each) for each in self.contradictions],
            },
            "alone": None if self.alone is None else self.alone.document(),
            "outward": self.outward,
            "side_known": self.side_known,
            "converged": self.rest.converged,
            "ending": self.rest.ending,
            "steps": len(self.rest.steps) - 1,
            "energy": self.rest.steps[-1].energy,
            "energies": self.rest.energies,
            "energies_tried": list(self.tried),
            "strain": {
                "largest": float(strain[most]),
                "ribbon": pattern.strips[int(self.rods.layout.rod_of_segment[most])].label,
            },
            "bow": {"largest": pattern.strips[bow].bow, "ribbon": pattern.strips[bow].label},
        }

    def document(self, on: Likeness | None = None) -> dict[str, Any]:
        """The contents of ``twin.json``, of the form of ``relaxed.json``; put on a weave if given."""
        pattern, surface = self.pattern, self.surface
        rotation, shift = (np.eye(3), np.zeros(3)) if on is None else (on.rotation, on.shift)
        families = max(strip.family for strip in pattern.strips) + 1
        blank = {
            "format": WEAVE_FORMAT,
            "version": WEAVE_VERSION,
            "units": "mm",
            "symmetry": 2 * families,
            "width": pattern.width,
            "thickness": pattern.thickness,
            "surface": {
                "genus": surface.genus,
                "boundary_loops": surface.openings or 0,
                "euler_characteristic": surface.euler_characteristic,
            },
            "ribbons": [
                {"id": r, "label": strip.label, "family": strip.family, "closed": strip.closed}
                for r, strip in enumerate(pattern.strips)
            ],
            "crossings": [
                {"ribbons": ribbons, "arclength": at}
                for ribbons, at in zip(pattern.ribbons.tolist(), pattern.at.tolist(), strict=True)
            ],
            "metrics": {
                "ribbons": len(pattern.strips),
                "crossings": len(pattern.ribbons),
                "total_length": sum(strip.length for strip in pattern.strips),
                # so that rods made of this file have segments as long as the twin's
                "spacing": float(self.rods.rest.mean() * self.start.unit) / FINENESS,
                "twin": self.metrics(),
            },
        }
        points = self.points @ rotation.T + shift
        normals = vertex_normals(self.rods) @ rotation.T
        return at_rest(blank, self.rods, points, normals, self.start.unit)

    def _at_crossings(self, points: Vectors) -> Vectors:
        """(C, 3) places between the two strips of each crossing, for vertices anywhere."""
        return _at_crossings(self.rods, self.start.cut, points)

    def lines_and_places(self, document: Mapping[str, Any], name: str) -> tuple[list[Vectors], Vectors]:
        """Centrelines of a weave, closed ones with the first point again, and (C, 3) its crossings or nan."""
        pattern = self.pattern
        if document.get("units") != "mm":
            raise FieldError(f"{name}: is not in mm, as patterns are; write it again with --size")
        try:
            document = trimmed(document, [strip.trimmed for strip in pattern.strips])
            labels = [str(each["label"]) for each in document["ribbons"]]
            lines = []
            for each in document["ribbons"]:
                line = np.array(each["points"], dtype=np.float64).reshape(-1, 3)
                lines.append(np.concatenate([line, line[:1]]) if each["closed"] else line)
            met = document["crossings"]
            pairs = np.array([each["ribbons"] for each in met], dtype=np.int64).reshape(-1, 2)
            at = np.array([each["arclength"] for each in met], dtype=np.float64).reshape(-1, 2)
            places = np.array([each["point"] for each in met], dtype=np.float64).reshape(-1, 3)
        except (KeyError, TypeError, ValueError) as error:
            raise FieldError(f"{name}: an entry of the weave is missing or wrong ({error!r})") from error
        if labels != [strip.label for strip in pattern.strips]:
            raise FieldError(
                f"{name}: has {counted(len(labels), 'ribbon')} where the pattern has {len(pattern.strips)}, "
                "or other names; give the weave that the pattern was exported from"
            )
        return lines, _matched(pattern, pairs, at, places)


def assembled(
    pattern: Pattern,
    *,
    anyway: bool = False,
    mirrored: bool = False,
    springs: Springs | None = None,
    stepping: Stepping | None = None,
    callback: Callable[[Step], None] | None = None,
) -> Twin:
    """Put a pattern together in simulation, from the strips alone, and let it come to rest.

    Parameters
    ----------
    pattern : flat strips and their crossings; no coordinate in space goes in
    anyway : put the pattern together even if it contradicts itself
    mirrored : begin with the mirror image. An object with an outside comes out the same; one without comes
        out mirrored (`Twin.side_known`)
    springs : stiffnesses of the contacts
    stepping : numbers of the relaxation; `STEPPING` if not given
    callback : called with every `Step` of it

    Raises
    ------
    FieldError
        If strips do not cross, fall into pieces, or a crossing contradicts those about it.
    RodError
        If a strip cannot be a rod.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.sphere(600), ribbons=16).sized(200.0)
    >>> twin = gw.twin.assembled(gw.fabrication.pattern_of(weave))
    >>> twin.compared(weave.document()).comes_back
    True
    """
    clock = time.perf_counter()
    surface = surface_of(pattern)
    check_sound(surface, anyway=anyway)
    points = placed(surface, net_of(surface), mirrored=mirrored)
    # Energies of different starts compare at one unit.
    unit = laid(surface, points[-1]).unit
    starts = [laid(surface, each, unit) for each in points]
    between = time.perf_counter()
    tries = [relax_rods(start.rods, springs=springs, stepping=TRYING, callback=callback) for start in starts]
    energies = tuple(each.steps[-1].energy for each in tries)
    best = _least(surface, starts, tries)
    rest = relax_rods(tries[best].rods, springs=springs, stepping=stepping or STEPPING, callback=callback)
    seconds = {"start": between - clock, "relax": time.perf_counter() - between}
    return Twin(surface, frozen(points[best]), starts[best], rest, energies, seconds)


def _least(surface: PatternSurface, starts: Sequence[LaidStrips], tries: Sequence[Equilibrium]) -> int:
    """Number of the try that reached the least energy.

    A bowl may snap through while it is relaxed, and rests inside out with the same energy. Of a shape with an
    outside those tries count that have the printed side out, if any has.
    """
    sides = [
        outward(surface, _at_crossings(each.rods, start.cut, each.rods.points))
        for start, each in zip(starts, tries, strict=True)
    ]
    inside_out = [has_outside(surface, side) and side < 0 for side in sides]
    return min(range(len(tries)), key=lambda k: (inside_out[k], tries[k].steps[-1].energy))


def _at_crossings(rods: Rods, cut: Cut, points: Vectors) -> Vectors:
    """(C, 3) places between the two strips of each crossing, for vertices anywhere."""
    ends, share = rods.layout.ends[cut.segments], cut.places[..., None]
    both = points[ends[..., 0]] * (1.0 - share) + points[ends[..., 1]] * share
    return np.asarray(both.mean(axis=1))


def _matched(pattern: Pattern, pairs: Indices, at: Scalars, places: Vectors) -> Vectors:
    """(C, 3) where the crossings of a pattern are in a weave: by number, or the nearest of both ribbons."""
    if np.array_equal(np.sort(pairs, axis=1), np.sort(pattern.ribbons, axis=1)):
        return places
    # Near-duplicates were merged on the way from the one to the other, so numbers have moved.
    of_pair: dict[tuple[int, int], list[int]] = {}
    for x, (one, other) in enumerate(pairs.tolist()):
        of_pair.setdefault((one, other), []).append(x)
    found = np.full((len(pattern.ribbons), 3), np.nan)
    for x, (one, other) in enumerate(pattern.ribbons.tolist()):
        if among := of_pair.get((one, other)):
            far = np.abs(at[among] - pattern.at[x]).sum(axis=1)
            found[x] = places[among[int(np.argmin(far))]]
    return found


def _sizes(values: Scalars, weights: Scalars, diagonal: float) -> Distances:
    return Distances(
        float(np.average(values, weights=weights)) / diagonal,
        float(np.sqrt(np.average(values**2, weights=weights))) / diagonal,
        float(values.max()) / diagonal,
    )
