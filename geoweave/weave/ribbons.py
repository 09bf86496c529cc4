"""From level sets to ribbons: cut where they bend, drop the short and the doubled, extend to a crossing.

The post-processing of Section 5.2.
Ribbons stay `Curves`, exact on the surface. All lengths are shares of the spacing of the ribbons, so that
one set of numbers serves every model.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from geoweave.arrays import Flags, Indices, Scalars, Vectors, frozen
from geoweave.curves import Crossings, Curves, crossings, geodesic_curvature, straightest, taken
from geoweave.errors import FieldError
from geoweave.weave import interlacing

PARALLEL = np.cos(np.radians(20.0))
"""Cosine of the angle up to which two curves run along each other."""


@dataclass(frozen=True)
class Cutting:
    """The numbers of the clean-up, in units of the spacing d between neighbours of one family.

    Attributes
    ----------
    sharpest : a ribbon is cut where its geodesic curvature exceeds this, 1 / d; the sharp stretch is left out
    window : half-width of the hat that this curvature is taken over, d: a kink by ``sharpest * window``
        radians is cut, on a coarse mesh and on a fine one
    shortest : pieces shorter than this are dropped, d
    reach : how far an open end may be extended along a geodesic to its first crossing, d
    tail : what is left of a ribbon beyond its last crossing, d; two ribbons that cross again within it on
        both of them touch
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
        return _loose(self.curves, self.crossings, self.cutting.tail * self.spacing)

    def __len__(self) -> int:
        return len(self.curves)


