"""A merged pair is gone and no other index has changed; an index goes where it is moved."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import ALL, surface

from geoweave.errors import FieldError
from geoweave.fields.index_pairs import EdgePaths, merged_pairs, moved
from geoweave.fields.rosy import RoSyField, smoothest_rosy
from geoweave.fields.trivial_connection import prescribed_rosy
from geoweave.models import shapes


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("degree", [4, 6])
def test_merged_pairs_are_gone_and_nothing_else_moved(name, degree):
    rosy = smoothest_rosy(surface(name), degree)
    for distance in (0.2, 0.5, 1.0):
        merged = merged_pairs(rosy, distance)
        expected = rosy.index_numerators.copy()
        for pair in merged.pairs:
            assert pair.distance <= distance
            expected[pair.positive] -= 1
            expected[pair.negative] += 1
        assert (merged.rosy.index_numerators == expected).all()
        assert (merged.rosy.boundary_numerators == rosy.boundary_numerators).all()


def test_no_pair_is_left_within_the_distance():
    rosy = smoothest_rosy(surface("genus 5"), 6)
    left = merged_pairs(rosy, 0.2).rosy
    assert 0 < np.abs(left.index_numerators).sum() < np.abs(rosy.index_numerators).sum()
    assert merged_pairs(left, 0.2).pairs == ()
    assert merged_pairs(left, 0.2).rosy is left


def test_the_nearest_two_go_first_and_each_loses_as_much():
    flat = shapes.square(faces=800)
    at = [int(np.linalg.norm(flat.vertices[:, :2] - [x, 0], axis=1).argmin()) for x in (-0.5, 0.0, 0.4)]
    numerators = np.zeros(flat.n_vertices, dtype=np.int64)
    numerators[at] = 1, -2, 2
    merged = merged_pairs(prescribed_rosy(flat, 6, numerators), 0.8)
    assert [(pair.positive, pair.negative) for pair in merged.pairs] == [(at[2], at[1])] * 2
    left = np.flatnonzero(merged.rosy.index_numerators)
    assert left.tolist() == [at[0]]


def test_the_field_changes_near_the_pair_and_hardly_far_from_it():
    flat = shapes.square(faces=3000)
    at = [int(np.linalg.norm(flat.vertices[:, :2] - [x, 0], axis=1).argmin()) for x in (-0.05, 0.05)]
    numerators = np.zeros(flat.n_vertices, dtype=np.int64)
    numerators[at] = 1, -1
    rosy = prescribed_rosy(flat, 6, numerators)
    merged = merged_pairs(rosy, 0.3).rosy
    turn = np.abs(
        np.angle(merged.values * rosy.values.conj() * np.conj(np.mean(merged.values / rosy.values)))
    )
    far = np.linalg.norm(flat.barycenters[:, :2], axis=1) > 0.7
    # A pair is a dipole: its angle falls as one over the distance, 2 pi 0.1 / (2 pi 0.7) = 0.14 at most.
    assert turn[far].max() < 0.25
    assert turn[~far].max() > 1.0
    # On a flat square without singularities it is parallel again.
    assert np.abs(np.angle(merged.values / merged.values[0])).max() < 1e-6 or np.ptp(merged.turns) < 1e-6


def test_distances_and_paths_are_those_along_edges():
    flat = shapes.square(faces=800)
    paths = EdgePaths(flat)
    start, end = (
        int(np.linalg.norm(flat.vertices[:, :2] - p, axis=1).argmin()) for p in ([-0.5, 0], [0.5, 0.1])
    )
    far, before = paths.within(np.array([start]), np.inf)
    straight = np.linalg.norm(flat.vertices[start] - flat.vertices[end])
    assert straight <= far[0, end] < 1.3 * straight
    jumps = np.zeros(len(flat.interior_edges), dtype=np.int64)
    paths.add_turn(jumps, before[0], start, end)
    edges = flat.interior_edges[np.flatnonzero(jumps)]
    assert flat.edge_lengths[edges].sum() == pytest.approx(far[0, end])


@pytest.mark.parametrize("name", ["sphere", "torus", "disk"])
def test_an_index_goes_where_it_is_moved(name):
    rosy = smoothest_rosy(surface(name), 6)
    inside = np.flatnonzero(~rosy.mesh.boundary_vertices & (rosy.index_numerators == 0))
    start, end, other = inside[[0, len(inside) // 2, -1]]
    change = moved(rosy, [(start, end), (start, other)]).index_numerators - rosy.index_numerators
    assert (change[start], change[end], change[other]) == (-2, 1, 1)
    assert np.abs(change).sum() == 4
    assert moved(rosy, []) is rosy


def test_what_cannot_be_merged_or_moved_is_refused():
    disk = surface("disk")
    rosy = RoSyField(disk, 6, np.ones(disk.n_faces))
    for bad in (-1.0, np.nan):
        with pytest.raises(FieldError, match="zero or more"):
            merged_pairs(rosy, bad)
    rim, inside = np.flatnonzero(disk.boundary_vertices)[0], np.flatnonzero(~disk.boundary_vertices)[0]
    with pytest.raises(FieldError, match="boundary"):
        moved(rosy, [(rim, inside)])
