"""Whether the finished field on a branched cover is what was asked of it (Section 5.1).

It is compared with the singularities of its RoSy, and records say how it follows a direction and a mirror.

Algorithm 1 cannot undo a branch point: the cover is cut out round it and glued as the RoSy says. It may still
wind once more or once less round the cut, and away from it a vector field on a sheet may become singular.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geoweave.arrays import Complexes, Flags, Indices
from geoweave.fields import FaceField, rotation_across, vertex_indices, windings
from geoweave.surface import connected_components
from geoweave.weave.cover import Cover

__all__ = ["Displaced", "Met", "Mirrored", "displaced", "lifted_vectors"]


class Displaced(NamedTuple):
    """A place whose index in the finished field is another than in the RoSy."""

    vertex: int
    """Of the surface below. Branch points whose punctures touch are one place, which one of them names."""
    numerator: int
    """N times the index in the RoSy."""
    found: int
    """N times the index in the finished field: the sum of what its N vectors turn."""


class Mirrored(NamedTuple):
    """The plane in which a field was made its own mirror image, and how nearly it is."""

    normal: tuple[float, float, float]
    """Of the plane, in the coordinates of the mesh file."""
    surface: float
    """Root mean square distance between the surface and its image, in bounding radii."""
    field: float
    """Mean angle between the finished field and its image, degrees."""


class Met(NamedTuple):
    """How far the finished field is what was asked of it."""

    displaced: tuple[Displaced, ...] | None = None
    """Where it differs from prescribed singularities; None where none were prescribed."""
    aligned: float | None = None
    """Mean angle from the direction or curve to the nearest family, degrees; None without one."""
    mirrored: Mirrored | None = None
    """How nearly it is its own mirror image; None where that was not asked for."""


def lifted_vectors(cover: Cover, field: FaceField) -> tuple[Indices, Complexes]:
    """(F',) faces that were not cut out, and (F', N) the vectors there of a field on the quotient."""
    quotient, count = cover.quotient, len(cover.part.faces)
    values = quotient.signs * field.values[quotient.faces]
    return cover.part.faces, values.reshape(cover.degree, count).T


def displaced(cover: Cover, field: FaceField) -> tuple[Displaced, ...]:
    """Find where a field on the quotient of a cover winds otherwise than the RoSy.

    Round a puncture, where a vector comes back as another, N turns of the loop are added up: the field winds
    ``N chi + sum of windings`` times round a region of Euler characteristic chi that was cut out.

    Parameters
    ----------
    cover : the cover
    field : of Algorithm 1, on `Cover.quotient`

    Returns
    -------
    The places, by their vertex; none if all singularities were kept. Punctures that touch the boundary of
    the surface are left out: what belongs to the boundary cannot be told from them.
    """
    quotient, whole = cover.quotient, cover.rosy.mesh
    lifted = FaceField(cover.mesh, quotient.signs * field.values[quotient.faces])
    numerators = cover.rosy.index_numerators
    inside = np.zeros(whole.n_vertices, dtype=np.int64)
    np.add.at(inside, cover.vertices, vertex_indices(lifted))
    region = _regions(cover)
    found = [
        Displaced(int(v), int(numerators[v]), int(inside[v]))
        for v in np.flatnonzero((inside != numerators) & (region < 0) & ~whole.boundary_vertices)
    ]
    rim = cover.mesh.boundary_vertices
    winding = np.where(rim, windings(cover.mesh, rotation_across(lifted)), 0.0)
    for each in range(int(region.max(initial=-1)) + 1):
        own = region == each
        if whole.boundary_vertices[own].any():
            continue
        around = float(winding[own[cover.vertices]].sum())
        total = round(cover.degree * _characteristic(cover, own) + around)
        due = int(numerators[own].sum())
        if total != due:
            vertex = int(np.flatnonzero(own & (numerators != 0))[0])
            found.append(Displaced(vertex, due, total))
    return tuple(sorted(found))


def _regions(cover: Cover) -> Indices:
    """(V,) region of faces that were cut out, faces that share a vertex being in one; -1 elsewhere."""
    whole = cover.rosy.mesh
    cut = whole.faces[~cover.part.kept]
    region = np.full(whole.n_vertices, -1, dtype=np.int64)
    if len(cut):
        joined = connected_components(np.concatenate([cut[:, :2], cut[:, 1:]]), whole.n_vertices)
        touched = np.unique(cut)
        region[touched] = np.unique(joined[touched], return_inverse=True)[1]
    return region


def _characteristic(cover: Cover, own: Flags) -> int:
    """Euler characteristic of the faces of one region that were cut out."""
    faces = cover.rosy.mesh.faces[~cover.part.kept]
    faces = faces[own[faces].all(axis=1)]
    sides = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    return len(np.unique(faces)) - len(np.unique(sides, axis=0)) + len(faces)
