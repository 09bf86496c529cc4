"""Fields that are as smooth as possible, of one vector or of N evenly turned ones (Knöppel et al. 2013).

One vector is where Algorithm 1 starts (Section 4.1.3); N of them, an N-RoSy, say where a weave has its
singularities (Section 5.1, Appendix D).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np
from scipy import sparse

from geoweave.arrays import Complexes, Flags, Indices, Scalars, frozen
from geoweave.errors import FieldError
from geoweave.fields.face_field import FaceField, edge_curl, random_field, unit
from geoweave.fields.least_bending import bending_power
from geoweave.fields.operators import connection_laplacian, spectral_shift
from geoweave.fields.singularities import windings
from geoweave.sparse import factorized, nested_dissection, one_blas_thread, smallest_eigenpair
from geoweave.surface import TriMesh

Phase: TypeAlias = Literal["least-curl", "seeded"]
"""How the common rotation is chosen that the Dirichlet energy leaves free: see `smoothest_field`."""

RoSyPhase: TypeAlias = Literal["bending", "seeded"]
"""The same for an N-RoSy: see `smoothest_rosy`."""

START_NOISE = 1e-3
"""Share of random numbers in a start vector that is given, whose numbers are about 1."""

UNIT_TOLERANCE = 1e-6
"""How far the modulus of an N-RoSy's number may be from 1, a number."""


@one_blas_thread()
def smoothest_eigenfield(
    mesh: TriMesh,
    seed: int | np.random.Generator = 0,
    degree: int = 1,
    *,
    start: Complexes | None = None,
) -> tuple[Scalars, FaceField]:
    """Solve ``L u = mu M u`` for the smallest mu: the globally smoothest face field, not yet unit.

    The Dirichlet energy of Appendix B on complex face fields, or of Appendix D on the N-th powers of the
    vectors of an N-RoSy, least for its norm (Knöppel et al. 2013). Each connected component is a problem of
    its own; eigenvectors are converged to working precision.

    Parameters
    ----------
    mesh : any surface
    seed : of the random start vector
    degree : N; 1 for a vector field
    start : (F,) start vector, to which a little of the random one is added: where the smallest eigenvalue is
        multiple, the eigenvector nearest to it is found. The random one alone if not given

    Returns
    -------
    mu : (components,) energy of the field at ``sum A |u|^2 = 1`` on each component, unit 1 / length^2
    field : the eigenvectors
    """
    rng = np.random.default_rng(seed)
    noise: Complexes = rng.normal(size=mesh.n_faces) + 1j * rng.normal(size=mesh.n_faces)
    # The noise is there for a start that is orthogonal to the eigenvector, by a symmetry or as it is zero.
    start = noise if start is None else start + START_NOISE * noise
    laplacian = connection_laplacian(mesh, degree)
    values = np.empty(mesh.n_faces, dtype=np.complex128)
    energies = []
    for faces, block in _component_blocks(mesh, laplacian):
        areas = mesh.face_areas[faces]
        # A flat surface has mu = 0.
        shift = spectral_shift(areas)
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

    See Also
    --------
    smoothest_rosy : N vectors on every face
    diffused_field : a field that a flow makes smooth, from a random start

    Examples
    --------
    >>> sphere = gw.shapes.sphere(faces=320)
    >>> gw.index_sum(gw.smoothest_field(sphere)) == sphere.euler_characteristic
    True
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

    See Also
    --------
    smoothest_field : the global optimum

    Examples
    --------
    >>> torus = gw.shapes.torus(faces=400)
    >>> [len(gw.singular_vertices(each)) > 20 for each in (gw.random_field(torus), gw.diffused_field(torus))]
    [True, False]
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


