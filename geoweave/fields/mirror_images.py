"""Mirror images of fields, and N-RoSys that are their own (beyond the paper: DEVIATIONS.md, symmetric).

A reflection takes the frame of a face to one of the other orientation. So the image of a vector is the
conjugate of its number, turned: ``image(v)_f = a_f conj(v_g)``, g the face that f is the image of.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from geoweave.arrays import Complexes, Indices, Scalars, frozen
from geoweave.errors import FieldError
from geoweave.fields.face_field import unit
from geoweave.fields.operators import connection_laplacian
from geoweave.fields.rosy import RoSyField
from geoweave.sparse import factorized, nested_dissection
from geoweave.surface import MirrorPlane, TriMesh, closest_points, triangle_tree

SMOOTHING = 1.0
"""Time for which the mean of a RoSy and its image flows, in squared `TriMesh.triangle_size`.

Both are constant on a face, and the faces of both do not lie on each other.
"""

OWN = 1e-4
"""Numbers of a RoSy that differ by no more from those of its image: it is its own image and stays."""


@dataclass(frozen=True, eq=False)
class MirrorImages:
    """Where the faces of a surface have their images, and how vectors get there.

    Attributes
    ----------
    mesh : the surface
    sources : (F,) the face whose image each face takes: the nearest to the image of its middle
    turns : (F,) complex, of modulus 1, by which conjugates are turned
    """

    mesh: TriMesh
    sources: Indices
    turns: Complexes

    @classmethod
    def of(cls, mesh: TriMesh, plane: MirrorPlane) -> MirrorImages:
        """Find them on a surface that a plane mirrors."""
        _, sources = closest_points(triangle_tree(mesh.vertices[mesh.faces]), plane.image(mesh.barycenters))
        first = plane.image_of_vectors(mesh.frames[sources, 0])
        return cls(mesh, frozen(sources), frozen(unit(mesh.planar(first))))

    def of_rosy(self, rosy: RoSyField) -> RoSyField:
        """The mirror image of an N-RoSy: N-th powers turn N times as far."""
        if rosy.mesh is not self.mesh:
            raise FieldError("the RoSy is not one on the surface that was mirrored")
        return RoSyField(self.mesh, rosy.degree, self.turns**rosy.degree * rosy.values[self.sources].conj())

    def departure(self, faces: Indices, vectors: Complexes) -> float:
        """How far vectors are from being their own mirror image.

        Parameters
        ----------
        faces : (n,) faces
        vectors : (n, N) the vectors there

        Returns
        -------
        Mean angle over the area, degrees, from each vector to the nearest of the images; over faces whose
        source is among them too.
        """
        place = np.full(self.mesh.n_faces, -1, dtype=np.int64)
        place[faces] = np.arange(len(faces))
        source = place[self.sources[faces]]
        known = source >= 0
        there = self.turns[faces[known], None] * vectors[source[known]].conj()
        between = np.abs(np.angle(vectors[known][:, :, None] * there[:, None, :].conj())).min(axis=2)
        areas = self.mesh.face_areas[faces[known]]
        return float(np.degrees(np.average(between.mean(axis=1), weights=areas)))


def symmetrized(rosy: RoSyField, images: MirrorImages) -> RoSyField:
    """Make an N-RoSy its own mirror image: the mean of it and its image, made smooth over one triangle.

    One that is its own image is left as it is. Otherwise it minimises, over the N-th powers u,

        |u - (w + image(w)) / 2|^2 + h^2 |grad u|^2,

    w those of the RoSy and h the size of a triangle.

    Parameters
    ----------
    rosy : the RoSy
    images : of its surface

    Examples
    --------
    >>> import geoweave as gw
    >>> from geoweave.fields import MirrorImages, symmetrized
    >>> from geoweave.surface import mirror_plane
    >>> torus = gw.shapes.torus(faces=600)
    >>> images = MirrorImages.of(torus, mirror_plane(torus, "z"))
    >>> tilted = gw.RoSyField(torus, 6, np.exp(0.6j) * gw.smoothest_rosy(torus, degree=6).values)
    >>> faces = np.arange(torus.n_faces)
    >>> [images.departure(faces, each.vectors) < 1.0 for each in (tilted, symmetrized(tilted, images))]
    [False, True]
    """
    mesh, image = rosy.mesh, images.of_rosy(rosy)
    if np.allclose(image.values, rosy.values, rtol=0.0, atol=OWN):
        return rosy
    mean = 0.5 * (rosy.values + image.values)
    laplacian = connection_laplacian(mesh, rosy.degree)
    mass: Scalars = mesh.face_areas
    system = sparse.csr_array(sparse.diags_array(mass) + SMOOTHING * mesh.triangle_size**2 * laplacian)
    found = factorized(system, nested_dissection(laplacian)).solve(mass * mean)
    return RoSyField(mesh, rosy.degree, unit(found))
