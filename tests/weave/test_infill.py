"""Bare places get a ribbon that crosses others well, and parts of a weave are joined."""

from __future__ import annotations

import numpy as np
import pytest
from laidlines import SPACING, kagome, laid

from geoweave.curves.curve_crossings import crossings
from geoweave.curves.curves import Curves
from geoweave.curves.nearest_curve import nearest_curves
from geoweave.curves.stretch import stretches
from geoweave.surface.mesh import TriMesh
from geoweave.weave.infill import Filling, bridged, filled
from geoweave.weave.ribbon_ends import off_ideal

ASKED = Filling(families=3, bare=0.9, apart=(0.5, 0.35), fewest=4, shallowest=40.0, tail=0.25)


def torn(radius: float) -> Curves:
    """A kagome with a round hole in its middle."""
    whole = laid(kagome(0.5)).ribbons.curves
    which, start, end = [], [], []
    for c in range(len(whole)):
        own = slice(whole.offsets[c], whole.offsets[c + 1])
        inside = np.linalg.norm(whole.points[own, :2], axis=1) < radius
        at, length = whole.arclength[own], float(whole.lengths[c])
        spans = [(0.0, at[inside].min()), (at[inside].max(), length)] if inside.any() else [(0.0, length)]
        for low, high in spans:
            which.append(c)
            start.append(low)
            end.append(high)
    return stretches(whole, np.array(which), np.array(start), np.array(end))


def test_a_hole_is_closed() -> None:
    hole = torn(0.35)
    mesh = hole.mesh
    before, _ = nearest_curves(hole, mesh.barycenters, mesh.face_normals)
    assert before.max() > 1.1 * SPACING
    laid_through = filled(hole, SPACING, ASKED)
    curves, new = laid_through.curves, len(laid_through.along)
    assert new >= 1
    after, _ = nearest_curves(curves, mesh.barycenters, mesh.face_normals)
    assert after.max() <= ASKED.bare * SPACING
    met = crossings(curves)
    for c in range(len(hole), len(curves)):
        own = (met.curves == c).any(axis=1)
        # a later one may cross an earlier one besides
        assert own.sum() >= 4
        assert off_ideal(met.angle[own], 3).mean() < 15
        at = np.concatenate([met.arclength[met.curves[:, k] == c, k] for k in (0, 1)])
        assert at.min() <= ASKED.tail * SPACING + 1e-9
        assert curves.lengths[c] - at.max() <= ASKED.tail * SPACING + 1e-9


def test_each_new_one_is_told_which_it_runs_along() -> None:
    laid_through = filled(torn(0.35), SPACING, ASKED)
    curves, given = laid_through.curves, len(laid_through.curves) - len(laid_through.along)
    assert (laid_through.along < given).all()
    for c, other in zip(range(given, len(curves)), laid_through.along.tolist(), strict=True):
        one, two = (curves[k].points[-1] - curves[k].points[0] for k in (c, other))
        assert abs(one @ two) > np.cos(np.radians(31)) * np.linalg.norm(one) * np.linalg.norm(two)


def test_the_first_corner_of_a_face_does_not_decide_where_they_go() -> None:
    hole = torn(0.35)
    mesh = hole.mesh
    first = np.random.default_rng(0).integers(3, size=mesh.n_faces)
    corners = (first[:, None] + np.arange(3)) % 3
    same = TriMesh(mesh.vertices, mesh.faces[np.arange(mesh.n_faces)[:, None], corners])
    moved = Curves(same, hole.points, hole.faces, hole.turning, hole.sliding, hole.offsets, hole.closed)
    one, other = (filled(each, SPACING, ASKED).curves for each in (hole, moved))
    np.testing.assert_allclose(one.points, other.points, atol=1e-9)


def test_a_weave_without_bare_places_is_left_as_it_is() -> None:
    whole = laid(kagome(0.5)).ribbons.curves
    assert filled(whole, SPACING, ASKED).curves is whole


@pytest.mark.parametrize(("fewest", "joined"), [(4, True), (40, False)])
def test_two_parts_are_joined_if_a_ribbon_crosses_enough_of_both(fewest: int, joined: bool) -> None:
    """Two squares of lines, a gap apart that no line crosses."""
    ticks = np.arange(4) * 0.1
    lines = []
    for left in (-0.55, 0.25):
        lines += [(0.0, left + 0.15, y) for y in ticks + 0.013]
        lines += [(90.0, left + x, 0.163) for x in ticks + 0.003]
    both = laid(lines, length=0.17).ribbons.curves
    one = np.arange(len(both)) < 8
    bridge = bridged(both, one, 0.1, ASKED._replace(families=2, fewest=fewest))
    assert (bridge is not None) == joined
    if bridge is not None:
        met = crossings(bridge.curves)
        crossed = met.curves[met.curves[:, 1] == len(both), 0]
        assert one[crossed].any()
        assert not one[crossed].all()
