"""Surfaces whose fields, forms and potentials are odd: they change sign on the way round some loops."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from geoweave.arrays import Indices, Scalars, Triangles, Vectors, frozen
from geoweave.errors import MeshError
from geoweave.surface.mesh import TriMesh
from geoweave.surface.sign_bundle import SignBundle
from geoweave.wording import counted


@dataclass(frozen=True, eq=False)
class TwistedMesh(TriMesh):
    """A mesh with a sign at every corner: how the face there sees the odd value of the vertex (`SignBundle`).

    Attributes
    ----------
    signs : (F, 3) +1 where the face sees the value as it is, -1 where it sees its opposite

    Raises
    ------
    MeshError
        As `TriMesh`, and if the signs do not fit the faces, or two faces compare their signs differently at
        the two ends of a shared edge.
    """

    signs: Scalars = field(kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        signs = np.array(self.signs, dtype=np.float64)
        if signs.shape != self.faces.shape or not (np.abs(signs) == 1.0).all():
            raise MeshError(f"signs must be +1 or -1 and have shape {self.faces.shape}, not {signs.shape}")
        object.__setattr__(self, "signs", frozen(signs))
        torn = self.bundle.over(0) != self.bundle.over(1)
        if torn.any():
            a, b = self.edges[self.interior_edges[np.flatnonzero(torn)[0]]]
            raise MeshError(
                f"{counted(int(torn.sum()), 'edge', 'has have')} signs that disagree at their ends "
                f"(first: vertices {a}, {b})"
            )

    @cached_property
    def bundle(self) -> SignBundle:
        """The signs as the operators read them."""
        return SignBundle(self, self.signs)

    def restricted(self, faces: Indices, vertices: Vectors, corners: Triangles) -> TwistedMesh:
        """Build the mesh of some of the faces with these vertices at their corners, and with their signs."""
        return TwistedMesh(vertices, corners, signs=self.signs[faces])
