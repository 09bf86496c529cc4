import numpy as np
import pytest
from rodded import crumpled

from geoweave.rods import hessian
from geoweave.rods.slide_and_relax import relaxing_terms
from geoweave.sparse import cholesky


@pytest.mark.parametrize("held", [0, 9])
def test_the_matrix_is_the_sum_of_squared_jacobians(held):
    rods = crumpled()
    terms = relaxing_terms(rods)
    fixed = np.arange(rods.size) < held
    pattern = hessian.analysed(rods.size, terms, fixed)
    shift = np.linspace(0.1, 0.2, rods.size)
    plain = pattern.matrix([term.derivative(rods) for term in terms], [None] * len(terms))
    matrix = pattern.shifted(plain, shift)
    dense = sum((term.jacobian(rods).T @ term.jacobian(rods)).toarray() for term in terms) + np.diag(shift)
    assert sorted(pattern.free.tolist()) == list(range(held, rods.size))
    np.testing.assert_allclose(
        matrix.toarray(), dense[np.ix_(pattern.free, pattern.free)], atol=1e-12 * abs(dense).max()
    )


def test_the_pattern_is_factored_at_other_places_too():
    rods = crumpled()
    terms = relaxing_terms(rods)
    pattern = hessian.analysed(rods.size, terms, np.zeros(rods.size, dtype=bool))
    moved = rods.stepped(0.01 * np.ones(rods.size))
    plain = pattern.matrix([t.derivative(moved) for t in terms], [None] * len(terms))
    matrix = pattern.shifted(plain, np.ones(rods.size))
    factor = cholesky.factor(matrix, pattern.symbolic)
    right = np.arange(rods.size, dtype=float)
    solution = cholesky.solve(pattern.symbolic, factor, right)
    np.testing.assert_allclose(matrix @ solution, right, atol=1e-6 * right.max())


def test_curvature_is_added_where_it_is_given():
    rods = crumpled()
    terms = relaxing_terms(rods)
    pattern = hessian.analysed(rods.size, terms, np.zeros(rods.size, dtype=bool))
    derivatives = [term.derivative(rods) for term in terms]
    longer = rods.stepped(0.5 * np.concatenate([rods.points.ravel(), np.zeros(rods.layout.segments)]))
    extra = [
        None if term.curvature is None else term.curvature(longer, term.residual(longer)) for term in terms
    ]
    plain = pattern.matrix(derivatives, [None] * len(terms))
    full = pattern.matrix(derivatives, extra)
    dense = np.zeros((rods.size, rods.size))
    for term, blocks in zip(terms, extra, strict=True):
        for unknowns, block in zip(
            term.unknowns, () if blocks is None else blocks, strict=blocks is not None
        ):
            dense[np.ix_(unknowns, unknowns)] += block
    np.testing.assert_allclose(
        (full - plain).toarray(), dense[np.ix_(pattern.free, pattern.free)], atol=1e-9 * abs(full).max()
    )
    assert abs(dense).max() > 0
