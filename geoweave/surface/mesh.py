"""The surface: an oriented manifold triangle mesh and everything that follows from it (Section 4).

Conventions
-----------
Half-edge ``k`` of a face lies opposite its corner ``k`` and runs from corner ``k + 1`` to corner ``k + 2``.
An edge has the direction it has in its first face, so it is "oriented consistently with face i" (Eq. 3)
for ``i = edge_faces[e, 0]``. Tangent vectors are complex numbers in the orthonormal frame of their face.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from geoweave.arrays import Complexes, Flags, Indices, Scalars, Triangles, Vectors, frozen
from geoweave.errors import MeshError
from geoweave.surface.components import connected_components

SMALLEST_ASPECT = 1e-12
"""A face is degenerate when its area is at most this share of its longest edge squared."""


@dataclass(frozen=True)
class Similarity:
    """The map ``x -> (x - center) / scale`` that took a mesh to its working position.

    ``center`` (3,) and ``scale`` > 0 are in the units of the original mesh.
    """

    center: Vectors
    scale: float

    def apply(self, points: Vectors) -> Vectors:
        """Take (N, 3) original points to the working position."""
        return (points - self.center) / self.scale

    def undo(self, points: Vectors) -> Vectors:
        """Take (N, 3) working points back to the original position and size."""
        return points * self.scale + self.center


@dataclass(frozen=True, eq=False)
class TriMesh:
    """An oriented manifold triangle mesh, the surface T of Section 4.

    Any genus, any number of boundary loops and components. Construction checks that the arrays
    describe such a surface; `geoweave.meshing.prepare` mends files that do not.

    Attributes
    ----------
    vertices : (V, 3) float64, read-only
    faces : (F, 3) int64, read-only, counter-clockwise seen from outside

    Raises
    ------
    MeshError
        If an index is out of range, a coordinate is not finite, a vertex belongs to no face, a face is
        degenerate, more than two faces share an edge, neighbours disagree in orientation, or two fans of
        faces meet in one vertex.
    """

    vertices: Vectors
    faces: Triangles

    def __post_init__(self) -> None:
        vertices = np.array(self.vertices, dtype=np.float64, order="C")
        faces = np.array(self.faces, dtype=np.int64, order="C")
        if vertices.ndim != 2 or vertices.shape[1] != 3:
            raise MeshError(f"vertices must have shape (V, 3), not {vertices.shape}")
        if faces.ndim != 2 or faces.shape[1] != 3 or not len(faces):
            raise MeshError(f"faces must have shape (F, 3) with F > 0, not {faces.shape}")
        object.__setattr__(self, "vertices", frozen(vertices))
        object.__setattr__(self, "faces", frozen(faces))
        self._check()

    def _check(self) -> None:
        if not np.isfinite(self.vertices).all():
            bad = int(np.flatnonzero(~np.isfinite(self.vertices).all(axis=1))[0])
            raise MeshError(f"vertex {bad} has a coordinate that is not finite")
        if self.faces.min() < 0 or self.faces.max() >= self.n_vertices:
            bad = int(np.flatnonzero(((self.faces < 0) | (self.faces >= self.n_vertices)).any(axis=1))[0])
            raise MeshError(f"face {bad} names a vertex outside 0..{self.n_vertices - 1}")
        used = np.zeros(self.n_vertices, dtype=bool)
        used[self.faces] = True
        if not used.all():
            raise MeshError(f"vertex {int(np.flatnonzero(~used)[0])} belongs to no face")
        self._check_edges()
        flat = self.face_areas <= SMALLEST_ASPECT * self.edge_lengths[self.face_edges].max(axis=1) ** 2
        if flat.any():
            first = int(np.flatnonzero(flat)[0])
            raise MeshError(f"{int(flat.sum())} faces have no area (first: face {first})")
        fans = self._fan_counts()
        if (fans > 1).any():
            first = int(np.flatnonzero(fans > 1)[0])
            raise MeshError(
                f"{int((fans > 1).sum())} vertices join separate fans of faces (first: vertex {first})"
            )

    def _check_edges(self) -> None:
        _, _, counts, clash = self._edge_table
        if (counts > 2).any():
            a, b = self.edges[np.flatnonzero(counts > 2)[0]]
            raise MeshError(
                f"{int((counts > 2).sum())} edges are shared by more than two faces "
                f"(first: vertices {a}, {b})"
            )
        if clash.any():
            a, b = self.edges[np.flatnonzero(clash)[0]]
            raise MeshError(
                f"{int(clash.sum())} edges lie between faces of opposite orientation "
                f"(first: vertices {a}, {b})"
            )

    def _fan_counts(self) -> Indices:
        """(V,) number of fans of faces around each vertex; 1 on a manifold."""
        i, j = self.edge_faces[self.interior_edges].T
        corners = np.arange(3 * self.n_faces).reshape(-1, 3)
        rows, columns = [], []
        for end in (0, 1):
            vertex = self.edges[self.interior_edges, end]
            rows.append(corners[i, np.argmax(self.faces[i] == vertex[:, None], axis=1)])
            columns.append(corners[j, np.argmax(self.faces[j] == vertex[:, None], axis=1)])
        row, column = np.concatenate(rows), np.concatenate(columns)
        label = connected_components(np.stack([row, column], axis=1), corners.size)
        vertex_of_fan = np.zeros(int(label.max()) + 1, dtype=np.int64)
        vertex_of_fan[label] = self.faces.ravel()
        return np.bincount(vertex_of_fan, minlength=self.n_vertices)

    # -- size -------------------------------------------------------------------------------------------

    @property
    def n_vertices(self) -> int:
        """V, the number of vertices."""
        return len(self.vertices)

    @property
    def n_faces(self) -> int:
        """F, the number of faces."""
        return len(self.faces)

    @property
    def n_edges(self) -> int:
        """E, the number of edges, boundary included."""
        return len(self.edges)

    # -- connectivity -----------------------------------------------------------------------------------

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

    @cached_property
    def betti_numbers(self) -> Indices:
        """(components,) how many independent closed fields on each are no gradient: 2 g, or 1 - chi if open.

        A twisted component has -chi of them, with or without a boundary.
        """
        count, component = self.n_components, self.vertex_components
        euler = np.bincount(component, minlength=count) + np.bincount(self.face_components, minlength=count)
        euler -= np.bincount(component[self.edges[:, 0]], minlength=count)
        bounded = np.zeros(count, dtype=bool)
        bounded[component[self.boundary_vertices]] = True
        constants = np.where(self.twisted_components, 0, np.where(bounded, 1, 2))
        return frozen(np.asarray(constants - euler, dtype=np.int64))

    @property
    def first_betti_number(self) -> int:
        """Number of independent closed fields that are no gradient, over all components."""
        return int(self.betti_numbers.sum())

    # -- signs of odd values: all +1 here, see `sign_bundle` -------------------------------------------

    @cached_property
    def corner_signs(self) -> Scalars:
        """(F, 3) sign with which each face sees the value at its corner's vertex."""
        return frozen(np.ones(self.faces.shape))

    @cached_property
    def end_signs(self) -> Scalars:
        """(E, 2) signs with which the first face of each edge sees its start and its end."""
        return frozen(np.ones(self.edges.shape))

    @cached_property
    def edge_signs(self) -> Scalars:
        """(E_int,) sign that a value takes on its way over each interior edge."""
        return frozen(np.ones(len(self.interior_edges)))

    @property
    def form_signs(self) -> Scalars:
        """(F, 3) sign that turns the value of a 1-form on an edge into that on the half-edge of the face."""
        return self.face_edge_signs

    @cached_property
    def twisted_components(self) -> Flags:
        """(components,) whether a value comes back as its opposite along some closed path."""
        return frozen(np.zeros(self.n_components, dtype=bool))

    # -- geometry ---------------------------------------------------------------------------------------

    @cached_property
    def edge_vectors(self) -> Vectors:
        """(E, 3) vector along each edge."""
        return frozen(self.vertices[self.edges[:, 1]] - self.vertices[self.edges[:, 0]])

    @cached_property
    def edge_lengths(self) -> Scalars:
        """(E,) length of each edge."""
        return frozen(np.linalg.norm(self.edge_vectors, axis=1))

    @property
    def mean_edge(self) -> float:
        """Mean edge length h."""
        return float(self.edge_lengths.mean())

    @property
    def bounding_radius(self) -> float:
        """Distance of the farthest vertex from the mean of all: the unit of length of the project."""
        return float(np.linalg.norm(self.vertices - self.vertices.mean(axis=0), axis=1).max())

    @cached_property
    def _area_vectors(self) -> Vectors:
        a, b, c = (self.vertices[self.faces[:, k]] for k in range(3))
        return frozen(np.cross(b - a, c - a))

    @cached_property
    def face_areas(self) -> Scalars:
        """(F,) area of each triangle."""
        return frozen(0.5 * np.linalg.norm(self._area_vectors, axis=1))

    @cached_property
    def face_normals(self) -> Vectors:
        """(F, 3) unit normal of each triangle."""
        return frozen(self._area_vectors / (2.0 * self.face_areas)[:, None])

    @cached_property
    def vertex_normals(self) -> Vectors:
        """(V, 3) unit normals, averaged over the faces by area."""
        total = np.zeros_like(self.vertices)
        for k in range(3):
            np.add.at(total, self.faces[:, k], self._area_vectors)
        length = np.linalg.norm(total, axis=1, keepdims=True)
        return frozen(total / np.where(length > 0, length, 1.0))

    @cached_property
    def barycenters(self) -> Vectors:
        """(F, 3) centre of each triangle."""
        return frozen(self.vertices[self.faces].mean(axis=1))

    @cached_property
    def frames(self) -> Vectors:
        """(F, 2, 3) orthonormal frame of each face: along its first side, and a quarter turn on."""
        first = self.vertices[self.faces[:, 1]] - self.vertices[self.faces[:, 0]]
        first = first / np.linalg.norm(first, axis=1, keepdims=True)
        return frozen(np.stack([first, np.cross(self.face_normals, first)], axis=1))

    @cached_property
    def halfedge_vectors(self) -> Complexes:
        """(F, 3) complex: the half-edge opposite each corner, in the frame of its face."""
        ambient = self.edge_vectors[self.face_edges] * self.face_edge_signs[:, :, None]
        planar = np.einsum("fkx,fax->fka", ambient, self.frames)
        return frozen(planar[..., 0] + 1j * planar[..., 1])

    @cached_property
    def transport(self) -> Complexes:
        """(E_int,) parallel transport ``T_{j<-i}`` over each interior edge, from face i to face j (Eq. 2).

        A unit complex number: unfolding face i about the edge takes the vector w_i to ``transport * w_i``
        in the frame of face j, with the sign of the edge.
        """
        along, against = self.edge_halfedges[self.interior_edges].T
        turn = -self.halfedge_vectors.ravel()[against] * self.halfedge_vectors.ravel()[along].conj()
        return frozen(turn / np.abs(turn) * self.edge_signs)

    @cached_property
    def corner_angles(self) -> Scalars:
        """(F, 3) interior angle at each corner, in radians."""
        side = self.halfedge_vectors
        turn = -side[:, [1, 2, 0]].conj() * side[:, [2, 0, 1]]
        return frozen(np.abs(np.angle(turn.conj())))

    @cached_property
    def angle_defects(self) -> Scalars:
        """(V,) discrete Gauss curvature: 2 pi (pi on the boundary) less the angles around the vertex.

        On the boundary this is the discrete geodesic curvature of the loop, and the sum is 2 pi chi.
        """
        around = np.bincount(
            self.faces.ravel(), weights=self.corner_angles.ravel(), minlength=self.n_vertices
        )
        return frozen(np.where(self.boundary_vertices, np.pi, 2.0 * np.pi) - around)

    # -- tangent vectors --------------------------------------------------------------------------------

    def ambient(self, planar: Complexes) -> Vectors:
        """Map (F,) complex tangent vectors to (F, 3) vectors in space."""
        return planar.real[:, None] * self.frames[:, 0] + planar.imag[:, None] * self.frames[:, 1]

    def planar(self, ambient: ArrayLike) -> Complexes:
        """Map (F, 3) vectors in space to complex tangent vectors, dropping what is normal to the face."""
        vectors = np.asarray(ambient, dtype=np.float64)
        first = np.einsum("fx,fx->f", vectors, self.frames[:, 0])
        second = np.einsum("fx,fx->f", vectors, self.frames[:, 1])
        return first + 1j * second

    # -- new meshes -------------------------------------------------------------------------------------

    def restricted(self, faces: Indices, vertices: Vectors, corners: Triangles) -> TriMesh:
        """Build the mesh of some of the faces with these vertices at their corners (see `submesh`)."""
        return TriMesh(vertices, corners)

    def normalized(self) -> tuple[TriMesh, Similarity]:
        """Move the vertex mean to the origin and scale the farthest vertex to distance 1.

        Total curl is a length and lambda an area, so both need a fixed scale; this is the one that every
        number in the project is stated in ("bounding radius 1").
        """
        center = self.vertices.mean(axis=0)
        shifted = self.vertices - center
        center = center + shifted.mean(axis=0)
        radius = float(np.linalg.norm(self.vertices - center, axis=1).max())
        placement = Similarity(frozen(center), radius)
        return TriMesh(placement.apply(self.vertices), self.faces), placement
