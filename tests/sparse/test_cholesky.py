from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse
from surfaces import surface

from geoweave.fields.closed_projection import ordering_of
from geoweave.fields.operators import ClosedFields
from geoweave.sparse import cholesky, factorization


def definite(n, density, seed):
    """A random sparse positive definite matrix, possibly of several pieces."""
    rng = np.random.default_rng(seed)
    half = sparse.random_array((n, n), density=density, rng=rng)
    return sparse.csr_array(half @ half.T + sparse.eye_array(n))


@pytest.mark.parametrize("n", [1, 2, 7, 60, 400])
@pytest.mark.parametrize("density", [0.0, 0.01, 0.2, 1.0])
def test_it_solves_what_numpy_solves(n, density):
    matrix = definite(n, density, n)
    order = np.random.default_rng(1).permutation(n)
    symbolic = cholesky.analysed(matrix, order)
    np.testing.assert_array_equal(np.sort(symbolic.order), np.arange(n))
    right = np.random.default_rng(2).normal(size=n)
    solution = cholesky.solve(symbolic, cholesky.factor(matrix, symbolic), right)
    np.testing.assert_allclose(solution, np.linalg.solve(matrix.toarray(), right), rtol=1e-8, atol=1e-10)


@pytest.mark.parametrize("name", ["jagged sphere", "genus 5", "Schwarz-P", "two pieces"])
def test_one_analysis_serves_every_smoothness_and_agrees_with_superlu(name):
    fields = ClosedFields(surface(name))
    ordering = ordering_of(fields)
    symbolic = None
    for smoothness in (1.0, 1e-3, 0.0):
        matrix = sparse.csr_array(fields.mass + smoothness * fields.smoothness)
        symbolic = symbolic or cholesky.analysed(matrix, ordering.order)
        right = np.random.default_rng(0).normal(size=matrix.shape[0])
        mine = cholesky.solve(symbolic, cholesky.factor(matrix, symbolic), right)
        theirs = factorization.factorized(matrix, ordering).solve(right)
        np.testing.assert_allclose(mine, theirs, rtol=1e-6, atol=1e-8 * np.abs(theirs).max())
    # SuperLU keeps both triangles; some zeros are stored for the sake of wider blocks.
    assert symbolic.fill < 1.05 * factorization.factorized(matrix, ordering).fill


def test_an_indefinite_matrix_is_refused():
    matrix = definite(80, 0.1, 0).tolil()
    matrix[30, 30] = -5.0
    matrix = sparse.csr_array(matrix)
    symbolic = cholesky.analysed(matrix, np.arange(80))
    with pytest.raises(cholesky.NotDefiniteError):
        cholesky.factor(matrix, symbolic)
    wide = sparse.csr_array(np.eye(100) - 2.0 * np.outer(np.arange(100) == 90, np.arange(100) == 90) + 0.001)
    with pytest.raises(cholesky.NotDefiniteError):
        cholesky.factor(wide, cholesky.analysed(wide, np.arange(100)))


def test_linalg_takes_it_for_large_real_matrices(monkeypatch):
    matrix = definite(300, 0.02, 5)
    right = np.random.default_rng(0).normal(size=(300, 3))
    ordering = factorization.nested_dissection(matrix)
    small = factorization.factorized(matrix, ordering)
    monkeypatch.setattr(factorization, "LARGE", 200)
    large = factorization.factorized(matrix, ordering)
    assert type(large) is not type(small)
    for b in (right, right[:, 0].copy()):
        np.testing.assert_allclose(large.solve(b), small.solve(b), rtol=1e-9, atol=1e-12)
    singular = sparse.csr_array(matrix - matrix)
    with pytest.raises(factorization.SingularMatrixError, match="300 unknowns"):
        factorization.factorized(sparse.csr_array(singular + sparse.eye_array(300) * 0.0), ordering)