def ribbons(level_sets: Curves, families: int = 3, cutting: Cutting | None = None) -> Ribbons:
    """Make ribbons of level sets drawn on a surface (the post-processing of Section 5.2).

    Cut where the geodesic curvature is too high, drop what is short or doubles another, extend open ends
    along straightest geodesics, also across punctures, to the first crossing, and trim them there; an end
    that would meet its first crossing at a shallow angle goes back to one that holds it. Ribbons that became
    too short are dropped, and ends that they held are trimmed back to a crossing that is left.

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
    longer, spans = _extended(pieces, numbers.reach * spacing)
    kept, start, end = _trimmed(longer, spans, tail, numbers.shallowest)
    while True:
        kept &= longer.closed | (end - start >= shortest)
        if not kept.any():
            raise FieldError("no ribbon is left: none crosses another; ask for a larger scale")
        which = np.flatnonzero(kept)
        found = stretches(longer, which, start[which], end[which])
        met = _without_touching(crossings(found), found, tail)
        holding = taken(met, _at_least(met, numbers.shallowest))
        loose = _loose(found, holding, tail)
        if not loose.any():
            return Ribbons(found, met, frozen(origin[which]), spacing, numbers)
        # What held these ends was itself trimmed or dropped: back to the last crossing that is left.
        first, last = _outermost(holding, len(found))
        start[which] += np.where(loose[:, 0], np.maximum(first - tail, 0.0), 0.0)
        back = np.maximum(found.lengths - last - tail, 0.0)
        end[which] -= np.where(loose[:, 1], back, 0.0)
        kept[which] = np.isfinite(first)


def doubled(curves: Curves, near: float) -> Flags:
    """(n,) curves that run along longer ones which stay: nearly parallel and near for over half their length.

    Two families may turn into one on a wall of the field, and their level sets come to lie on each other.

    Parameters
    ----------
    curves : the curves
    near : distance in space, between points with nearly one normal; a length
    """
    step = 0.5 * near
    sizes = np.maximum(np.ceil(curves.lengths / step).astype(np.int64), 1)
    owner = np.repeat(np.arange(len(curves)), sizes)
    number = np.arange(len(owner)) - (np.cumsum(sizes) - sizes)[owner]
    along = (number + 0.5) / sizes[owner] * curves.lengths[owner]
    # One axis for all curves: each begins where the one before it ends.
    begin = np.cumsum(curves.lengths) - curves.lengths
    segment = (
        np.searchsorted(begin[curves.curve_of_point] + curves.arclength, begin[owner] + along, "right") - 1
    )
    length = np.maximum(curves.segment_lengths[segment], 1e-300)[:, None]
    heading = curves.segments[segment] / length
    points = curves.points[segment] + (along - curves.arclength[segment])[:, None] * heading
    pairs = KDTree(points).query_pairs(near, output_type="ndarray")
    one, other = pairs.T
    normals = curves.normals[segment]
    parallel = np.abs((heading[one] * heading[other]).sum(axis=1)) > PARALLEL
    facing = (normals[one] * normals[other]).sum(axis=1) > 0.5
    pairs = pairs[parallel & facing & (owner[one] != owner[other])]
    both = np.concatenate([pairs, pairs[:, ::-1]])
    both = both[np.argsort(owner[both[:, 0]], kind="stable")]
    bounds = np.searchsorted(owner[both[:, 0]], np.arange(len(curves) + 1))
    out = np.zeros(len(curves), dtype=bool)
    done = np.zeros(len(curves), dtype=bool)
    for c in np.argsort(-curves.lengths, kind="stable"):
        mine = both[bounds[c] : bounds[c + 1]]
        against = owner[mine[:, 1]]
        beside = np.unique(mine[done[against] & ~out[against], 0])
        out[c] = 2 * len(beside) > sizes[c]
        done[c] = True
    return out


def stretches(
    curves: Curves, which: Indices, start: Scalars | None = None, end: Scalars | None = None
) -> Curves:
    """Take stretches of curves, from one arc length to another.

    Parameters
    ----------
    curves : the curves
    which : (n,) the curve of each stretch
    start, end : (n,) arc lengths, ``start < end``; the whole curve if not given. On a closed curve the end
        may lie beyond its length, and a stretch as long as the curve stays closed.
    """
    begin = np.zeros(len(which)) if start is None else start
    stop = curves.lengths[which] if end is None else end
    points, faces, turning, sliding, sizes, closed = [], [], [], [], [], []
    for c, a, b in zip(which, begin, stop, strict=True):
        own = np.arange(curves.offsets[c], curves.offsets[c + 1])
        length = float(curves.lengths[c])
        if curves.closed[c] and b - a >= length * (1 - 1e-12):
            points.append(curves.points[own])
            faces.append(curves.faces[own])
            turning.append(curves.turning[own])
            sliding.append(curves.sliding[own])
            sizes.append(len(own))
            closed.append(True)
            continue
        at = curves.arclength[own]
        if curves.closed[c]:  # twice round, so that a stretch may pass the first point
            own, at = np.concatenate([own, own]), np.concatenate([at, at + length])
        near = 1e-9 * length
        inner = np.flatnonzero((at > a + near) & (at < b - near))
        first = max(int(np.searchsorted(at, a + near, side="right")) - 1, 0)
        last = int(inner[-1]) if len(inner) else first
        ends = [
            curves.points[own[k]]
            + (s - at[k]) / max(curves.segment_lengths[own[k]], 1e-300) * curves.segments[own[k]]
            for k, s in ((first, a), (last, b))
        ]
        points.append(np.concatenate([ends[:1], curves.points[own[inner]], ends[1:]]))
        faces.append(curves.faces[np.concatenate([own[[first]], own[inner], own[[last]]])])
        turning.append(np.concatenate([[0.0], curves.turning[own[inner]], [0.0]]))
        sliding.append(np.concatenate([curves.sliding[own[[first]]], curves.sliding[own[inner]], [False]]))
        sizes.append(len(inner) + 2)
        closed.append(False)
    if not sizes:
        none = np.zeros(0, dtype=np.int64)
        return Curves(
            curves.mesh,
            np.zeros((0, 3)),
            none,
            np.zeros(0),
            np.zeros(0, bool),
            np.zeros(1, np.int64),
            np.zeros(0, bool),
        )
    return Curves(
        curves.mesh,
        np.concatenate(points),
        np.concatenate(faces),
        np.concatenate(turning),
        np.concatenate(sliding),
        np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64),
        np.array(closed, dtype=bool),
    )


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


def _extended(curves: Curves, reach: float) -> tuple[Curves, Scalars]:
    """Continue open ends straight on; (n, 2) where the given curve starts and ends on the longer one."""
    mesh = curves.mesh
    goes_on = ~_on_boundary(curves) & ~curves.closed[:, None]
    first, last = curves.offsets[:-1], curves.offsets[1:] - 1
    tips = [first[goes_on[:, 0]], last[goes_on[:, 1]]]
    # A segment belongs to the point it starts from, so the last one to the last point but one.
    sides = [(tips[0], -curves.segments[tips[0]]), (tips[1] - 1, curves.segments[tips[1] - 1])]
    more = [
        straightest(mesh, curves.faces[at], heading, reach, points=curves.points[tip]) if len(tip) else None
        for tip, (at, heading) in zip(tips, sides, strict=True)
    ]
    number = np.cumsum(goes_on, axis=0) - 1
    points: list[Vectors] = []
    faces: list[Indices] = []
    turning: list[Scalars] = []
    sliding: list[Flags] = []
    spans = np.stack([np.zeros(len(curves)), curves.lengths], axis=1)
    for c in range(len(curves)):
        own = slice(int(curves.offsets[c]), int(curves.offsets[c + 1]))
        pieces = [(curves.points[own], curves.faces[own], curves.turning[own], curves.sliding[own])]
        if goes_on[c, 0] and more[0] is not None:
            behind = more[0][int(number[c, 0])]
            spans[c] += more[0].lengths[number[c, 0]]
            still = np.zeros(len(behind.points) - 1, dtype=bool)
            # Turned round, a segment belongs to the point at its other end.
            pieces.insert(0, (behind.points[:0:-1], behind.faces[-2::-1], -behind.turning[:0:-1], still))
        if goes_on[c, 1] and more[1] is not None:
            front = more[1][int(number[c, 1])]
            still = np.zeros(len(front.points) - 1, dtype=bool)
            there, under, turns, slides = pieces[-1]
            pieces[-1] = (there, np.append(under[:-1], front.faces[0]), turns, slides)
            pieces.append((front.points[1:], front.faces[1:], front.turning[1:], still))
        points.append(np.concatenate([each[0] for each in pieces]))
        faces.append(np.concatenate([each[1] for each in pieces]))
        turning.append(np.concatenate([each[2] for each in pieces]))
        sliding.append(np.concatenate([each[3] for each in pieces]))
    sizes = [len(each) for each in points]
    longer = Curves(
        mesh,
        np.concatenate(points),
        np.concatenate(faces),
        np.concatenate(turning),
        np.concatenate(sliding),
        np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64),
        curves.closed.copy(),
    )
    return longer, spans


def _trimmed(
    longer: Curves, spans: Scalars, tail: float, shallowest: float
) -> tuple[Flags, Scalars, Scalars]:
    """Which curves cross any, and where each is to start and end.

    An end goes a tail beyond the first crossing outside the curve's own part. Where its extension meets none,
    or one too shallow to hold it, it goes back to the last one inside that holds. A crossing counts if the
    other curve is there with its own part.
    """
    met = crossings(longer)
    low, high = spans[met.curves, 0], spans[met.curves, 1]
    own = (met.arclength >= low - tail) & (met.arclength <= high + tail)
    owner, at, firm = met.curves.ravel(), met.arclength.ravel(), own[:, ::-1].ravel()
    holds = np.repeat(_at_least(met, shallowest), 2)
    order = np.lexsort((at, owner))
    order = order[firm[order]]
    owner, at, holds = owner[order], at[order], holds[order]
    bounds = np.searchsorted(owner, np.arange(len(longer) + 1))
    at_rim = _on_boundary(longer)
    start, end = np.zeros(len(longer)), longer.lengths.copy()
    crossed = longer.closed & (np.diff(bounds) > 0)
    for c in np.flatnonzero(~longer.closed):
        there, good = (each[bounds[c] : bounds[c + 1]] for each in (at, holds))
        inside = np.flatnonzero(good & (there > spans[c, 0]) & (there < spans[c, 1]))
        before, after = np.flatnonzero(there <= spans[c, 0]), np.flatnonzero(there >= spans[c, 1])
        # An end that came to the boundary before it met anything stays there.
        first = before[-1:][good[before[-1:]]] if len(before) else inside[:1]
        last = after[:1][good[after[:1]]] if len(after) else inside[-1:]
        first, last = (first if len(first) else inside[:1]), (last if len(last) else inside[-1:])
        if len(before) or not at_rim[c, 0]:
            if not len(first):
                continue
            start[c] = max(there[first[0]] - tail, 0.0)
        if len(after) or not at_rim[c, 1]:
            if not len(last):
                continue
            end[c] = min(there[last[0]] + tail, longer.lengths[c])
        crossed[c] = len(there) > 0
    return crossed, start, end


def _at_least(met: Crossings, shallowest: float) -> Flags:
    """(C,) whether the two lines of each crossing are so many degrees apart or more."""
    return np.asarray(np.abs(np.sin(met.angle)) >= np.sin(np.radians(shallowest)))


def _without_touching(met: Crossings, curves: Curves, near: float) -> Crossings:
    """One crossing for several of the same two curves near each other on both; none where these are even."""
    plain = interlacing.Crossings(met.curves, met.arclength, curves.closed)
    joined = interlacing.merged(plain, near, curves.lengths)
    odd = np.bincount(joined.group, minlength=len(joined.kept)) % 2 == 1
    return taken(met, joined.kept[odd])


def _outermost(met: Crossings, count: int) -> tuple[Scalars, Scalars]:
    """(count,) arc length of the first and the last crossing on each curve, inf and -inf without one."""
    owner, at = met.curves.ravel(), met.arclength.ravel()
    first, last = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(first, owner, at)
    np.maximum.at(last, owner, at)
    return first, last


def _loose(curves: Curves, met: Crossings, tail: float) -> Flags:
    """(n, 2) open ends without a crossing within a tail of them, unless they lie on the boundary."""
    first, last = _outermost(met, len(curves))
    away = np.stack([first, curves.lengths - last], axis=1)
    beyond = away > tail + 1e-6 * curves.mesh.mean_edge
    return np.asarray(beyond & ~_on_boundary(curves) & ~curves.closed[:, None])


def _on_boundary(curves: Curves) -> Flags:
    """(n, 2) whether start and end of each curve lie on the boundary of the surface."""
    mesh = curves.mesh
    ends = np.stack([curves.offsets[:-1], curves.offsets[1:] - 1], axis=1)
    face, point = curves.faces[ends], curves.points[ends]
    corners = mesh.vertices[mesh.faces[face]]
    found = np.zeros(ends.shape, dtype=bool)
    for k in range(3):
        a, b = corners[..., (k + 1) % 3, :], corners[..., (k + 2) % 3, :]
        along = b - a
        share = np.clip(((point - a) * along).sum(-1) / (along**2).sum(-1), 0.0, 1.0)
        off = np.linalg.norm(point - a - share[..., None] * along, axis=-1)
        found |= (mesh.face_neighbors[face, k] < 0) & (off < 1e-6 * mesh.mean_edge)
    return found
