"""The strips of a pattern as elastic rods, laid where its crossings were placed (Appendix E)."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from geoweave.arrays import Indices, Scalars, Vectors, frozen
from geoweave.errors import RodError
from geoweave.fabrication import Pattern
from geoweave.rods import Contacts, Layout, Material, Rods, natural_of_strips
from geoweave.sparse import factorization
from geoweave.twin.pattern_surface import PatternSurface
from geoweave.twin.placement import crossing_normals
from geoweave.weave import Passages, merged

__all__ = ["PIECES", "Cut", "LaidStrips", "cut", "laid"]

PIECES = 3
"""Segments to a usual stretch between two crossings, as many as rods of a weave have."""

SMOOTH = 0.3
"""Weight of the second differences of a strip against its distance from its crossings, at the start."""

YOUNG = 1e8
"""Young's modulus at bounding radius 1, that of the rods of a weave."""


class Cut(NamedTuple):
    """The strips cut into equal segments, in the pattern's unit."""

    layout: Layout
    rest: Scalars
    """(S,) length of each segment, mm."""
    segments: Indices
    """(C, 2) segment on which each crossing lies."""
    places: NDArray[np.float64]
    """(C, 2) how far along it, 0 to 1."""
    contact: Indices
    """(C,) contact that stands for each crossing; -1 for a strip that crosses itself within a segment."""
    stands: Indices
    """(K,) crossing that each contact is made of."""


class LaidStrips(NamedTuple):
    """Rods at bounding radius 1 about the origin."""

    rods: Rods
    unit: float
    """Of the pattern over that of the rods."""
    cut: Cut


def cut(pattern: Pattern) -> Cut:
    """Cut strips into equal segments, `PIECES` of them to a mean stretch between two crossings."""
    lengths = np.array([strip.length for strip in pattern.strips])
    closed = np.array([strip.closed for strip in pattern.strips])
    size = lengths.sum() / (2 * PIECES * len(pattern.ribbons))
    counts = np.maximum(np.round(lengths / size).astype(np.int64), np.where(closed, 3, 1))
    layout = Layout(np.concatenate([[0], np.cumsum(counts + ~closed)]), closed)
    each = lengths / counts
    owner = pattern.ribbons
    at = pattern.at / each[owner]
    at = np.where(closed[owner], np.remainder(at, counts[owner]), at)
    whole = np.clip(np.floor(at).astype(np.int64), 0, counts[owner] - 1)
    segments = layout.segment_offsets[owner] + whole
    # Two strips that cross twice within a width lie along each other there: one contact stands for both.
    merge = merged(Passages(owner, pattern.at, closed), pattern.width, lengths)
    apart = segments[merge.kept, 0] != segments[merge.kept, 1]
    return Cut(
        layout,
        frozen(np.repeat(each, counts)),
        frozen(segments),
        frozen(np.clip(at - whole, 0.0, 1.0)),
        frozen(np.where(apart, np.cumsum(apart) - 1, -1)[merge.group]),
        frozen(merge.kept[apart]),
    )


def laid(surface: PatternSurface, points: Vectors, unit: float | None = None) -> LaidStrips:
    """Lay strips smoothly near their crossings, flush with the surface there, the printed side out.

    Rods are naturally flat, as curved and as long as the strips. Their vertices minimise the sum of
    squared distances from crossings and of squared second differences (`SMOOTH`), so free ends go on
    straight.

    Parameters
    ----------
    surface : of the pattern
    points : (C, 3) places of its crossings, mm
    unit : bounding radius, mm; that of the crossings if not given

    Raises
    ------
    RodError
        If a strip is not as wide as it is thick, or too short for a segment.
    """
    pattern, pieces = surface.pattern, cut(surface.pattern)
    layout, count = pieces.layout, pieces.layout.vertices
    rows = np.repeat(np.arange(2 * len(points)), 2)
    share = np.stack([1.0 - pieces.places, pieces.places], axis=2)
    ends = layout.ends[pieces.segments]
    meet = sparse.csr_array((share.ravel(), (rows, ends.ravel())), shape=(2 * len(points), count))
    a, b = layout.joints.T
    joints = np.column_stack([layout.ends[a], layout.ends[b, 1]])
    rows = np.repeat(np.arange(len(a)), 3)
    second = np.tile([1.0, -2.0, 1.0], len(a))
    bend = sparse.csr_array((second, (rows, joints.ravel())), shape=(len(a), count))
    matrix = sparse.csr_array(
        meet.T @ meet + SMOOTH * (bend.T @ bend) + 1e-9 * sparse.eye_array(count, format="csr")
    )
    normals = crossing_normals(surface, points)
    goal = np.repeat(np.concatenate([points, normals], axis=1), 2, axis=0)
    fit = factorization.factorized(matrix, factorization.nested_dissection(matrix)).solve(meet.T @ goal)
    line, up = fit[:, :3], fit[:, 3:]
    line = line - line.mean(axis=0)
    # Without free ends this is nearly the bounding radius of the surface that the weave was designed on.
    if unit is None:
        unit = float(np.linalg.norm(points - points.mean(axis=0), axis=1).max())
    edges = line[layout.ends[:, 1]] - line[layout.ends[:, 0]]
    length = np.linalg.norm(edges, axis=1, keepdims=True)
    if not (length > 0).all():
        raise RodError("a segment of the twin has no length at the start; the pattern's lengths contradict")
    tangents = edges / length
    directors = up[layout.ends].sum(axis=1)
    directors -= (directors * tangents).sum(axis=1)[:, None] * tangents
    size = np.linalg.norm(directors, axis=1, keepdims=True)
    # Where a strip stands on the fitted surface, any direction square to it will do.
    spare = np.cross(tangents, np.eye(3)[np.abs(tangents).argmin(axis=1)])
    directors = np.where(size > 1e-6, directors, spare)
    directors /= np.linalg.norm(directors, axis=1, keepdims=True)
    stands = pieces.stands
    contacts = Contacts(pieces.segments[stands], pieces.places[stands], pattern.over[stands], pieces.contact)
    rods = Rods(
        layout,
        line / unit,
        directors,
        np.full(layout.segments, pattern.width / unit),
        pieces.rest / unit,
        contacts,
        Material(pattern.thickness / unit, YOUNG),
    )
    natural = natural_of_strips(rods, [strip.curve for strip in pattern.strips])
    return LaidStrips(replace(rods, natural=natural), unit, pieces)
