"""Where the crossings of a pattern lie in space, before any physics: the start of its twin.

The pattern gives lengths along strips and across faces. Sums of them are distances between any two crossings
along the surface. Classical scaling (Torgerson 1952) finds places whose straight distances are as near to
these as possible. Their topology is right, but round parts come out too large. From there springs of the
short distances alone pull crossings to their places, while strips are kept smooth, in stages with less and
less force.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Indices, Scalars, Vectors, frozen
from geoweave.errors import FieldError
from geoweave.sparse import factorization
from geoweave.twin.pattern_surface import PatternSurface
from geoweave.wording import counted

__all__ = [
    "SMOOTHING",
    "Net",
    "Smoothing",
    "crossing_normals",
    "has_outside",
    "net_of",
    "outward",
    "placed",
    "scaled",
    "settled",
]


class Smoothing(NamedTuple):
    """Weights of the bending of strips against their stretching."""

    normal: float
    """Out of the surface, which a thin strip does easily."""
    tangential: float
    """Within the surface, which it hardly does."""


SMOOTHING = (Smoothing(1.0, 1.0), Smoothing(0.1, 0.1), Smoothing(0.01, 0.1), Smoothing(0.001, 0.1))
"""Those of the stages, each of which starts where the one before ended."""

ACROSS = 0.5
"""Weight of a distance across a face against one along a strip, which is cut to its length."""

SHORT = 0.2
"""Springs shorter than this share of the usual length are no stiffer than one of this length."""

SPREAD = 0.5
"""The bending of a strip is measured between crossings at least this share of the usual length apart."""

ROUND = 0.3
"""The third axis of the scaling is unclear if the fourth has this share of its eigenvalue."""

NO_OUTSIDE = 0.6
"""A surface with openings has an outside from this `outward` on; it is 1 for a cone and 0.3 for a saddle."""

VOICE, VOTES = 0.5, 4
"""Weight of each neighbour in the normal of a crossing, and number of rounds of averaging."""

LEAST_DAMPING, FIRST_DAMPING, MOST_DAMPING = 1e-6, 1e-3, 1e6
"""Damping of the Gauss-Newton steps, in units of a spring's stiffness."""

LESS, MORE = 3.0, 5.0
"""The damping is divided by the first after a step that lowers the energy, else multiplied by the second."""

STEPS = 40
"""Steps of a stage at most."""

STILL = 1e-3
"""A stage ends when a step lowers the energy by less than this share."""


class Net(NamedTuple):
    """Crossings, and how far apart neighbouring ones are."""

    ends: Indices
    """(K, 2) crossings."""
    lengths: Scalars
    """(K,) mm."""
    strips: int
    """The first so many lie along strips, the others across faces."""
    triples: Indices
    """(T, 3) crossings that follow each other on a strip, not too near."""
    steps: NDArray[np.float64]
    """(T, 2) distance from the second to the first and to the third along the strip, mm."""
    usual: float
    """Median length of a stretch of strip, mm."""


def net_of(surface: PatternSurface) -> Net:
    """Collect the distances between crossings that a pattern's surface gives."""
    forward = surface.edges[:, 0]
    pairs, along = surface.edges // 4, surface.stretch[forward]
    proper = pairs[:, 0] != pairs[:, 1]
    usual = float(np.median(along))
    chords = surface.chords()
    ends = np.concatenate([pairs[proper], chords.ends])
    beside = _neighbours(surface, SPREAD * usual)
    inner = (beside.back > 0) & (beside.ahead > 0)
    middle = np.broadcast_to(np.arange(len(inner))[:, None], inner.shape)
    triples = np.stack([beside.before, middle, beside.after], axis=2)[inner]
    steps = np.stack([beside.back, beside.ahead], axis=2)[inner]
    return Net(
        frozen(ends),
        frozen(np.concatenate([along[proper], chords.lengths])),
        int(proper.sum()),
        frozen(triples),
        frozen(steps),
        usual,
    )


