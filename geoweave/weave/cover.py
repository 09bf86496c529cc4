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

from geoweave.arrays import Flags, Indices, Scalars, Triangles, frozen
from geoweave.curves import Curves
from geoweave.errors import FieldError
from geoweave.fields import FaceField, RoSyField, Triples
from geoweave.foliation import CircleFunction, Foliation
from geoweave.surface import Part, TriMesh, TwistedMesh, connected_components, part_of


def family_count(symmetry: int) -> int:
    """Families of ribbons of an N-RoSy: two opposite vectors share one."""
    return symmetry // 2 if symmetry % 2 == 0 else symmetry


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

    Examples
    --------
    >>> import geoweave as gw
    >>> cover = gw.branched_cover(gw.smoothest_rosy(gw.shapes.torus(faces=400), degree=6))
    >>> cover.mesh.n_faces == 6 * len(cover.part.faces)
    True
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
    def combed(self) -> Indices:
        """(N F',) sheet of each face, numbered so that gluings keep the number but across branch cuts.

        `sheets` counts from the frame of each face: vectors of neighbours that match have any two numbers.
        Here numbers are carried from face to face along a breadth-first tree of each component. Cuts are left
        that join the branch points; across one the number changes by a constant, that of the families too.
        """
        below, shift = self.part.mesh, _matching_on(self.rosy, self.part)
        i, j = below.edge_faces[below.interior_edges].T
        # Entry i, j: one more than the shift from face i to face j, since nothing is stored for zero.
        steps = sparse.coo_array(
            (1 + np.concatenate([shift, -shift]) % self.degree, (np.append(i, j), np.append(j, i))),
            shape=(below.n_faces,) * 2,
        ).tocsr()
        _, roots = np.unique(below.face_components, return_index=True)
        depth, parent, _ = csgraph.dijkstra(
            steps, indices=roots, unweighted=True, return_predecessors=True, min_only=True
        )
        offset = np.zeros(below.n_faces, dtype=np.int64)
        for level in range(1, int(depth.max()) + 1):
            face = np.flatnonzero(depth == level)
            offset[face] = offset[parent[face]] - (steps[parent[face], face] - 1)
        return frozen((self.sheets + np.tile(offset, self.degree)) % self.degree)

    @cached_property
    def field(self) -> FaceField:
        """The lifted RoSy: on each face the unit vector of its sheet (w^0 of Section 5.2)."""
        return FaceField(self.mesh, self.rosy.vectors[self.faces, self.sheets])

    def turned(self, sheets: int = 1) -> tuple[Indices, Indices]:
        """The turn by so many sheets, which takes the cover to itself: the image of each face and vertex.

        The gluings are shifts, so they commute with it; after N sheets everything is back.

        Returns
        -------
        faces, vertices : (N F',) and (V',) permutations; on `field` the turn by one sheet is that
            of every vector by an N-th of a turn
        """
        faces = np.roll(np.arange(self.mesh.n_faces), -sheets * len(self.part.faces))
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
        return self.turned(self.degree // 2)

    @cached_property
    def quotient(self) -> Quotient:
        """The surface to solve on: one of each two antipodal faces for even N, all of them for odd N.

        Where a component of the cover is apart from its antipodal one, it stands for both. Where the two are
        one, sheets 0 to N/2 - 1 are taken, and values change sign where the gluing leads beyond them.
        """
        everyone = np.arange(self.mesh.n_faces)
        if self.degree % 2:
            signs = np.ones(self.mesh.n_faces)
            return Quotient(self, self.mesh, everyone, signs, np.arange(self.mesh.n_faces))
        antipode, _ = self.antipodes
        own, other = self.mesh.face_components, self.mesh.face_components[antipode]
        chosen = np.where(own == other, self.sheets < self.degree // 2, own < other)
        return _quotient(self, chosen, antipode)

    def project(self, curves: Curves) -> Leaves:
        """Take curves drawn on the cover to the surface below: the same lines, in the faces there.

        Where the curves are level sets of a foliation of the cover, these are the leaves of N / 2 families
        of foliations on the surface.

        Raises
        ------
        FieldError
            If the curves lie on another mesh than the cover's.
        """
        if curves.mesh is not self.mesh:
            raise FieldError("the curves do not lie on the mesh of the cover that is to be projected")
        return Leaves(
            self.rosy.mesh,
            curves.points,
            self.faces[curves.faces],
            curves.turning,
            curves.sliding,
            curves.offsets,
            curves.closed,
            self,
            curves.faces,
        )


@dataclass(frozen=True, eq=False)
class Leaves(Curves):
    """Curves on a surface that come from its cover, and so belong to families.

    Attributes
    ----------
    cover : the cover they were drawn on
    cover_faces : (P,) face of the cover that holds the segment starting at each point
    """

    cover: Cover
    cover_faces: Indices

    @cached_property
    def families(self) -> Indices:
        """(n,) family of each curve: the sheet, opposite sheets taken for one, of most of its length."""
        count = family_count(self.cover.degree)
        share = np.zeros((len(self), count))
        family = self.cover.combed[self.cover_faces] % count
        np.add.at(share, (self.curve_of_point, family), self.segment_lengths)
        return frozen(np.asarray(share.argmax(axis=1), dtype=np.int64))


@dataclass(frozen=True, eq=False)
class Quotient:
    """A cover with antipodal faces taken for one, and the way back.

    Opposite vectors, potentials and angles of antipodal faces are one up to sign, positive factors are equal.
    What is solved here by Part 1 is odd on the cover by construction: two families of level sets on antipodal
    sheets interleave by half a period, with no rounding (DEVIATIONS.md, antipodes).

    Attributes
    ----------
    cover : the cover
    mesh : its quotient, a `TwistedMesh` unless no component is its own antipode; for odd N the cover's mesh
    faces : (N F',) face of the quotient that stands for each face of the cover
    signs : (N F',) -1 where the face of the cover carries the opposite
    representatives : (faces of the quotient,) the face of the cover that each is a copy of
    """

    cover: Cover
    mesh: TriMesh
    faces: Indices
    signs: Scalars
    representatives: Indices

    @cached_property
    def triples(self) -> Triples:
        """The sheets 120 degrees apart, whose phase decides whether three ribbons meet in a point.

        Sheet k stands with sheets k + N/3 and k + 2 N/3. For N = 6 that is one triple over each face, for
        N = 3 all three sheets, and the turn by one sheet takes triples to triples.

        Raises
        ------
        FieldError
            If 3 does not divide N: no three directions are 120 degrees apart. For N = 4 two families have no
            phase but a shift of the pattern; for N = 5 no phase keeps three ribbons apart everywhere.
        """
        degree, count = self.cover.degree, len(self.cover.part.faces)
        if degree % 3:
            raise FieldError(f"a regular phase needs a symmetry that 3 divides, as 6, not {degree}")
        first = np.arange(degree // (6 if degree % 2 == 0 else 3))
        sheet = first[:, None, None] + degree // 3 * np.arange(3)
        face = (sheet * count + np.arange(count)[:, None]).reshape(-1, 3)
        ribbons = 2 if degree % 2 == 0 else 1
        return Triples(self.mesh, frozen(self.faces[face]), frozen(self.signs[face]), ribbons)

    @cached_property
    def field(self) -> FaceField:
        """The lifted RoSy on the representatives."""
        return FaceField(self.mesh, self.cover.field.values[self.representatives])

    def lifted(self, foliation: Foliation) -> Foliation:
        """Take a foliation of the quotient to the cover: ``s`` as it is, ``theta`` odd.

        Its energies and changes stay those of the quotient.

        Raises
        ------
        FieldError
            If the foliation is one of another mesh.
        """
        if foliation.part.whole is not self.mesh:
            raise FieldError("the foliation is not one of the quotient that is to be lifted from")
        below = foliation.part
        part = part_of(self.cover.mesh, below.kept[self.faces])
        place = np.full(self.mesh.n_faces, -1, dtype=np.int64)
        place[below.faces] = np.arange(len(below.faces))
        face, sign = place[self.faces[part.faces]], self.signs[part.faces]
        field = FaceField(part.mesh, sign * foliation.field.values[face])
        theta = np.empty(part.mesh.n_vertices)
        seen = foliation.circle.theta[below.mesh.faces] * below.mesh.bundle.corners
        theta[part.mesh.faces] = sign[:, None] * seen[face]
        side = part.mesh.edge_halfedges[:, 0]
        jumps = sign[side // 3] * foliation.circle.corner_jumps[face[side // 3], side % 3]
        circle = CircleFunction(part.mesh, theta, jumps)
        return replace(foliation, field=field, part=part, s=frozen(foliation.s[face]), circle=circle)


def _quotient(cover: Cover, chosen: Flags, antipode: Indices) -> Quotient:
    """The quotient by antipodes in which the chosen faces stand for their pairs."""
    mesh, representatives = cover.mesh, np.flatnonzero(chosen)
    number = np.cumsum(chosen) - 1
    faces = np.where(chosen, number, number[antipode])
    # Of two antipodal vertices the lower-numbered stands for both, unless only the other is a corner there.
    _, opposite = cover.antipodes
    corners = mesh.faces[representatives]
    present = np.zeros(mesh.n_vertices, dtype=bool)
    present[corners] = True
    standing = present & ~(present[opposite] & (opposite < np.arange(mesh.n_vertices)))
    vertex = np.cumsum(standing) - 1
    own = standing[corners]
    triangles = np.where(own, vertex[corners], vertex[opposite[corners]])
    points = mesh.vertices[standing]
    signs = np.where(own, 1.0, -1.0)
    surface = TriMesh(points, triangles) if own.all() else TwistedMesh(points, triangles, signs=signs)
    return Quotient(
        cover, surface, frozen(faces), frozen(np.where(chosen, 1.0, -1.0)), frozen(representatives)
    )


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

    Examples
    --------
    >>> import geoweave as gw
    >>> cover = gw.branched_cover(gw.smoothest_rosy(gw.shapes.sphere(faces=320), degree=4))
    >>> cover.degree, cover.mesh.euler_characteristic == 4 * cover.part.mesh.euler_characteristic
    (4, True)
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
    # The corners at both ends of the shared side, seen from either face.
    here, there = (each.T.ravel() for each in below.corners_across(below.interior_edges))
    sheet = np.arange(degree)[:, None]
    target = (sheet + np.tile(shift, 2)) % degree
    pairs = np.stack([(sheet * count + here).ravel(), (target * count + there).ravel()], axis=1)
    number = connected_components(pairs, degree * count)
    _, first = np.unique(number, return_index=True)
    return number.reshape(-1, 3), first
