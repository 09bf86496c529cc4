import itertools
import time

import numpy as np
import pytest

from geoweave.errors import GeoweaveError
from geoweave.weave import best_labels as labelling
from geoweave.weave.best_labels import best_labels
from geoweave.weave.interlacing import EFFORT


def exhaustive(nodes, first, second, parity, tie):
    """Fewest broken edges over all labellings, and the smallest sum of ties among those that reach it."""
    labels = (np.arange(2**nodes)[:, None] >> np.arange(nodes)) & 1
    broken = (labels[:, first] ^ labels[:, second]) != parity
    count = broken.sum(axis=1)
    return count.min(), (broken @ tie)[count == count.min()].min()


@pytest.mark.parametrize("seed", range(60))
def test_optimal_on_everything_small(seed):
    """Random multigraphs with loops and several components, against all labellings."""
    rng = np.random.default_rng(seed)
    nodes, edges = rng.integers(2, 11), rng.integers(1, 30)
    first, second = rng.integers(0, nodes, (2, edges))
    parity, tie = rng.integers(0, 2, edges), rng.integers(0, 3, edges)
    found = best_labels(nodes, first, second, parity, tie)
    fewest, cheapest = exhaustive(nodes, first, second, parity, tie)
    np.testing.assert_array_equal(found.broken, (found.labels[first] ^ found.labels[second]) != parity)
    assert found.broken.sum() == found.bound == fewest
    assert found.proven
    assert found.best_cost
    assert tie[found.broken].sum() == cheapest


def lattice(side, seed):
    """A square lattice in which one wish in eight is turned round at random."""
    node = np.arange(side * side).reshape(side, side)
    first = np.concatenate([node[:, :-1].ravel(), node[:-1].ravel()])
    second = np.concatenate([node[:, 1:].ravel(), node[1:].ravel()])
    return side * side, first, second, np.random.default_rng(seed).random(len(first)) < 0.125


def test_planar_lattice_is_closed_and_repeats():
    once, again = (best_labels(*lattice(12, 3)) for _ in range(2))
    assert once.proven
    np.testing.assert_array_equal(once.labels, again.labels)
    # Each odd face breaks an edge, and an edge lies on two faces at most.
    parity = lattice(12, 3)[3].astype(int)
    right, down = parity[: 12 * 11].reshape(12, 11), parity[12 * 11 :].reshape(11, 12)
    odd = (right[:-1] + right[1:] + down[:, :-1] + down[:, 1:]) % 2
    assert once.bound >= odd.sum() / 2


def test_wishes_of_hidden_labels_come_back():
    rng = np.random.default_rng(5)
    hidden = rng.integers(0, 2, 500)
    first, second = rng.integers(0, 500, (2, 900))
    found = best_labels(500, first, second, hidden[first] ^ hidden[second])
    assert found.bound == found.broken.sum() == 0
    assert found.proven


def test_with_little_effort_the_bound_is_still_a_bound():
    graph = lattice(20, 0)
    hasty, patient = best_labels(*graph, effort=1), best_labels(*graph)
    assert patient.proven
    assert hasty.bound <= patient.bound <= hasty.broken.sum()
    assert hasty.bound < hasty.broken.sum()


def test_no_clock_ends_a_proof(monkeypatch):
    """A machine on which every call takes an hour finds the same labels, bound and effort."""
    here = best_labels(*lattice(20, 0), effort=300)
    hours = itertools.count(0.0, 3600.0)
    for clock in ("time", "monotonic", "perf_counter", "process_time"):
        monkeypatch.setattr(time, clock, lambda: next(hours))
    there = best_labels(*lattice(20, 0), effort=300)
    np.testing.assert_array_equal(here.labels, there.labels)
    assert (here.bound, here.effort, here.proven) == (there.bound, there.effort, False)


def test_elementary_steps_end_a_proof_on_a_large_graph(monkeypatch):
    graph = lattice(40, 1)
    monkeypatch.setattr(labelling, "_WORK", 20)
    found = best_labels(*graph)
    assert not found.proven
    assert found.effort < 0.5 * EFFORT
    assert 0 <= found.bound < found.broken.sum()


def test_effort_is_counted_and_ends_the_proof_where_it_ends_on_every_machine():
    graph = lattice(20, 0)
    patient = best_labels(*graph)
    some = [best_labels(*graph, effort=effort) for effort in (patient.effort // 4, patient.effort // 4)]
    np.testing.assert_array_equal(some[0].labels, some[1].labels)
    for found in some:
        assert not found.proven
        assert patient.effort // 4 <= found.effort < patient.effort
        assert found.bound <= patient.bound <= found.broken.sum()


def test_nothing_to_label():
    empty = best_labels(3, [], [], [])
    assert empty.proven
    assert empty.labels.tolist() == [False] * 3
    assert best_labels(0, [], [], []).proven


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((3, [0, 1], [1], [0, 1]), "one length"),
        ((3, [0, 1], [1, 3], [0, 1]), "outside 0..2"),
        ((3, [0, 1], [1, 2], [0, 2]), "0 or 1"),
        ((3, [0, 1], [1, 2], [0, 1], [-1, 0]), "not negative"),
        ((3, [0, 1], [1, 2], [0, 1], [0, 0], 0), "effort"),
    ],
)
def test_refusals(arguments, words):
    with pytest.raises(GeoweaveError, match=words):
        best_labels(*arguments)
