"""The delta step of Algorithm 1: the closed field nearest to a unit field (Section 4.1.2, Eq. 9)."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from geoweave.arrays import Complexes, Indices, Scalars
from geoweave.errors import FieldError
from geoweave.fields.face_field import Handles, unit
from geoweave.fields.operators import AllFields, ClosedFields, as_complex, as_real, dual_weights
from geoweave.fields.refinement import Refinement
from geoweave.sparse import Analysis, Factorization, Ordering, factorized, nested_dissection

REPEATED = 1e-11
"""Constraints of handles whose eigenvalue is below this share of the largest repeat other constraints."""

CONTRADICTION = 1e-6
"""Misfit of a unit vector on a handle beyond which the handles contradict one another."""

TOLERABLE_LOSS = 1e-5
"""Relative error of the first closed field up to which its factors are taken at their word."""


class ClosedProjection:
    """The delta step of Algorithm 1: the closed field nearest to w, and smooth (Eq. 9 without multipliers).

    ``v = argmin 1/2 |v - w|^2 + lambda/2 |grad v|^2`` over all closed fields ``v = B x``, with ``v = w`` on
    the handles; the normal equations ``B' (M + lambda L) B x = B' M w`` are factored once.

    Parameters
    ----------
    fields : the closed fields of the mesh, or all its fields
    smoothness : lambda >= 0, unit length^2
    ordering : of `ordering_of(fields)`, or an analysis in it; the same for every smoothness
    handles : faces where v is prescribed

    Raises
    ------
    FieldError
        If the smoothness is negative, or no closed field takes the handles' values.
    """

    def __init__(
        self,
        fields: ClosedFields | AllFields,
        smoothness: float,
        ordering: Ordering | Analysis,
        handles: Handles | None = None,
    ) -> None:
        if not 0 <= smoothness < np.inf:
            raise FieldError(f"the smoothness must be finite and must not be negative, not {smoothness}")
        self.fields = fields
        self.smoothness = smoothness
        self._mass = np.repeat(fields.mesh.face_areas, 2)
        self._refining: Refinement | None = None
        self._checked = False
        system = fields.mass + smoothness * fields.smoothness
        if handles is not None:
            system = system + _pinning(fields, smoothness, handles)
        self._factors = factorized(sparse.csr_array(system), ordering)
        self._pins = _Pins(fields, self._factors, handles) if handles is not None else None

    def unit(self, v: Complexes) -> Complexes:
        """The w step of Algorithm 1: scale to length one; on handles take the prescribed vector, exactly."""
        w = unit(v)
        return w if self._pins is None else self._pins.exact(w)

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return self._factors.size

    @property
    def fill(self) -> int:
        """Stored entries of the factors."""
        return self._factors.fill

    def refine(self) -> bool:
        """Solve to rounding from now on; False if that was so already (DEVIATIONS.md, refinement)."""
        if self._refining is not None:
            return False
        self._refining = self._refinement()
        return True

    def _refinement(self) -> Refinement:
        tangential = None if self._pins is None else self._pins.tangential
        return Refinement(self.fields, self.smoothness, self._factors, tangential)

    def _loss(self, w: Complexes, x: Scalars) -> float:
        """Relative error that the factors leave in the closed field nearest to w, as one correction shows."""
        return self._refinement().loss(as_real(w), x)

    def __call__(self, w: Complexes) -> tuple[Complexes, float]:
        """Return the closed field v nearest to w, (F,), and the energy of Eq. 5 at ``delta = v - w``."""
        x = self._factors.solve(self.fields.basis_transposed @ (self._mass * as_real(w)))
        if self._pins is not None:
            x = self._pins.impose(x)
        if not self._checked:
            self._checked = True
            if self._loss(w, x) > TOLERABLE_LOSS:
                self.refine()
        refining = self._refining
        v = as_complex(self.fields.basis @ x if refining is None else refining(as_real(w), x))
        if self._pins is not None:
            v = self._pins.exact(v)
        distance = float(self.fields.mesh.face_areas @ np.abs(v - w) ** 2)
        if refining is None:
            roughness = max(0.0, float(x @ (self.fields.smoothness @ x)))
        else:
            roughness = refining.roughness(as_real(v))
        return v, 0.5 * distance + 0.5 * self.smoothness * roughness


def _pinning(fields: ClosedFields | AllFields, smoothness: float, handles: Handles) -> sparse.csr_array:
    """``g B_H' B_H``: constant where the handles hold, so it changes no minimiser, but it keeps K definite.

    At large lambda the mass alone holds what has no Dirichlet energy (on flat surfaces the constant fields),
    and the solution would lose as many digits as lambda has.
    """
    mesh = fields.mesh
    rows = fields.basis[_rows(handles)]
    weight = float(mesh.face_areas.mean() + smoothness * dual_weights(mesh).mean())
    return sparse.csr_array(weight * (rows.T @ rows))


def _rows(handles: Handles) -> Indices:
    """Rows of B that belong to the handles' faces."""
    return np.asarray((2 * handles.faces[:, None] + np.arange(2)).ravel(), dtype=np.int64)


class _Pins:
    """Handles as equality constraints ``B_H x = w^H`` on a factored system, through its Schur complement."""

    def __init__(self, fields: ClosedFields | AllFields, factors: Factorization, handles: Handles) -> None:
        self._handles = handles
        self._constraint = fields.basis[_rows(handles)]
        self._values = as_real(handles.values)
        self._response = factors.solve(self._constraint.T.toarray())
        schur = self._constraint @ self._response
        # Touching handle faces share an edge, so some constraints repeat others: a pseudo-inverse.
        size, axes = np.linalg.eigh(schur)
        kept = size > REPEATED * size[-1]
        self._inverse = (axes[:, kept] / size[kept]) @ axes[:, kept].T
        misfit = np.abs(schur @ (self._inverse @ self._values) - self._values).reshape(-1, 2).max(axis=1)
        if misfit.max() > CONTRADICTION:
            raise FieldError(
                f"the handle on face {int(handles.faces[misfit.argmax()])} contradicts its neighbours: no "
                "curl-free field takes their values (across a shared edge both must have the same "
                "projection on it); turn it or leave it out"
            )

    def impose(self, x: Scalars) -> Scalars:
        # The second round takes away what rounding left in the first: 1e-9 at large smoothness.
        for _ in range(2):
            x = x + self._response @ (self._inverse @ (self._values - self._constraint @ x))
        return x

    def tangential(self, x: Scalars) -> Scalars:
        """Take from a change of coordinates what would change the values on the handles."""
        return np.asarray(x - self._response @ (self._inverse @ (self._constraint @ x)))

    def exact(self, v: Complexes) -> Complexes:
        v = v.copy()
        v[self._handles.faces] = self._handles.values
        return v


def ordering_of(fields: ClosedFields | AllFields) -> Ordering:
    """Elimination order of ``B' (M + lambda L) B`` for every lambda: potentials, then generators."""
    if isinstance(fields, AllFields):
        return nested_dissection(fields.smoothness)
    free = len(fields.free_vertices)
    return nested_dissection(fields.smoothness[:free, :free]).with_last(fields.basis.shape[1] - free)
