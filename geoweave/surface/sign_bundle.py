"""Surfaces whose fields, forms and potentials are odd: they change sign on the way round some loops.

The quotient of a branched cover by its antipodes is one (`weave.cover`). Opposite vectors are one vector
there, up to a sign that each face chooses for itself; a flat bundle of signs keeps the account. The operators
read it from the mesh, so that Part 1 of the paper runs on such a surface as on any other.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Flags, Indices, Scalars, Triangles, Vectors, frozen
from geoweave.errors import MeshError
from geoweave.surface.mesh import TriMesh


@dataclass(frozen=True, eq=False)
class TwistedMesh(TriMesh):
    """A mesh with a sign at every corner: how the face there sees the odd value of the vertex.

    Vectors belong to faces, potentials and angles to vertices, forms to edges as their first face sees them.
    Areas, lengths and positive factors know no sign.

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
        torn = self._sign_over(0) != self._sign_over(1)
        if torn.any():
            a, b = self.edges[self.interior_edges[np.flatnonzero(torn)[0]]]
            raise MeshError(
                f"{int(torn.sum())} edges have signs that disagree at their ends (first: vertices {a}, {b})"
            )

    def _sign_over(self, end: int) -> Scalars:
        """(E_int,) whether the two faces of an edge see its start (0) or its end (1) with the same sign."""
        along, against = self.edge_halfedges[self.interior_edges].T
        signs = self.signs.ravel()
        here = 3 * (along // 3) + (along + 1 + end) % 3
        there = 3 * (against // 3) + (against + 2 - end) % 3
        return np.asarray(signs[here] * signs[there])

    @property
    def corner_signs(self) -> Scalars:
        """(F, 3) `signs`."""
        return self.signs

    @cached_property
    def end_signs(self) -> Scalars:
        """(E, 2) signs with which the first face of each edge sees its start and its end."""
        along = self.edge_halfedges[:, :1]
        return frozen(self.signs.ravel()[3 * (along // 3) + (along + [1, 2]) % 3])

    @cached_property
    def edge_signs(self) -> Scalars:
        """(E_int,) sign that a value takes on its way over each interior edge."""
        return frozen(self._sign_over(0))

    @cached_property
    def form_signs(self) -> Scalars:
        """(F, 3) sign that turns the value of a 1-form on an edge into that on the half-edge of the face."""
        over = np.ones(self.n_edges)
        over[self.interior_edges] = self.edge_signs
        return frozen(np.where(self.face_edge_signs > 0, 1.0, -over[self.face_edges]))

    @cached_property
    def twisted_components(self) -> Flags:
        """(components,) whether a value comes back as its opposite along some closed path."""
        straight, crossed = _double(self, np.arange(self.n_edges))
        twisted = np.zeros(self.n_components, dtype=bool)
        twisted[self.vertex_components[straight == crossed]] = True
        return frozen(twisted)

    def restricted(self, faces: Indices, vertices: Vectors, corners: Triangles) -> TwistedMesh:
        """Build the mesh of some of the faces with these vertices at their corners, and with their signs."""
        return TwistedMesh(vertices, corners, signs=self.signs[faces])


def gauge(mesh: TriMesh, edges: Indices) -> Scalars:
    """Choose a sign per vertex, (V,), with which no value changes along the edges of a spanning forest."""
    straight, _ = _double(mesh, edges)
    root = np.unique(mesh.vertex_components, return_index=True)[1]
    return np.where(straight == straight[root][mesh.vertex_components], 1.0, -1.0)


def _double(mesh: TriMesh, edges: Indices) -> tuple[Indices, Indices]:
    """Components of two copies of the vertices, edges joining them straight or, by their sign, crosswise."""
    n, (tail, head) = mesh.n_vertices, mesh.edges[edges].T
    shift = np.where(mesh.end_signs[edges].prod(axis=1) < 0, n, 0)
    pairs = np.concatenate([tail, tail + n]), np.concatenate([head + shift, head + n - shift])
    graph = sparse.coo_array((np.ones(len(pairs[0]), np.int8), pairs), shape=(2 * n,) * 2)
    label = csgraph.connected_components(graph, directed=False)[1].astype(np.int64)
    return label[:n], label[n:]
