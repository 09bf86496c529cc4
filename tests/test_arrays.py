"""Frozen arrays refuse to be written to; cross products and parallel transport keep what they must."""

import numpy as np
import pytest

from geoweave.arrays import cross, frozen, parallel_transport


def test_frozen_is_the_same_array_made_read_only() -> None:
    array = np.arange(3.0)
    assert frozen(array) is array
    with pytest.raises(ValueError, match="read-only"):
        array[0] = 1.0


def test_cross_is_the_cross_product() -> None:
    one, two = np.random.default_rng(0).normal(size=(2, 5, 4, 3))
    np.testing.assert_array_equal(cross(one, two), np.cross(one, two))


def test_parallel_transport_turns_one_tangent_to_the_other_and_keeps_angles() -> None:
    rng = np.random.default_rng(0)
    before, after, v, w = rng.normal(size=(4, 50, 3))
    before /= np.linalg.norm(before, axis=1)[:, None]
    after /= np.linalg.norm(after, axis=1)[:, None]
    np.testing.assert_allclose(parallel_transport(before, after, before), after, atol=1e-12)
    np.testing.assert_allclose(
        (parallel_transport(before, after, v) * parallel_transport(before, after, w)).sum(1),
        (v * w).sum(1),
        atol=1e-12,
    )
    axis = np.cross(before, after)
    np.testing.assert_allclose(parallel_transport(before, after, axis), axis, atol=1e-12)


def test_parallel_transport_between_opposite_vectors_is_finite() -> None:
    up = np.array([[0.0, 0.0, 1.0]])
    np.testing.assert_array_equal(
        parallel_transport(up, -up, np.array([[1.0, 2.0, 0.0]])), [[-1.0, -2.0, 0.0]]
    )
