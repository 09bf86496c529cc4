"""Odd cycles are found, lightest first, and are odd."""

from __future__ import annotations

import itertools

import numpy as np

from geoweave.weave.odd_cycles import DoubledGraph, Graph


def random_graph(seed: int, nodes: int = 7, edges: int = 12) -> Graph:
    rng = np.random.default_rng(seed)
    pairs = rng.permutation(list(itertools.combinations(range(nodes), 2)))[:edges]
    ones = np.ones(edges, dtype=np.int64)
    return Graph(nodes, pairs[:, 0], pairs[:, 1], rng.integers(0, 2, edges), ones, ones.astype(float))


def lightest_odd_cycle(graph: Graph, weight: np.ndarray, source: int) -> float:
    """Over all simple cycles through a node, tried one by one."""
    best = np.inf
    where = {}
    for e, (a, b) in enumerate(zip(graph.first, graph.second, strict=True)):
        where[a, b] = where[b, a] = e
    others = [node for node in range(graph.nodes) if node != source]
    for count in range(2, graph.nodes):
        for between in itertools.permutations(others, count):
            ring = (source, *between, source)
            steps = [where.get(step) for step in itertools.pairwise(ring)]
            if None not in steps and int(graph.parity[steps].sum()) % 2:
                best = min(best, float(weight[steps].sum()))
    return best


def test_the_lightest_odd_cycle_through_a_node_is_found() -> None:
    found_any = 0
    for seed in range(12):
        graph = random_graph(seed)
        weight = np.random.default_rng(100 + seed).uniform(0.1, 1.0, len(graph.first))
        found = DoubledGraph(graph).odd_cycles(weight.copy(), np.array([0]), np.inf)
        least = lightest_odd_cycle(graph, weight, 0)
        if not found:
            assert not np.isfinite(least)
            continue
        (cycle,) = found
        ends = graph.first[cycle], graph.second[cycle]
        for labels in itertools.product((0, 1), repeat=graph.nodes):
            differ = np.array(labels)[ends[0]] ^ np.array(labels)[ends[1]]
            assert (differ != graph.parity[cycle]).any(), "no labels meet all edges of an odd cycle"
        # a walk through the node may run there and back before and after its cycle
        assert weight[cycle].sum() <= least + 1e-12
        found_any += 1
    assert found_any > 6


def test_no_cycle_is_heavier_than_the_limit_and_the_weights_found_are_raised() -> None:
    graph = Graph(3, np.array([0, 1, 0]), np.array([1, 2, 2]), np.array([1, 1, 1]), *np.ones((2, 3)))
    doubled = DoubledGraph(graph)
    assert not doubled.odd_cycles(np.ones(3), np.array([0]), 2.9)
    weight = np.ones(3)
    (cycle,) = doubled.odd_cycles(weight, np.array([0]), 3.1)
    assert cycle.tolist() == [0, 1, 2]
    assert (weight > 1).all()


def test_nodes_near_their_copies_come_nearest_first() -> None:
    graph = Graph(
        6,
        np.array([0, 1, 0, 3, 4, 3]),
        np.array([1, 2, 2, 4, 5, 5]),
        np.ones(6, dtype=np.int64),
        *np.ones((2, 6)),
    )
    lengths = np.array([0.2, 0.2, 0.2, 0.1, 0.1, 0.1])
    near = DoubledGraph(graph).near_their_copies(lengths, np.arange(6))
    assert near.tolist() == [3, 4, 5, 0, 1, 2]
    lengths[:3] = 0.4
    assert DoubledGraph(graph).near_their_copies(lengths, np.arange(6)).tolist() == [3, 4, 5]
