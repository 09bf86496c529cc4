from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from geoweave.sparse import factorization


def grid_laplacian(n=30, shift=0.1):
    line = sparse.diags_array([-np.ones(n - 1), 2 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1])
    eye = sparse.eye_array(n)
    matrix = sparse.kron(line, eye) + sparse.kron(eye, line) + shift * sparse.eye_array(n * n)
    return sparse.csr_array(matrix)


def hermitian():
    matrix = grid_laplacian().tocoo()
    phase = np.exp(1j * 0.7 * np.sign(matrix.coords[1] - matrix.coords[0]))
    return sparse.csr_array((matrix.data * phase, matrix.coords), shape=matrix.shape)


@pytest.mark.parametrize("matrix", [grid_laplacian(), hermitian()], ids=["real", "Hermitian"])
@pytest.mark.parametrize("metis", [True, False])
def test_factors_solve(matrix, metis, monkeypatch):
    if metis:
        assert factorization.HAS_METIS
    monkeypatch.setattr(factorization, "HAS_METIS", metis)
    ordering = factorization.nested_dissection(matrix)
    assert (ordering.order is not None) == metis
    factors = factorization.factorized(matrix, ordering)
    right = np.random.default_rng(0).normal(size=(900, 3)).astype(matrix.dtype)
    for b in (right, right[:, 0].copy()):
        np.testing.assert_allclose(matrix @ factors.solve(b), b, atol=1e-12)


def test_nested_dissection_is_a_permutation_with_less_fill_than_the_given_order():
    matrix = grid_laplacian(60)
    ordering = factorization.nested_dissection(matrix)
    np.testing.assert_array_equal(np.sort(ordering.order), np.arange(3600))
    natural = factorization.Ordering(np.arange(3600))
    assert (
        factorization.factorized(matrix, ordering).fill < 0.6 * factorization.factorized(matrix, natural).fill
    )


def test_orderings_extend_to_blocks_and_to_last_rows():
    base = factorization.Ordering(np.array([2, 0, 1]))
    np.testing.assert_array_equal(base.repeated(2).order, [4, 5, 0, 1, 2, 3])
    np.testing.assert_array_equal(base.with_last(2).order, [2, 0, 1, 3, 4])
    assert factorization.Ordering(None).repeated(2).with_last(1).order is None


def test_a_singular_matrix_is_refused():
    with pytest.raises(factorization.SingularMatrixError, match="3 unknowns"):
        factorization.factorized(
            sparse.csr_array(np.diag([1.0, 0.0, 2.0])), factorization.Ordering(np.arange(3))
        )


@pytest.mark.parametrize("matrix", [grid_laplacian(), hermitian()], ids=["real", "Hermitian"])
def test_smallest_eigenpair_against_a_dense_solver(matrix):
    mass = np.random.default_rng(1).uniform(0.5, 2.0, 900)
    start = np.random.default_rng(2).normal(size=900).astype(matrix.dtype)
    factors = factorization.factorized(matrix, factorization.nested_dissection(matrix))
    mu, u = factorization.smallest_eigenpair(factors, mass, start)
    root = 1 / np.sqrt(mass)
    assert mu == pytest.approx(np.linalg.eigvalsh(root[:, None] * matrix.toarray() * root)[0], rel=1e-10)
    np.testing.assert_allclose(matrix @ u, mu * mass * u, atol=1e-9)
    assert (u.conj() * mass) @ u == pytest.approx(1)


@pytest.mark.parametrize("size", [1, 2])
def test_smallest_eigenpair_of_a_tiny_matrix(size):
    """One or two faces are a component, too."""
    matrix = sparse.csr_array(np.array([[2.0, 0.5j], [-0.5j, 1.0]])[:size, :size])
    mass = np.array([1.0, 2.0])[:size]
    value, vector = factorization.smallest_eigenpair(
        factorization.factorized(matrix, factorization.nested_dissection(matrix)),
        mass,
        np.ones(size, dtype=complex),
    )
    np.testing.assert_allclose(matrix @ vector, value * mass * vector, atol=1e-12)
    assert np.vdot(vector, mass * vector).real == pytest.approx(1.0)
    dense = np.linalg.eigvals(np.diag(1 / mass) @ matrix.toarray()).real
    assert value == pytest.approx(dense.min())


