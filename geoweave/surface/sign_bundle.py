"""Signs of odd values: those that change sign on the way round some loops, as on the quotient of a cover.

The quotient of a branched cover by its antipodes (`weave.cover`) has such values. Opposite vectors are one
vector there, up to a sign that each face chooses for itself. The operators read the signs from the mesh
(`TriMesh.bundle`), so that Part 1 of the paper runs on such a surface as on any other.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geoweave.arrays import Flags, Indices, Scalars, frozen
from geoweave.surface.components import connected_components
from geoweave.surface.connectivity import Connectivity, corner_after


@dataclass(frozen=True, eq=False)
class SignBundle:
    """The signs with which the faces of a mesh see the odd values of its vertices and edges.

    Vectors belong to faces, potentials and angles to vertices, forms to edges as their first face sees them.
    Areas, lengths and positive factors have no sign.

    Attributes
    ----------
    mesh : the faces and how they hang together
    corners : (F, 3) +1 where the face sees the value at its corner's vertex as it is, -1 where it sees the
        opposite
    """

    mesh: Connectivity
    corners: Scalars

    def over(self, end: int) -> Scalars:
        """(E_int,) +1 where both faces of an edge see its start (0) or end (1) alike, else -1."""
        here, there = (each[:, end] for each in self.mesh.corners_across(self.mesh.interior_edges))
        signs = self.corners.ravel()
        return np.asarray(signs[here] * signs[there])

    @cached_property
    def ends(self) -> Scalars:
        """(E, 2) signs with which the first face of each edge sees its start and its end."""
        along = self.mesh.edge_halfedges[:, 0]
        corners = np.stack([corner_after(along, 1), corner_after(along, 2)], axis=1)
        return frozen(self.corners.ravel()[corners])

    @cached_property
    def over_edges(self) -> Scalars:
        """(E_int,) sign that a value takes on its way over each interior edge."""
        return frozen(self.over(0))

    @cached_property
    def forms(self) -> Scalars:
        """(F, 3) sign that turns the value of a 1-form on an edge into that on the half-edge of the face."""
        over = np.ones(self.mesh.n_edges)
        over[self.mesh.interior_edges] = self.over_edges
        return frozen(np.where(self.mesh.face_edge_signs > 0, 1.0, -over[self.mesh.face_edges]))

    @cached_property
    def twisted_components(self) -> Flags:
        """(components,) whether a value comes back as its opposite along some closed path."""
        straight, crossed = self._two_copies(np.arange(self.mesh.n_edges))
        twisted = np.zeros(self.mesh.n_components, dtype=bool)
        twisted[self.mesh.vertex_components[straight == crossed]] = True
        return frozen(twisted)

    @cached_property
    def betti_numbers(self) -> Indices:
        """(components,) how many independent closed fields on each are no gradient: 2 g, or 1 - chi if open.

        A twisted component has -chi of them, with or without a boundary.
        """
        mesh = self.mesh
        count, component = mesh.n_components, mesh.vertex_components
        euler = np.bincount(component, minlength=count) + np.bincount(mesh.face_components, minlength=count)
        euler -= np.bincount(component[mesh.edges[:, 0]], minlength=count)
        bounded = np.zeros(count, dtype=bool)
        bounded[component[mesh.boundary_vertices]] = True
        constants = np.where(self.twisted_components, 0, np.where(bounded, 1, 2))
        return frozen(np.asarray(constants - euler, dtype=np.int64))

    def gauge(self, edges: Indices) -> Scalars:
        """Choose a sign per vertex, (V,), so that no value changes along the edges of a spanning forest."""
        straight, _ = self._two_copies(edges)
        root = np.unique(self.mesh.vertex_components, return_index=True)[1]
        return np.where(straight == straight[root][self.mesh.vertex_components], 1.0, -1.0)

    def _two_copies(self, edges: Indices) -> tuple[Indices, Indices]:
        """Components of two copies of the vertices, joined by an edge straight or, by its sign, crosswise."""
        n, (tail, head) = self.mesh.n_vertices, self.mesh.edges[edges].T
        shift = np.where(self.ends[edges].prod(axis=1) < 0, n, 0)
        first, second = np.concatenate([tail, tail + n]), np.concatenate([head + shift, head + n - shift])
        label = connected_components(np.stack([first, second], axis=1), 2 * n)
        return label[:n], label[n:]
