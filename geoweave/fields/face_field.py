"""Vector fields with one tangent vector per face, and how far they are from being geodesic (Section 4.1)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from geoweave.arrays import Complexes, Flags, Indices, Scalars, Vectors, frozen
from geoweave.errors import FieldError
from geoweave.surface import TriMesh
from geoweave.wording import counted

STEEP = 1e-9
"""A vector has no direction in a plane that holds less than this share of its length."""


@dataclass(frozen=True, eq=False)
class FaceField:
    """A tangent vector on every face, as a complex number in the frame of the face.

    Attributes
    ----------
    mesh : the surface
    values : (F,) complex128, read-only; multiply by 1j for a counter-clockwise quarter turn

    See Also
    --------
    RoSyField : N vectors on every face

    Examples
    --------
    >>> disk = gw.shapes.disk(faces=200)
    >>> field = gw.FaceField.from_ambient(disk, np.tile([3.0, 4.0, 0.0], (disk.n_faces, 1)))
    >>> field.norms.min().round(9), field.normalized().ambient[0].round(9)
    (np.float64(5.0), array([0.6, 0.8, 0. ]))
    """

    mesh: TriMesh
    values: Complexes

    def __post_init__(self) -> None:
        values = np.array(self.values, dtype=np.complex128)
        if values.shape != (self.mesh.n_faces,):
            raise FieldError(f"a field needs one vector per face, ({self.mesh.n_faces},), not {values.shape}")
        if not np.isfinite(values).all():
            bad = int(np.flatnonzero(~np.isfinite(values))[0])
            raise FieldError(f"the vector on face {bad} is not finite")
        object.__setattr__(self, "values", frozen(values))

    @classmethod
    def from_ambient(cls, mesh: TriMesh, vectors: ArrayLike) -> FaceField:
        """Build a field from (F, 3) vectors in space; what is normal to a face is dropped."""
        return cls(mesh, mesh.planar(vectors))

    @property
    def ambient(self) -> Vectors:
        """(F, 3) the vectors in space."""
        return self.mesh.ambient(self.values)

    @property
    def norms(self) -> Scalars:
        """(F,) length of each vector."""
        return np.abs(self.values)

    def normalized(self) -> FaceField:
        """Scale every vector to length one; a vector of length zero becomes the first frame vector."""
        return FaceField(self.mesh, unit(self.values))

    def __sub__(self, other: FaceField) -> FaceField:
        return FaceField(self.mesh, self.values - other.values)

    def __add__(self, other: FaceField) -> FaceField:
        return FaceField(self.mesh, self.values + other.values)


def unit(values: Complexes) -> Complexes:
    """Scale complex numbers to modulus one, zero to 1."""
    size = np.abs(values)
    return np.where(size > 0, values / np.where(size > 0, size, 1.0), 1.0 + 0j)


def random_field(mesh: TriMesh, seed: int | np.random.Generator = 0) -> FaceField:
    """Draw a unit vector on every face, uniformly and independently.

    Examples
    --------
    >>> field = gw.random_field(gw.shapes.torus(faces=400), seed=1)
    >>> bool(np.allclose(field.norms, 1.0))
    True
    """
    angle = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, mesh.n_faces)
    return FaceField(mesh, np.exp(1j * angle))


def edge_curl(field: FaceField) -> Scalars:
    """Jump of the field's projection on each interior edge, ``(w_j - w_i) . e_ij`` (Eq. 3).

    Returns
    -------
    (E_int,) zero everywhere exactly when the field is locally a gradient; unit: length x field.
    The value does not depend on which of the two faces is called i.

    See Also
    --------
    signed_curl : one number per face

    Examples
    --------
    >>> disk = gw.shapes.disk(faces=200)
    >>> constant = gw.FaceField.from_ambient(disk, np.tile([1.0, 0.0, 0.0], (disk.n_faces, 1)))
    >>> bool(abs(gw.edge_curl(constant)).max() < 1e-12)
    True
    """
    mesh = field.mesh
    projected = (field.values[:, None].conj() * mesh.halfedge_vectors).real.ravel()
    along, against = mesh.edge_halfedges[mesh.interior_edges].T
    return -(projected[along] + mesh.bundle.over_edges * projected[against])


def integrated_curl(field: FaceField) -> Scalars:
    """Signed curl of each face times its area, ``sum over j of (w_j - w_i) . e_ij`` (Appendix B.1).

    Returns
    -------
    (F,) unit: length x field. Boundary edges have no neighbour and are skipped.

    See Also
    --------
    signed_curl : the same over the area of the face

    Examples
    --------
    >>> field = gw.random_field(gw.shapes.torus(faces=400))
    >>> bool(abs(gw.integrated_curl(field).sum() - 2 * gw.edge_curl(field).sum()) < 1e-9)
    True
    """
    mesh = field.mesh
    jump = edge_curl(field)
    sides = mesh.edge_faces[mesh.interior_edges]
    seen = np.stack([jump, mesh.bundle.over_edges * jump], axis=1)
    both = np.bincount(sides.ravel(), weights=seen.ravel(), minlength=mesh.n_faces)
    return np.asarray(both, dtype=np.float64)


def signed_curl(field: FaceField) -> Scalars:
    """Curl of each face, ``(1 / A_i) sum over j of (w_j - w_i) . e_ij`` (Appendix B.1), field / length.

    Every jump counts for the faces on both sides, so it is twice the curl of a smooth field.

    See Also
    --------
    integrated_curl : the same times the area, so that it sums over faces
    edge_curl : the jump over each edge

    Examples
    --------
    >>> disk = gw.shapes.disk(faces=2000)
    >>> whirl = gw.FaceField.from_ambient(disk, np.cross([0.0, 0.0, 1.0], disk.barycenters))
    >>> round(float(np.median(gw.signed_curl(whirl))), 1)  # of (-y, x), whose curl is 2
    4.0
    """
    return integrated_curl(field) / field.mesh.face_areas


def total_curl(field: FaceField) -> float:
    """Integral of |curl| over the surface (Appendix B.1): the number of Table 1.

    It is a length, and it depends on the resolution: compare values on the same mesh only.

    Examples
    --------
    >>> start = gw.smoothest_field(gw.shapes.genus_g(2, faces=600))
    >>> gw.total_curl(gw.geodesic_field(start).field) < 0.7 * gw.total_curl(start)
    True
    """
    return float(np.abs(integrated_curl(field)).sum())


@dataclass(frozen=True, eq=False)
class Handles:
    """Faces on which the field is prescribed, ``w_i = w_i^H`` and ``delta_i = 0`` (the set H of Eq. 5).

    Attributes
    ----------
    faces : (H,) int64, distinct
    values : (H,) complex unit vectors in the frames of those faces

    Examples
    --------
    >>> torus = gw.shapes.torus(faces=400)
    >>> upward = gw.Handles.from_ambient(torus, [0], torus.face_normals[:1] + torus.frames[:1, 1])
    >>> solve = gw.geodesic_field(gw.smoothest_field(torus), handles=upward)
    >>> solve.field.ambient[0].round(6) == torus.frames[0, 1].round(6)
    array([ True,  True,  True])
    """

    faces: Indices
    values: Complexes

    @classmethod
    def from_ambient(cls, mesh: TriMesh, faces: Iterable[int], vectors: ArrayLike) -> Handles:
        """Build handles from (H, 3) vectors in space, projected to their faces and scaled to length one.

        Raises
        ------
        FieldError
            If a face is out of range or named twice, or a vector has no part in the plane of its face.
        """
        index = np.array(list(faces), dtype=np.int64)
        ambient = np.asarray(vectors, dtype=np.float64).reshape(-1, 3)
        if len(ambient) != len(index):
            raise FieldError(
                f"{counted(len(index), 'handle face')} but {counted(len(ambient), 'handle vector')}"
            )
        outside = (index < 0) | (index >= mesh.n_faces)
        if outside.any():
            raise FieldError(f"handle face {int(index[outside][0])} is not one of 0..{mesh.n_faces - 1}")
        if len(np.unique(index)) < len(index):
            raise FieldError("a handle face is named twice; give each face one direction")
        frames = mesh.frames[index]
        planar = np.einsum("hx,hx->h", ambient, frames[:, 0]) + 1j * np.einsum(
            "hx,hx->h", ambient, frames[:, 1]
        )
        steep = ~(np.abs(planar) > STEEP * np.linalg.norm(ambient, axis=1))
        if steep.any():
            raise FieldError(
                f"the handle on face {int(index[steep][0])} has no direction in its plane; tilt it"
            )
        return cls(frozen(index), frozen(planar / np.abs(planar)))

    def marks(self, mesh: TriMesh) -> Flags:
        """(F,) whether each face of the mesh is a handle."""
        on = np.zeros(mesh.n_faces, dtype=bool)
        on[self.faces] = True
        return on
