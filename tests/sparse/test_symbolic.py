from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from geoweave.sparse.symbolic import analysed, upper_triangle


def pattern(n, density, seed):
    """A random symmetric pattern with its diagonal, the entries of a definite matrix."""
    half = sparse.random_array((n, n), density=density, rng=np.random.default_rng(seed))
    return sparse.csr_array(half @ half.T + sparse.eye_array(n))


@pytest.mark.parametrize("n", [1, 5, 40, 150])
@pytest.mark.parametrize("density", [0.0, 0.02, 0.1])
def test_every_entry_of_the_factor_has_its_place(n, density):
    matrix = pattern(n, density, n)
    symbolic = analysed(matrix, np.random.default_rng(1).permutation(n))
    lower = np.linalg.cholesky(matrix.toarray()[np.ix_(symbolic.order, symbolic.order)])
    room = np.zeros((n, n), dtype=bool)
    for s, (low, high) in enumerate(zip(symbolic.first[:-1], symbolic.first[1:], strict=True)):
        rows = symbolic.rows[symbolic.row_start[s] : symbolic.row_start[s + 1]]
        np.testing.assert_array_equal(rows[: high - low], np.arange(low, high))
        assert (np.diff(rows) > 0).all()
        room[np.ix_(rows, np.arange(low, high))] = True
        if symbolic.parent[s] >= 0:
            assert symbolic.parent[s] > s
    assert room[lower != 0.0].all()
    assert symbolic.fill == room.sum()


def test_entries_of_the_triangle_are_found_in_the_matrix():
    matrix = pattern(60, 0.05, 3)
    order = np.random.default_rng(2).permutation(60)
    upper, place = upper_triangle(matrix, order)
    expected = np.triu(matrix.toarray()[np.ix_(order, order)])
    found = sparse.csc_array((matrix.data[place], upper.indices, upper.indptr), shape=(60, 60))
    np.testing.assert_array_equal(found.toarray(), expected)
    symbolic = analysed(matrix, order)
    lower = sparse.csc_array(
        (matrix.data[symbolic.place], symbolic.lower_rows, symbolic.lower_start), shape=(60, 60)
    )
    both = matrix.toarray()[np.ix_(symbolic.order, symbolic.order)]
    np.testing.assert_array_equal(lower.toarray(), np.tril(both))


def test_it_fits_its_own_pattern_only():
    matrix = pattern(30, 0.1, 0)
    symbolic = analysed(matrix, np.arange(30))
    assert symbolic.fits(sparse.csr_array(2.0 * matrix))
    assert not symbolic.fits(sparse.csr_array(sparse.eye_array(30)))
