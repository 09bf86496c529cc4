"""Closed fields to working precision on distorted meshes (DEVIATIONS.md, refinement).

The condition of ``B' (M + lambda L) B`` grows with the fourth power of the size over the edge length, and
with the large weights that flat triangles have in L. On long strips and on meshes with slivers its factors
lose most digits. There the field is corrected by conjugate gradients with the factors as preconditioner.
Their residuals are made from the vectors on the faces, where nothing cancels.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from geoweave.arrays import Scalars
from geoweave.errors import FieldError
from geoweave.fields.operators import AllFields, ClosedFields, dual_weights, transport_differences
from geoweave.sparse import Factorization

REFINED = 1e-10
"""A correction smaller than this share of the field is the last."""

CORRECTIONS = 200
"""Most corrections of one field; two or three are usual."""


class Refinement:
    """Corrections of ``v = argmin 1/2 |v - w|^2 + lambda/2 |grad v|^2`` over ``v = B x``.

    Parameters
    ----------
    fields : the fields ``B x``
    smoothness : lambda, unit length^2
    factors : of ``B' (M + lambda L) B``, inexact
    tangential : takes from a change of x what handles do not allow; None without handles
    """

    def __init__(
        self,
        fields: ClosedFields | AllFields,
        smoothness: float,
        factors: Factorization,
        tangential: Callable[[Scalars], Scalars] | None,
    ) -> None:
        self._mesh = fields.mesh
        self._basis, self._transposed = fields.basis, fields.basis_transposed
        self._mass = np.repeat(fields.mesh.face_areas, 2)
        self._jumps = transport_differences(fields.mesh)
        self._falls = self._jumps.T.tocsr()
        self._weights = np.repeat(dual_weights(fields.mesh), 2)
        self._smoothness, self._factors, self._tangential = smoothness, factors, tangential

    def roughness(self, v: Scalars) -> float:
        """``|grad v|^2`` of a field, (2F,), as a sum of squares: it cannot come out negative."""
        return float(self._weights @ (self._jumps @ v) ** 2)

    def _residual(self, w: Scalars, v: Scalars) -> Scalars:
        """Minus the gradient in x of the energy at v."""
        rough = self._falls @ (self._weights * (self._jumps @ v))
        return np.asarray(self._transposed @ (self._mass * (w - v) - self._smoothness * rough))

    def _step(self, residual: Scalars) -> Scalars:
        x = self._factors.solve(residual)
        return x if self._tangential is None else self._tangential(x)

    def _size(self, v: Scalars) -> float:
        return float(np.sqrt(self._mass @ v**2))

    def loss(self, w: Scalars, x: Scalars) -> float:
        """Size of the first correction at x, as a share of the field."""
        v = self._basis @ x
        return self._size(self._basis @ self._step(self._residual(w, v))) / self._size(w)

    def __call__(self, w: Scalars, x: Scalars) -> Scalars:
        """Return the field (2F,) nearest to w, from coordinates x near its own.

        Raises
        ------
        FieldError
            If the corrections do not become small.
        """
        v = np.asarray(self._basis @ x)
        residual = self._residual(w, v)
        ahead, last = np.zeros_like(x), 1.0
        for _ in range(CORRECTIONS):
            step = self._step(residual)
            slope = float(residual @ step)
            if slope <= 0:
                break
            ahead = step + slope / last * ahead
            along = self._basis @ ahead
            bend = float(self._mass @ along**2) + self._smoothness * self.roughness(along)
            v = v + slope / bend * along
            if slope / bend * self._size(along) < REFINED * self._size(w):
                return v
            residual, last = self._residual(w, v), slope
        mesh = self._mesh
        flat = mesh.face_areas / mesh.edge_lengths[mesh.face_edges].max(axis=1) ** 2
        raise FieldError(
            f"some triangles are too flat for double precision (face {int(flat.argmin())} is "
            f"{0.5 / flat.min():.2g} times as long as high); remesh the surface (--faces N)"
        )
