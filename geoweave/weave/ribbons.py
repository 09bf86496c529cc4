"""From level sets to ribbons, the post-processing of Section 5.2.

Level sets are cut where they bend too much. Short ones and doubled ones are dropped. Open ends are extended
to a crossing. Ribbons stay `Curves`, exact on the surface. All lengths are shares of the spacing of the
ribbons, so that one set of numbers serves every model.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geoweave.arrays import Flags, Indices, frozen
from geoweave.curves import Crossings, Curves, crossings, geodesic_curvature, stretches
from geoweave.errors import FieldError
from geoweave.weave.doubled_curves import doubled
from geoweave.weave.passages import Passages, merged
from geoweave.weave.ribbon_ends import extended, holding, loose_ends, outermost, trimmed


@dataclass(frozen=True)
class Cutting:
    """The numbers of the clean-up, in units of the spacing d between neighbours of one family.

    Attributes
    ----------
    sharpest : a ribbon is cut where its geodesic curvature exceeds this, 1 / d; the sharp stretch is left out
    window : half-width of the hat that this curvature is averaged over, d. A kink of ``sharpest * window``
        radians is cut, on a coarse mesh as on a fine one
    shortest : pieces shorter than this are dropped, d
    reach : how far an open end may be extended along a geodesic to its first crossing, d
    tail : length of a ribbon beyond its last crossing, d. Two ribbons that cross again within this length
        along both of them count as touching
    shallowest : an end is held by a crossing at this angle or more, degrees
    beside : a ribbon that runs along longer ones at this distance or less, d, for more than half of its
        length doubles them and is left out

    Raises
    ------
    FieldError
        If a number is not positive, the tail is longer than the reach, or the angle is 90 degrees or more.
    """

    sharpest: float = 1.0
    window: float = 0.5
    shortest: float = 3.0
    reach: float = 2.0
    tail: float = 0.25
    shallowest: float = 30.0
    beside: float = 0.25

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value) and value > 0):
                raise FieldError(f"'{name}' of the ribbons must be a positive number, not {value}")
        if self.tail > self.reach:
            raise FieldError(f"a tail of {self.tail} is longer than the reach of {self.reach}")
        if self.shallowest >= 90:
            raise FieldError(f"crossings at {self.shallowest} degrees or more cannot be asked for")


@dataclass(frozen=True, eq=False)
class Ribbons:
    """Centrelines of ribbons on a surface, and where they cross.

    Attributes
    ----------
    curves : the centrelines
    crossings : every crossing, of two ribbons or of one with itself
    origin : (n,) level set that each ribbon was cut from
    spacing : mean distance d between neighbours of one family, a length
    cutting : the numbers they were made with
    """

    curves: Curves
    crossings: Crossings
    origin: Indices
    spacing: float
    cutting: Cutting

    @property
    def loose(self) -> Flags:
        """(n, 2) whether start and end hang loose: open, off the boundary, no crossing within a tail."""
        return loose_ends(self.curves, self.crossings, self.cutting.tail * self.spacing)

    @property
    def passages(self) -> Passages:
        """The crossings in the order in which each ribbon meets the others."""
        return Passages.on(self.curves, self.crossings)

    def __len__(self) -> int:
        return len(self.curves)


def ribbons(level_sets: Curves, families: int = 3, cutting: Cutting | None = None) -> Ribbons:
    """Make ribbons of level sets drawn on a surface (the post-processing of Section 5.2).

    Level sets are cut where the geodesic curvature is too high. Ribbons that are short or double another are
    dropped. Open ends are extended along straightest geodesics, also across punctures, to the first crossing
    and trimmed there. An end that would meet its first crossing at a shallow angle goes back to a crossing
    that holds it. Ribbons that became too short are dropped, and ends that they held are trimmed back to a
    crossing that is left.

    Parameters
    ----------
    level_sets : on the whole surface, of all families together
    families : how many families there are, for the spacing ``families A / length``, A the area
    cutting : the numbers

    Raises
    ------
    FieldError
        If there is no level set, or nothing is left.
    """
    numbers = cutting or Cutting()
    if not len(level_sets):
        raise FieldError("there is no level set to make ribbons of; ask for a larger scale")
    spacing = families * float(level_sets.mesh.face_areas.sum() / level_sets.lengths.sum())
    tail, shortest = numbers.tail * spacing, numbers.shortest * spacing
    pieces, origin = _cut(level_sets, numbers.sharpest / spacing, numbers.window * spacing, shortest)
    if not len(pieces):
        raise FieldError(f"all level sets are shorter than {shortest:.3g}; ask for a larger scale")
    single = np.flatnonzero(~doubled(pieces, numbers.beside * spacing))
    pieces, origin = stretches(pieces, single), origin[single]
    longer, spans = extended(pieces, numbers.reach * spacing)
    kept, start, end = trimmed(longer, spans, tail, numbers.shallowest)
    while True:
        kept &= longer.closed | (end - start >= shortest)
        if not kept.any():
            raise FieldError("no ribbon is left: none crosses another; ask for a larger scale")
        which = np.flatnonzero(kept)
        found = stretches(longer, which, start[which], end[which])
        met = _without_touching(crossings(found), found, tail)
        firm = met.taken(holding(met, numbers.shallowest))
        loose = loose_ends(found, firm, tail)
        if not loose.any():
            return Ribbons(found, met, frozen(origin[which]), spacing, numbers)
        # The ribbon that held these ends was itself trimmed or dropped. Trim back to the last crossing left.
        first, last = outermost(firm, len(found))
        start[which] += np.where(loose[:, 0], np.maximum(first - tail, 0.0), 0.0)
        back = np.maximum(found.lengths - last - tail, 0.0)
        end[which] -= np.where(loose[:, 1], back, 0.0)
        kept[which] = np.isfinite(first)


def _cut(curves: Curves, sharpest: float, window: float, shortest: float) -> tuple[Curves, Indices]:
    """Leave out what bends more than allowed, and pieces that are too short."""
    bends = np.abs(geodesic_curvature(curves, window)) > sharpest
    which, start, end = [], [], []
    for c in range(len(curves)):
        own = slice(int(curves.offsets[c]), int(curves.offsets[c + 1]))
        at, length, sharp = curves.arclength[own], float(curves.lengths[c]), bends[own]
        if not sharp.any():
            spans = [(0.0, length)]
        else:
            cuts = at[sharp]
            # Gaps between sharp points; round a closed curve the last gap passes its first point.
            lows = cuts if curves.closed[c] else np.concatenate([[0.0], cuts])
            highs = np.append(cuts[1:], cuts[0] + length) if curves.closed[c] else np.append(cuts, length)
            spans = list(zip(lows, highs, strict=True))
        for low, high in spans:
            if high - low >= shortest:
                which.append(c)
                start.append(low)
                end.append(high)
    chosen = np.array(which, dtype=np.int64)
    return stretches(curves, chosen, np.array(start), np.array(end)), chosen


def _without_touching(met: Crossings, curves: Curves, near: float) -> Crossings:
    """Leave out crossings at which two curves only touch.

    Where the same two curves cross several times near each other, one crossing stays if their number is odd.
    If it is even, each curve ends on the side where it began, and none stays.
    """
    joined = merged(Passages.on(curves, met), near, curves.lengths)
    odd = np.bincount(joined.group, minlength=len(joined.kept)) % 2 == 1
    return met.taken(joined.kept[odd])