@dataclass(frozen=True, eq=False)
class RoSyField:
    """N unit vectors on every face, each an N-th of a turn from the next (Appendix D).

    Attributes
    ----------
    mesh : the surface
    degree : N >= 1
    values : (F,) complex128, read-only: the N-th power of any of the vectors, of modulus 1

    Raises
    ------
    FieldError
        If the degree is not positive or the values are not one unit number per face.

    See Also
    --------
    FaceField : one vector on every face

    Examples
    --------
    >>> disk = gw.shapes.disk(faces=200)
    >>> cross = gw.RoSyField(disk, 4, np.ones(disk.n_faces))
    >>> cross.vectors[0].round(9)
    array([ 1.+0.j,  0.+1.j, -1.+0.j, -0.-1.j])
    """

    mesh: TriMesh
    degree: int
    values: Complexes

    def __post_init__(self) -> None:
        values = np.array(self.values, dtype=np.complex128)
        if self.degree < 1:
            raise FieldError(f"an N-RoSy has N >= 1 vectors on a face, not {self.degree}")
        if values.shape != (self.mesh.n_faces,):
            raise FieldError(
                f"an N-RoSy needs one number per face, ({self.mesh.n_faces},), not {values.shape}"
            )
        off = ~(np.abs(np.abs(values) - 1.0) < UNIT_TOLERANCE)
        if off.any():
            bad = int(np.flatnonzero(off)[0])
            raise FieldError(
                f"the number of the N-RoSy on face {bad} has modulus {abs(values[bad]):.6g}, not 1"
            )
        object.__setattr__(self, "values", frozen(values / np.abs(values)))

    @cached_property
    def vectors(self) -> Complexes:
        """(F, N) the vectors, counter-clockwise: ``w_k = exp(i (arg(value) + 2 pi k) / N)``."""
        turn = np.exp(2j * np.pi * np.arange(self.degree) / self.degree)
        return frozen(np.exp(1j * np.angle(self.values) / self.degree)[:, None] * turn)

    @cached_property
    def matching(self) -> Indices:
        """(E_int,) shift sigma: vector k of face i goes to vector ``(k + sigma) mod N`` of face j.

        The permutation of least summed squared angle between corresponding vectors (Section 5.1). Unfolded,
        two N-RoSys differ by one rotation of at most pi / N; it takes each vector to the nearest, so the best
        of all N! permutations is a cyclic shift.
        """
        i, j = self.mesh.edge_faces[self.mesh.interior_edges].T
        first = self.vectors[:, 0]
        ahead = np.angle(self.mesh.transport * first[i] * first[j].conj())
        return frozen(np.rint(ahead * self.degree / (2.0 * np.pi)).astype(np.int64) % self.degree)

    @cached_property
    def _winding(self) -> Scalars:
        """(V,) N times the turns of the N vectors round each vertex, matched edge by edge."""
        i, j = self.mesh.edge_faces[self.mesh.interior_edges].T
        first = self.vectors[:, 0]
        matched = first[j] * np.exp(2j * np.pi * self.matching / self.degree)
        turn = np.angle(matched * (self.mesh.transport * first[i]).conj())
        return windings(self.mesh, self.degree * turn, self.degree)

    @cached_property
    def index_numerators(self) -> Indices:
        """(V,) N times the index at each interior vertex, zero where the RoSy is regular and on the boundary.

        The index is the number of turns that a vector makes on its way round the vertex, followed from face
        to face by the matching: a multiple of 1 / N.
        """
        numerators = np.rint(self._winding).astype(np.int64)
        numerators[self.mesh.boundary_vertices] = 0
        return frozen(numerators)

    @cached_property
    def boundary_numerators(self) -> Indices:
        """(loops,) N times the index of each boundary loop, relative to the loop's tangent.

        In the order of `TriMesh.boundary_loops`. Together with `index_numerators` they sum to N chi.
        """
        loops = [np.rint(self._winding[loop].sum()) for loop in self.mesh.boundary_loops]
        return frozen(np.array(loops, dtype=np.int64))

    @property
    def branch_points(self) -> Indices:
        """Interior vertices round which the matchings do not compose to the identity (Section 5.1).

        Going once round, vector k comes back as vector ``k + numerator``: a branch point is a vertex whose
        index is not whole. One of whole index is an ordinary singularity on every sheet of the cover.
        """
        return frozen(np.flatnonzero(self.branching))

    @property
    def branching(self) -> Flags:
        """(V,) whether each vertex is a branch point."""
        return np.asarray(self.index_numerators % self.degree != 0)


def smoothest_rosy(
    mesh: TriMesh,
    degree: int = 6,
    seed: int | np.random.Generator = 0,
    *,
    phase: RoSyPhase = "bending",
) -> RoSyField:
    """Compute the globally smoothest N-RoSy on the faces (Appendix D, Knöppel et al. 2013).

    ``argmin |grad w*|^2 subject to |w*|^2 = 1`` over the representative ``w* = w^N``, the true smallest
    eigenvector of each component, then scaled to modulus 1. A common rotation of all vectors is left free
    by the energy, and by the sum of squared curls over all N vectors where N > 2.

    Parameters
    ----------
    mesh : any surface
    degree : N: 6 for a triaxial weave, 4 for a biaxial one
    seed : of the random part of the start vector
    phase : which rotation to return. ``"bending"``, the default, is the one that brings the vectors nearest
        to the directions in which the surface bends least, weighted by how much more it bends across them
        (`bending_power`).
        Neither the numbering of the mesh nor its place in space decides it, and a mirror image gets the
        mirror image (DEVIATIONS.md, rosy-phase). ``"seeded"`` is the one that the random vector leads to;
        where the smallest eigenvalue is multiple, as on the sphere, the seed then decides too where the
        singularities lie

    Raises
    ------
    FieldError
        If the degree is not positive or there is no such phase.

    See Also
    --------
    smoothest_field : one vector on every face, and its phase

    Examples
    --------
    >>> rosy = gw.smoothest_rosy(gw.shapes.sphere(faces=320), degree=6)
    >>> int(rosy.index_numerators.sum()), len(rosy.branch_points)  # sixths: 12 / 6 = 2 = chi
    (12, 12)
    """
    if degree < 1:
        raise FieldError(f"an N-RoSy has N >= 1 vectors on a face, not {degree}")
    if phase not in ("bending", "seeded"):
        raise FieldError(f"there is no phase '{phase}' of an N-RoSy: use 'bending' or 'seeded'")
    if phase == "seeded":
        _, field = smoothest_eigenfield(mesh, seed, degree)
        return RoSyField(mesh, degree, unit(field.values))
    wanted, weight = bending_power(mesh, degree)
    _, field = smoothest_eigenfield(mesh, seed, degree, start=wanted)
    values = unit(field.values)
    # The rotation by a that makes the weighted sum of |exp(ia) u - wanted|^2 least.
    product = mesh.face_areas * weight * wanted * values.conj()
    component = mesh.face_components
    total = np.bincount(component, product.real) + 1j * np.bincount(component, product.imag)
    return RoSyField(mesh, degree, values * unit(total)[component])
