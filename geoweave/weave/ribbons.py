"""From level sets to ribbons, the post-processing of Section 5.2.

Level sets are cut where they bend too much. Short ones and doubled ones are dropped. Open ends are extended
to a crossing. What is still bare gets a ribbon, and so does a gap between two parts of the weave. Ribbons
stay `Curves`, exact on the surface. All lengths are shares of the spacing of the ribbons, so that one set of
numbers serves every model.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Flags, Indices, frozen
from geoweave.curves import Crossings, Curves, crossings, geodesic_curvature, stretches
from geoweave.errors import FieldError
from geoweave.weave.doubled_curves import doubled
from geoweave.weave.growing_ends import Growth, lengthened
from geoweave.weave.infill import Filling, Laid, bridged, filled
from geoweave.weave.passages import Passages, merged
from geoweave.weave.ribbon_ends import extended, holding, loose_ends


@dataclass(frozen=True)
class Cutting:
    """The numbers of the clean-up, in units of the spacing d between neighbours of one family.

    Attributes
    ----------
    sharpest : a ribbon is cut where its geodesic curvature exceeds this, 1 / d; the sharp stretch is left out
    window : half-width of the hat that this curvature is averaged over, d. A kink of ``sharpest * window``
        radians is cut, on a coarse mesh as on a fine one
    shortest : pieces of level sets shorter than this are dropped, d
    fewest : ribbons with fewer crossings than this are dropped; where none has so many, the largest number
        below it that leaves a ribbon takes its place
    reach : how far an open end may be extended along a geodesic to a crossing, d
    tail : length of a ribbon beyond its last crossing, d. Two ribbons that cross again within this length
        along both of them count as touching
    shallowest : an end is held by a crossing at this angle or more, degrees; between more families than
        three by one at two thirds of their angle
    beside : a ribbon that runs along longer ones at this distance or less, d, for more than half of its
        length doubles them and is left out
    bare : a place farther than this from every ribbon gets one, d
    apart : distances that such a ribbon keeps from those that it runs along, the next one where the one
        before leaves no way, d

    Raises
    ------
    FieldError
        If a number is not positive, the tail is longer than the reach, or the angle is 90 degrees or more.
    """

    sharpest: float = 1.0
    window: float = 0.5
    shortest: float = 3.0
    fewest: int = 4
    reach: float = 4.0
    tail: float = 0.25
    shallowest: float = 40.0
    beside: float = 0.25
    bare: float = 0.9
    apart: tuple[float, ...] = (0.5, 0.35)

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not (np.isfinite(value).all() and np.greater(value, 0).all()):
                raise FieldError(f"'{name}' of the ribbons must be a positive number, not {value}")
        if self.tail > self.reach:
            raise FieldError(f"a tail of {self.tail} is longer than the reach of {self.reach}")
        if self.shallowest >= 90:
            raise FieldError(f"crossings at {self.shallowest} degrees or more cannot be asked for")

    def seen_from(self, denser: float) -> Cutting:
        """The same lengths and crossings where the spacing is so many times smaller.

        By these numbers level sets that lie so many times as close are cut as wider ones are. ``beside``
        stays: which ribbons double one another is judged by the spacing that they have. ``bare`` does not
        fall: between level sets that are to stand for closer ones all would be bare.

        Examples
        --------
        >>> from geoweave.weave.ribbons import Cutting
        >>> Cutting(shortest=3.0).seen_from(2.0).shortest
        6.0
        """
        return replace(
            self,
            sharpest=self.sharpest / denser,
            window=self.window * denser,
            shortest=self.shortest * denser,
            fewest=max(1, round(self.fewest * denser)),
            reach=self.reach * denser,
            tail=self.tail * denser,
            bare=self.bare * max(denser, 1.0),
            apart=tuple(each * denser for each in self.apart),
        )


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
    dropped. Open ends grow along straightest geodesics, also across punctures, until they run into another
    ribbon, and are trimmed there (`Growth`). Ribbons with too few crossings are dropped, and the others grow
    anew without them. Bare places get ribbons of their own, and so do gaps between parts that do not hang
    together; a part that cannot be joined is dropped.

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
    shallowest = min(numbers.shallowest, 120.0 / families)
    growth = Growth.of(longer, spans, crossings(longer), shallowest)
    # A surface with room for few ribbons may have none with so many crossings.
    for fewest in range(numbers.fewest, 0, -1):
        which, found = _held(growth, tail, fewest, shallowest)
        if len(which):
            break
    else:
        raise FieldError("no ribbon is left: none crosses another; ask for a larger scale")
    numbers = replace(numbers, fewest=fewest)
    asked = Filling(families, numbers.bare, numbers.apart, numbers.fewest, shallowest, numbers.tail)
    found, along = _in_one_part(found, spacing, numbers.reach * spacing, asked)
    met = without_touching(crossings(found), found, tail)
    return Ribbons(found, met, frozen(origin[which[along]]), spacing, numbers)


def _held(growth: Growth, tail: float, fewest: int, shallowest: float) -> tuple[Indices, Curves]:
    """Grow the ends and drop ribbons with too few crossings, the worst first; those that stay, if any."""
    kept = np.ones(len(growth.longer), dtype=bool)
    while True:
        start, end = growth.grown(kept, tail)
        kept &= end > start
        which = np.flatnonzero(kept)
        if not len(which):
            return which, growth.longer
        found = stretches(growth.longer, which, start[which], end[which])
        met = without_touching(crossings(found), found, tail)
        number = np.bincount(met.curves.ravel(), minlength=len(found))
        wrong = (number < fewest) | _loose(found, met, tail, shallowest).any(axis=1)
        if not wrong.any():
            return which, found
        # Only the worst go at a time: without them the others may reach farther.
        kept[which[wrong & (number == number[wrong].min())]] = False


def _loose(curves: Curves, met: Crossings, tail: float, shallowest: float) -> Flags:
    """(n, 2) ends that no crossing at a large enough angle holds."""
    return loose_ends(curves, met.taken(holding(met, shallowest)), tail)


def _in_one_part(curves: Curves, spacing: float, reach: float, asked: Filling) -> tuple[Curves, Indices]:
    """Lay ribbons where it is bare, and join the parts of the weave on each component of the surface.

    A new ribbon joins two parts, or else an end that goes on to the other part; or else the smaller one goes.

    Returns
    -------
    the curves; and (n,) the given curve that each one is or runs along
    """
    tail, along = asked.tail * spacing, np.arange(len(curves))
    while True:
        curves, along, met = _sound(filled(curves, spacing, asked), along, tail, asked)
        part = _parts(met, len(curves))
        small = _smaller_part(curves, part)
        if not small.any():
            return curves, along
        bridge = bridged(curves, small, spacing, asked)
        if bridge is not None:
            longer, more, met = _sound(bridge, along, tail, asked)
            if _parts(met, len(longer)).max() < part.max():
                curves, along = longer, more
                continue
        stretched = lengthened(curves, small, reach, tail, asked.shallowest)
        if stretched is not None:
            met = without_touching(crossings(stretched), stretched, tail)
            if _parts(met, len(stretched)).max() < part.max():
                curves = stretched
                continue
        curves, along = stretches(curves, np.flatnonzero(~small)), along[~small]


def _sound(laid: Laid, along: Indices, tail: float, asked: Filling) -> tuple[Curves, Indices, Crossings]:
    """Drop new ribbons that turn out to have a loose end or too few crossings."""
    curves, along = laid.curves, np.concatenate([along, along[laid.along]])
    old = len(along) - len(laid.along)
    while True:
        met = without_touching(crossings(curves), curves, tail)
        wrong = np.bincount(met.curves.ravel(), minlength=len(curves)) < asked.fewest
        wrong |= _loose(curves, met, tail, asked.shallowest).any(axis=1)
        wrong[:old] = False
        if not wrong.any():
            return curves, along, met
        curves, along = stretches(curves, np.flatnonzero(~wrong)), along[~wrong]


def _parts(met: Crossings, count: int) -> Indices:
    """(n,) number of the part of each curve; those of one part hang together by crossings."""
    links = sparse.csr_array((np.ones(len(met)), tuple(met.curves.T)), shape=(count, count))
    return np.asarray(csgraph.connected_components(links, directed=False)[1])


def _smaller_part(curves: Curves, part: Indices) -> Flags:
    """(n,) the curves of a part that is not the longest on its component of the surface, if there is one."""
    component = curves.mesh.face_components[curves.faces[curves.offsets[:-1]]]
    length = np.bincount(part, curves.lengths)
    order = np.argsort(-length[part], kind="stable")
    _, first = np.unique(component[order], return_index=True)
    others = np.setdiff1d(part, part[order[first]])
    return np.isin(part, others[:1])


def expected_number(level_sets: Curves, families: int, cutting: Cutting, share: float) -> float:
    """How many ribbons to expect where level sets lie ``1 / share`` times as far apart as those given.

    A level set then stands for a share of one. All are cut by the numbers of the other spacing, and those
    that are left are counted by their share. No field is integrated anew. In a weave that is too dense, all
    is bare between any two of these level sets. They are then cut as for the densest one in which it is not.

    Parameters
    ----------
    level_sets, families, cutting : as for `ribbons`
    share : of the number of level sets, more or less than 1

    Returns
    -------
    float
        0 where nothing would be left.
    """
    densest = 2.0 * cutting.bare
    try:
        return share * len(ribbons(level_sets, families, cutting.seen_from(1.0 / min(share, densest))))
    except FieldError:
        return 0.0


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


def without_touching(met: Crossings, curves: Curves, near: float) -> Crossings:
    """Leave out crossings at which two curves only touch.

    Where the same two curves cross several times near each other, one crossing stays if their number is odd.
    If it is even, each curve ends on the side where it began, and none stays.
    """
    joined = merged(Passages.on(curves, met), near, curves.lengths)
    odd = np.bincount(joined.group, minlength=len(joined.kept)) % 2 == 1
    return met.taken(joined.kept[odd])
