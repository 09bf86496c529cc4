"""Ribbons as they are drawn cut each other nowhere where the surface is even, and seldom elsewhere."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

from geoweave.models import shapes
from geoweave.viz.solids import ribbon_bodies
from geoweave.weave.body import Body, Centreline, bodies
from geoweave.weave.design import Weave, weave_pattern
from geoweave.weave.lying_over import NARROWEST

WIDTH, THICK = 4.0, 0.2


@cache
def cone() -> Weave:
    return weave_pattern(shapes.cone(faces=2000), ribbons=16)


@cache
def torus() -> Weave:
    return weave_pattern(shapes.torus(faces=2500), scale=0.6)


def cut_share(found: tuple[Body, ...]) -> float:
    """Share of points of the ribbons that lie within another ribbon by over 1 % of its thickness."""
    points, ups, owners = [], [], []
    width, thickness = found[0].width, found[0].thickness
    near = 0.06 * width
    for r, body in enumerate(found):
        s = np.linspace(0.0, body.at[-1], max(int(body.at[-1] / near), 4))
        centre, side, up = (
            np.stack([np.interp(s, body.at, each[:, k]) for k in range(3)], axis=1)
            for each in (body.centre, body.side, body.up)
        )
        half = 0.5 * width * np.interp(s, body.at, body.share)
        for v in np.linspace(-0.98, 0.98, 17):
            points.append(centre + (v * half)[:, None] * side)
            ups.append(up / np.linalg.norm(up, axis=1, keepdims=True))
            owners.append(np.full(len(s), r))
    p, up, owner = np.concatenate(points), np.concatenate(ups), np.concatenate(owners)
    one, two = cKDTree(p).query_pairs(near + thickness, output_type="ndarray").T
    other = (owner[one] != owner[two]) & ((up[one] * up[two]).sum(axis=1) > 0.7)
    one, two = one[other], two[other]
    normal = up[one] + up[two]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    apart = p[one] - p[two]
    height = (apart * normal).sum(axis=1)
    beside = np.linalg.norm(apart - height[:, None] * normal, axis=1)
    within = (np.abs(height) < 0.99 * thickness) & (beside < 0.5 * near)
    return float(within.sum()) / len(p)


def flat(
    lines: list[tuple[tuple[float, float], tuple[float, float]]], over: dict[tuple[int, int], int]
) -> tuple[Body, ...]:
    """Straight ribbons in a plane; over says which of two that cross lies above."""
    made = []
    for start, end in lines:
        steps = np.linspace(0.0, 1.0, 41)[:, None]
        points = np.array([*start, 0.0]) + steps * (np.array([*end, 0.0]) - np.array([*start, 0.0]))
        made.append(Centreline(points, np.tile([0.0, 0.0, 1.0], (len(points), 1)), closed=False))
    places = []
    for a, b in over:
        (p, q), (r, s) = (np.array(lines[each]) for each in (a, b))
        u, v = np.linalg.solve(np.stack([q - p, r - s], axis=1), r - p)
        places.append((u * np.linalg.norm(q - p), v * np.linalg.norm(s - r)))
    above = np.array([0 if top == a else 1 for (a, _), top in over.items()])
    return bodies(made, np.array(list(over)), np.array(places), above, width=WIDTH, thickness=THICK)


def three(inradius: float) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Three lines at 60 degrees round a triangle of this inradius."""
    found = []
    for angle in np.deg2rad([90.0, 210.0, 330.0]):
        out, along = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        found.append((tuple(inradius * out - 30 * along), tuple(inradius * out + 30 * along)))
    return found


TURN = {(0, 1): 0, (1, 2): 1, (2, 0): 2}
"""Each lies over the next one: they hold each other."""

STACK = {(0, 1): 0, (1, 2): 1, (2, 0): 0}
"""One over two over three."""


@pytest.mark.parametrize("share", [1.2, 0.9, 0.6])
def test_three_that_hold_each_other_are_drawn_narrower_where_they_must(share: float) -> None:
    made = flat(three(0.5 * WIDTH * share), TURN)
    assert cut_share(made) == 0.0
    least = min(float(body.share.min()) for body in made)
    assert least == 1.0 if share > 1.15 else 0.8 * share < least < share
    # away from the triangle they have their full width
    for body in made:
        assert body.share[0] == body.share[-1] == 1.0


@pytest.mark.parametrize("share", [0.5, 0.1, 0.0])
def test_three_in_a_point_lie_in_three_layers_at_full_width(share: float) -> None:
    made = flat(three(0.5 * WIDTH * share), STACK)
    assert cut_share(made) == 0.0
    assert all(float(body.share.min()) == 1.0 for body in made)
    middle = [float(body.centre[np.argmin(np.abs(body.at - 30.0)), 2]) for body in made]
    assert middle[0] > middle[1] > middle[2]


def test_three_in_a_point_that_hold_each_other_are_not_drawn_as_threads() -> None:
    made = flat(three(0.0), TURN)
    assert min(float(body.share.min()) for body in made) == pytest.approx(NARROWEST)


def test_ribbons_side_by_side_do_not_overlap() -> None:
    lines = [((-30.0, 0.0), (30.0, 0.0)), ((-30.0, 3.0), (30.0, 3.0)), ((0.0, -30.0), (0.0, 30.0))]
    made = flat(lines, {(0, 2): 0, (1, 2): 1})
    assert cut_share(made) == 0.0
    assert made[0].share[2] == pytest.approx(0.97 * 3.0 / WIDTH)
    assert made[2].share.min() == 1.0


def test_no_ribbon_of_a_cone_cuts_another() -> None:
    assert cut_share(ribbon_bodies(cone())) == 0.0


def test_ribbons_of_a_torus_hardly_cut_each_other() -> None:
    """Without levels and necks it is 5 % of their area."""
    assert cut_share(ribbon_bodies(torus())) < 0.01


def test_the_lowest_ribbon_stays_above_the_drawn_surface() -> None:
    """Pictures draw the surface 1.3 thicknesses lower than it is."""
    weave = cone()
    tree = cKDTree(weave.mesh.vertices)
    for body in ribbon_bodies(weave):
        _, near = tree.query(body.centre)
        depth = ((weave.mesh.vertices[near] - body.centre) * weave.mesh.vertex_normals[near]).sum(axis=1)
        assert depth.max() < 1.3 * weave.thickness
