"""From ribbons and .rod files to elastic rods and back (Appendix E).

Ribbons are cut into equal segments (Section 5.2). Their directors are the normals of the surface, and their
rest lengths are the lengths they have at the start. Ribbons that could not be rods are put right here:
vertices that coincide or fold back are merged, and several crossings of two ribbons at one place become one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Flags, Indices, Scalars, Vectors, frozen, parallel_transport
from geoweave.errors import RodError
from geoweave.rods.rod_file import Rod, RodCrossing, RodFile
from geoweave.rods.rods import Contacts, Layout, Material, Rods
from geoweave.weave import Passages, Ribbons, interlacing, merged
from geoweave.wording import counted

__all__ = ["FINENESS", "ends_on", "file_of_rods", "rods_of_file", "rods_of_polylines", "rods_of_ribbons"]

FINENESS = 0.2
"""Length of a segment as a share of the spacing of the ribbons: about three between two crossings."""

SHORTEST = 1e-6
"""Segments shorter than this share of the mean of their rod are merged with the next."""

FOLDED = np.cos(np.radians(170.0))
"""Cosine of the angle between two segments from which on the second goes back over the first."""


class _Chain(NamedTuple):
    """One rod before it is joined to the others."""

    points: Vectors
    directors: Vectors
    widths: Scalars
    closed: bool
    knots: Scalars
    """(m + 1,) arclength of the ends of the segments, along the ribbon that the rod was made of."""


def rods_of_ribbons(
    ribbons: Ribbons,
    over: ArrayLike,
    width: float,
    thickness: float,
    *,
    young: float = 1e8,
    poisson: float = 0.3,
    density: float = 1.0,
    segment: float | None = None,
) -> Rods:
    """Make elastic rods of ribbons on a surface.

    Parameters
    ----------
    ribbons : with their crossings, on a surface
    over : (C,) 0 or 1: which of the two ribbons of each crossing lies above, on the outside
    width, thickness : w and h of the section, lengths
    young, poisson, density : of the material; 1e8 is that of the paper's cone, whose bounding radius is 1 too
    segment : length of the segments; a fifth of the spacing if not given

    Raises
    ------
    RodError
        If a number is out of range, or a ribbon is too short for a segment.

    Examples
    --------
    >>> weave = gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)
    >>> rods = gw.rods.rods_of_ribbons(weave.ribbons, weave.interlacing.over, 0.05, 0.002)
    >>> bool(abs(rods.lengths - rods.rest).max() < 1e-12)
    True
    """
    size = FINENESS * ribbons.spacing if segment is None else float(segment)
    for name, value in (("width", width), ("length of a segment", size)):
        if not (np.isfinite(value) and value > 0):
            raise RodError(f"the {name} of the rods is {value:g}; give a positive number")
    material = Material(thickness, young, poisson, density)
    curves = ribbons.curves
    bounds = list(zip(curves.offsets[:-1], curves.offsets[1:], strict=True))
    return rods_of_polylines(
        [curves.points[start:end] for start, end in bounds],
        [curves.normals[start:end] for start, end in bounds],
        # Every crossing keeps a ribbon number and an arclength, which is all that contacts are made of.
        ribbons.passages,
        np.asarray(over, dtype=np.int64),
        width,
        material,
        size,
    )


def rods_of_polylines(
    lines: Sequence[Vectors],
    normals: Sequence[Vectors],
    crossings: Passages,
    over: Indices,
    width: float,
    material: Material,
    size: float,
) -> Rods:
    """Make elastic rods of lines on a surface, cut into equal segments of about a given size.

    Parameters
    ----------
    lines : (n, 3) points of each ribbon; a closed one does not repeat its first
    normals : (n, 3) normal of the surface on the piece from each point to the next
    crossings : of the ribbons, by arclength, and whether they are closed
    over : (C,) 0 or 1: which of the two lies above
    width, material : of the section
    size : length of a segment

    Raises
    ------
    RodError
        If a ribbon is too short for a segment, or the sides are not zeros and ones.
    """
    chains = []
    for number, (line, normal) in enumerate(zip(lines, normals, strict=True)):
        closed = bool(crossings.closed[number])
        points = np.concatenate([line, line[:1]]) if closed else line
        facing = np.concatenate([normal, normal[:1]]) if closed else normal
        chains.append(_resampled(points, facing, closed, size, width, number))
    return _joined(chains, crossings, over, material, width)


def _resampled(
    points: Vectors, normals: Vectors, closed: bool, size: float, width: float, number: int
) -> _Chain:
    """Cut a polyline into equal pieces of its length; a director is the mean normal along its piece."""
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    place = np.concatenate([[0.0], np.cumsum(length)])
    count = max(int(np.round(place[-1] / size)), 3 if closed else 1)
    knots = np.linspace(0.0, place[-1], count + 1)
    at = np.column_stack([np.interp(knots, place, points[:, x]) for x in range(3)])
    # The face of a point is that of the segment that starts there, so its normal holds for the whole of it.
    swept = np.concatenate([np.zeros((1, 3)), np.cumsum(normals[:-1] * length[:, None], axis=0)])
    mean = np.diff(np.column_stack([np.interp(knots, place, swept[:, x]) for x in range(3)]), axis=0)
    vertices = at[:-1] if closed else at
    return _mended(_Chain(vertices, mean, np.full(count, width), closed, knots), f"ribbon {number}")


def rods_of_file(
    file: RodFile, over: ArrayLike | None = None, *, poisson: float = 0.3, effort: int = interlacing.EFFORT
) -> Rods:
    """Make elastic rods of the contents of a .rod file, as they are, with the file's vertices and lengths.

    A file's directors may change their sign from segment to segment. They are turned to agree along each rod,
    then across contacts from rod to rod. The stiffness of a crossing in the file belongs to RibbonSim's
    contacts, which are not those of the paper; it is not used.

    Parameters
    ----------
    file : what `geoweave.rods.rod_file.read_rods` returns
    over : (C,) 0 or 1: which rod of each crossing lies above; a file does not say. If not given, the choice
        that alternates most often
    poisson : Poisson's ratio, which is not in the file either
    effort : counted steps for the proof that no choice alternates more often

    Raises
    ------
    RodError
        If there is no rod, a rod is nothing but coinciding vertices, or the sides are not zeros and ones.

    Examples
    --------
    >>> rods = gw.elastic_rods(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)).rods
    >>> len(gw.rods.rods_of_file(gw.rods.file_of_rods(rods))) == len(rods)
    True
    """
    if not file.rods:
        raise RodError("there is no rod in the file; export it again")
    placed = file.placed()
    sides = interlacing.optimal(placed, effort).over if over is None else np.asarray(over)
    chains = []
    for number, rod in enumerate(file.rods):
        knots = np.concatenate([[0.0], np.cumsum(rod.lengths)])
        ends = np.roll(rod.centerline, -1, axis=0)[: rod.segments]
        tangents = (ends - rod.centerline[: rod.segments]) / rod.lengths[:, None]
        angles = np.asarray(rod.angles)[:, None]
        turned = np.cos(angles) * rod.directors + np.sin(angles) * np.cross(tangents, rod.directors)
        chains.append(_mended(_Chain(rod.centerline, turned, rod.widths, rod.closed, knots), f"rod {number}"))
    material = Material(file.thickness, file.young, poisson, file.density)
    near = float(np.mean(np.concatenate([rod.widths for rod in file.rods])))
    return _joined(chains, placed, sides.astype(np.int64), material, near, agree=True)


def _ends(points: Vectors, closed: bool) -> Vectors:
    """Segment vectors of one chain."""
    return np.diff(np.concatenate([points, points[:1]]) if closed else points, axis=0)


def _mended(chain: _Chain, name: str) -> _Chain:
    """Merge vertices that coincide and spikes that fold back, make directors unit and square."""
    points, directors, widths, closed, knots = chain
    while True:
        edges = _ends(points, closed)
        length = np.linalg.norm(edges, axis=1)
        m = len(length)
        if m < (3 if closed else 1) or not length.max(initial=0.0) > 0:
            raise RodError(f"{name} is too short for a rod once coinciding vertices are merged; leave it out")
        with np.errstate(invalid="ignore", divide="ignore"):
            tangents = edges / length[:, None]
        ahead = np.roll(np.arange(m), -1) if closed else np.arange(1, m)
        cosine = (tangents[: len(ahead)] * tangents[ahead]).sum(axis=1)
        tiny = ~(length > SHORTEST * length.mean())
        spike = np.flatnonzero(~(cosine > FOLDED) & ~tiny[: len(ahead)] & ~tiny[ahead])
        if tiny.any():
            first = int(np.flatnonzero(tiny)[0])
            if first + 1 == m and not closed:
                first -= 1
        elif len(spike):
            first = int(spike[0])
        else:
            break
        points, directors, widths, knots = _without(points, directors, widths, knots, length, first, closed)
    tangents = edges / length[:, None]
    square = directors - (directors * tangents).sum(axis=1)[:, None] * tangents
    size: Scalars = np.linalg.norm(square, axis=1)
    flat = ~(size > 1e-9 * np.linalg.norm(directors, axis=1).max())
    if flat.all():
        raise RodError(f"{name} has no direction square to it that could be its thickness; leave it out")
    for s in np.flatnonzero(flat):  # a segment that points along its normal takes its neighbour's director
        near = int(np.flatnonzero(~flat)[np.argmin(np.abs(np.flatnonzero(~flat) - s))])
        there = (square / size[:, None])[near][None]
        square[s] = parallel_transport(tangents[near][None], tangents[s][None], there)[0]
        size[s] = np.linalg.norm(square[s])
    return _Chain(points, square / size[:, None], widths, closed, knots)


def _without(
    points: Vectors,
    directors: Vectors,
    widths: Scalars,
    knots: Scalars,
    length: Scalars,
    first: int,
    closed: bool,
) -> tuple[Vectors, Vectors, Scalars, Scalars]:
    """Leave out the vertex between a segment and the next, and join the two segments."""
    m = len(length)
    if m < 2:
        return points[:0], directors[:0], widths[:0], knots[:0]
    after = (first + 1) % m
    weight = length[[first, after]] + 1e-300
    sign = 1.0 if directors[first] @ directors[after] >= 0 else -1.0
    joined = (weight[0] * directors[first] + sign * weight[1] * directors[after]) / weight.sum()
    directors, widths = directors.copy(), widths.copy()
    directors[first], widths[first] = joined, weight @ widths[[first, after]] / weight.sum()
    if after == 0:  # the first vertex of a closed rod goes: its start moves to the next
        return (
            points[1:],
            np.concatenate([directors[1:m]]),
            widths[1:m],
            np.concatenate([knots[1:m], [knots[m] + knots[1] - knots[0]]]),
        )
    return (
        np.delete(points, after, axis=0),
        np.delete(directors, after, axis=0),
        np.delete(widths, after),
        np.delete(knots, after),
    )


def _joined(
    chains: Sequence[_Chain],
    crossings: Passages,
    over: Indices,
    material: Material,
    near: float,
    *,
    agree: bool = False,
) -> Rods:
    """Join chains into one set of rods; several crossings of two ribbons at one place become one contact."""
    if over.shape != (len(crossings),) or not np.isin(over, (0, 1)).all():
        raise RodError(f"the sides of {counted(len(crossings), 'crossing')} are that many zeros and ones")
    offsets = np.concatenate([[0], np.cumsum([len(chain.points) for chain in chains])])
    layout = Layout(offsets, np.array([chain.closed for chain in chains]))
    points = np.concatenate([chain.points for chain in chains])
    start, end = layout.ends.T
    edges = points[end] - points[start]
    rest = np.linalg.norm(edges, axis=1)
    whole = np.array([chain.knots[-1] - chain.knots[0] for chain in chains])
    merge = merged(crossings, near, whole)
    kept = merge.passages
    segments, places = _located(chains, layout, kept.ribbons, kept.arclengths)
    apart = segments[:, 0] != segments[:, 1]
    group = np.where(apart, np.cumsum(apart) - 1, -1)[merge.group]
    contacts = Contacts(segments[apart], places[apart], over[merge.kept][apart], frozen(group))
    directors = np.concatenate([chain.directors for chain in chains])
    if agree:
        directors = _agreeing(layout, edges / rest[:, None], directors, contacts)
    widths = np.concatenate([chain.widths for chain in chains])
    return Rods(layout, points, directors, widths, rest, contacts, material)


def _located(
    chains: Sequence[_Chain], layout: Layout, ribbons: Indices, arclengths: NDArray[np.float64]
) -> tuple[Indices, NDArray[np.float64]]:
    """Segment, and place along it, of each (rod, arclength)."""
    segments = np.zeros(ribbons.shape, dtype=np.int64)
    places = np.zeros(ribbons.shape)
    for c, chain in enumerate(chains):
        mine = ribbons == c
        if not mine.any():
            continue
        knots, m = chain.knots, len(chain.knots) - 1
        s = arclengths[mine]
        if chain.closed:
            s = knots[0] + np.mod(s - knots[0], knots[-1] - knots[0])
        at = np.clip(np.searchsorted(knots, s, side="right") - 1, 0, m - 1)
        segments[mine] = layout.segment_offsets[c] + at
        places[mine] = np.clip((s - knots[at]) / (knots[at + 1] - knots[at]), 0.0, 1.0)
    return segments, places


def _agreeing(layout: Layout, tangents: Vectors, directors: Vectors, contacts: Contacts) -> Vectors:
    """Turn directors to the same side along each rod, then from rod to rod along a spanning tree of contacts.

    On a one-sided weave some contacts must disagree, which the energies allow.
    """
    a, b = layout.joints.T
    inner = b > a
    same = (parallel_transport(tangents[a], tangents[b], directors[a]) * directors[b]).sum(axis=1) >= 0
    sign = np.ones(layout.segments)
    sign[b[inner]] = np.where(same[inner], 1.0, -1.0)
    sign = np.cumprod(sign).astype(np.float64)
    first = sign[layout.segment_offsets[:-1]]
    directors = (sign * first[layout.rod_of_segment])[:, None] * directors
    one, two = contacts.segments.T
    alike = (directors[one] * directors[two]).sum(axis=1)
    rods = layout.rod_of_segment[contacts.segments]
    count = len(layout)
    votes = sparse.coo_array((alike, (rods[:, 0], rods[:, 1])), shape=(count, count)).tocsr()
    votes = votes + votes.T
    links = abs(votes)
    links.data = 1.0 / (1e-9 + links.data)  # the shortest tree uses contacts whose directors are most alike
    tree = csgraph.minimum_spanning_tree(links)
    side = np.ones(count)
    seen = np.zeros(count, dtype=bool)
    for root in range(count):
        if seen[root]:
            continue
        order, parent = csgraph.breadth_first_order(tree, root, directed=False)
        for rod in order[1:]:
            side[rod] = side[parent[rod]] * (-1.0 if votes[rod, parent[rod]] < 0 else 1.0)
        seen[order] = True
    return side[layout.rod_of_segment][:, None] * directors


def file_of_rods(rods: Rods) -> RodFile:
    """Return rods as the contents of a .rod file; which rod lies above is not in the format.

    >>> rods = gw.elastic_rods(gw.weave_pattern(gw.shapes.cone(faces=400), ribbons=8)).rods
    >>> len(gw.rods.file_of_rods(rods).crossings) == len(rods.contacts)
    True
    """
    layout, parts = rods.layout, []
    for r in range(len(rods)):
        vertices = slice(layout.offsets[r], layout.offsets[r + 1])
        segments = slice(layout.segment_offsets[r], layout.segment_offsets[r + 1])
        parts.append(
            Rod(
                rods.points[vertices], rods.directors[segments], rods.widths[segments], bool(layout.closed[r])
            )
        )
    pair, places = rods.contacts.segments, rods.contacts.places
    owner = layout.rod_of_segment[pair]
    within = pair - layout.segment_offsets[owner]
    crossings = tuple(
        RodCrossing((a, b), (s, t), (x, y))
        for (a, b), (s, t), (x, y) in zip(owner.tolist(), within.tolist(), places.tolist(), strict=True)
    )
    material = rods.material
    return RodFile(tuple(parts), crossings, material.thickness, material.young, material.density)


def ends_on(rods: Rods, near: Vectors, within: float) -> Flags:
    """(V,) first and last vertices of open rods that lie within a distance of points (N, 3)."""
    from scipy.spatial import KDTree

    flags = np.zeros(rods.layout.vertices, dtype=bool)
    open_rods = ~rods.layout.closed
    ends = np.concatenate([rods.layout.offsets[:-1][open_rods], rods.layout.offsets[1:][open_rods] - 1])
    flags[ends] = KDTree(near).query(rods.points[ends])[0] <= within
    return flags
