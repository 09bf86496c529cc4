"""Factors of one matrix that serve the next ones."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from geoweave.sparse import Ordering, factorization, factorized, nested_dissection, reuse
from geoweave.sparse.reuse import Reused, near_solution


def matrices(count: int = 6, drift: float = 0.1, n: int = 400) -> list[sparse.csr_array]:
    """Chains of springs whose stiffness drifts."""
    random = np.random.default_rng(0)
    difference = sparse.diags_array([-np.ones(n), np.ones(n)], offsets=[0, 1], shape=(n, n + 1))
    found, stiffness = [], np.ones(n)
    for _ in range(count):
        spring = difference.T @ sparse.diags_array(stiffness) @ difference
        found.append(sparse.csr_array(spring + 1e-3 * sparse.eye_array(n + 1)))
        stiffness = stiffness * np.exp(drift * random.normal(size=n))
    return found


def test_conjugate_gradients_come_as_near_as_asked_and_every_step_goes_downhill() -> None:
    first, *_, last = matrices()
    factors = factorized(first, Ordering(None))
    right = np.random.default_rng(1).normal(size=first.shape[0])
    exact = factorized(last, Ordering(None)).solve(right)
    values = []
    for steps in range(1, 8):
        x, _ = near_solution(last, factors, right, 0.0, steps)
        values.append(0.5 * x @ (last @ x) - right @ x)
    assert values[0] < 0
    assert (np.diff(values) <= 0).all()
    for nearness in (1e-1, 1e-4, 1e-8):
        x, near = near_solution(last, factors, right, nearness, 60)
        assert near
        rest = right - last @ x
        assert np.sqrt(rest @ factors.solve(rest)) <= 1.01 * nearness * np.sqrt(right @ factors.solve(right))
    np.testing.assert_allclose(x, exact, rtol=1e-5, atol=1e-6 * np.abs(exact).max())


@pytest.mark.parametrize(("drift", "made"), [(0.05, 1), (3.0, 6)])
def test_what_drifts_little_is_factored_once_and_what_drifts_far_each_time(
    drift: float, made: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    count = 0

    def counted(*arguments, single):  # type: ignore[no-untyped-def]
        nonlocal count
        count += 1
        return factorized(*arguments, single=single)

    monkeypatch.setattr(reuse, "factorized", counted)
    reused = Reused(Ordering(None), nearness=1e-3)
    for matrix in matrices(drift=drift):
        right = np.random.default_rng(2).normal(size=matrix.shape[0])
        solver = reused.of(matrix)
        rest = right - matrix @ solver.solve(right)
        weight = factorized(matrix, Ordering(None)).solve
        assert rest @ weight(rest) <= 1e-4 * right @ weight(right)
        assert (solver.size, solver.fill > 0) == (401, True)
    assert count == made


def test_the_first_matrix_and_one_that_was_factored_are_solved_with_exactly() -> None:
    first, *_, last = matrices(drift=0.7)
    right = np.random.default_rng(3).normal(size=first.shape[0])
    reused = Reused(Ordering(None), nearness=1e-9)
    for matrix in (first, last):
        np.testing.assert_allclose(matrix @ reused.of(matrix).solve(right), right, atol=1e-8)


def _precisions(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Note of all factors made from here on whether they were asked for in single precision."""
    asked: list[bool] = []

    def noted(*arguments, single):  # type: ignore[no-untyped-def]
        asked.append(single)
        return factorized(*arguments, single=single)

    monkeypatch.setattr(factorization, "LARGE", 100)
    monkeypatch.setattr(reuse, "factorized", noted)
    return asked


def test_factors_of_single_precision_serve_where_they_can(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = _precisions(monkeypatch)
    first, *_, last = matrices(drift=0.7)
    right = np.random.default_rng(3).normal(size=first.shape[0])
    reused = Reused(nested_dissection(first), nearness=1e-9)
    for matrix in (first, last):
        solver = reused.of(matrix, anew=True)
        np.testing.assert_allclose(matrix @ solver.solve(right), right, atol=1e-6 * np.abs(right).max())
        assert not solver.exact
    assert asked == [True, True]


def test_an_ill_conditioned_matrix_is_factored_in_double_precision(monkeypatch: pytest.MonkeyPatch) -> None:
    """With factors in single precision conjugate gradients do not come near enough."""
    asked = _precisions(monkeypatch)
    n = 2000
    difference = sparse.diags_array([-np.ones(n), np.ones(n)], offsets=[0, 1], shape=(n, n + 1))
    matrix = sparse.csr_array(difference.T @ difference + 1e-9 * sparse.eye_array(n + 1))
    right = np.random.default_rng(3).normal(size=n + 1)
    solver = Reused(nested_dissection(matrix), nearness=1e-9, steps=2).of(matrix)
    x, exact = solver.solve(right), factorized(matrix, Ordering(None)).solve(right)
    np.testing.assert_allclose(x, exact, rtol=1e-3)
    assert asked == [True, False]
    assert solver.exact
