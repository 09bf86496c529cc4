"""Where ribbons end: at a crossing that holds them, or at the boundary (Section 5.2)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geoweave.arrays import Flags, Indices, Scalars
from geoweave.curves import Crossings, Curve, Curves, straightest

ROUNDING = 1e-6
"""Share of the mean edge within which a place is another one."""


def extended(curves: Curves, reach: float) -> tuple[Curves, Scalars]:
    """Continue open ends along straightest geodesics, by a length or up to the boundary.

    Returns
    -------
    the longer curves, and (n, 2) arc lengths at which each given curve starts and ends on its longer one
    """
    mesh = curves.mesh
    goes_on = ~on_boundary(curves) & ~curves.closed[:, None]
    first, last = curves.offsets[:-1], curves.offsets[1:] - 1
    tips = [first[goes_on[:, 0]], last[goes_on[:, 1]]]
    # A segment belongs to the point it starts from, so the last one to the last point but one.
    sides = [(tips[0], -curves.segments[tips[0]]), (tips[1] - 1, curves.segments[tips[1] - 1])]
    more = [
        straightest(mesh, curves.faces[at], heading, reach, points=curves.points[tip]) if len(tip) else None
        for tip, (at, heading) in zip(tips, sides, strict=True)
    ]
    number = np.cumsum(goes_on, axis=0) - 1
    longer: list[Curve] = []
    spans = np.stack([np.zeros(len(curves)), curves.lengths], axis=1)
    for c, curve in enumerate(curves):
        whole = curve
        if goes_on[c, 0] and more[0] is not None:
            which = int(number[c, 0])
            spans[c] += more[0].lengths[which]
            whole = turned(joined(turned(whole), more[0][which]))
        if goes_on[c, 1] and more[1] is not None:
            whole = joined(whole, more[1][int(number[c, 1])])
        longer.append(whole)
    return Curves.concatenate(mesh, longer), spans


def turned(line: Curve) -> Curve:
    """An open curve, run through from its end to its start."""
    # Turned round, a segment belongs to the point at its other end.
    faces, sliding = line.faces[:-1][::-1], line.sliding[:-1][::-1]
    return replace(
        line,
        points=line.points[::-1],
        faces=np.append(faces, faces[-1]),
        turning=-line.turning[::-1],
        sliding=np.append(sliding, False),
    )


def joined(one: Curve, other: Curve) -> Curve:
    """Two open curves as one, the second from where the first ends."""
    # The common point belongs to the second curve's segment, but turns as the first says.
    return Curve(
        np.concatenate([one.points, other.points[1:]]),
        np.concatenate([one.faces[:-1], other.faces]),
        np.concatenate([one.turning, other.turning[1:]]),
        np.concatenate([one.sliding, other.sliding[1:]]),
        False,
    )


def off_ideal(angle: Scalars, families: int) -> Scalars:
    """(C,) degrees between each angle, in radians, and the nearest of evenly turned families."""
    turn = 180.0 / families
    degrees = np.degrees(np.abs(angle)) % 180.0
    return np.asarray(np.abs(degrees - np.clip(np.round(degrees / turn), 1, families - 1) * turn))


def holding(met: Crossings, shallowest: float) -> Flags:
    """(C,) whether the two curves of each crossing meet at so many degrees or more."""
    return np.asarray(np.abs(np.sin(met.angle)) >= np.sin(np.radians(shallowest)))


def outermost(met: Crossings, count: int) -> tuple[Scalars, Scalars]:
    """(count,) arc length of the first and the last crossing on each curve, inf and -inf without one."""
    owner, at = met.curves.ravel(), met.arclength.ravel()
    first, last = np.full(count, np.inf), np.full(count, -np.inf)
    np.minimum.at(first, owner, at)
    np.maximum.at(last, owner, at)
    return first, last


def loose_ends(curves: Curves, met: Crossings, tail: float) -> Flags:
    """(n, 2) open ends without a crossing within a tail of them, unless they lie on the boundary."""
    first, last = outermost(met, len(curves))
    away = np.stack([first, curves.lengths - last], axis=1)
    beyond = away > tail + ROUNDING * curves.mesh.mean_edge
    return np.asarray(beyond & ~on_boundary(curves) & ~curves.closed[:, None])


def on_boundary(curves: Curves) -> Flags:
    """(n, 2) whether start and end of each curve lie on the boundary of the surface."""
    return np.asarray(_boundary_sides(curves)[1] >= 0)


def openings_reached(curves: Curves) -> Indices:
    """(n, 2) boundary loop of the surface on which start and end of each open curve lie, -1 for none.

    Loops are counted as in `TriMesh.boundary_loops`. The ends of a closed curve lie on none.
    """
    mesh, (face, side) = curves.mesh, _boundary_sides(curves)
    loop = np.full(mesh.n_vertices, -1, dtype=np.int64)
    for number, vertices in enumerate(mesh.boundary_loops):
        loop[vertices] = number
    reached = loop[mesh.faces[face, (side + 1) % 3]]
    return np.where((side >= 0) & ~curves.closed[:, None], reached, -1)


def _boundary_sides(curves: Curves) -> tuple[Indices, Indices]:
    """(n, 2) face of start and end of each curve, and the side of it on the boundary there, -1 inside."""
    mesh = curves.mesh
    ends = np.stack([curves.offsets[:-1], curves.offsets[1:] - 1], axis=1)
    face, point = curves.faces[ends], curves.points[ends]
    corners = mesh.vertices[mesh.faces[face]]
    found = np.full(ends.shape, -1, dtype=np.int64)
    for k in range(3):
        a, b = corners[..., (k + 1) % 3, :], corners[..., (k + 2) % 3, :]
        along = b - a
        share = np.clip(((point - a) * along).sum(-1) / (along**2).sum(-1), 0.0, 1.0)
        off = np.linalg.norm(point - a - share[..., None] * along, axis=-1)
        found[(mesh.face_neighbors[face, k] < 0) & (off < ROUNDING * mesh.mean_edge)] = k
    return face, found
