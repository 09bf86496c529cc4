"""Factors that serve several matrices: those of one matrix as preconditioner for the next ones."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from geoweave.arrays import Scalars
from geoweave.sparse.factorization import (
    Analysis,
    Column,
    Factorization,
    Ordering,
    SingularMatrixError,
    SparseMatrix,
    analysed,
    factorized,
)

__all__ = ["NEARNESS", "STEPS", "Reused", "near_solution"]

NEARNESS = 0.1
"""What conjugate gradients leave of a step of Newton's method, as a share: the next step mends it.

On foliations smaller shares took more solves and ended no lower; at 0.3 some stopped at a worse phase.
"""

STEPS = 8
"""Steps after which a matrix is factored: by then they cost more than half of its factorisation."""


def near_solution(
    matrix: SparseMatrix, factors: Factorization, right: Scalars, nearness: float, steps: int
) -> tuple[Scalars, bool]:
    """Solve ``A x = b`` by conjugate gradients, preconditioned with the factors of a similar matrix P.

    Parameters
    ----------
    matrix : A, symmetric positive definite, (n, n)
    factors : of P, symmetric positive definite, (n, n)
    right : (n,) b
    nearness : the root of ``r' P^-1 r``, r what is left of b, is to fall to this share
    steps : most solves with the factors

    Returns
    -------
    x, whether it is so near. Each step lowers ``1/2 x' A x - b' x``, so that x is a way downhill of that
    function in any case

    Examples
    --------
    >>> from scipy import sparse
    >>> from geoweave.sparse import Ordering, factorized, near_solution
    >>> matrix = sparse.diags_array([2.0, 3.0, 4.0]).tocsr()
    >>> x, near = near_solution(matrix, factorized(matrix, Ordering(None)), np.ones(3), 1e-9, 2)
    >>> near, bool(np.allclose(matrix @ x, 1.0))
    (True, True)
    """
    x, rest, direction = np.zeros_like(right), right, np.zeros_like(right)
    first = last = 0.0
    for step in range(steps + 1):
        # The last look needs a solve too: what is left is measured with the factors.
        descent = factors.solve(rest)
        slope = float(rest @ descent)
        if step == 0:
            first = slope
        if slope <= nearness**2 * first:
            return x, True
        if step == steps:
            return x, False
        direction = descent if step == 0 else descent + slope / last * direction
        image = matrix @ direction
        length = slope / float(direction @ image)
        x, rest, last = x + length * direction, rest - length * image, slope
    raise AssertionError("the loop returns")


SHIFT = 1e-7
"""Share of its diagonal that is added to a matrix before it is factored in single precision: its rounding."""


class Reused:
    """Matrices of one pattern that change little from one to the next, and factors that serve several.

    A system is solved by conjugate gradients with the factors made last. Where that takes too many steps,
    its own matrix is factored. Factors are made in single precision, in half the time, since conjugate
    gradients mend what that leaves; where a matrix is too ill-conditioned for it, in double precision.
    Nothing depends on a clock.

    Parameters
    ----------
    ordering : of the pattern of all matrices
    nearness, steps : as for `near_solution`
    soft : (n, k) directions in which all matrices are nearly singular; along them factors in single precision
        say nothing, and what conjugate gradients leave there is solved for in double precision
    """

    def __init__(
        self,
        ordering: Ordering,
        *,
        nearness: float = NEARNESS,
        steps: int = STEPS,
        soft: sparse.csr_array | None = None,
    ) -> None:
        self.nearness, self.steps, self.soft = nearness, steps, soft
        self._ordering = ordering
        self._analysis: Analysis | None = None
        self._factors: Factorization | None = None

    def of(self, matrix: SparseMatrix, *, anew: bool = False) -> Factorization:
        """What solves with a matrix; its answers are as near as `nearness` says, or nearer.

        With ``anew`` it is factored at once. That pays where the answer is to be near and the matrix is not
        near the last one.
        """
        return _Near(self, matrix, anew)

    def _factored(self, matrix: SparseMatrix, single: bool) -> Factorization:
        if self._analysis is None:
            self._analysis = analysed(matrix, self._ordering)
        single = single and self._analysis.symbolic is not None
        if single:
            matrix = sparse.csr_array(matrix + sparse.diags_array(SHIFT * matrix.diagonal()))
        self._factors = factorized(matrix, self._analysis, single=single)
        return self._factors


class _Near:
    """One matrix, solved with by the factors of another until that takes too long."""

    def __init__(self, reused: Reused, matrix: SparseMatrix, anew: bool) -> None:
        self._reused, self._matrix = reused, matrix
        self._exact: Factorization | None = None
        self._precisions = [False, True]
        """Whether the factors that are made of this matrix are of single precision, the first ones last."""
        if anew or reused._factors is None:
            self._make()

    @property
    def size(self) -> int:
        return int(self._matrix.shape[0])

    @property
    def fill(self) -> int:
        assert self._reused._factors is not None  # since the first matrix
        return self._reused._factors.fill

    @property
    def exact(self) -> bool:
        return self._exact is not None

    def _make(self) -> None:
        """Factor the matrix, in single precision if that was not tried and is enough."""
        while True:
            single = self._precisions.pop()
            try:
                factors = self._reused._factored(self._matrix, single)
            except SingularMatrixError:
                if not single:
                    raise
                continue
            self._exact = factors if factors.exact else None
            return

    def _along_soft(self, rest: Scalars) -> Scalars:
        """The combination of soft directions that answers best to what is left of a right-hand side."""
        soft, factors = self._reused.soft, self._reused._factors
        if soft is None or factors is None or factors.exact:
            return np.zeros_like(rest)
        among = (soft.T @ (self._matrix @ soft)).toarray()
        return np.asarray(soft @ np.linalg.solve(among, soft.T @ rest))

    def solve(self, right: Column) -> Column:
        reused = self._reused
        while self._exact is None:
            assert reused._factors is not None  # since the first matrix
            real = np.asarray(right, dtype=np.float64)
            x, near = near_solution(self._matrix, reused._factors, real, reused.nearness, reused.steps)
            if near:
                return (x + self._along_soft(real - self._matrix @ x)).astype(right.dtype)
            self._make()
        return self._exact.solve(right)
