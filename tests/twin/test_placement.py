"""Crossings placed in space from distances along the surface."""

from __future__ import annotations

import laidflat
import numpy as np
import pytest
from twinned import pattern, woven

from geoweave.errors import FieldError
from geoweave.fabrication.flattening import pattern_of
from geoweave.rods.departure import rigid_fit
from geoweave.twin.pattern_surface import surface_of
from geoweave.twin.placement import Net, crossing_normals, net_of, outward, placed, scaled, settled


def places(name: str) -> np.ndarray:
    return np.array([each["point"] for each in woven(name).designed["crossings"]])


def farthest(points: np.ndarray, targets: np.ndarray) -> float:
    """Largest distance after the best rigid fit, in bounding diagonals."""
    rotation, shift = rigid_fit(points, targets, np.ones(len(points)))
    far = np.linalg.norm(points @ rotation.T + shift - targets, axis=1).max()
    return float(far / np.linalg.norm(np.ptp(targets, axis=0)))


def test_scaling_gives_points_of_the_plane_back() -> None:
    rng = np.random.default_rng(3)
    flat = np.column_stack([rng.uniform(0, 100, (12, 2)), np.zeros(12)])
    one, other = np.triu_indices(12, 1)
    lengths = np.linalg.norm(flat[one] - flat[other], axis=1)
    none = np.zeros((0, 2))
    net = Net(np.column_stack([one, other]), lengths, len(one), none.astype(int), none, 10.0)
    points, shares = scaled(net, 12)
    np.testing.assert_allclose(np.linalg.norm(points[one] - points[other], axis=1), lengths, atol=1e-6)
    assert abs(shares[2]) < 1e-9


def test_scaling_needs_one_net_of_six() -> None:
    none = np.zeros((0, 2))
    few = Net(np.array([[0, 1]]), np.ones(1), 1, none.astype(int), none, 1.0)
    with pytest.raises(FieldError, match="cross at 3 places only"):
        scaled(few, 3)
    with pytest.raises(FieldError, match="fall into pieces"):
        scaled(few, 6)


@pytest.mark.parametrize("name", ["cone", "sphere", "torus"])
def test_crossings_are_placed_near_where_they_were_designed(name: str) -> None:
    surface = surface_of(pattern(name, "designed"))
    points = placed(surface, net_of(surface))[-1]
    assert farthest(points, places(name)) < 0.1
    assert outward(surface, points) > 0.3


@pytest.mark.parametrize("name", ["cone", "sphere", "torus"])
def test_a_mirrored_start_is_put_right(name: str) -> None:
    surface = surface_of(pattern(name, "designed"))
    net = net_of(surface)
    one, other = placed(surface, net)[-1], placed(surface, net, mirrored=True)[-1]
    assert farthest(one, other) < 1e-3
    # the mirror image itself is far from it, or this would say nothing
    assert farthest(one * [1.0, 1.0, -1.0], other) > 0.05
    assert outward(surface, one * [1.0, 1.0, -1.0]) == pytest.approx(-outward(surface, one))


def test_springs_keep_lengths_and_energy_falls() -> None:
    surface = surface_of(pattern("sphere", "designed"))
    net = net_of(surface)
    start, _ = scaled(net, len(surface.pattern.ribbons))
    stages, _ = settled(surface, net, start)

    def strain(points: np.ndarray) -> float:
        one, other = net.ends[: net.strips].T
        length = np.linalg.norm(points[one] - points[other], axis=1)
        want = net.lengths[: net.strips]
        clear = want > 0.5 * net.usual
        return float(np.sqrt(np.mean((length[clear] / want[clear] - 1) ** 2)))

    assert strain(stages[-1]) < 0.05 < strain(start)
    assert strain(stages[-1]) < strain(stages[0])


def test_normals_are_those_of_the_plane() -> None:
    flat = laidflat.flat()
    pattern_flat = pattern_of(flat)
    start = np.array([each["points"][0] for each in flat["ribbons"]])
    way = np.array([np.subtract(each["points"][1], each["points"][0]) for each in flat["ribbons"]])
    way /= np.linalg.norm(way, axis=1)[:, None]
    one = pattern_flat.ribbons[:, 0]
    points = start[one] + pattern_flat.at[:, :1] * way[one]
    normals = crossing_normals(surface_of(pattern_flat), points)
    np.testing.assert_allclose(normals, np.tile([0.0, 0.0, 1.0], (len(points), 1)), atol=1e-9)
    mirrored = crossing_normals(surface_of(pattern_flat), points * [1.0, -1.0, 1.0])
    np.testing.assert_allclose(mirrored, -normals, atol=1e-9)
