"""The integrating factor s: it makes ``s w-perp`` as integrable as it can be (Section 4.2.3, Appendix C).

Both methods look for the integrable field ``v = B x`` (`ClosedFields`) nearest to ``s w-perp``; they differ
in how nearness is measured. "eigenvector" is the paper's Eq. 7. "logarithm" writes ``s = exp(sigma)``,
positive whatever sigma is, and measures nearness relative to s (DEVIATIONS.md, rescaling).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from scipy import sparse

from geoweave.arrays import Complexes, Indices, Scalars, frozen
from geoweave.errors import FieldError
from geoweave.fields import (
    ClosedFields,
    FaceField,
    as_complex,
    as_real,
    face_laplacian,
    face_mass,
    field_mass,
)
from geoweave.sparse import (
    Ordering,
    Reused,
    factorized,
    nested_dissection,
    one_blas_thread,
)
from geoweave.surface import TriMesh

Method: TypeAlias = Literal["logarithm", "eigenvector"]
"""How `integrating_factor` measures the distance to the integrable fields."""

SMOOTHNESS = {"eigenvector": 1e-4, "logarithm": 2e-4}
"""mu of Eq. 7, "in all of our examples", and of its logarithm, in squared bounding radii."""

LEAST_SMOOTHNESS = 0.25
"""mu of the logarithm is at least so many squared mean edges: below, a coarse mesh has s follow its noise."""

POWER_STEPS = 10
"""Steps of Algorithm 2 from s = 1; more of them drift into modes that change sign."""

NEWTON_STEPS = 12
"""Most Gauss-Newton steps of the logarithm."""

SETTLED = 1e-4
"""A Gauss-Newton step that lowers the energy by less than this share of it is the last."""

SHORTEST = 1e-3
"""A Gauss-Newton step is halved until it lowers the energy, but not below this share of its length."""

EXACT = 1e-7
"""What conjugate gradients leave of a Gauss-Newton step, as a share."""

GAUGE = 1e-6
"""Weight of a step in sigma beside 1: it decides the direction in which v and s grow together."""


@dataclass(frozen=True, eq=False)
class IntegratingFactor:
    """What `integrating_factor` found.

    Attributes
    ----------
    field : the unit field w that was rescaled
    s : (F,) the factor, area mean 1 on each component; positive by construction with "logarithm", and with
        "eigenvector" as it came
    integrable : (F,) the integrable field nearest to s w-perp, complex, in the same unit
    energies : the functional at the start and after each step
    """

    field: FaceField
    s: Scalars
    integrable: Complexes
    energies: tuple[float, ...]


def perpendicular(field: FaceField) -> Complexes:
    """w-perp, (F,): the clockwise quarter turn of the unit field, where grad theta should point."""
    return -1j * field.normalized().values


def vertices_and_faces(mesh: TriMesh, places: Indices | None = None) -> Ordering:
    """Elimination order of matrices with a row per vertex, then one per face, that couple neighbours.

    Parameters
    ----------
    mesh : the surface
    places : (V + F,) number of the place of each vertex and face, from 0, where those that share a place are
        coupled too; they are then eliminated one after the other
    """
    n, edges = mesh.n_vertices, mesh.edges
    pairs = mesh.edge_faces[mesh.interior_edges]
    first = [edges[:, 0], n + pairs[:, 0], mesh.faces.ravel()]
    second = [edges[:, 1], n + pairs[:, 1], n + np.repeat(np.arange(mesh.n_faces), 3)]
    i, j, size = np.concatenate(first), np.concatenate(second), n + mesh.n_faces
    if places is not None:
        i, j, size = places[i], places[j], int(places.max()) + 1
    half = sparse.coo_array((np.ones(len(i)), (i, j)), shape=(size, size)).tocsr()
    found = nested_dissection(sparse.csr_array(half + half.T))
    if places is None or found.order is None:
        return found
    rank = np.empty(size, dtype=np.int64)
    rank[found.order] = np.arange(size)
    return Ordering(np.argsort(rank[places], kind="stable"))


def integrating_factor(
    field: FaceField,
    *,
    method: Method = "logarithm",
    smoothness: float | None = None,
    steps: int | None = None,
    ordering: Ordering | None = None,
) -> IntegratingFactor:
    """Rescale a unit field so that ``s w-perp`` is as near as possible to being integrable (Section 4.2.3).

    "eigenvector" is Eq. 7: with ``delta = v - s w-perp``, v integrable,

        min 1/2 |delta|^2 + mu/2 |grad s|^2   subject to |s|^2 + |delta|^2 = const,

    by steps of ``(A1 + A2)^-1 A2`` from s = 1 in the unknowns (x, s), ``v = B x``, which need no projection.
    "logarithm" minimises, over sigma and x together, by Gauss-Newton steps,

        1/2 |exp(-sigma) v - w-perp|^2 + mu/2 |grad sigma|^2,   s = exp(sigma).

    It measures the same departure in units of s: the sine of the angle by which level sets would leave the
    field. Smoothing the logarithm does not shrink the large values of s near singularities.

    Parameters
    ----------
    field : the field w, on a surface without its singular vertices
    method : see above
    smoothness : mu, in squared bounding radii of the mesh. If not given, 1e-4 for "eigenvector" (the
        paper's), and for "logarithm" 2e-4 or a quarter of the squared mean edge, whichever is more
    steps : number of steps; 10 of the power iteration, up to 12 Gauss-Newton steps if not given
    ordering : of `vertices_and_faces`, made here if not given

    Raises
    ------
    FieldError
        If mu is not a positive number or the method is unknown.
    """
    if method not in SMOOTHNESS:
        raise FieldError(
            f"there is no method '{method}' for the integrating factor: {' or '.join(SMOOTHNESS)}"
        )
    mesh = field.mesh
    weight = SMOOTHNESS[method] if smoothness is None else smoothness
    if smoothness is None and method == "logarithm":
        weight = max(weight, LEAST_SMOOTHNESS * (mesh.mean_edge / mesh.bounding_radius) ** 2)
    if not (np.isfinite(weight) and weight > 0):
        raise FieldError(f"the smoothness of the integrating factor must be positive, not {weight}")
    closed = ClosedFields(mesh)
    mu = weight * mesh.bounding_radius**2
    with one_blas_thread():
        order = _unknowns(closed, ordering or vertices_and_faces(mesh))
        if method == "eigenvector":
            return _eigenvector(field, closed, mu, POWER_STEPS if steps is None else steps, order)
        return _logarithm(field, closed, mu, NEWTON_STEPS if steps is None else steps, order)


def _unknowns(closed: ClosedFields, ordering: Ordering) -> Ordering:
    """Order (x, s): potentials and faces as they are among all vertices and faces, generators last."""
    mesh, free = closed.mesh, closed.free_vertices
    kept = ordering.of(np.concatenate([free, mesh.n_vertices + np.arange(mesh.n_faces)])).order
    if kept is None:
        return ordering
    generators = closed.basis.shape[1] - len(free)
    moved = np.where(kept < len(free), kept, kept + generators)
    return Ordering(np.concatenate([moved, len(free) + np.arange(generators)]))


def _eigenvector(
    field: FaceField, closed: ClosedFields, mu: float, steps: int, ordering: Ordering
) -> IntegratingFactor:
    """Eq. 7 as the generalised eigenproblem of Appendix C, without its constraint."""
    mesh = field.mesh
    target = _scaled_by_faces(perpendicular(field))
    cross = -sparse.csr_array(closed.basis_transposed @ field_mass(mesh) @ target)
    areas = face_mass(mesh)
    # x' A1 x and x' A2 x, with |delta|^2 = |B x - W s|^2 written out.
    first = _blocks(closed.mass, cross, sparse.csr_array(areas + mu * face_laplacian(mesh)))
    second = _blocks(closed.mass, cross, sparse.csr_array(2.0 * areas))
    total = sparse.csr_array(first + second)
    factors = factorized(total, ordering)
    split = closed.basis.shape[1]
    ones = np.ones(mesh.n_faces)
    y = np.concatenate([_nearest_integrable(closed, perpendicular(field), ones, ordering), ones])
    energies = [_quotient(first, second, y)]
    for _ in range(steps):
        y = factors.solve(second @ y)
        y /= np.sqrt(y @ (second @ y))
        energies.append(_quotient(first, second, y))
    return _normalised(field, y[split:], as_complex(closed.basis @ y[:split]), energies)


def _quotient(first: sparse.csr_array, second: sparse.csr_array, y: Scalars) -> float:
    return float((y @ (first @ y)) / (y @ (second @ y)))


def _logarithm(
    field: FaceField, closed: ClosedFields, mu: float, steps: int, ordering: Ordering
) -> IntegratingFactor:
    """Gauss-Newton on (x, sigma); a face's sigma couples to its neighbours and to the x of its corners."""
    mesh, target = field.mesh, perpendicular(field)
    area, laplacian, split = mesh.face_areas, face_laplacian(mesh), closed.basis.shape[1]

    def energy(v: Complexes, sigma: Scalars) -> float:
        miss = np.abs(np.exp(-sigma) * v - target) ** 2
        return float(0.5 * area @ miss + 0.5 * mu * sigma @ (laplacian @ sigma))

    sigma = np.zeros(mesh.n_faces)
    x = _nearest_integrable(closed, target, np.exp(sigma), ordering)
    v = as_complex(closed.basis @ x)
    energies = [energy(v, sigma)]
    solver = Reused(ordering, nearness=EXACT)
    for _ in range(steps):
        shrink = np.exp(-sigma)
        relative = shrink * v
        miss = relative - target
        # Residual shrink * (B dx) - relative * dsigma + miss; scaling s and v together changes nothing, and
        # the small diagonal term keeps the step from drifting that way.
        weight = np.repeat(area * shrink**2, 2)
        upper = sparse.csr_array(closed.basis_transposed @ sparse.diags_array(weight) @ closed.basis)
        cross = -closed.basis_transposed @ _scaled_by_faces(area * shrink * relative)
        lower = sparse.diags_array(area * (np.abs(relative) ** 2 + GAUGE)) + mu * laplacian
        matrix = _blocks(upper, cross, lower)
        downhill = np.concatenate(
            [
                -(closed.basis_transposed @ as_real(area * shrink * miss)),
                area * (relative.conj() * miss).real - mu * (laplacian @ sigma),
            ]
        )
        # sigma changes too much from step to step for factors to serve two of them.
        step = solver.of(matrix, anew=True).solve(downhill)
        dv, ds, length = as_complex(closed.basis @ step[:split]), step[split:], 1.0
        while (new := energy(v + length * dv, sigma + length * ds)) > energies[-1] and length > SHORTEST:
            length *= 0.5
        if new >= energies[-1]:
            break
        v, sigma = v + length * dv, sigma + length * ds
        energies.append(new)
        if energies[-2] - new < SETTLED * new:
            break
    return _normalised(field, np.exp(sigma - sigma.mean()), v * np.exp(-sigma.mean()), energies)


def _scaled_by_faces(vectors: Complexes) -> sparse.csr_array:
    """The map from a number per face to that multiple of the face's vector, (2F, F)."""
    count = len(vectors)
    rows = np.arange(2 * count)
    return sparse.csr_array((as_real(vectors), (rows, rows // 2)), shape=(2 * count, count))


def _blocks(upper: sparse.csr_array, cross: sparse.csr_array, lower: sparse.csr_array) -> sparse.csr_array:
    return sparse.csr_array(sparse.block_array([[upper, cross], [cross.T, lower]], format="csr"))


def _nearest_integrable(closed: ClosedFields, target: Complexes, s: Scalars, ordering: Ordering) -> Scalars:
    """Coordinates x of the integrable field nearest to ``s target``."""
    right = closed.basis_transposed @ (field_mass(closed.mesh) @ as_real(s * target))
    return factorized(closed.mass, ordering.of(np.arange(closed.basis.shape[1]))).solve(right)


def _normalised(field: FaceField, s: Scalars, v: Complexes, energies: list[float]) -> IntegratingFactor:
    """Give s the area mean 1 on each component (Appendix C: components do not know each other's scale)."""
    mean = field.mesh.component_means(np.abs(s))[field.mesh.face_components]
    return IntegratingFactor(field, frozen(s / mean), frozen(v / mean), tuple(energies))
