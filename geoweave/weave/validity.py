"""Whether ribbons make a valid weave, checked on the result alone (Section 5.2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from geoweave.arrays import Flags, Indices, Scalars, Vectors
from geoweave.curves import Curves
from geoweave.surface import TriMesh
from geoweave.weave.ribbons import Ribbons
from geoweave.wording import counted

__all__ = ["violations"]

ROUNDING = 1e-6
"""Share of the mean edge by which a point may be off its place."""

PARALLEL = 1e-6
"""Sine of the angle up to which two segments count as parallel."""

OFF = 10
"""A crossing may be so many times the rounding away from the place its ribbon has at its arc length."""

MARGIN = 1e-6
"""Share of a segment next to its ends that the search for unlisted crossings leaves to its neighbours."""


def violations(ribbons: Ribbons, over: ArrayLike | None = None) -> list[str]:
    """Say what is wrong with a weave, one sentence per rule that it breaks; nothing for a valid one.

    The rules: each crossing lies on exactly two ribbons, or on one at two places, and is listed once; each
    place where two segments cross inside a face is listed, unless the same two ribbons cross again within a
    tail; each end of an open ribbon lies on the boundary or has a crossing
    within a tail of it; no ribbon has fewer than ``cutting.fewest`` crossings; one ribbon lies over at each
    crossing.

    Parameters
    ----------
    ribbons : centrelines and crossings
    over : (C,) which of the two ribbons lies over at each crossing, 0 or 1; not looked at if not given

    Returns
    -------
    list of sentences that count, and name the first place by its ribbon or crossing and its position
    """
    curves, met = ribbons.curves, ribbons.crossings
    if not len(curves):
        return ["there is no ribbon"]
    known = np.all((met.curves >= 0) & (met.curves < len(curves)), axis=1)
    if not known.all():
        return _said("crossing", "names name", "a ribbon that is not there", ~known, met.points)
    near = ROUNDING * curves.mesh.mean_edge
    found = _off_their_ribbons(ribbons, near) + _listed_twice(ribbons, near)
    found += _unlisted(ribbons, 10 * near)
    number = np.bincount(met.curves.ravel(), minlength=len(curves))
    tips = np.stack([curves.points[curves.offsets[:-1]], curves.points[curves.offsets[1:] - 1]], axis=1)
    found += _said("ribbon", "crosses cross", "nothing", number == 0, tips[:, 0])
    fewest = ribbons.cutting.fewest
    found += _said(
        "ribbon", "has have", f"fewer than {fewest} crossings", (number > 0) & (number < fewest), tips[:, 0]
    )
    found += _said("end", "hangs hang", "loose", _hanging(ribbons, near).ravel(), tips.reshape(-1, 3))
    if over is not None:
        sides = np.asarray(over)
        if sides.shape != (len(met),):
            found.append(f"sides of shape {sides.shape} do not fit {counted(len(met), 'crossing')}")
        else:
            found += _said("crossing", "has have", "no ribbon over", ~np.isin(sides, (0, 1)), met.points)
    return found


def _said(noun: str, verb: str, rest: str, wrong: Flags, points: Vectors) -> list[str]:
    """One sentence with the count and the first place, or nothing."""
    if not wrong.any():
        return []
    first = int(np.flatnonzero(wrong)[0])
    place = ", ".join(f"{x:.4g}" for x in points[first])
    return [f"{counted(int(wrong.sum()), noun, verb)} {rest}, first number {first} at ({place})"]


def _place(curves: Curves, which: Indices, at: Scalars) -> Vectors:
    """(n, 3) point of each curve at an arc length."""
    segment = curves.segments_at(which, at)
    length = curves.segment_lengths[segment]
    share = np.clip((at - curves.arclength[segment]) / np.where(length > 0, length, 1.0), 0.0, 1.0)
    return np.asarray(curves.points[segment] + share[:, None] * curves.segments[segment])


def _off_their_ribbons(ribbons: Ribbons, near: float) -> list[str]:
    """Crossings at no two places of ribbons, or elsewhere than the ribbons are there."""
    curves, met = ribbons.curves, ribbons.crossings
    inside = (met.arclength >= -near) & (met.arclength <= curves.lengths[met.curves] + near)
    found = _said("crossing", "lies lie", "beyond the end of a ribbon", ~np.all(inside, axis=1), met.points)
    off = np.zeros(len(met), dtype=bool)
    for side in (0, 1):
        there = _place(curves, met.curves[:, side], met.arclength[:, side])
        off |= np.linalg.norm(there - met.points, axis=1) > OFF * near
    found += _said("crossing", "is are", "not where their ribbons are", off, met.points)
    own = met.curves[:, 0] == met.curves[:, 1]
    apart = np.abs(met.arclength[:, 0] - met.arclength[:, 1])
    return found + _said(
        "crossing", "is are", "of one ribbon at one place", own & (apart <= near), met.points
    )


def _listed_twice(ribbons: Ribbons, near: float) -> list[str]:
    """Crossings of the same two ribbons at the same two arc lengths."""
    met = ribbons.crossings
    turned = (met.curves[:, 0] > met.curves[:, 1]) | (
        (met.curves[:, 0] == met.curves[:, 1]) & (met.arclength[:, 0] > met.arclength[:, 1])
    )
    pair = np.where(turned[:, None], met.curves[:, ::-1], met.curves)
    at = np.where(turned[:, None], met.arclength[:, ::-1], met.arclength)
    order = np.lexsort((at[:, 1], at[:, 0], pair[:, 1], pair[:, 0]))
    same = (pair[order[1:]] == pair[order[:-1]]).all(axis=1)
    same &= (np.abs(at[order[1:]] - at[order[:-1]]) <= near).all(axis=1)
    twice = np.zeros(len(met), dtype=bool)
    twice[order[1:][same]] = True
    return _said("crossing", "is are", "listed twice", twice, met.points)


def _unlisted(ribbons: Ribbons, near: float) -> list[str]:
    """Places inside a face where two ribbons cross and no crossing is listed: every pair in every face."""
    curves, met = ribbons.curves, ribbons.crossings
    last = np.zeros(len(curves.points), dtype=bool)
    last[curves.offsets[1:][~curves.closed] - 1] = True
    own = np.flatnonzero(~last & (curves.segment_lengths > near))
    own = own[np.argsort(curves.faces[own], kind="stable")]
    face = curves.faces[own]
    first, second = _pairs(face)
    a, b = own[first], own[second]
    mesh = curves.mesh
    frame = mesh.frames[curves.faces[a]]
    u, v = _flat(frame, curves.segments[a]), _flat(frame, curves.segments[b])
    between = _flat(frame, curves.points[b] - curves.points[a])
    det = _cross(u, v)
    steep = np.abs(det) > PARALLEL * np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1)
    det = np.where(steep, det, 1.0)
    s, t = _cross(between, v) / det, _cross(between, u) / det
    strict = steep & (s > MARGIN) & (s < 1 - MARGIN) & (t > MARGIN) & (t < 1 - MARGIN)
    a, s, b = a[strict], s[strict], b[strict]
    where = curves.points[a] + s[:, None] * curves.segments[a]
    pairs = np.sort(curves.curve_of_point[np.stack([a, b], axis=1)], axis=1)
    missed = np.flatnonzero(~_among(pairs, where, met.curves, met.points, near))
    pairs, where = pairs[missed], where[missed]
    # Ribbons that cross and cross back within a tail only touch: each such place has another beside it.
    tail = ribbons.cutting.tail * ribbons.spacing
    touching = _among(pairs, where, met.curves, met.points, tail) | _among(
        pairs, where, pairs, where, tail, besides_itself=True
    )
    return _said("place", "is are", "not listed though ribbons cross there", ~touching, where)


def _pairs(label: Indices) -> tuple[Indices, Indices]:
    """All pairs of positions with the same label; labels are sorted."""
    n = len(label)
    end = np.searchsorted(label, label, side="right")
    more = end - np.arange(n) - 1
    first = np.repeat(np.arange(n), more)
    start = np.cumsum(more) - more
    return first, first + 1 + np.arange(len(first)) - start[first]


def _flat(frame: Vectors, vectors: Vectors) -> Vectors:
    return np.asarray(np.einsum("nkx,nx->nk", frame, vectors))


def _cross(u: Vectors, v: Vectors) -> Scalars:
    return np.asarray(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])


def _among(
    pairs: Indices,
    points: Vectors,
    known_pairs: Indices,
    known: Vectors,
    near: float,
    *,
    besides_itself: bool = False,
) -> Flags:
    """(n,) whether a known place of the same two ribbons is so near to a point."""
    from scipy.spatial import KDTree

    rank = 2 if besides_itself else 1
    if len(known) < rank:
        return np.zeros(len(pairs), dtype=bool)
    # The two ribbons are two more coordinates, scaled so that the nearest place is one of the same two.
    far = 4.0 * float(np.abs(known).max() + np.abs(points).max(initial=0.0) + near)
    there = np.concatenate([known, far * np.sort(known_pairs, axis=1)], axis=1)
    here = np.concatenate([points, far * pairs], axis=1)
    distance = np.asarray(KDTree(there).query(here, [rank])[0])
    return np.asarray(distance[:, 0] <= near)


def _hanging(ribbons: Ribbons, near: float) -> Flags:
    """(n, 2) open ends off the boundary without a crossing of their ribbon within a tail."""
    curves, met = ribbons.curves, ribbons.crossings
    tail = ribbons.cutting.tail * ribbons.spacing
    owner, at = met.curves.ravel(), met.arclength.ravel()
    held = np.zeros((len(curves), 2), dtype=bool)
    held[owner[at <= tail + near], 0] = True
    held[owner[curves.lengths[owner] - at <= tail + near], 1] = True
    loose = ~held & ~curves.closed[:, None]
    for c, side in np.argwhere(loose):
        tip = curves.points[curves.offsets[c + 1] - 1 if side else curves.offsets[c]]
        loose[c, side] = _to_boundary(curves.mesh, tip) > near
    return loose


def _to_boundary(mesh: TriMesh, point: Vectors) -> float:
    """Distance of a point to the nearest boundary edge, infinite on a closed surface."""
    a, b = mesh.vertices[mesh.edges[mesh.boundary_edges]].transpose(1, 0, 2)
    if not len(a):
        return float("inf")
    along = b - a
    share = np.clip(((point - a) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    return float(np.linalg.norm(a + share[:, None] * along - point, axis=1).min())