def placed(surface: PatternSurface, net: Net, *, mirrored: bool = False) -> tuple[Vectors, ...]:
    """Place the crossings of a pattern in space, its printed side out, in several ways.

    A shape and its mirror image have the same distances. Of the two, that with the printed side out is taken,
    where the shape has an outside (`outward`). A shape that is flat in the scaling, as a cone seen from its
    tip, is also tried as a bowl, and the better fit is taken.

    Parameters
    ----------
    surface, net : of the pattern
    mirrored : begin with the mirror image of the scaling. The result is the same if the surface has an
        outside, and the mirror image if it has none

    Returns
    -------
    (C, 3) points, mm, about the origin, after each stage of `settled`. Later stages fit the lengths better
    but may have wrinkles, which relaxing does not always remove.

    Raises
    ------
    FieldError
        If crossings are not all joined to each other.
    """
    points, shares = scaled(net, len(surface.pattern.ribbons))
    starts = [points]
    if shares[3] > ROUND * shares[2]:
        bowl = points.copy()
        height = -(points[:, :2] ** 2).sum(axis=1)
        height -= height.mean()
        bowl[:, 2] = height * np.sqrt((points[:, 2] ** 2).sum() / (height**2).sum())
        starts.append(bowl)
    image = np.array([1.0, 1.0, -1.0])
    found = [settled(surface, net, start * image if mirrored else start) for start in starts]
    stages = min(found, key=lambda each: each[1])[0]
    side = outward(surface, stages[-1])
    turn = (side < 0) if has_outside(surface, side) else (side < 0) != mirrored
    return tuple(each * image if turn else each for each in stages)


def scaled(net: Net, count: int) -> tuple[Vectors, Scalars]:
    """Classical scaling of the distances along the net.

    Parameters
    ----------
    net : of all crossings
    count : number of crossings, C

    Returns
    -------
    tuple
        (C, 3) points, mm, about the origin, and the (5,) largest eigenvalues as shares of the first.

    Raises
    ------
    FieldError
        If there are fewer than six crossings, or they are not all joined to each other.
    """
    from scipy.sparse.linalg import eigsh

    if count < 6:
        raise FieldError(f"the strips cross at {counted(count, 'place')} only, which does not make a surface")
    low, high = np.sort(net.ends, axis=1).T
    order = np.lexsort((net.lengths, high, low))
    first = np.diff(low[order] * count + high[order], prepend=-1) != 0
    kept = order[first]
    shortest = np.maximum(net.lengths[kept], 1e-9 * net.usual)  # zeros would be no edges
    graph = sparse.csr_array((shortest, (low[kept], high[kept])), shape=(count, count))
    apart = csgraph.shortest_path(graph, directed=False)
    if not np.isfinite(apart).all():
        raise FieldError("the strips of the pattern fall into pieces that nothing holds together")
    square = apart**2
    gram = -0.5 * (square - square.mean(axis=0) - square.mean(axis=1)[:, None] + square.mean())
    start = np.cos(np.arange(count))  # any fixed vector: the same pattern, the same twin
    value, vector = eigsh(gram, k=5, which="LA", v0=start)
    down = np.argsort(-value)
    value, vector = value[down], vector[:, down]
    vector *= np.where(vector[np.abs(vector).argmax(axis=0), np.arange(5)] < 0, -1.0, 1.0)
    return vector[:, :3] * np.sqrt(np.maximum(value[:3], 0.0)), value / value[0]


def settled(
    surface: PatternSurface, net: Net, points: Vectors, smoothing: tuple[Smoothing, ...] = SMOOTHING
) -> tuple[tuple[Vectors, ...], float]:
    """Balance springs of the net's lengths against the bending of strips, whose weight falls in stages.

    Minimises ``sum w (|p - q| - l)^2 / l + b u^2 sum |(p+ - p) / l+ - (p - p-) / l-|^2 / l`` by damped
    Gauss-Newton steps, with w = 1 along strips and `ACROSS` across faces, u the usual length, l in the
    denominator never below `SHORT` of it, and b other along the normals than square to them (`Smoothing`).

    Returns
    -------
    tuple
        (C, 3) points about the origin after each stage, and the energy at the end, mm.
    """
    problem = _Springs(net, len(points))
    energy, stages = np.inf, []
    for smooth in smoothing:
        points, energy = problem.minimum(points, smooth, crossing_normals(surface, points))
        stages.append(points - points.mean(axis=0))
    return tuple(stages), energy