def m_matrix(rng):
    """A definite matrix of 60 rows without positive entries off its diagonal."""
    graph = sparse.random_array((60, 60), density=0.1, rng=rng, data_sampler=lambda size: -rng.random(size))
    off = sparse.csr_array(graph + graph.T)
    off.setdiag(0.0)
    return sparse.csr_array(off + sparse.diags_array(0.05 + rng.random(60) - off.sum(axis=1)))


def test_bounded_minimum_is_the_minimum_from_wherever_it_starts():
    """Against the conditions of Karush, Kuhn and Tucker, on random matrices of the kind that occurs."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        matrix = m_matrix(rng)
        factors = factorization.factorized(matrix, factorization.nested_dissection(matrix))
        right, least = rng.normal(size=60), 0.2 * rng.random(60)
        found = [
            factorization.bounded_minimum(matrix, factors, right, least, start)
            for start in (least, least + 1.0, least + rng.random(60))
        ]
        for r in found:
            force = matrix @ r - right
            assert (r >= least).all()
            assert force.min() > -1e-9
            np.testing.assert_allclose(force[r > least + 1e-12], 0.0, atol=1e-9)
            np.testing.assert_allclose(r, found[0], atol=1e-9)


def test_bounded_minimum_of_nothing_and_of_all_bounds():
    matrix = sparse.csr_array(np.diag([2.0, 3.0]))
    factors = factorization.factorized(matrix, factorization.Ordering(np.arange(2)))
    for right, least in ((np.zeros(2), -np.ones(2)), (-np.ones(2), np.zeros(2))):
        r = factorization.bounded_minimum(matrix, factors, right, least, least + 1.0)
        np.testing.assert_allclose(r, np.zeros(2), atol=1e-15)


@pytest.mark.parametrize("dtype", [float, complex])
def test_assembly_sums_what_falls_together_and_keeps_zeros(dtype):
    rng = np.random.default_rng(0)
    rows, columns = rng.integers(0, 6, (2, 50))
    entries = rng.normal(size=50).astype(dtype) * (1.0 if dtype is float else np.exp(0.3j))
    assembly = factorization.Assembly(rows, columns, 6)
    dense = np.zeros((6, 6), dtype=dtype)
    np.add.at(dense, (rows, columns), entries)
    np.testing.assert_allclose(assembly(entries).toarray(), dense, atol=1e-14)
    nothing = assembly(np.zeros(50, dtype=dtype))
    assert nothing.nnz == assembly(entries).nnz == np.count_nonzero(dense)
    assert nothing.dtype == dtype


def test_an_ordering_of_a_part_renumbers_it():
    base = factorization.Ordering(np.array([4, 2, 0, 3, 1]))
    np.testing.assert_array_equal(base.of(np.array([1, 2, 4])).order, [2, 1, 0])
    assert factorization.Ordering(None).of(np.array([1])).order is None


def test_one_analysis_serves_matrices_of_its_pattern_and_of_others(monkeypatch):
    monkeypatch.setattr(factorization, "LARGE", 100)
    matrix, right = grid_laplacian(), np.random.default_rng(0).normal(size=900)
    analysis = factorization.analysed(matrix, factorization.nested_dissection(matrix))
    assert analysis.symbolic is not None
    other = matrix + sparse.diags_array(np.linspace(1.0, 2.0, 900))
    wider = sparse.csr_array(matrix @ matrix)
    for each in (matrix, other, wider):
        solution = factorization.factorized(sparse.csr_array(each), analysis).solve(right)
        np.testing.assert_allclose(each @ solution, right, atol=1e-10)
    assert factorization.analysed(hermitian(), analysis.ordering).symbolic is None
