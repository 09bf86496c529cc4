"""Fields that are as smooth as possible: where Algorithm 1 starts (Section 4.1.3, Knöppel et al. 2013)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, TypeAlias

import numpy as np
from scipy import sparse

from geoweave.arrays import Complexes, Indices, Scalars
from geoweave.errors import FieldError
from geoweave.fields import FaceField, edge_curl, random_field, unit
from geoweave.linalg import factorized, nested_dissection, one_blas_thread, smallest_eigenpair
from geoweave.mesh import TriMesh
from geoweave.operators import connection_laplacian

Phase: TypeAlias = Literal["least-curl", "seeded"]
"""How the common rotation is chosen that the Dirichlet energy leaves free: see `smoothest_field`."""


@one_blas_thread()
def smoothest_eigenfield(mesh: TriMesh, seed: int | np.random.Generator = 0) -> tuple[Scalars, FaceField]:
    """Solve ``L u = mu M u`` for the smallest mu: the globally smoothest face field, not yet unit.

    The Dirichlet energy of Appendix B on complex face fields, least for its norm (Knöppel et al. 2013).
    Each connected component is a problem of its own; eigenvectors are converged to working precision.

    Returns
    -------
    mu : (components,) energy of the field at ``sum A |u|^2 = 1`` on each component, unit 1 / length^2
    field : the eigenvectors
    """
    rng = np.random.default_rng(seed)
    start: Complexes = rng.normal(size=mesh.n_faces) + 1j * rng.normal(size=mesh.n_faces)
    laplacian = connection_laplacian(mesh)
    values = np.empty(mesh.n_faces, dtype=np.complex128)
    energies = []
    for faces, block in _component_blocks(mesh, laplacian):
        areas = mesh.face_areas[faces]
        # A flat surface has mu = 0: the shift, small against 1 / area, keeps the matrix definite.
        shift = 1e-3 / areas.sum()
        factors = factorized(block + sparse.diags_array(shift * areas), nested_dissection(block))
        mu, values[faces] = smallest_eigenpair(factors, areas, start[faces])
        energies.append(mu - shift)
    return np.array(energies), FaceField(mesh, values)


def _component_blocks(mesh: TriMesh, matrix: sparse.csr_array) -> Iterator[tuple[Indices, sparse.csr_array]]:
    """Split a matrix over faces into one block per component, with the faces of each."""
    if mesh.n_components == 1:
        yield np.arange(mesh.n_faces), matrix
        return
    order = np.argsort(mesh.face_components, kind="stable")
    ends = np.cumsum(np.bincount(mesh.face_components))
    grouped = matrix[order][:, order]
    for start, end in zip(np.concatenate([[0], ends[:-1]]), ends, strict=True):
        yield order[start:end], grouped[start:end, start:end]


def smoothest_field(
    mesh: TriMesh, seed: int | np.random.Generator = 0, *, phase: Phase = "least-curl"
) -> FaceField:
    """Compute the smoothest unit field on the faces (Knöppel et al. 2013, with one vector per face).

    The eigenvector of `smoothest_eigenfield`, each vector scaled to length one. Rotating all its vectors by
    one common angle leaves the Dirichlet energy unchanged, so the minimiser is a circle of fields.

    Parameters
    ----------
    mesh : any surface; each component gets its own field
    seed : of the start vector
    phase : which field of the circle to return. ``"least-curl"``, the default, is the one whose edge curl
        ``|C w|`` is least, so that neither the seed nor the frames decide; ``"seeded"`` is the one the
        start vector leads to, as in Knöppel et al.

    Returns
    -------
    FaceField of unit vectors
    """
    if phase not in ("least-curl", "seeded"):
        raise FieldError(f"there is no phase '{phase}': use 'least-curl' or 'seeded'")
    _, field = smoothest_eigenfield(mesh, seed)
    field = field.normalized()
    return field if phase == "seeded" else _with_least_curl(field)


def _with_least_curl(field: FaceField) -> FaceField:
    """Rotate the field by the common angle, one per component, that makes ``|C w|^2`` least."""
    # |C (cos a w + sin a Jw)|^2 is a quadratic form in (cos a, sin a), least along its first eigenvector.
    mesh = field.mesh
    component = mesh.face_components[mesh.edge_faces[mesh.interior_edges, 0]]
    jumps = edge_curl(field), edge_curl(FaceField(mesh, 1j * field.values))
    forms = np.empty((mesh.n_components, 2, 2))
    for a, b in np.ndindex(2, 2):
        forms[:, a, b] = np.bincount(component, jumps[a] * jumps[b], mesh.n_components)
    axes = np.linalg.eigh(forms)[1][:, :, 0]
    # Of the two opposite fields the one nearer to the given.
    rotation = (axes[:, 0] + 1j * axes[:, 1]) * np.where(axes[:, 0] < 0, -1.0, 1.0)
    return FaceField(mesh, field.values * rotation[mesh.face_components])


@one_blas_thread()
def diffused_field(
    mesh: TriMesh,
    smoothness: float = 1.0,
    seed: int | np.random.Generator = 0,
    *,
    tolerance: float = 1e-6,
    iterations: int = 1000,
) -> FaceField:
    """Flow a random field to a smooth one: Eq. 5 without the curl constraint, the start of Table 1.

    Alternates ``(M + lambda L) v = M w`` and ``w <- v / |v|`` until the field stands still. The paper starts
    the rows of Table 1 here and calls the result qualitatively similar to Knöppel et al. 2013.

    Parameters
    ----------
    smoothness : lambda, unit length^2
    seed : of the random field
    tolerance : stop when the root mean square change of w in a step is below this
    iterations : stop after so many steps in any case

    Returns
    -------
    FaceField of unit vectors
    """
    if not 0 < smoothness < np.inf:
        raise FieldError(f"the smoothness must be positive and finite, not {smoothness}")
    mass = sparse.diags_array(mesh.face_areas)
    laplacian = connection_laplacian(mesh)
    factors = factorized(mass + smoothness * laplacian, nested_dissection(laplacian))
    w = random_field(mesh, seed).values
    for _ in range(iterations):
        w, previous = unit(factors.solve(mesh.face_areas * w)), w
        if np.average(np.abs(w - previous) ** 2, weights=mesh.face_areas) < tolerance**2:
            break
    return FaceField(mesh, w)