def crossing_normals(surface: PatternSurface, points: Vectors) -> Vectors:
    """(C, 3) unit normals at the crossings, on the side from which angles turn as the pattern says.

    From the directions of the two strips; where they are nearly along each other, from the neighbours.
    """
    pattern = surface.pattern
    before, after, _, _ = _neighbours(
        surface, SPREAD * float(np.median(surface.stretch[surface.edges[:, 0]]))
    )
    ways = points[after] - points[before]
    ways /= np.maximum(np.linalg.norm(ways, axis=2, keepdims=True), 1e-300)
    side = np.where(pattern.angle >= 0, 1.0, -1.0)[:, None]
    own = side * np.cross(ways[:, 0], ways[:, 1])
    # The normal of a shallow crossing is noise, that of a wrong sign points inwards: average with neighbours.
    pairs = surface.edges // 4
    links = sparse.coo_array(
        (np.full(2 * len(pairs), VOICE), (pairs.T.ravel(), pairs.T[::-1].ravel())), shape=(len(points),) * 2
    ).tocsr()
    normals = own
    for _ in range(VOTES):
        normals = own + links @ normals
        normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
    lost = np.linalg.norm(normals, axis=1) < 0.5
    normals[lost] = [0.0, 0.0, 1.0]
    return np.asarray(normals)


