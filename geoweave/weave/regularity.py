"""How regular a weave is, measured on its ribbons and crossings alone.

In a regular triaxial weave the ribbons cut the surface into triangles and hexagons, as in a kagome lattice,
and no three of them meet near one point. The paper leaves this to chance.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Flags, Indices, Scalars, Vectors
from geoweave.curves import Crossings, Curves, nearest_curves
from geoweave.weave.cover import family_count
from geoweave.weave.passages import Passages
from geoweave.weave.ribbon_ends import off_ideal, on_boundary
from geoweave.weave.weave import Weave

__all__ = [
    "Cells",
    "Regularity",
    "crossing_density",
    "local_spacing",
    "near_ideal",
    "phase_order",
    "piled",
    "piled_crossings",
]

PILED = 0.3
"""Crossings nearer to each other than this many spacings are piled."""

BARE = 1.0
"""Surface farther than this many spacings from every ribbon is bare."""

SAME_SIDE = 0.5
"""Least cosine between the normals at two points on the same side of a thin wall."""

OFF_IDEAL = 20.0
"""Degrees by which the angle of a good crossing differs at most from that of evenly turned families."""

FEWEST = 4
"""Crossings that a ribbon should have at least."""


@dataclass(frozen=True)
class Regularity:
    """How regular a weave is.

    Attributes
    ----------
    piled : share of the crossings with another one within 0.3 spacings. No crossing of a kagome has one, and
        about half of all crossings have where the families do not know of each other
    phase_order : mean of ``-cos(2 pi t)``, t the share of one of two successive gaps between the crossings of
        a ribbon in both. 1 for a kagome, 0 where the families do not know of each other, -1 where all
        crossings of three ribbons fall together. None for other weaves than triaxial ones
    bare : share of the area that is farther than one spacing from every ribbon
    spacing_spread : standard deviation of the logarithm of the local spacing
    triangles, hexagons : share of the cells between ribbons that have three or six corners. Cells at the
        boundary are not counted
    interleaved : of the triangles of three ribbons, the share in which each lies over one and under one
    few_crossings : ribbons with fewer than four crossings
    fewest_crossings : of all ribbons
    near_ideal : share of the crossings within 20 degrees of the angle of evenly turned families, which is 60
        degrees in a triaxial weave
    parts : groups of ribbons that hang together by crossings; one at least on each woven component

    Examples
    --------
    >>> found = gw.weave.Regularity.of(gw.weave_pattern(gw.shapes.torus(faces=600), scale=0.5))
    >>> 0 <= found.piled <= 1, found.parts
    (True, 1)
    """

    piled: float
    phase_order: float | None
    bare: float
    spacing_spread: float
    triangles: float
    hexagons: float
    interleaved: float
    few_crossings: int
    fewest_crossings: int
    near_ideal: float
    parts: int

    @classmethod
    def of(cls, weave: Weave) -> Regularity:
        """Measure a weave."""
        curves, met, passages = weave.ribbons.curves, weave.ribbons.crossings, weave.passages
        families, spacing = family_count(weave.symmetry), weave.ribbons.spacing
        number = np.bincount(met.curves.ravel(), minlength=len(curves))
        local = local_spacing(passages, curves.lengths, families)
        corners = Cells.of(curves, met).corners
        turns = weave.interlacing
        return cls(
            piled=float(piled_crossings(weave).mean()),
            phase_order=phase_order(passages, curves.lengths) if families == 3 else None,
            bare=_bare(curves, spacing),
            spacing_spread=float(np.log(local).std()) if len(local) else 0.0,
            triangles=float((corners == 3).mean()) if len(corners) else 0.0,
            hexagons=float((corners == 6).mean()) if len(corners) else 0.0,
            interleaved=turns.interleaved / turns.triples if turns.triples else 1.0,
            few_crossings=int((number < FEWEST).sum()),
            fewest_crossings=int(number.min()),
            near_ideal=float(near_ideal(weave.crossing_angles, families).mean()),
            parts=_parts(met, len(curves)),
        )

    def document(self) -> dict[str, Any]:
        """For reports."""
        return asdict(self)


def piled(points: Vectors, normals: Vectors, spacing: float) -> Flags:
    """(C,) whether another crossing lies within 0.3 spacings, on the same side of a thin wall."""
    from scipy.spatial import KDTree

    found = np.zeros(len(points), dtype=bool)
    pairs = KDTree(points).query_pairs(PILED * spacing, output_type="ndarray")
    facing = (normals[pairs[:, 0]] * normals[pairs[:, 1]]).sum(axis=1) > SAME_SIDE
    found[pairs[facing].ravel()] = True
    return found


def piled_crossings(weave: Weave) -> Flags:
    """(C,) whether each crossing has another one within 0.3 spacings: there three ribbons lie on each other.

    Examples
    --------
    >>> woven = gw.weave_pattern(gw.shapes.torus(faces=600), scale=0.5)
    >>> found = gw.weave.piled_crossings(woven)
    >>> bool(found.mean() == gw.weave.Regularity.of(woven).piled), len(found) == len(woven.ribbons.crossings)
    (True, True)
    """
    met, mesh = weave.ribbons.crossings, weave.mesh
    return piled(met.points, mesh.face_normals[met.faces], weave.ribbons.spacing)


def near_ideal(angles: Scalars, families: int) -> Flags:
    """(C,) whether an angle, in degrees, is within 20 degrees of a multiple of 180 / families."""
    return np.asarray(off_ideal(np.radians(angles), families) <= OFF_IDEAL)


def crossing_density(families: int) -> float:
    """Crossings on one spacing of a ribbon, ``sum_j sin(pi j / n) = cot(pi / 2n)`` for n families."""
    return float(1.0 / np.tan(0.5 * np.pi / families))


def local_spacing(passages: Passages, lengths: Scalars, families: int) -> Scalars:
    """Spacing along the ribbons: `crossing_density` times the mean of successive gaps between crossings.

    One period of the pattern has ``families - 1`` gaps. Each value is the mean over two periods.
    """
    gaps = _gaps(passages, lengths, 2 * (families - 1))
    return crossing_density(families) * gaps.mean(axis=1)


def phase_order(passages: Passages, lengths: Scalars) -> float:
    """Mean of ``-cos(2 pi t)`` over two successive gaps on a ribbon, t the share of the first in both.

    Three families of parallel lines make triangles of two sizes, t and 1 - t of the period along a line. The
    sum of their three phases is ``phi = pi (t - 1/2)``, so that the mean is that of ``cos(2 phi)``.
    """
    gaps = _gaps(passages, lengths, 2)
    both = gaps.sum(axis=1)
    share = gaps[both > 0, 0] / both[both > 0]
    return float(-np.cos(2.0 * np.pi * share).mean()) if len(share) else 0.0


def _gaps(passages: Passages, lengths: Scalars, count: int) -> Scalars:
    """(n, count) lengths of successive gaps between crossings, for each passage that has so many after it."""
    ribbon, at = passages.ribbons.ravel(), passages.arclengths.ravel()
    following = passages.following
    gap = at[following] - at
    # Round a closed ribbon the next crossing may lie beyond its start.
    gap = np.where(gap < 0, gap + np.asarray(lengths)[ribbon], gap)
    now, found = np.flatnonzero(following >= 0), list[Scalars]()
    for _ in range(count):
        kept = following[now] >= 0
        now, found = now[kept], [each[kept] for each in found]
        found.append(gap[now])
        now = following[now]
    return np.stack(found, axis=1)


class Cells(NamedTuple):
    """The cells into which ribbons cut a surface, without those at its boundary."""

    corners: Indices
    """(n,) corners of each: where the way round it leaves one ribbon for another."""

    @classmethod
    def of(cls, curves: Curves, met: Crossings) -> Cells:
        """Walk round every cell with it on the left.

        Four ways leave a crossing, forward and back on two ribbons. A way is ``2 p + back``, p its passage.
        Beyond the last crossing of a ribbon there is none; the walk goes past it. Where that end lies on the
        boundary of the surface, so does the cell.
        """
        passages = Passages.on(curves, met)
        following, count = passages.following, len(met)
        here = np.flatnonzero(following >= 0)
        twin = np.full(4 * count, -1, dtype=np.int64)
        twin[2 * here], twin[2 * following[here] + 1] = 2 * following[here] + 1, 2 * here
        at_rim = on_boundary(curves)[passages.ribbons.ravel()][:, ::-1].ravel()
        # The ways of each crossing clockwise, forward on its first ribbon first.
        left = met.angle > 0
        first, second = 4 * np.arange(count), 4 * np.arange(count) + 2
        round_it = np.stack([first, second + left, first + 1, second + ~left], axis=1)
        place = np.empty(4 * count, dtype=np.int64)
        place[round_it] = np.arange(4)
        way = np.flatnonzero(twin >= 0)
        arrived = twin[way]
        onward, corner = np.full(len(way), -1), np.zeros(len(way), dtype=bool)
        rim = np.zeros(len(way), dtype=bool)
        for step in range(1, 5):
            tried = round_it[arrived // 4, (place[arrived] + step) % 4]
            open_still = onward < 0
            taken = open_still & (twin[tried] >= 0)
            rim |= open_still & (twin[tried] < 0) & at_rim[tried]
            onward[taken] = tried[taken]
            corner |= taken & (step % 2 == 1)
        number = np.full(4 * count, -1, dtype=np.int64)
        number[way] = np.arange(len(way))
        links = sparse.csr_array((np.ones(len(way)), (np.arange(len(way)), number[onward])), (len(way),) * 2)
        found, cell = csgraph.connected_components(links, directed=False)
        outside = np.bincount(cell[rim], minlength=found) > 0
        return cls(np.bincount(cell[corner], minlength=found)[~outside])


def _bare(curves: Curves, spacing: float) -> float:
    """Share of the area farther than a spacing from every ribbon, by the middles of the faces."""
    mesh = curves.mesh
    distance, _ = nearest_curves(curves, mesh.barycenters, mesh.face_normals)
    return float(mesh.face_areas[distance > BARE * spacing].sum() / mesh.face_areas.sum())


def _parts(met: Crossings, count: int) -> int:
    """Groups of ribbons that hang together by crossings."""
    links = sparse.csr_array((np.ones(len(met)), tuple(met.curves.T)), shape=(count, count))
    return int(csgraph.connected_components(links, directed=False)[0])
