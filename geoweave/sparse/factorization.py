"""Sparse factorisations as values: fill-reducing orderings, solves, inverse iteration (Appendices B and C).

The module knows matrices and never meshes.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Any, Protocol, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, SuperLU, eigsh, splu
from threadpoolctl import ThreadpoolController

from geoweave.arrays import Flags, Indices, Scalars
from geoweave.errors import GeoweaveError
from geoweave.sparse import cholesky

SparseMatrix: TypeAlias = sparse.csr_array | sparse.csc_array | sparse.dia_array
"""A square sparse matrix in a format that is fast to read by rows or columns."""

Column = TypeVar("Column", NDArray[np.float64], NDArray[np.complex128])

LARGE = 12_000
"""Unknowns from which our own Cholesky factorisation takes the place of SuperLU."""

HELD_TOLERANCE = 1e-13
"""What a solve beside held unknowns may leave, as a share of the right-hand side."""

ROUNDS = 50
"""Active sets that `bounded_minimum` tries; most problems settle in five."""

HAS_METIS = importlib.util.find_spec("pymetis") is not None
"""Whether METIS nested dissection is installed; without it SuperLU's minimum degree takes its place."""


@cache
def _libraries() -> ThreadpoolController:
    return ThreadpoolController()


@contextmanager
def one_blas_thread() -> Iterator[None]:
    """Keep BLAS to one thread inside a block: on the small blocks of sparse factors more make it slower."""
    with _libraries().limit(limits=1, user_api="blas"):
        yield


class SingularMatrixError(GeoweaveError):
    """A matrix that should be positive definite is not, to working precision."""


@dataclass(frozen=True)
class Ordering:
    """An elimination order that keeps the factor of a symmetric matrix sparse.

    Attributes
    ----------
    order : (n,) int64, or None to let SuperLU choose by minimum degree
        Row ``order[k]`` of the matrix is eliminated in step k. It depends on the pattern alone, so one
        ordering serves every matrix of that pattern: all smoothness weights, all alternations.
    """

    order: Indices | None

    def repeated(self, block: int) -> Ordering:
        """Extend an ordering of nodes to ``block`` interleaved unknowns per node."""
        if self.order is None:
            return self
        return Ordering((self.order[:, None] * block + np.arange(block)).ravel())

    def with_last(self, count: int) -> Ordering:
        """Append ``count`` further unknowns, eliminated after all others (dense rows belong there)."""
        if self.order is None:
            return self
        return Ordering(np.concatenate([self.order, len(self.order) + np.arange(count)]))

    def of(self, kept: Indices) -> Ordering:
        """Order a part of the unknowns alone, renumbered as they are listed; separators remain separators."""
        if self.order is None:
            return self
        place = np.full(len(self.order), -1, dtype=np.int64)
        place[kept] = np.arange(len(kept))
        renumbered = place[self.order]
        return Ordering(renumbered[renumbered >= 0])


