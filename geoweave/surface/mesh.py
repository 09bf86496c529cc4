"""The surface: an oriented manifold triangle mesh and its geometry (Section 4).

Tangent vectors are complex numbers in the orthonormal frame of their face. `connectivity` says how
half-edges, corners and edges are numbered.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from geoweave.arrays import Complexes, Indices, Scalars, Triangles, Vectors, frozen
from geoweave.errors import MeshError
from geoweave.surface.connectivity import Connectivity
from geoweave.surface.sign_bundle import SignBundle
from geoweave.wording import counted

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
class TriMesh(Connectivity):
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

    See Also
    --------
    isotropic_remesh : gives a mesh even triangles

    Examples
    --------
    >>> mesh = gw.shapes.torus(faces=400)
    >>> mesh.genus, len(mesh.boundary_loops), mesh.n_components
    (1, 0, 1)
    >>> bool(abs(mesh.angle_defects.sum()) < 1e-9)  # Gauss and Bonnet: 2 pi (2 - 2 g)
    True
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
            raise MeshError(f"{counted(int(flat.sum()), 'face', 'has have')} no area (first: face {first})")
        self._check_fans()

    @property
    def n_vertices(self) -> int:
        """V, the number of vertices."""
        return len(self.vertices)

    @cached_property
    def bundle(self) -> SignBundle:
        """With which signs faces see the odd values of vertices and edges: all +1 but on a `TwistedMesh`."""
        return SignBundle(self, frozen(np.ones(self.faces.shape)))

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
    def triangle_size(self) -> float:
        """The mean edge length h, or twice the root of the mean face area where that is less.

        Long thin triangles have long edges, which say little about the lengths that the mesh resolves. The
        two differ where triangles are on average more than about five times as long as high.
        """
        return min(self.mean_edge, 2.0 * float(np.sqrt(self.face_areas.mean())))

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
        return frozen(turn / np.abs(turn) * self.bundle.over_edges)

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

    def component_means(self, values: Scalars) -> Scalars:
        """(components,) area mean of (F,) face values on each connected component."""
        total = np.bincount(self.face_components, self.face_areas * values)
        return np.asarray(total / np.bincount(self.face_components, self.face_areas))

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
