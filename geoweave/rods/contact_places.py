"""Where the contacts of rods lie: moved to where ribbons cross now, some of them, the outermost ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geoweave.arrays import Flags, Indices, Scalars, Vectors
from geoweave.rods.rods import Contacts, Rods

__all__ = ["chosen", "outermost", "replaced_contacts"]

NEARBY = 3
"""A contact looks for its new place this many segments to each side."""

PARALLEL = 1e-12
"""Two segments are parallel if the squared sine of the angle between them is below this."""


def chosen(contacts: Contacts, flags: Flags) -> Contacts:
    """Some of the contacts."""
    return Contacts(contacts.segments[flags], contacts.places[flags], contacts.over[flags])


def outermost(rods: Rods) -> Flags:
    """(C,) whether a contact is the first or the last of an open rod."""
    layout, contacts = rods.layout, rods.contacts
    rod = layout.rod_of_segment[contacts.segments]
    place = (contacts.segments + contacts.places).ravel()
    order = np.lexsort((place, rod.ravel()))
    ranked = rod.ravel()[order]
    begins = np.flatnonzero(np.diff(ranked, prepend=-1))
    ends = np.append(begins[1:], len(ranked)) - 1 if len(ranked) else begins
    found = order[np.concatenate([begins, ends])]
    found = found[~layout.closed[rod.ravel()[found]]]
    flags = np.zeros(len(contacts), dtype=bool)
    flags[found // 2] = True
    return flags


def replaced_contacts(rods: Rods, holding: Flags | None = None) -> Contacts:
    """Move each contact to where its two rods are closest now, at most `NEARBY` segments away.

    Contacts that hold, flags (C,), keep their places on both rods.
    """
    layout, contacts = rods.layout, rods.contacts
    if not len(contacts):
        return contacts
    shifts = np.arange(-NEARBY, NEARBY + 1)
    one = _neighbours(rods, contacts.segments[:, 0], shifts)
    two = _neighbours(rods, contacts.segments[:, 1], shifts)
    count, m = one.shape
    a, b = np.repeat(one, m, axis=1).ravel(), np.tile(two, m).ravel()
    start = rods.points[layout.ends[:, 0]]
    edges = rods.points[layout.ends[:, 1]] - start
    s, t = _closest_places(start[a], edges[a], start[b], edges[b])
    gap = (start[a] - start[b]) + s[:, None] * edges[a] - t[:, None] * edges[b]
    distance = (gap**2).sum(axis=1).reshape(count, -1)
    distance[(a == b).reshape(count, -1)] = np.inf
    best = np.arange(count) * m * m + np.argmin(distance, axis=1)
    segments, places = np.column_stack([a[best], b[best]]), np.column_stack([s[best], t[best]])
    if holding is not None:
        keep = holding[:, None]
        segments = np.where(keep, contacts.segments, segments)
        places = np.where(keep, contacts.places, places)
    return replace(contacts, segments=segments, places=places)


def _neighbours(rods: Rods, segments: Indices, shifts: Indices) -> Indices:
    """(C, m) segments of the same rod a few before and after; at an open end the last one is repeated."""
    layout = rods.layout
    rod = layout.rod_of_segment[segments][:, None]
    first, past = layout.segment_offsets[rod], layout.segment_offsets[rod + 1]
    at = segments[:, None] + shifts
    around = first + np.mod(at - first, past - first)
    return np.where(layout.closed[rod], around, np.clip(at, first, past - 1))


def _closest_places(p: Vectors, u: Vectors, q: Vectors, v: Vectors) -> tuple[Scalars, Scalars]:
    """Places, 0 to 1, at which the segments from p along u and from q along v are closest."""
    w = p - q
    uu, uv, vv = (u * u).sum(axis=1), (u * v).sum(axis=1), (v * v).sum(axis=1)
    uw, vw = (u * w).sum(axis=1), (v * w).sum(axis=1)
    determinant = uu * vv - uv**2
    safe = np.maximum(determinant, PARALLEL * uu * vv)
    s = np.clip((uv * vw - vv * uw) / safe, 0.0, 1.0)
    t = np.clip((uv * s + vw) / vv, 0.0, 1.0)
    s = np.clip((uv * t - uw) / uu, 0.0, 1.0)
    return s, t