class Assembly:
    """Matrices of one pattern, made from entries of which those in the same place are summed.

    Parameters
    ----------
    rows, columns : (K,) place of each entry
    size : n
    """

    def __init__(self, rows: Indices, columns: Indices, size: int) -> None:
        key, self._slot = np.unique(rows * size + columns, return_inverse=True)
        self._starts = np.concatenate([[0], np.cumsum(np.bincount(key // size, minlength=size))])
        self._columns = key % size
        self._size = size

    def __call__(self, entries: Column) -> sparse.csr_array:
        """(n, n) matrix with these (K,) entries, real or complex; zeros are stored."""
        count = len(self._columns)
        data = np.bincount(self._slot, entries.real, count)
        if np.iscomplexobj(entries):
            data = data + 1j * np.bincount(self._slot, entries.imag, count)
        return sparse.csr_array((data, self._columns, self._starts), shape=(self._size, self._size))


def nested_dissection(pattern: SparseMatrix) -> Ordering:
    """Order a symmetric pattern by METIS nested dissection.

    Parameters
    ----------
    pattern : (n, n) sparse; only where it is not zero matters

    Returns
    -------
    Ordering
        Without METIS, the ordering that leaves the choice to SuperLU (minimum degree of A + A').
    """
    if not HAS_METIS:
        return Ordering(None)
    import pymetis

    csr = sparse.csr_array(pattern)
    n = csr.shape[0]
    rows = np.repeat(np.arange(n), np.diff(csr.indptr))
    off_diagonal = csr.indices != rows
    degree = np.bincount(rows[off_diagonal], minlength=n)
    offsets = np.concatenate([[0], np.cumsum(degree)])
    order, _ = pymetis.nested_dissection(
        adjacency=pymetis.CSRAdjacency(offsets.astype(np.int32), csr.indices[off_diagonal].astype(np.int32))
    )
    return Ordering(np.asarray(order, dtype=np.int64))


@dataclass(frozen=True, eq=False)
class Analysis:
    """An elimination order, and for large real matrices where the entries of their factor will be.

    One analysis serves every matrix of its pattern (`analysed`, `factorized`).
    """

    ordering: Ordering
    symbolic: cholesky.Symbolic | None


def analysed(pattern: SparseMatrix, ordering: Ordering) -> Analysis:
    """Do once what a factorisation owes to the pattern of its matrix and not to its entries.

    Parameters
    ----------
    pattern : (n, n) sparse, real where the matrices will be
    ordering : elimination order for it
    """
    if ordering.order is None or pattern.shape[0] < LARGE or np.iscomplexobj(pattern):
        return Analysis(ordering, None)
    return Analysis(ordering, cholesky.analysed(pattern, ordering.order))


class Factorization(Protocol):
    """The factors of a Hermitian positive definite matrix: made once, solved with many times."""

    @property
    def size(self) -> int:
        """Number of unknowns."""

    @property
    def fill(self) -> int:
        """Number of stored entries."""

    @property
    def exact(self) -> bool:
        """Whether a solve is as near as double precision allows."""

    def solve(self, right: Column) -> Column:
        """Solve for one right-hand side (n,) or several (n, k), real or complex as the matrix is."""


@dataclass(frozen=True, eq=False)
class _Cholesky:
    _symbolic: cholesky.Symbolic
    _entries: cholesky.Entries
    size: int

    @property
    def fill(self) -> int:
        return self._symbolic.fill

    @property
    def exact(self) -> bool:
        return bool(self._entries.dtype == np.float64)

    def solve(self, right: Column) -> Column:
        columns = np.asarray(right, dtype=np.float64).reshape(self.size, -1)
        solution = np.empty_like(right)
        for k, column in enumerate(columns.T):
            solution.reshape(self.size, -1)[:, k] = cholesky.solve(self._symbolic, self._entries, column)
        return solution


@dataclass(frozen=True, eq=False)
class _SuperLU:
    _factors: SuperLU
    _order: Indices | None
    size: int

    @property
    def fill(self) -> int:
        return int(self._factors.nnz)

    @property
    def exact(self) -> bool:
        return True

    def solve(self, right: Column) -> Column:
        if self._order is None:
            return self._factors.solve(right)
        solution = np.empty_like(right)
        solution[self._order] = self._factors.solve(right[self._order])
        return solution


def factorized(matrix: SparseMatrix, ordering: Ordering | Analysis, *, single: bool = False) -> Factorization:
    """Factor a Hermitian positive definite sparse matrix in a given order.

    Parameters
    ----------
    matrix : (n, n) sparse, real symmetric or complex Hermitian, positive definite
    ordering : elimination order of the same pattern, or an analysis of it; where the matrix has another
        pattern than the one analysed, by entries that cancelled, only the order is used
    single : let our Cholesky work in single precision, for factors that precondition and need not be exact

    Large real matrices go to our Cholesky, several times faster on them but compiled on first use;
    small ones, complex ones, and all where METIS is missing, go to SuperLU.

    Raises
    ------
    SingularMatrixError
        If a pivot vanishes.
    """
    known = ordering if isinstance(ordering, Analysis) else Analysis(ordering, None)
    order = known.ordering.order
    if order is not None and matrix.shape[0] >= LARGE and not np.iscomplexobj(matrix):
        csr = sparse.csr_array(matrix)
        symbolic = known.symbolic
        if symbolic is None or not symbolic.fits(csr):
            symbolic = cholesky.analysed(csr, order)
        try:
            return _Cholesky(symbolic, cholesky.factor(csr, symbolic, single), csr.shape[0])
        except cholesky.NotDefiniteError as error:
            raise SingularMatrixError(f"a matrix of {csr.shape[0]} unknowns is not definite") from error
    csc = sparse.csc_array(matrix)
    if order is not None:
        csc = csc[order][:, order].tocsc()
    # Positive definite: no pivoting, so the symmetric order is kept and the fill is what METIS promised.
    options: dict[str, Any] = {"SymmetricMode": True}
    try:
        factors = splu(
            csc,
            permc_spec="MMD_AT_PLUS_A" if order is None else "NATURAL",
            diag_pivot_thresh=0.0,
            options=options,
        )
    except RuntimeError as error:
        raise SingularMatrixError(f"a matrix of {csc.shape[0]} unknowns is singular") from error
    return _SuperLU(factors, order, csc.shape[0])


def smallest_eigenpair(
    factors: Factorization, mass: Scalars, start: Column, *, tolerance: float = 1e-12
) -> tuple[float, Column]:
    """Smallest eigenpair of ``A u = mu M u``, converged, by Lanczos on the inverse.

    Parameters
    ----------
    factors : of A, Hermitian positive definite, (n, n)
    mass : (n,) positive diagonal of M
    start : (n,) real or complex start vector; the same start gives the same eigenvector, also where
        the smallest eigenvalue is multiple

    Returns
    -------
    mu, u : the eigenvalue and the eigenvector, ``conj(u) M u = 1``
    """
    root = np.sqrt(mass)
    if factors.size <= 2:  # Lanczos needs more room
        columns = factors.solve(np.diag(root).astype(start.dtype))
        values, vectors = np.linalg.eigh(root[:, None] * columns)
        return float(1.0 / values[-1]), (vectors[:, -1] / root).astype(start.dtype)
    inverse = LinearOperator(
        (factors.size, factors.size),
        matvec=lambda u: root * factors.solve(root * u.ravel()),
        dtype=start.dtype,
    )
    values, vectors = eigsh(inverse, k=1, which="LM", v0=root * start, tol=tolerance, rng=0)
    return float(1.0 / values[0]), vectors[:, 0] / root


def bounded_minimum(
    matrix: sparse.csr_array, factors: Factorization, right: Scalars, least: Scalars, start: Scalars
) -> Scalars:
    """Minimise ``1/2 r' K r - b' r`` over ``r >= least``, by the primal-dual active set method.

    For a matrix K with no positive entry off its diagonal, as here, the method ends at the exact minimiser.
    K is factored once: the unknowns that are free are solved for by conjugate gradients with the block of
    ``K^-1`` as preconditioner, which is the inverse of the free block but for a correction of the rank of
    the active set.

    Parameters
    ----------
    matrix : K, symmetric positive definite, (n, n)
    factors : of K
    right : (n,) b
    least : (n,) the bounds
    start : (n,) a guess, and which bounds it meets

    Raises
    ------
    SingularMatrixError
        If the active set has not settled after 50 rounds, or the free unknowns not in as many steps as there
        are of them.
    """
    r, active = start, start <= least
    for _ in range(ROUNDS):
        r = _with_held(matrix, factors, right, np.where(active, least, r), active)
        force = matrix @ r - right
        settled = np.where(active, force >= 0, r < least)
        if (settled == active).all():
            return r
        active = settled
    raise SingularMatrixError(
        "a minimum with bounds did not settle in 50 rounds; the matrix is too ill-conditioned"
    )


def _with_held(
    matrix: sparse.csr_array, factors: Factorization, right: Scalars, start: Scalars, held: Flags
) -> Scalars:
    """Solve ``K r = b`` for the unknowns that are not held; the others keep their values in ``start``."""
    r, free = start.copy(), ~held
    rest = np.where(free, right - matrix @ r, 0.0)
    small = HELD_TOLERANCE * float(np.abs(right).max(initial=0.0))
    direction, last = np.zeros_like(r), 1.0
    for _ in range(len(r)):
        if np.abs(rest).max() <= small:
            return r
        descent = np.where(free, factors.solve(rest), 0.0)
        slope = float(rest @ descent)
        direction = descent + slope / last * direction
        image = np.where(free, matrix @ direction, 0.0)
        length = slope / float(direction @ image)
        r, rest, last = r + length * direction, rest - length * image, slope
    raise SingularMatrixError("conjugate gradients did not end; the matrix is too ill-conditioned")
