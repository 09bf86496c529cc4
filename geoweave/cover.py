"""The branched cover of an N-RoSy: N copies of a surface, glued as its vectors match (Section 5.1).

A vector field, one vector per face, is all that is left of the RoSy there: Part 1 runs on the cover as on
any other surface.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.arrays import Flags, Indices, Triangles, frozen
from geoweave.curves import Curves
from geoweave.errors import FieldError
from geoweave.fields import FaceField
from geoweave.mesh import TriMesh
from geoweave.part import Part, part_of
from geoweave.rosy import RoSyField


@dataclass(frozen=True, eq=False)
class Cover:
    """N copies of a punctured surface as one surface, which carries one vector of the RoSy on each face.

    Face ``f`` of sheet ``k`` is face ``k F' + f`` of the cover. It keeps its corners and so its frame:
    vectors, curves and areas go from the cover to the surface below as they are. The cover may have several
    components; in space it lies N times on the surface.

    Attributes
    ----------
    rosy : the N-RoSy on the surface below
    part : that surface without its branch points and the faces round them, F' faces
    mesh : the cover, N F' faces
    vertices : (V',) vertex of the surface below under each vertex of the cover
    """

    rosy: RoSyField
    part: Part
    mesh: TriMesh
    vertices: Indices

    @property
    def degree(self) -> int:
        """N, the number of sheets."""
        return self.rosy.degree

    @cached_property
    def faces(self) -> Indices:
        """(N F',) face of the surface below under each face of the cover."""
        return frozen(np.tile(self.part.faces, self.degree))

    @cached_property
    def sheets(self) -> Indices:
        """(N F',) sheet of each face: which of the N vectors it carries."""
        return frozen(np.repeat(np.arange(self.degree), len(self.part.faces)))

    @cached_property
    def field(self) -> FaceField:
        """The lifted RoSy: on each face the unit vector of its sheet (w^0 of Section 5.2)."""
        return FaceField(self.mesh, self.rosy.vectors[self.faces, self.sheets])

    @cached_property
    def next_sheet(self) -> tuple[Indices, Indices]:
        """The turn by one sheet, which takes the cover to itself: the image of each face and vertex.

        The gluings are shifts, so they commute with it; after N turns everything is back.

        Returns
        -------
        faces, vertices : (N F',) and (V',) permutations
        """
        faces = np.roll(np.arange(self.mesh.n_faces), -len(self.part.faces))
        vertices = np.empty(self.mesh.n_vertices, dtype=np.int64)
        vertices[self.mesh.faces] = self.mesh.faces[faces]
        return frozen(faces), frozen(vertices)

    @cached_property
    def antipodes(self) -> tuple[Indices, Indices]:
        """The turn by half of the sheets, an involution without fixed points: opposite vectors meet in it.

        Returns
        -------
        faces, vertices : (N F',) and (V',) permutations; on `field`, ``values[faces] == -values``

        Raises
        ------
        FieldError
            If N is odd: then no vector has an opposite.
        """
        if self.degree % 2:
            raise FieldError(f"a cover of {self.degree} sheets has no antipodes: their number is odd")
        faces = np.roll(np.arange(self.mesh.n_faces), -(self.degree // 2) * len(self.part.faces))
        vertices = np.empty(self.mesh.n_vertices, dtype=np.int64)
        vertices[self.mesh.faces] = self.mesh.faces[faces]
        return frozen(faces), frozen(vertices)

    def project(self, curves: Curves) -> Curves:
        """Take curves drawn on the cover to the surface below: the same lines, in the faces there.

        Raises
        ------
        FieldError
            If the curves lie on another mesh than the cover's.
        """
        if curves.mesh is not self.mesh:
            raise FieldError("the curves do not lie on the mesh of the cover that is to be projected")
        return replace(curves, mesh=self.rosy.mesh, faces=self.faces[curves.faces])


def branched_cover(rosy: RoSyField) -> Cover:
    """Build the branched cover of an N-RoSy (Section 5.1, Fig. 17).

    Branch points are taken out with the faces round them; N copies of each remaining face are made; copy k of
    face i is glued to copy ``k + sigma_ij`` of its neighbour j, sigma the matching of the RoSy.

    Parameters
    ----------
    rosy : the N-RoSy

    Returns
    -------
    Cover
        Its Euler characteristic is N times that of the punctured surface: outside the punctures nothing
        branches (Riemann and Hurwitz).

    Raises
    ------
    MeshError
        If every face touches a branch point.
    """
    away: Flags = ~np.any(rosy.branching[rosy.mesh.faces], axis=1)
    part = part_of(rosy.mesh, away)
    below = part.mesh
    corners, first = _glued(below, _matching_on(rosy, part), rosy.degree)
    # Corner c of face f of sheet k is 3 (k F' + f) + c, so below it lies corner number first mod 3 F'.
    under = below.faces.ravel()[first % below.faces.size]
    return Cover(
        rosy, part, TriMesh(below.vertices[under], corners), frozen(np.asarray(part.vertices[under]))
    )


def _matching_on(rosy: RoSyField, part: Part) -> Indices:
    """The matching over the interior edges of the punctured surface, from face i to face j there."""
    whole, below = rosy.mesh, part.mesh
    shift = np.zeros(whole.n_edges, dtype=np.int64)
    shift[whole.interior_edges] = rosy.matching
    halfedge = below.edge_halfedges[below.interior_edges, 0]
    face, side = part.faces[halfedge // 3], halfedge % 3
    forward = whole.face_edge_signs[face, side] > 0
    shift = shift[whole.face_edges[face, side]]
    return np.asarray(np.where(forward, shift, -shift))


def _glued(below: TriMesh, shift: Indices, degree: int) -> tuple[Triangles, Indices]:
    """Glue copies of the faces: the vertex at each corner, and the first corner of each vertex."""
    count = below.faces.size
    along, against = below.edge_halfedges[below.interior_edges].T
    # The ends of the shared side, seen from either face.
    here = np.concatenate([_corner(along, 1), _corner(along, 2)])
    there = np.concatenate([_corner(against, 2), _corner(against, 1)])
    sheet = np.arange(degree)[:, None]
    target = (sheet + np.tile(shift, 2)) % degree
    pairs = (sheet * count + here).ravel(), (target * count + there).ravel()
    graph = sparse.coo_array((np.ones(len(pairs[0]), np.int8), pairs), shape=(degree * count,) * 2)
    number = csgraph.connected_components(graph, directed=False)[1].astype(np.int64)
    _, first = np.unique(number, return_index=True)
    return number.reshape(-1, 3), first


def _corner(halfedge: Indices, step: int) -> Indices:
    """Corner that is so many steps on from the corner opposite a half-edge."""
    return np.asarray(3 * (halfedge // 3) + (halfedge + step) % 3)
