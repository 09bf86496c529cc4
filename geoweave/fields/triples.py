"""Three sheets over one place: the faces whose directions are 120 degrees apart (Section 5.1).

For N sheets there are N directions, spanned over the whole numbers by as many of them as numbers below N are
prime to it. Where families are fewer, as for N = 4, their phases only shift the pattern. Where three families
cross at 60 degrees, which takes an N that 3 divides, the third phase decides whether three ribbons meet in a
point. For N = 5 there is one relation too, of all five; but no pattern of five families repeats, and no phase
keeps ribbons from nearly meeting somewhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geoweave.arrays import Indices, Scalars, frozen
from geoweave.errors import FieldError
from geoweave.surface import Part, TriMesh, connected_components


@dataclass(frozen=True, eq=False)
class Triples:
    """Which faces of a surface lie over one another, three by three, with directions 120 degrees apart.

    Attributes
    ----------
    mesh : the surface, some of N sheets of another
    faces : (T, 3) three faces that are copies of one, corner by corner and frame by frame
    signs : (T, 3) with which their vectors, and their theta, are taken
    ribbons : level sets in one turn of theta: 2 where opposite sheets are taken for one, else 1

    Raises
    ------
    FieldError
        If the shapes do not fit, or the number of ribbons is neither 1 nor 2.
    """

    mesh: TriMesh
    faces: Indices
    signs: Scalars
    ribbons: int

    def __post_init__(self) -> None:
        """Refuse what is not three faces each."""
        if self.faces.ndim != 2 or self.faces.shape[1] != 3 or self.signs.shape != self.faces.shape:
            raise FieldError(
                f"a phase is that of three faces: faces and signs must have shape (T, 3), not "
                f"{self.faces.shape} and {self.signs.shape}"
            )
        if self.ribbons not in (1, 2):
            raise FieldError(f"one turn of theta holds 1 or 2 ribbons, not {self.ribbons}")

    def on(self, part: Part) -> Triples:
        """The triples of which all three faces are in a part of the surface.

        Raises
        ------
        FieldError
            If it is a part of another surface.
        """
        if part.whole is not self.mesh:
            raise FieldError("the part is not one of the surface that the triples belong to")
        place = np.full(self.mesh.n_faces, -1, dtype=np.int64)
        place[part.faces] = np.arange(len(part.faces))
        faces = place[self.faces]
        there = (faces >= 0).all(axis=1)
        return Triples(part.mesh, frozen(faces[there]), frozen(self.signs[there]), self.ribbons)

    @cached_property
    def corners(self) -> tuple[Indices, Scalars, Scalars]:
        """The vertices that lie over one another, (R, 3), their signs, (R, 3), and the area of each, (R,)."""
        mesh = self.mesh
        vertex = mesh.faces[self.faces].transpose(0, 2, 1).reshape(-1, 3)
        sign = self.signs[:, :, None] * mesh.bundle.corners[self.faces]
        sign = sign.transpose(0, 2, 1).reshape(-1, 3).astype(np.int64)
        order = np.argsort(vertex, axis=1)
        vertex = np.take_along_axis(vertex, order, axis=1)
        sign = np.take_along_axis(sign, order, axis=1)
        if self.ribbons == 2:  # where phi is right, -phi is
            sign = sign * sign[:, :1]
        rows, row = np.unique(np.hstack([vertex, sign]), axis=0, return_inverse=True)
        area = np.repeat(mesh.face_areas[self.faces[:, 0]] / 3.0, 3)
        mass = np.bincount(row.ravel(), area, len(rows))
        return frozen(rows[:, :3]), frozen(rows[:, 3:].astype(np.float64)), frozen(np.asarray(mass))

    @cached_property
    def groups(self) -> Indices:
        """(components,) number of the group of each component: those that lie over one another."""
        component = self.mesh.face_components[self.faces]
        pairs = np.concatenate([component[:, :2], component[:, 1:]])
        return frozen(connected_components(pairs, self.mesh.n_components))

    @cached_property
    def places(self) -> Indices:
        """(V + F,) number of the place of each vertex and each face: over one place lie up to three."""
        vertex, face = self.corners[0], self.mesh.n_vertices + self.faces
        pairs = np.concatenate([vertex[:, :2], vertex[:, 1:], face[:, :2], face[:, 1:]])
        return frozen(connected_components(pairs, self.mesh.n_vertices + self.mesh.n_faces))
