"""Anti-holomorphic fields (Knöppel et al. 2013), with which Section 4.1 compares geodesic fields (Fig. 7)."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from geoweave.arrays import Complexes
from geoweave.comparisons.fitted_derivatives import Derivatives
from geoweave.errors import FieldError
from geoweave.fields import FaceField, dual_weights, spectral_shift, unit
from geoweave.sparse import factorized, nested_dissection, one_blas_thread, smallest_eigenpair
from geoweave.surface import TriMesh, part_of
from geoweave.wording import counted


def conformal_energy(mesh: TriMesh, balance: float) -> sparse.csr_array:
    """Energy between the anti-holomorphic and the holomorphic one, (F, F) Hermitian (Knöppel et al. 2013).

    ``conj(u) @ E @ u = (1 + s) E_H + (1 - s) E_A``, s the balance: 1 is holomorphic, 0 Dirichlet, -1
    anti-holomorphic. The halves ``E_H = 2 integral |du / d conj(z)|^2`` and ``E_A = 2 integral |du / dz|^2 =
    1/2 integral (div^2 + curl^2)`` add up to the Dirichlet energy; their difference is ``E_A - E_H = integral
    K |u|^2`` and a term on the boundary. Knöppel et al. start from that identity, for fields on vertices. On
    faces the derivatives are fitted to the neighbours of each face; what the fit leaves, zero on linear
    fields, counts as in Appendix B and keeps alternating fields out (DEVIATIONS.md, anti-holomorphic).

    Parameters
    ----------
    balance : s, between -1 and 1

    Returns
    -------
    (F, F) positive semi-definite

    Raises
    ------
    FieldError
        If the balance is out of range.
    """
    if not -1 <= balance <= 1:
        raise FieldError(f"the balance of a conformal energy lies between -1 and 1, not at {balance}")
    fit = Derivatives.fitted(mesh)
    areas = sparse.diags_array(2.0 * mesh.face_areas)
    weights = np.zeros(mesh.n_edges)
    weights[mesh.interior_edges] = 0.5 * dual_weights(mesh)  # each edge is seen from both sides
    left = sparse.diags_array(weights[mesh.face_edges].ravel())
    return sparse.csr_array(
        (1.0 + balance) * (fit.q.conj().T @ areas @ fit.q)
        + (1.0 - balance) * (fit.p.conj().T @ areas @ fit.p)
        + fit.misfit.conj().T @ left @ fit.misfit
    )


@one_blas_thread()
def anti_holomorphic_field(mesh: TriMesh, seed: int | np.random.Generator = 0) -> FaceField:
    """Compute the unit field of least anti-holomorphic energy (Knöppel et al. 2013, Fig. 7, second panel).

    The eigenvector of ``E_A u = mu M u`` for the smallest mu, each vector scaled to length one. The energy is
    the squared divergence plus the squared curl, so a rotation of all vectors by one angle leaves it
    unchanged; which field of that circle comes out is up to the seed, as with ``phase="seeded"`` of
    `smoothest_field`. On a sphere its minimisers are those of the Dirichlet energy, a space of
    three complex dimensions, and the seed chooses among them.

    Parameters
    ----------
    mesh : closed; each component gets its own field
    seed : of the start vector

    Returns
    -------
    FaceField of unit vectors

    Raises
    ------
    FieldError
        If the surface has a boundary: there every anti-holomorphic field has zero energy, infinitely many.
    """
    if len(mesh.boundary_edges):
        raise FieldError(
            "the anti-holomorphic energy needs a closed surface, and this one has "
            f"{counted(len(mesh.boundary_loops), 'boundary loop')}: there infinitely many fields have no "
            "energy at all"
        )
    rng = np.random.default_rng(seed)
    start: Complexes = rng.normal(size=mesh.n_faces) + 1j * rng.normal(size=mesh.n_faces)
    values = np.empty(mesh.n_faces, dtype=np.complex128)
    for component in range(mesh.n_components):
        part = part_of(mesh, mesh.face_components == component)
        areas = part.mesh.face_areas
        energy = conformal_energy(part.mesh, -1.0)
        # Harmonic fields have next to no energy.
        shift = spectral_shift(areas)
        factors = factorized(
            sparse.csr_array(energy + sparse.diags_array(shift * areas)), nested_dissection(energy)
        )
        _, values[part.faces] = smallest_eigenpair(factors, areas, start[part.faces])
    return FaceField(mesh, unit(values))