def outward(surface: PatternSurface, points: Vectors) -> float:
    """Volume between the centre and the faces as a share of the volumes of all their cones, from -1 to 1.

    It is 1 for a convex shape with the printed side out, -1 for its mirror image, and near 0 for a saddle,
    which has no outside.
    """
    centre = points.mean(axis=0)
    cones = []
    for walk in surface.meshes:
        corner = points[walk // 4] - centre
        cones.append(np.cross(corner[1:-1], corner[2:]) @ corner[0])
    volumes = np.concatenate(cones)
    total = float(np.abs(volumes).sum())
    return float(volumes.sum()) / total if total > 0 else 0.0


def has_outside(surface: PatternSurface, side: float) -> bool:
    """Whether `outward` tells a shape from its mirror image: a closed one has an outside, a saddle none."""
    return abs(side) > (0.0 if surface.openings == 0 else NO_OUTSIDE)


class _Springs:
    """The energy of `settled` and its steps."""

    def __init__(self, net: Net, count: int) -> None:
        self.net, self.count = net, count
        floor = np.maximum(net.lengths, SHORT * net.usual)
        weight = np.where(np.arange(len(net.ends)) < net.strips, 1.0, ACROSS)
        self.weight = np.sqrt(weight / floor)
        self.unit = float((self.weight**2).mean())
        before, after = net.steps.T
        share = np.column_stack([1 / before, -1 / before - 1 / after, 1 / after])
        self.share = share * (net.usual * np.sqrt(2 / (before + after)))[:, None]
        axis = np.arange(3)
        self.of_springs = (3 * net.ends[:, :, None] + axis).reshape(-1, 6)
        self.of_triples = (3 * net.triples[:, :, None] + axis).reshape(-1, 9)
        every = np.arange(3 * count)
        blocks = (self.of_springs, self.of_triples)
        rows = np.concatenate([*(np.repeat(own, own.shape[1], axis=1).ravel() for own in blocks), every])
        columns = np.concatenate([*(np.tile(own, own.shape[1]).ravel() for own in blocks), every])
        self.sum = factorization.Assembly(rows, columns, 3 * count)
        pattern = self.sum(np.ones(len(rows)))
        nodes = sparse.csr_array(pattern[::3, ::3])
        self.analysis = factorization.analysed(pattern, factorization.nested_dissection(nodes).repeated(3))

    def stretched(self, points: Vectors) -> tuple[Vectors, Scalars, Scalars]:
        """Unit directions of the springs, their lengths and their residuals."""
        one, other = self.net.ends.T
        edge = points[other] - points[one]
        length = np.maximum(np.sqrt((edge**2).sum(axis=1)), 1e-12 * self.net.usual)
        return edge / length[:, None], length, self.weight * (length - self.net.lengths)

    def bent(self, points: Vectors, roots: Vectors) -> Vectors:
        """(T, 3) residuals of bending."""
        change = np.einsum("tk,tkx->tx", self.share, points[self.net.triples])
        return np.einsum("txy,ty->tx", roots, change)

    def energy(self, points: Vectors, roots: Vectors) -> float:
        return float((self.stretched(points)[2] ** 2).sum() + (self.bent(points, roots) ** 2).sum())

    def minimum(self, points: Vectors, smooth: Smoothing, normals: Vectors) -> tuple[Vectors, float]:
        """Go down from points until nothing changes any more; normals are those of the crossings there."""
        up = normals[self.net.triples[:, 1]]
        along = up[:, :, None] * up[:, None, :]
        roots = np.sqrt(smooth.normal) * along + np.sqrt(smooth.tangential) * (np.eye(3) - along)
        pulls = np.einsum("tk,txy->txky", self.share, roots).reshape(len(roots), 3, 9)
        bending = (pulls.transpose(0, 2, 1) @ pulls).ravel()
        damping, energy = FIRST_DAMPING, self.energy(points, roots)
        for _ in range(STEPS):
            way, length, residual = self.stretched(points)
            pull = self.weight[:, None] * np.concatenate([-way, way], axis=1)
            local = np.einsum("tx,txk->tk", self.bent(points, roots), pulls)
            force = np.bincount(
                np.concatenate([self.of_springs.ravel(), self.of_triples.ravel()]),
                np.concatenate([(residual[:, None] * pull).ravel(), local.ravel()]),
                minlength=3 * self.count,
            ).astype(np.float64)
            # A stretched spring resists rotation. A compressed one would buckle; that part is left out.
            taut = self.weight**2 * np.maximum(1.0 - self.net.lengths / length, 0.0)
            side = taut[:, None, None] * (np.eye(3) - way[:, :, None] * way[:, None, :])
            block = pull[:, :, None] * pull[:, None, :] + np.block([[side, -side], [-side, side]])
            before = energy
            while damping < MOST_DAMPING:
                extra = np.full(3 * self.count, damping * self.unit)
                matrix = self.sum(np.concatenate([block.ravel(), bending, extra]))
                step = factorization.factorized(matrix, self.analysis).solve(force)
                trial = points - step.reshape(-1, 3)
                reached = self.energy(trial, roots)
                if reached < energy:
                    points, energy = trial, reached
                    damping = max(damping / LESS, LEAST_DAMPING)
                    break
                damping *= MORE
            if before - energy <= STILL * before:
                break
        return points, energy


class _Beside(NamedTuple):
    """Neighbours of each crossing on both of its strips that are not too near, (C, 2) arrays."""

    before: Indices
    """Crossing; the crossing itself at the start of a strip."""
    after: Indices
    """Crossing; the crossing itself at the end of a strip."""
    back: NDArray[np.float64]
    """How far before, mm; 0 at the start of a strip."""
    ahead: NDArray[np.float64]
    """How far after, mm; 0 at the end of a strip."""


def _neighbours(surface: PatternSurface, near: float) -> _Beside:
    """Find the next crossings on each strip, to both sides, that are not nearer than this."""
    pattern = surface.pattern
    every = np.broadcast_to(np.arange(len(pattern.ribbons))[:, None], pattern.ribbons.shape)
    found = _Beside(every.copy(), every.copy(), np.zeros(every.shape), np.zeros(every.shape))
    for strip, met in zip(pattern.strips, pattern.passages, strict=True):
        n = len(met)
        at = np.array([each.at for each in met])
        crossing = np.array([each.crossing for each in met], dtype=np.int64)
        own = (crossing, np.array([each.side for each in met], dtype=np.int64))
        if strip.closed:
            at = np.concatenate([at - strip.length, at, at + strip.length])
            crossing = np.tile(crossing, 3)
        here = np.arange(n) + (n if strip.closed else 0)
        after = np.searchsorted(at, at[here] + near)
        before = np.searchsorted(at, at[here] - near, side="right") - 1
        after, before = np.where(after < len(at), after, here), np.where(before >= 0, before, here)
        found.before[own], found.after[own] = crossing[before], crossing[after]
        found.back[own], found.ahead[own] = at[here] - at[before], at[after] - at[here]
    return found
