"""What hangs on one crossing is found, and nothing else."""

from __future__ import annotations

import laidflat
import numpy as np
import pytest
from scipy import sparse
from scipy.sparse import csgraph

from geoweave.fabrication.flattening import pattern_of
from geoweave.fabrication.pattern import Pattern
from geoweave.twin.joints import _joints, hanging_parts
from geoweave.twin.pattern_surface import surface_of

ACROSS = [(y, -5, 55 if y == 0 else 25) for y in (0, 10, 20)] + [(y, 45, 65) for y in (10, 20)]
"""Height, start and end of strips that lie along x: three of one net, and two of a smaller one beside it."""

UP = [(x, -5, 25) for x in (0, 10, 20, 50)] + [(60, 5, 25)]
"""The same of strips along y. That at 50 belongs to the smaller net, and crosses one strip of the larger."""


def two_nets() -> Pattern:
    lines = [laidflat.ribbon(f"A{y}", 0, [(a, y, 0), (b, y, 0)], laidflat.UP) for y, a, b in ACROSS]
    lines += [laidflat.ribbon(f"B{x}", 1, [(x, a, 0), (x, b, 0)], laidflat.UP) for x, a, b in UP]
    met = [
        laidflat.crossing(i, len(ACROSS) + j, (x - a, y - low), (i + j) % 2)
        for i, (y, a, b) in enumerate(ACROSS)
        for j, (x, low, high) in enumerate(UP)
        if a < x < b and low < y < high
    ]
    return pattern_of(laidflat.document(lines, met))


def test_a_net_that_one_strip_joins_to_a_larger_one_hangs_on_it() -> None:
    pattern = two_nets()
    starts = np.array([a for _, a, _ in ACROSS] + [a for _, a, _ in UP])
    places = pattern.at + starts[pattern.ribbons]
    (part,) = hanging_parts(surface_of(pattern))
    assert places[part.at].tolist() == [20, 0]
    assert sorted(part.crossings) == np.flatnonzero(places[:, 0] >= 50).tolist()


def test_nothing_hangs_on_a_net_without_a_joint() -> None:
    assert hanging_parts(surface_of(pattern_of(laidflat.flat()))) == ()
    assert hanging_parts(surface_of(pattern_of(laidflat.circles()))) == ()


@pytest.mark.parametrize("seed", range(6))
def test_joints_are_what_takes_the_rest_apart(seed: int) -> None:
    random, count = np.random.default_rng(seed), 40
    pairs = random.integers(0, count, (count + 6, 2))
    links = sparse.csr_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
    links = sparse.csr_array(links + links.T)

    def pieces(kept: list[int]) -> int:
        return int(csgraph.connected_components(links[kept][:, kept], directed=False)[0])

    every = list(range(count))
    alone = links.sum(axis=0) == links.diagonal()
    expected = [x for x in every if pieces([y for y in every if y != x]) > pieces(every) - alone[x]]
    assert _joints(links) == expected
    assert expected
