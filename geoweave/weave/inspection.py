"""Where a weave will be hard to make, and how wide its ribbons can be (Sections 5.2 and 6).

The paper notes that its model does nothing about the width of ribbons (footnote 5). This is what a maker
would otherwise find out at the bench: each place with its position and the ribbons that meet there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from geoweave.arrays import Flags, Indices, Scalars, Vectors
from geoweave.compiled import compiled
from geoweave.curves import Curves
from geoweave.errors import FieldError
from geoweave.surface import BoxTree, nearest, segment_tree
from geoweave.weave.validity import violations
from geoweave.weave.weave import Weave
from geoweave.weave.widths import Neighbours

__all__ = ["FORMAT", "KINDS", "VERSION", "Inspection", "Limits", "Place", "inspected"]

FORMAT, VERSION = "geoweave-report", 1
"""What the first lines of ``report.json`` say."""

KINDS = {
    "near_parallel": "crossings at a small angle; value: the angle, degrees",
    "alongside": "ribbons that run side by side and overlap; value: the length of the stretch",
    "lap": "ends that lie on each other, one ribbon going on where the other stops; value: the length",
    "crowded": "crossings next to each other that overlap; value: the width that would fit between them",
    "knot": "short ribbons that hold mostly each other; value: how many of them",
    "gap": "holes; value: how far their middle is from the nearest ribbon",
    "loose_end": "ends that nothing holds; value: the length beyond the last crossing",
    "bare_component": "pieces of the surface without any ribbon; value: the area",
}
"""The kinds of places that will not weave, and what is measured there."""

SHARES = (0.95, 0.75, 0.5, 0.25)
"""Shares of the neighbouring crossings for which the report says up to which width they fit."""

STEP = 0.05
"""Least distance between the samples of ribbons that run alongside each other, in spacings."""


HEAP = 3
"""Short ribbons that make a knot."""


@dataclass(frozen=True)
class Limits:
    """From where on a place is reported.

    Attributes
    ----------
    angle : degrees; ribbons that meet or run alongside each other at less are near parallel
    gap : spacings; a place of the surface farther than this from any ribbon is a hole. In a flat triaxial
        weave no place is farther than 0.5
    short : spacings; three open ribbons or more, no longer than this, that cross each other are a knot
    fitting : share of the neighbouring crossings that fit side by side at the suggested width. Three families
        often cross nearly in one point, and then three ribbons lie on each other: at the width in RibbonSim's
        file of the torus that the authors made half of the neighbouring crossings fit, on their cone all

    Raises
    ------
    FieldError
        If a number is out of range.
    """

    angle: float = 20.0
    gap: float = 1.0
    fitting: float = 0.5
    short: float = 6.0

    def __post_init__(self) -> None:
        for name, value, most in (
            ("angle", self.angle, 90),
            ("gap", self.gap, np.inf),
            ("fitting", self.fitting, 1),
            ("short", self.short, np.inf),
        ):
            if not 0 < value <= most or value == np.inf:
                raise FieldError(f"the limit '{name}' of an inspection is out of range: {value}")


class Place(NamedTuple):
    """A place that will not weave."""

    kind: str
    """One of `KINDS`."""
    point: tuple[float, float, float]
    """Where, in the unit of the weave."""
    ribbons: tuple[str, ...]
    """Names of the ribbons that meet there."""
    value: float
    """What `KINDS` says."""


@dataclass(frozen=True, eq=False)
class Inspection:
    """What a maker should know before cutting.

    Attributes
    ----------
    weave : the weave
    limits : from where on a place was reported
    suggested_width : the largest at which the wanted share of the neighbouring crossings fits, in the unit of
        the weave; nothing where no ribbon has two crossings
    widths : (share, width) up to which width a share of the neighbouring crossings fits, in that unit
    share_that_fits : of the neighbouring crossings at the width of the weave, 1 where there are none
    places : those that will not weave, by kind, the worst first
    violations : rules of a valid weave that it breaks (`geoweave.weave.validity`), nothing for a valid one
    """

    weave: Weave
    limits: Limits
    suggested_width: float | None
    widths: tuple[tuple[float, float], ...]
    share_that_fits: float
    places: tuple[Place, ...]
    violations: tuple[str, ...]

    @property
    def counts(self) -> dict[str, int]:
        """Number of places of each kind."""
        return {kind: sum(place.kind == kind for place in self.places) for kind in KINDS}

    def document(self) -> dict[str, Any]:
        """The contents of ``report.json``."""
        metrics = self.weave.metrics()
        spacing = metrics["spacing"]
        return {
            "format": FORMAT,
            "version": VERSION,
            "units": self.weave.units,
            "ribbons": metrics["ribbons"],
            "crossings": metrics["crossings"],
            "total_length": metrics["total_length"],
            **({"metres": metrics["metres"]} if "metres" in metrics else {}),
            "spacing": spacing,
            "width": self.weave.width * self.weave.placement.scale,
            "thickness": self.weave.thickness * self.weave.placement.scale,
            "suggested_width": self.suggested_width,
            "share_that_fits": self.share_that_fits,
            "widths_that_fit": [{"share": share, "width": width} for share, width in self.widths],
            "crossing_angle_deg": metrics["crossing_angle_deg"],
            "alternation": metrics["alternation"],
            "limits": {
                "angle_deg": self.limits.angle,
                "gap": self.limits.gap * spacing,
                "short": self.limits.short * spacing,
                "fitting": self.limits.fitting,
            },
            "violations": list(self.violations),
            "counts": self.counts,
            "kinds": KINDS,
            "places": [
                {
                    "kind": each.kind,
                    "point": list(each.point),
                    "ribbons": list(each.ribbons),
                    "value": each.value,
                }
                for each in self.places
            ],
        }


def inspected(weave: Weave, limits: Limits | None = None) -> Inspection:
    """Look for the places of a weave that will not weave at its width.

    Positions and lengths come in the unit of the weave. Distances are straight ones, to ribbons on the same
    side of a thin wall; holes are found at vertices and middles of faces, to within half an edge.
    """
    asked = limits or Limits()
    unit = weave.placement.scale
    pairs = Neighbours(weave)
    widths = [(share, pairs.fitting(share) * unit) for share in SHARES] if len(pairs.widths) else []
    suggested = pairs.fitting(asked.fitting) * unit if widths else None
    fits = float((pairs.widths >= weave.width).mean()) if widths else 1.0
    found = [
        *_near_parallel(weave, asked.angle),
        *_alongside(weave, asked.angle),
        *_crowded(weave, pairs, asked.angle),
        *_knots(weave, asked.short),
        *_gaps(weave, asked.gap),
        *_loose_ends(weave),
        *_bare_components(weave),
    ]
    broken = tuple(violations(weave.ribbons, weave.interlacing.over))
    return Inspection(weave, asked, suggested, tuple(widths), fits, tuple(found), broken)


def _places(
    weave: Weave,
    kind: str,
    points: Vectors,
    ribbons: list[tuple[int, ...]],
    values: Scalars,
    least_first: bool,
) -> list[Place]:
    """Places in the unit and with the names of the weave, the worst first."""
    names, where = weave.names, weave.placement.undo(points).tolist()
    order = np.argsort(values if least_first else -values, kind="stable")
    return [
        Place(kind, tuple(where[k]), tuple(names[c] for c in ribbons[k]), float(values[k]))
        for k in order.tolist()
    ]


def _near_parallel(weave: Weave, limit: float) -> list[Place]:
    angle, met = weave.crossing_angles, weave.ribbons.crossings
    small = np.flatnonzero(angle < limit)
    owners = [tuple(pair) for pair in met.curves[small].tolist()]
    return _places(weave, "near_parallel", met.points[small], owners, angle[small], True)


def _crowded(weave: Weave, pairs: Neighbours, limit: float) -> list[Place]:
    """Neighbouring crossings that overlap at the width, but for those that are near parallel anyway."""
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
    return _places(weave, "crowded", middle, ribbons, values, True)


def _knots(weave: Weave, limit: float) -> list[Place]:
    """Heaps of three or more short ribbons that cross each other, at the crossing nearest to the middle."""
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
        places = met.points[inner[heap[pairs[:, 0]] == which]]
        points[k] = places[np.linalg.norm(places - places.mean(axis=0), axis=1).argmin()]
        owners.append(tuple(np.flatnonzero(short & (heap == which)).tolist()))
    return _places(weave, "knot", points, owners, size[large].astype(np.float64), False)


def _loose_ends(weave: Weave) -> list[Place]:
    curves, met = weave.ribbons.curves, weave.ribbons.crossings
    ribbon, end = np.nonzero(weave.ribbons.loose)
    points = curves.points[np.where(end == 0, curves.offsets[ribbon], curves.offsets[ribbon + 1] - 1)]
    owner, at = met.curves.ravel(), met.arclength.ravel()
    first, last = np.full(len(curves), np.inf), np.full(len(curves), -np.inf)
    np.minimum.at(first, owner, at)
    np.maximum.at(last, owner, at)
    beyond = np.where(end == 0, first[ribbon], curves.lengths[ribbon] - last[ribbon])
    # A ribbon that crosses nothing is loose all along.
    beyond = np.minimum(beyond, curves.lengths[ribbon]) * weave.placement.scale
    return _places(weave, "loose_end", points, [(c,) for c in ribbon.tolist()], beyond, False)


def _alongside(weave: Weave, limit: float) -> list[Place]:
    """Stretches on which two strands run near parallel with less than a width between their centrelines.

    Where one ends and the other begins, the two lap.
    """
    ribbons, width = weave.ribbons, weave.width
    step = max(0.5 * width, STEP * ribbons.spacing)
    where, at, owner, heading, up = _samples(ribbons.curves, step)
    near = cKDTree(where).query_pairs(float(np.hypot(width, step)), output_type="ndarray")
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
    other = (owner[a] != owner[b]) | (apart > 4.0 * (width + step))
    kept = (np.abs(along) <= step) & (distance < width) & other
    a, b, distance = a[kept], b[kept], distance[kept]
    order = np.lexsort((at[a], owner[b], owner[a]))
    a, b, distance = a[order], b[order], distance[order]
    if not len(a):
        return []
    pair = np.stack([owner[a], owner[b]], axis=1)
    new = np.ones(len(a), dtype=bool)
    new[1:] = (np.diff(pair, axis=0) != 0).any(axis=1) | (np.diff(at[a]) > 3.0 * step)
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
        found += _places(weave, kind, middle[which], [owners[k] for k in which], lengths[which], False)
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


def _samples(curves: Curves, step: float) -> tuple[Vectors, Scalars, Indices, Vectors, Vectors]:
    """Points at about equal distances: place, arc length, ribbon, direction, and normal of the surface."""
    number = np.maximum(np.ceil(curves.lengths / step).astype(np.int64), 1)
    owner = np.repeat(np.arange(len(curves)), number)
    rank = np.arange(len(owner)) - np.repeat(np.cumsum(number) - number, number)
    at = (rank + 0.5) * (curves.lengths / number)[owner]
    # One coordinate that grows over all curves finds every segment at once.
    begin = np.cumsum(curves.lengths) - curves.lengths
    segment = (
        np.searchsorted(curves.arclength + begin[curves.curve_of_point], at + begin[owner], side="right") - 1
    )
    segment = np.clip(segment, curves.offsets[owner], curves.offsets[owner + 1] - 1)
    length = np.maximum(curves.segment_lengths[segment], 1e-300)
    heading = curves.segments[segment] / length[:, None]
    where = curves.points[segment] + (at - curves.arclength[segment])[:, None] * heading
    return where, at, owner, heading, curves.normals[segment]


def _gaps(weave: Weave, limit: float) -> list[Place]:
    """Middles of the holes: one place for each piece of the surface that is too far from any ribbon."""
    mesh, curves = weave.mesh, weave.ribbons.curves
    points = np.concatenate([mesh.vertices, mesh.barycenters])
    normals = np.concatenate([mesh.vertex_normals, mesh.face_normals])
    running = np.flatnonzero(curves.segment_lengths > 0)
    ends = np.stack([curves.points[running], curves.points[curves.following[running]]], axis=1)
    tree = segment_tree(ends)._replace(normals=np.ascontiguousarray(curves.normals[running]))
    covered = np.isin(mesh.face_components, mesh.face_components[curves.faces])
    asked = np.concatenate([covered[_a_face(mesh.faces, mesh.n_vertices)], covered])
    distance = np.zeros(len(points))
    distance[asked], piece = _distances(tree, points[asked], normals[asked])
    far = distance > limit * weave.ribbons.spacing
    if not far.any():
        return []
    # Vertices and faces that touch, faces as points after the vertices.
    face = mesh.n_vertices + np.repeat(np.arange(mesh.n_faces), 3)
    links = np.concatenate([np.stack([face, mesh.faces.ravel()], axis=1), mesh.edges])
    links = links[far[links].all(axis=1)]
    graph = sparse.coo_array((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(len(points),) * 2)
    label = csgraph.connected_components(graph, directed=False)[1][far]
    inside = np.flatnonzero(far)
    order = np.lexsort((inside, -distance[inside], label))
    middle = inside[order[np.unique(label[order], return_index=True)[1]]]
    pieces = np.full(len(points), -1)
    pieces[asked] = piece
    owner = curves.curve_of_point[running[pieces[middle]]].tolist()
    values = distance[middle] * weave.placement.scale
    return _places(weave, "gap", points[middle], [(c,) for c in owner], values, False)


def _a_face(faces: Indices, count: int) -> Indices:
    """(V,) one of the faces at each vertex."""
    found = np.zeros(count, dtype=np.int64)
    found[faces.ravel()] = np.repeat(np.arange(len(faces)), 3)
    return found


@compiled
def _distances(tree: BoxTree, points: Vectors, normals: Vectors) -> tuple[Scalars, Indices]:
    """Distance to the nearest piece on the same side, or to any where there is none; and that piece."""
    distance, piece = np.empty(len(points)), np.empty(len(points), dtype=np.int64)
    found, anywhere = np.empty(3), np.zeros(3)
    for i in range(len(points)):
        piece[i] = nearest(tree, points[i], normals[i], found)
        if piece[i] < 0:
            piece[i] = nearest(tree, points[i], anywhere, found)
        distance[i] = np.sqrt(((found - points[i]) ** 2).sum())
    return distance, piece


def _bare_components(weave: Weave) -> list[Place]:
    mesh = weave.mesh
    part = mesh.face_components
    area = np.zeros(mesh.n_components)
    np.add.at(area, part, mesh.face_areas)
    bare = np.setdiff1d(part, part[weave.ribbons.curves.faces])
    # A face of the component, so that the place is on the surface.
    first = np.unique(part, return_index=True)[1][bare]
    values = area[bare] * weave.placement.scale**2
    return _places(weave, "bare_component", mesh.barycenters[first], [()] * len(bare), values, False)
