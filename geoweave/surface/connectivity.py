"""What follows from the faces of a mesh alone: edges, neighbours, loops, components, genus (Section 4).

Conventions
-----------
Half-edge ``k`` of a face lies opposite its corner ``k`` and runs from corner ``k + 1`` to corner ``k + 2``.
Half-edge and corner ``k`` of face ``f`` have the number ``3 f + k``. An edge has the direction it has in its
first face, so it is "oriented consistently with face i" (Eq. 3) for ``i = edge_faces[e, 0]``.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from geoweave.arrays import Flags, Indices, Scalars, Triangles, frozen
from geoweave.errors import MeshError
from geoweave.surface.components import connected_components
from geoweave.wording import counted


def corner_after(halfedge: Indices, step: int) -> Indices:
    """Number of the corner that comes ``step`` corners after the one opposite each half-edge.

    Steps of 1 and 2 are the corners where the half-edge starts and ends.

    Examples
    --------
    >>> from geoweave.surface.connectivity import corner_after
    >>> corner_after(np.array([5]), 1)
    array([3])
    """
    return np.asarray(3 * (halfedge // 3) + (halfedge + step) % 3)


class Connectivity:
    """How triangles hang together: the part of `TriMesh` that does not depend on where the vertices are.

    Attributes
    ----------
    faces : (F, 3) int64, read-only, counter-clockwise seen from outside
    """

    faces: Triangles

    def _check_edges(self) -> None:
        """Refuse edges of three or more faces, and neighbours of opposite orientation."""
        _, _, counts, clash = self._edge_table
        if (counts > 2).any():
            a, b = self.edges[np.flatnonzero(counts > 2)[0]]
            raise MeshError(
                f"{counted(int((counts > 2).sum()), 'edge', 'is are')} shared by more than two faces "
                f"(first: vertices {a}, {b})"
            )
        if clash.any():
            a, b = self.edges[np.flatnonzero(clash)[0]]
            raise MeshError(
                f"{counted(int(clash.sum()), 'edge', 'lies lie')} between faces of opposite orientation "
                f"(first: vertices {a}, {b})"
            )

    def _check_fans(self) -> None:
        """Refuse vertices in which several fans of faces meet."""
        fans = self._fan_counts()
        if (fans > 1).any():
            first = int(np.flatnonzero(fans > 1)[0])
            raise MeshError(
                f"{counted(int((fans > 1).sum()), 'vertex', 'joins join')} separate fans of faces (first: "
                f"vertex {first})"
            )

    def _fan_counts(self) -> Indices:
        """(V,) number of fans of faces around each vertex; 1 on a manifold."""
        here, there = self.corners_across(self.interior_edges)
        fan = connected_components(np.stack([here.ravel(), there.ravel()], axis=1), self.faces.size)
        vertex_of_fan = np.zeros(int(fan.max()) + 1, dtype=np.int64)
        vertex_of_fan[fan] = self.faces.ravel()
        return np.bincount(vertex_of_fan, minlength=self.n_vertices)

    # -- size -------------------------------------------------------------------------------------------

    @property
    def n_vertices(self) -> int:
        """V, the number of vertices: each belongs to a face."""
        return int(self.faces.max()) + 1

    @property
    def n_faces(self) -> int:
        """F, the number of faces."""
        return len(self.faces)

    @property
    def n_edges(self) -> int:
        """E, the number of edges, boundary included."""
        return len(self.edges)

    # -- edges and neighbours ---------------------------------------------------------------------------

    @cached_property
    def _edge_table(self) -> tuple[Indices, Indices, Indices, Flags]:
        """Edges, edge of each half-edge, faces per edge, and whether two faces run along it the same way."""
        tail, head = self.faces[:, [1, 2, 0]].ravel(), self.faces[:, [2, 0, 1]].ravel()
        key = np.minimum(tail, head) * self.n_vertices + np.maximum(tail, head)
        _, first, of_halfedge, counts = np.unique(
            key, return_index=True, return_inverse=True, return_counts=True
        )
        edges = np.stack([tail[first], head[first]], axis=1)
        forward = tail == edges[of_halfedge, 0]
        clash = np.bincount(of_halfedge, weights=forward, minlength=len(edges)) > 1
        return frozen(edges), frozen(of_halfedge), counts, clash

    @property
    def edges(self) -> Indices:
        """(E, 2) vertices of each edge, directed as in its first face."""
        return self._edge_table[0]

    @cached_property
    def face_edges(self) -> Indices:
        """(F, 3) edge opposite each corner."""
        return frozen(self._edge_table[1].reshape(-1, 3))

    @cached_property
    def face_edge_signs(self) -> Scalars:
        """(F, 3) +1 where the half-edge opposite the corner runs along its edge, -1 against it."""
        tail = self.faces[:, [1, 2, 0]]
        return frozen(np.where(tail == self.edges[self.face_edges, 0], 1.0, -1.0))

    @cached_property
    def edge_halfedges(self) -> Indices:
        """(E, 2) half-edge ``3 f + k`` that runs along each edge, and against it (-1 on the boundary)."""
        halfedges = np.full((self.n_edges, 2), -1, dtype=np.int64)
        side = (self.face_edge_signs.ravel() < 0).astype(np.int64)
        halfedges[self.face_edges.ravel(), side] = np.arange(3 * self.n_faces)
        return frozen(halfedges)

    @cached_property
    def edge_faces(self) -> Indices:
        """(E, 2) face i along which the edge is directed, and the face j across it (-1 on the boundary)."""
        return frozen(np.where(self.edge_halfedges < 0, -1, self.edge_halfedges // 3))

    @cached_property
    def interior_edges(self) -> Indices:
        """(E_int,) indices of the edges with a face on either side."""
        return frozen(np.flatnonzero(self.edge_faces[:, 1] >= 0))

    @cached_property
    def boundary_edges(self) -> Indices:
        """Indices of the edges with one face only."""
        return frozen(np.flatnonzero(self.edge_faces[:, 1] < 0))

    @cached_property
    def face_neighbors(self) -> Indices:
        """(F, 3) face across the edge opposite each corner, -1 on the boundary."""
        across = np.where(self.face_edge_signs > 0, 1, 0)
        return frozen(self.edge_faces[self.face_edges, across])

    def corners_across(self, edges: Indices) -> tuple[Indices, Indices]:
        """Corners that two faces have at the ends of the edges between them.

        Parameters
        ----------
        edges : (n,) interior edges

        Returns
        -------
        here, there : (n, 2) corner ``3 f + k`` at the start and at the end of each edge, in its first face
            and in the face across it
        """
        along, against = self.edge_halfedges[edges].T
        here = np.stack([corner_after(along, 1), corner_after(along, 2)], axis=1)
        there = np.stack([corner_after(against, 2), corner_after(against, 1)], axis=1)
        return here, there

    # -- boundary, components, genus --------------------------------------------------------------------

    @cached_property
    def boundary_vertices(self) -> Flags:
        """(V,) whether the vertex lies on the boundary."""
        on = np.zeros(self.n_vertices, dtype=bool)
        on[self.edges[self.boundary_edges]] = True
        return frozen(on)

    @cached_property
    def boundary_loops(self) -> tuple[Indices, ...]:
        """The vertices of each boundary loop, in the direction of the faces beside it."""
        tail, head = self.edges[self.boundary_edges].T
        following = dict(zip(tail.tolist(), head.tolist(), strict=True))
        loops = []
        while following:
            start, vertex = following.popitem()
            loop = [start]
            while vertex != start:
                loop.append(vertex)
                vertex = following.pop(vertex)
            loops.append(frozen(np.array(loop, dtype=np.int64)))
        return tuple(sorted(loops, key=lambda loop: int(loop.min())))

    @cached_property
    def face_components(self) -> Indices:
        """(F,) number of the connected component of each face."""
        return frozen(self.vertex_components[self.faces[:, 0]])

    @cached_property
    def vertex_components(self) -> Indices:
        """(V,) number of the connected component of each vertex."""
        return frozen(connected_components(self.edges, self.n_vertices))

    @property
    def n_components(self) -> int:
        """Number of connected components."""
        return int(self.vertex_components.max()) + 1

    @property
    def euler_characteristic(self) -> int:
        """chi = V - E + F."""
        return self.n_vertices - self.n_edges + self.n_faces

    @property
    def genus(self) -> int:
        """Sum of the genera of the components: chi = 2 c - 2 g - b."""
        return (2 * self.n_components - len(self.boundary_loops) - self.euler_characteristic) // 2
