"""Eq. 8 as a function of theta and s: its value, its slopes, and convex models of it (Section 4.2.4)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from geoweave.arrays import Indices, Scalars
from geoweave.fields import FaceField, face_laplacian
from geoweave.foliation.integrability import perpendicular
from geoweave.surface import TriMesh

LEAST_COTANGENT = 0.02
"""Floor of the cotangent weights: half the cotangent of an angle of 88 degrees."""

LEAST_COSINE = 0.1
"""The quadratic model of ``1 - cos`` stays at least so convex."""


def along_edges(field: FaceField) -> Scalars:
    """(F, 3) ``w-perp . e`` on the half-edge opposite each corner."""
    return np.asarray((perpendicular(field).conj()[:, None] * field.mesh.halfedge_vectors).real)


def _cotangents(mesh: TriMesh) -> Scalars:
    """(F, 3) half the cotangent of each corner, the weight of the half-edge opposite, kept positive."""
    h = mesh.halfedge_vectors
    at_corner = -(h[:, [1, 2, 0]].conj() * h[:, [2, 0, 1]]).real
    return np.maximum(at_corner / (4.0 * mesh.face_areas[:, None]), LEAST_COTANGENT)


class HalfedgeEnds(NamedTuple):
    """The two ends of every half-edge, (3F,) each, and the signs with which its face sees their angles."""

    tail: Indices
    head: Indices
    tail_sign: Scalars
    head_sign: Scalars

    @classmethod
    def of(cls, mesh: TriMesh) -> HalfedgeEnds:
        """The ends of the half-edges of a mesh, face by face."""
        starts, ends, corner = [1, 2, 0], [2, 0, 1], mesh.bundle.corners
        return cls(
            mesh.faces[:, starts].ravel(),
            mesh.faces[:, ends].ravel(),
            corner[:, starts].ravel(),
            corner[:, ends].ravel(),
        )

    @property
    def between(self) -> Scalars:
        """(3F,) sign of one end as seen from the other."""
        return self.tail_sign * self.head_sign


class Model(NamedTuple):
    """A convex quadratic model of Eq. 8 at one theta and s, and the way downhill from there."""

    weights: Scalars
    """(F, 3) curvature in the residual of each half-edge."""
    in_theta: Scalars
    """(V,) minus the gradient in theta."""
    in_share: Scalars
    """(F,) minus the gradient in ``s / shat``."""


class ThetaEnergy:
    """Eq. 8 on one surface.

    Parameters
    ----------
    field : the unit field w
    unit : (F,) shat, the unit in which Eq. 8 measures s
    smoothness : mu, unit length^2
    """

    def __init__(self, field: FaceField, unit: Scalars, smoothness: float) -> None:
        mesh = field.mesh
        self.mesh, self.unit, self.smoothness = mesh, unit, smoothness
        self.along = along_edges(field)
        self.slope = unit[:, None] * self.along
        self.weight = _cotangents(mesh) / unit[:, None] ** 2
        self.ends = HalfedgeEnds.of(mesh)
        self.laplacian = face_laplacian(mesh)

    def residual(self, theta: Scalars, s: Scalars) -> Scalars:
        """(F, 3) ``theta_b - theta_a - s_i w-perp_i . e_ab``, radians, up to full turns."""
        tail, head, tail_sign, head_sign = self.ends
        rise = head_sign * theta[head] - tail_sign * theta[tail]
        return np.asarray(rise.reshape(-1, 3) - s[:, None] * self.along)

    def __call__(self, theta: Scalars, s: Scalars) -> float:
        """Eq. 8, in the unit that `geoweave.foliation.foliation.foliate` says."""
        share = s / self.unit
        smooth = 0.5 * self.smoothness * share @ (self.laplacian @ share)
        return float((self.weight * (1.0 - np.cos(self.residual(theta, s)))).sum() + smooth)

    def model(self, theta: Scalars, s: Scalars) -> Model:
        """The model of Eq. 8 near a theta and an s."""
        tail, head, tail_sign, head_sign = self.ends
        residual, n = self.residual(theta, s), self.mesh.n_vertices
        convex = self.weight * np.maximum(np.cos(residual), LEAST_COSINE)
        pull = self.weight * np.sin(residual)
        in_theta = np.bincount(tail, tail_sign * pull.ravel(), n)
        in_theta -= np.bincount(head, head_sign * pull.ravel(), n)
        in_share = (pull * self.slope).sum(axis=1) - self.smoothness * (self.laplacian @ (s / self.unit))
        return Model(convex, np.asarray(in_theta, dtype=np.float64), np.asarray(in_share))
