"""Components of a graph: the ones scipy finds, with the same numbers."""

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.surface.components import connected_components


def expected(pairs: np.ndarray, size: int) -> np.ndarray:
    graph = sparse.coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(size, size))
    return csgraph.connected_components(graph, directed=False)[1]


@pytest.mark.parametrize("links", [0, 1, 40, 90, 400])
@pytest.mark.parametrize("seed", range(5))
def test_components_and_their_order_are_those_of_scipy(links: int, seed: int) -> None:
    pairs = np.random.default_rng(seed).integers(0, 100, (links, 2))
    assert (connected_components(pairs, 100) == expected(pairs, 100)).all()


def test_a_long_chain_in_any_order_is_one_component() -> None:
    chain = np.stack([np.arange(9_999), np.arange(1, 10_000)], axis=1)
    shuffled = np.random.default_rng(3).permutation(10_000)[chain]
    assert (connected_components(shuffled, 10_000) == 0).all()


def test_no_nodes() -> None:
    assert len(connected_components(np.zeros((0, 2), dtype=np.int64), 0)) == 0
