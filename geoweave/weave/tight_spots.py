"""Where ribbons get in each other's way: small angles, neighbours that overlap, heaps (Section 6)."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Flags, Indices, Scalars
from geoweave.weave.places import Place, places
from geoweave.weave.weave import Weave
from geoweave.weave.widths import Neighbours

__all__ = ["alongside", "crowded", "knots", "near_parallel"]

STEP = 0.05
"""Least distance between the samples of ribbons that run alongside each other, in spacings."""

HEAP = 3
"""Short ribbons that make a knot."""

TURN_BACK = 4.0
"""Widths along a ribbon within which its own samples are not taken for another ribbon beside it."""

SAME_STRETCH = 3.0
"""Samples of one stretch follow each other within so many sampling distances."""


def near_parallel(weave: Weave, limit: float) -> list[Place]:
    """Crossings at a smaller angle than the limit, degrees."""
    angle, met = weave.crossing_angles, weave.ribbons.crossings
    small = np.flatnonzero(angle < limit)
    owners = [tuple(pair) for pair in met.curves[small].tolist()]
    return places(weave, "near_parallel", met.points[small], owners, angle[small], True)


def crowded(weave: Weave, pairs: Neighbours, limit: float) -> list[Place]:
    """Neighbouring crossings that overlap at the width, both at the limit (degrees) or more."""
    angle, met = weave.crossing_angles, weave.ribbons.crossings
    steep = (angle[pairs.first] >= limit) & (angle[pairs.second] >= limit)
    tight = steep & (pairs.widths < weave.width)
    # The three sides of a triangle say the same: no strip fits that is wider than its incircle.
    group = np.arange(len(tight)) + len(pairs.triangles)
    for k in range(3):
        group[pairs.triangles[:, k]] = np.arange(len(pairs.triangles))
    order = np.lexsort((pairs.widths, group))
    order = order[tight[order]]
    chosen = order[np.unique(group[order], return_index=True)[1]]
    middle = 0.5 * (met.points[pairs.first[chosen]] + met.points[pairs.second[chosen]])
    owners = np.column_stack([pairs.ribbon[chosen], pairs.others[chosen]]).tolist()
    ribbons = [tuple(dict.fromkeys(three)) for three in owners]
    values = pairs.widths[chosen] * weave.placement.scale
    return places(weave, "crowded", middle, ribbons, values, True)


def knots(weave: Weave, limit: float) -> list[Place]:
    """Three or more ribbons no longer than the limit, in spacings, that cross each other.

    The place is the crossing nearest to their middle.
    """
    curves, met = weave.ribbons.curves, weave.ribbons.crossings
    short = ~curves.closed & (curves.lengths <= limit * weave.ribbons.spacing)
    inner = np.flatnonzero(short[met.curves].all(axis=1) & (met.curves[:, 0] != met.curves[:, 1]))
    pairs, count = met.curves[inner], len(curves)
    links = sparse.csr_array((np.ones(len(inner)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    _, heap = csgraph.connected_components(links, directed=False)
    size = np.bincount(heap[short], minlength=heap.max() + 1)
    large = np.flatnonzero(size >= HEAP)
    points, owners = np.zeros((len(large), 3)), []
    for k, which in enumerate(large.tolist()):
        met_there = met.points[inner[heap[pairs[:, 0]] == which]]
        away = np.linalg.norm(met_there - met_there.mean(axis=0), axis=1)
        points[k] = met_there[away.argmin()]
        owners.append(tuple(np.flatnonzero(short & (heap == which)).tolist()))
    return places(weave, "knot", points, owners, size[large].astype(np.float64), False)


def alongside(weave: Weave, limit: float) -> list[Place]:
    """Stretches on which two ribbons run near parallel, less than a width apart.

    The limit is the angle between them, degrees. Where one ends and the other begins, the two lap.
    """
    from scipy.spatial import KDTree

    ribbons, width = weave.ribbons, weave.width
    step = max(0.5 * width, STEP * ribbons.spacing)
    owner, at, where, heading, up = ribbons.curves.sampled(step)
    near = KDTree(where).query_pairs(float(np.hypot(width, step)), output_type="ndarray")
    a, b = near[:, 0], near[:, 1]
    parallel = np.abs((heading[a] * heading[b]).sum(axis=1)) > np.cos(np.radians(limit))
    parallel &= (up[a] * up[b]).sum(axis=1) > 0
    a, b = a[parallel], b[parallel]
    between = where[b] - where[a]
    along = (between * heading[a]).sum(axis=1)
    distance = np.linalg.norm(between - along[:, None] * heading[a], axis=1)
    apart = np.abs(at[a] - at[b])
    length = ribbons.curves.lengths[owner[a]]
    apart = np.where(ribbons.curves.closed[owner[a]], np.minimum(apart, length - apart), apart)
    # The next samples of the same strand are no neighbours; a strand needs a few widths to turn back.
    other = (owner[a] != owner[b]) | (apart > TURN_BACK * (width + step))
    kept = (np.abs(along) <= step) & (distance < width) & other
    a, b, distance = a[kept], b[kept], distance[kept]
    order = np.lexsort((at[a], owner[b], owner[a]))
    a, b, distance = a[order], b[order], distance[order]
    if not len(a):
        return []
    pair = np.stack([owner[a], owner[b]], axis=1)
    new = np.ones(len(a), dtype=bool)
    new[1:] = (np.diff(pair, axis=0) != 0).any(axis=1) | (np.diff(at[a]) > SAME_STRETCH * step)
    run = np.cumsum(new) - 1
    start = np.flatnonzero(new)
    span = np.stack([at[a][start], at[a][np.append(start[1:], len(a)) - 1]], axis=1)
    worst = np.lexsort((distance, run))[start]
    told = _holds_small_crossing(weave, pair[start], span, 2.0 * step, limit)
    tips = []
    for side, place in enumerate((at[a], at[b])):
        ribbon = pair[start, side]
        low, high = np.minimum.reduceat(place, start), np.maximum.reduceat(place, start)
        opened, rest = ~ribbons.curves.closed[ribbon], ribbons.curves.lengths[ribbon] - high
        tips.append((opened & (low <= step) & (rest > step), opened & (rest <= step) & (low > step)))
    (start_a, end_a), (start_b, end_b) = tips
    along = (heading[a[start]] * heading[b[start]]).sum(axis=1) > 0
    ends = np.where(along, (start_a & end_b) | (end_a & start_b), (start_a & start_b) | (end_a & end_b))
    middle = 0.5 * (where[a[worst]] + where[b[worst]])
    owners = [tuple(dict.fromkeys(two)) for two in pair[worst].tolist()]
    lengths = (span[:, 1] - span[:, 0] + step) * weave.placement.scale
    found = []
    for kind, kept in (("alongside", ~told & ~ends), ("lap", ~told & ends)):
        which = np.flatnonzero(kept)
        found += places(weave, kind, middle[which], [owners[k] for k in which], lengths[which], False)
    return found


def _holds_small_crossing(weave: Weave, pair: Indices, span: Scalars, margin: float, limit: float) -> Flags:
    """Whether a stretch holds a crossing of its two ribbons that is reported as near parallel."""
    met = weave.ribbons.crossings
    small = weave.crossing_angles < limit
    told = np.zeros(len(pair), dtype=bool)
    for c, s in zip(met.curves[small], met.arclength[small], strict=True):
        for one, two, place in ((c[0], c[1], s[0]), (c[1], c[0], s[1])):
            inside = (span[:, 0] - margin <= place) & (place <= span[:, 1] + margin)
            told |= (pair[:, 0] == one) & (pair[:, 1] == two) & inside
    return told
