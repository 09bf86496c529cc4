from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from geoweave.sparse.eigenvectors import smallest_eigenvectors
from geoweave.sparse.factorization import Ordering, SingularMatrixError, factorized, nested_dissection


def spectrum(values, *, seed=0, hermitian=False):
    """A matrix with these eigenvalues for the mass that is returned with it."""
    rng, n = np.random.default_rng(seed), len(values)
    noise = rng.normal(size=(n, n)) + (1j * rng.normal(size=(n, n)) if hermitian else 0.0)
    basis, _ = np.linalg.qr(noise)
    mass = rng.uniform(0.5, 2.0, n)
    root = np.sqrt(mass)
    return root[:, None] * (basis * values) @ basis.conj().T * root, mass


def solved(matrix, mass, start, groups, **options):
    matrix = sparse.csr_array(matrix)
    factors = factorized(matrix, nested_dissection(matrix))
    return smallest_eigenvectors(factors, mass, start, groups, **options)


@pytest.mark.parametrize("hermitian", [False, True])
def test_eigenvalues_a_thousandth_apart_are_told_apart_whatever_the_start(hermitian):
    values = np.concatenate([[1.0, 1.001], np.linspace(1.1, 50.0, 98)])
    matrix, mass = spectrum(values, hermitian=hermitian)
    found = []
    for seed in range(3):
        start = np.random.default_rng(seed).normal(size=100).astype(matrix.dtype)
        (mu,), u = solved(matrix, mass, start, np.zeros(100, dtype=int), tolerance=1e-10)
        assert mu == pytest.approx(1.0, rel=1e-9)
        np.testing.assert_allclose(matrix @ u, mu * mass * u, atol=1e-6)
        assert (u.conj() * mass @ u).real == pytest.approx(1.0)
        found.append(u)
    for other in found[1:]:
        assert abs(found[0].conj() * mass @ other) == pytest.approx(1.0, abs=1e-9)


def test_every_group_gets_its_own_in_whatever_order_unknowns_are_mixed():
    sizes = (1, 2, 30)
    parts = [spectrum(np.linspace(k + 1.0, 9.0, size), seed=k) for k, size in enumerate(sizes)]
    order = np.random.default_rng(4).permutation(sum(sizes))
    matrix = sparse.block_diag([part for part, _ in parts]).toarray()[np.ix_(order, order)]
    mass = np.concatenate([each for _, each in parts])[order]
    groups = np.repeat(np.arange(3), sizes)[order]
    mu, u = solved(matrix, mass, np.ones(sum(sizes)), groups)
    np.testing.assert_allclose(mu, [1.0, 2.0, 3.0], rtol=1e-9)
    np.testing.assert_allclose(matrix @ u, mu[groups] * mass * u, atol=1e-9)
    np.testing.assert_allclose(np.bincount(groups, mass * u**2), 1.0)


def test_of_a_multiple_eigenvalue_the_eigenvector_nearest_to_the_start_is_found():
    matrix, mass = spectrum(np.concatenate([[1.0, 1.0], np.linspace(2.0, 5.0, 38)]), seed=3)
    basis = np.linalg.eigh(matrix / np.sqrt(np.outer(mass, mass)))[1][:, :2]
    start = np.random.default_rng(6).normal(size=40)
    _, u = solved(matrix, mass, start, np.zeros(40, dtype=int))
    nearest = basis @ (basis.T @ (np.sqrt(mass) * start)) / np.sqrt(mass)
    np.testing.assert_allclose(u, nearest / np.sqrt(mass @ nearest**2), atol=1e-9)


def test_a_group_that_has_settled_is_left_alone_while_another_goes_on():
    """Its eigenvalue is double: more steps would bring in the other eigenvector by rounding."""
    small, hard = np.diag([1.0, 1.0, 3.0, 3.0]), np.concatenate([[1.0, 1.0001], np.linspace(1.1, 9.0, 58)])
    matrix, mass = spectrum(hard)
    groups = np.repeat([0, 1], [4, 60])
    start = np.random.default_rng(5).normal(size=64)
    whole = sparse.block_diag([small, matrix])
    _, u = solved(whole, np.concatenate([np.ones(4), mass]), start, groups)
    np.testing.assert_allclose(u[:2], start[:2] / np.linalg.norm(start[:2]), atol=1e-9)


def test_what_does_not_settle_is_refused(monkeypatch):
    monkeypatch.setattr("geoweave.sparse.eigenvectors.STEPS", 3)
    matrix, mass = spectrum(np.linspace(1.0, 1.1, 60))
    factors = factorized(sparse.csr_array(matrix), Ordering(np.arange(60)))
    start = np.random.default_rng(0).normal(size=60)
    with pytest.raises(SingularMatrixError, match="did not settle in 3 steps"):
        smallest_eigenvectors(factors, mass, start, np.zeros(60, dtype=int))
