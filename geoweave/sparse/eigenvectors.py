"""Smallest eigenvectors, converged: with a start that does not decide what is found (Section 4.2.4)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh_tridiagonal

from geoweave.arrays import Indices, Scalars
from geoweave.sparse.factorization import Column, Factorization, SingularMatrixError

STEPS = 500
"""Most solves that `smallest_eigenvectors` takes."""

EXHAUSTED = 1e-14
"""A direction shorter than this, beside the eigenvalue, is rounding: there is no other."""

FIRST_ROOM = 32
"""Directions that there is room for at first."""


def smallest_eigenvectors(
    factors: Factorization, mass: Scalars, start: Column, groups: Indices, *, tolerance: float = 1e-12
) -> tuple[Scalars, Column]:
    """Smallest eigenpair of ``A u = mu M u`` on each group of unknowns, by Lanczos on the inverse.

    No entry of A couples two groups, so that each is a problem of its own; one solve serves them all. All
    directions are kept and made orthogonal again, so that close eigenvalues are told apart: with a gap of a
    thousandth, 30 to 60 solves are usual where inverse iteration takes thousands.

    Parameters
    ----------
    factors : of A, Hermitian positive definite, (n, n)
    mass : (n,) positive diagonal of M
    start : (n,) real or complex start vector, not zero on any group
    groups : (n,) number of the group of each unknown, from 0
    tolerance : what ``A^-1 M u - u / mu`` may leave, as a share of ``u / mu``; the eigenvector is then off by
        this over the relative gap to the next eigenvalue

    Returns
    -------
    mu, u : (groups,) the eigenvalues, and the eigenvectors, ``conj(u) M u = 1`` on each group

    Raises
    ------
    SingularMatrixError
        If the eigenvectors have not settled after `STEPS` solves.
    """
    root = np.sqrt(mass)
    order = np.argsort(groups, kind="stable")
    bounds = np.concatenate([[0], np.cumsum(np.bincount(groups))])
    spaces = [_Krylov(vector) for vector in np.split((root * start)[order], bounds[1:-1])]
    scaled = np.empty_like(start)
    for _ in range(STEPS):
        scaled[order] = np.concatenate([space.last for space in spaces])
        image = (root * factors.solve(root * scaled))[order]
        settled = [
            space.extended(part, tolerance)
            for space, part in zip(spaces, np.split(image, bounds[1:-1]), strict=True)
        ]
        if all(settled):
            scaled[order] = np.concatenate([space.ritz_vector for space in spaces])
            return np.array([1.0 / space.value for space in spaces]), scaled / root
    raise SingularMatrixError(f"an eigenvector of {factors.size} unknowns did not settle in {STEPS} steps")


class _Krylov:
    """The directions that Lanczos has found on one group of unknowns, and the largest Ritz pair of them."""

    def __init__(self, start: NDArray[Any]) -> None:
        self.basis = np.empty((FIRST_ROOM, len(start)), dtype=start.dtype)
        self.basis[0] = start / np.linalg.norm(start)
        self.count = 1
        self.diagonal: list[float] = []
        self.beside: list[float] = []
        self.value, self.weights = 0.0, np.ones(1)
        self.settled = False

    @property
    def last(self) -> NDArray[Any]:
        """The direction whose image is wanted, zero when no other is."""
        return 0.0 * self.basis[0] if self.settled else self.basis[self.count - 1]

    @property
    def ritz_vector(self) -> NDArray[Any]:
        """The eigenvector as it is known, of its two signs the one nearer to the start."""
        weights = self.weights * np.copysign(1.0, self.weights[0])
        vector = weights @ self.basis[: len(weights)]
        return np.asarray(vector / np.linalg.norm(vector))

    def extended(self, image: NDArray[Any], tolerance: float) -> bool:
        """Add the image of the last direction; return whether the largest Ritz pair has settled.

        It is left alone then. Of a multiple eigenvalue the start has only one eigenvector in it; rounding
        would bring in others.
        """
        if self.settled:
            return True
        count = self.count
        basis = self.basis[:count]
        self.diagonal.append(float((basis[-1].conj() @ image).real))
        for _ in range(2):  # once is not orthogonal enough
            image = np.asarray(image - (basis.conj() @ image) @ basis)
        length = float(np.linalg.norm(image))
        values, vectors = eigh_tridiagonal(self.diagonal, self.beside[: count - 1])
        self.value, self.weights = float(values[-1]), np.asarray(vectors[:, -1], dtype=np.float64)
        if length <= EXHAUSTED * abs(self.value) or count == len(image):
            self.settled = True
            return True
        self.beside.append(length)
        if count == len(self.basis):
            self.basis = np.concatenate([self.basis, np.empty_like(self.basis)])
        self.basis[count] = image / length
        self.count += 1
        self.settled = bool(length * abs(self.weights[-1]) <= tolerance * self.value)
        return self.settled
