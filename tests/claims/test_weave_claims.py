"""What Section 5.2 says of ribbons, crossings, over and under, on weaves made without a parameter."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from geoweave.curves.curves import geodesic_curvature
from geoweave.models import catalogue, shapes
from geoweave.weave.design import Weave, weave_field
from geoweave.weave.interlacing import greedy
from geoweave.weave.validity import violations

WOVEN = ("armadillo", "bunny", "cone", "icosahedron", "sphere", "torus")


@cache
def weave_of(name: str, geodesic: bool = True) -> Weave:
    # the sphere of the figures has 20,480 faces, more than this takes
    mesh = shapes.sphere(5_120) if name == "sphere" else catalogue.load(name)
    return weave_field(mesh, geodesic=geodesic).pattern()


def bending(weave: Weave) -> float:
    """Mean absolute geodesic curvature of ribbons, over their length."""
    curves = weave.ribbons.curves
    return float(np.average(np.abs(geodesic_curvature(curves)), weights=curves.segment_lengths))


@pytest.mark.parametrize("name", WOVEN)
def test_one_click_makes_a_valid_weave(name):
    """Section 5.3: "all of these examples were generated in a single click ... with no parameter tuning"."""
    assert violations(weave_of(name).ribbons) == []


@pytest.mark.parametrize("name", ["armadillo", "bunny", "torus"])
def test_ribbons_cross_at_roughly_sixty_degrees(name):
    """Section 5.2: "these curves will form three overlapping families crossing at roughly sixty degrees"."""
    angles = weave_of(name).crossing_angles
    assert np.median(angles) == pytest.approx(60.0, abs=6.0)
    assert np.mean(np.abs(angles - 60.0) <= 20.0) >= 0.9


@pytest.mark.parametrize("name", WOVEN)
def test_ribbons_go_over_and_under_in_turn(name):
    """Section 5.2 assigns over and under greedily; here the best choice, and its proof."""
    weave = weave_of(name)
    best, rule = weave.interlacing, greedy(weave.passages)
    assert best.alternation >= 0.95
    assert best.alternation_bound - best.alternation <= 0.01
    assert rule.alternation < best.alternation or rule.alternation == 1.0


@pytest.mark.parametrize("name", ["bunny", "icosahedron"])
def test_ribbons_bend_less_than_along_the_smoothest_rosy(name):
    """Section 6: the geodesic optimisation finds "weave patterns that are close to geodesic" (Fig. 23)."""
    ours, rosy = bending(weave_of(name)), bending(weave_of(name, geodesic=False))
    # on the icosahedron both are lines that unfold straight; on the bunny 0.54 and 0.66: not half, see
    # DEVIATIONS.md, ribbon-curvature
    assert ours < 0.85 * rosy or max(ours, rosy) < 0.01


def test_the_weave_of_the_icosahedron_has_its_sixty_rotations():
    """Fig. 19: the weave of the icosahedron is as symmetric as the solid, with its mirror images.

    Its lines follow the edges, as the direction in which the solid bends least. They are a perfect kagome.
    """
    weave = weave_of("icosahedron")
    corners = weave.mesh.vertices[weave.branch_points]
    crossings = np.array([each["point"] for each in weave.document()["crossings"]])
    axes = Rotation.create_group("I")
    around = (turn.as_rotvec() for turn in axes if np.isclose(turn.magnitude(), 0.4 * np.pi))
    first, *others = (axis / np.linalg.norm(axis) for axis in around)
    second = next(axis for axis in others if 0 < first @ axis < 0.9)  # a corner beside the first
    beside = next(corner for corner in corners if 0 < corners[0] @ corner < 0.9)
    placed, _ = Rotation.align_vectors([corners[0], beside], [first, second])
    nearest = cKDTree(crossings)
    for turn in axes:
        distances, onto = nearest.query((placed * turn * placed.inv()).apply(crossings))
        assert distances.max() < 1e-6 * weave.ribbons.spacing
        assert len(np.unique(onto)) == len(crossings)
    mirrored, _ = nearest.query(-crossings)
    assert mirrored.max() < 1e-6 * weave.ribbons.spacing
    others, _ = nearest.query(crossings, k=2)
    assert others[:, 1].min() > 0.4 * weave.ribbons.spacing
    assert weave.interlacing.alternation == 1.0
