"""Ordered domains of a field and the walls between them (Sections 4.1.2 and 4.1.4, Figs. 5, 9 and 10)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Flags, Indices, Scalars, frozen
from geoweave.errors import FieldError
from geoweave.fields import FaceField, rotation_across
from geoweave.surface import TriMesh

WALL_ANGLE = 10.0
"""Degrees by which a field turns across an edge of a wall; a fan turns less, six edges from its centre."""


@dataclass(frozen=True, eq=False)
class Domains:
    """The parts into which a field falls when the mesh is cut along its walls.

    Attributes
    ----------
    mesh : the surface
    walls : (E_int,) whether each interior edge belongs to a wall
    of_face : (F,) domain of each face, numbered from 0
    """

    mesh: TriMesh
    walls: Flags
    of_face: Indices

    @cached_property
    def areas(self) -> Scalars:
        """(domains,) area of each domain."""
        return frozen(np.asarray(np.bincount(self.of_face, self.mesh.face_areas), dtype=np.float64))

    @property
    def effective_number(self) -> float:
        """``A^2 / sum A_d^2``: the number of domains, weighted by area; n for n domains of equal area.

        Unlike the plain number it hardly counts the tiny domains along a wall.
        """
        return float(self.areas.sum() ** 2 / (self.areas**2).sum())

    @property
    def wall_length(self) -> float:
        """Total length of the wall edges."""
        return float(self.mesh.edge_lengths[self.mesh.interior_edges][self.walls].sum())


def ordered_domains(field: FaceField, angle: float = WALL_ANGLE) -> Domains:
    """Cut the surface along the edges across which the field turns by more than an angle.

    Parameters
    ----------
    field : the field, lengths do not matter
    angle : degrees, between 0 and 180

    Raises
    ------
    FieldError
        If the angle is out of range.
    """
    if not 0 < angle < 180:
        raise FieldError(f"a wall turns the field by an angle between 0 and 180 degrees, not {angle}")
    mesh = field.mesh
    walls = np.abs(rotation_across(field)) > np.radians(angle)
    i, j = mesh.edge_faces[mesh.interior_edges[~walls]].T
    graph = sparse.coo_array((np.ones(len(i), dtype=np.int8), (i, j)), shape=(mesh.n_faces,) * 2)
    of_face = csgraph.connected_components(graph, directed=False)[1].astype(np.int64)
    return Domains(mesh, frozen(walls), frozen(of_face))


def worst_share(values: Scalars, part: float = 0.01) -> float:
    """Share of the sum of ``|values|`` in the fraction ``part`` of largest ones; 1 if the rest is zero."""
    size = np.sort(np.abs(values))[::-1]
    return float(size[: max(1, round(part * len(size)))].sum() / size.sum())


def area_holding(mesh: TriMesh, density: Scalars, share: float = 0.9) -> float:
    """Smallest fraction of the area that holds a share of the integral of ``|density|``, density (F,).

    It is near ``share`` for an even density and near 0 for a sparse one, such as the ``|delta|^2`` of a
    sharpened field (Section 4.1.4).
    """
    order = np.argsort(-np.abs(density), kind="stable")
    held = np.cumsum((mesh.face_areas * np.abs(density))[order])
    count = int(np.searchsorted(held, share * held[-1])) + 1
    return float(mesh.face_areas[order[:count]].sum() / mesh.face_areas.sum())
