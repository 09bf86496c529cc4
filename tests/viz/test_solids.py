"""Ribbons and rods as solids: as wide as asked, closed surfaces, above where they pass over."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from pictures import ring

from geoweave import viz
from geoweave.errors import RenderError
from geoweave.models import shapes
from geoweave.rods.rods import Contacts, Rods
from geoweave.viz.solids import ribbon_bodies
from geoweave.weave.body import CLEAR
from geoweave.weave.design import Weave, weave_pattern


def far_apart() -> Rods:
    """The ring and the rod that crossed it, which is elsewhere now."""
    rods, nothing = ring(), np.zeros((0, 2), dtype=np.int64)
    points = rods.points.copy()
    points[24:] += (9.0, 0.0, 0.0)
    return replace(rods, points=points, contacts=Contacts(nothing, nothing.astype(float), nothing[:, 0]))


@cache
def pattern() -> Weave:
    return weave_pattern(shapes.torus(faces=2500), scale=0.6)


def ribbons_of(family: int) -> np.ndarray:
    return np.flatnonzero(pattern().families == family)


def test_strips_are_closed_solids() -> None:
    made = viz.strips(pattern(), ribbons_of(0))
    edges = np.concatenate([made.quads[:, [k, (k + 1) % 4]] for k in range(4)])
    forward = {tuple(edge) for edge in edges.tolist()}
    assert len(forward) == len(edges)  # no edge twice the same way
    assert all((b, a) in forward for a, b in forward)  # and every one back


def test_strips_are_as_wide_and_thick_as_asked() -> None:
    weave = pattern()
    made = viz.strips(weave, ribbons_of(1), width=0.03, thickness=0.01)
    rings = made.points.reshape(-1, 4, 3)
    wide = np.linalg.norm(rings[:, 1] - rings[:, 0], axis=1)
    # narrower only where ribbons hold each other too closely
    assert wide.max() == pytest.approx(0.03, rel=1e-9)
    assert (wide > 0.0299).mean() > 0.9
    np.testing.assert_allclose(np.linalg.norm(rings[:, 3] - rings[:, 0], axis=1), 0.01, rtol=1e-9)


def test_a_ribbon_without_width_is_refused() -> None:
    with pytest.raises(RenderError, match="positive width"):
        viz.strips(pattern(), ribbons_of(0), width=0.0)


def test_ribbons_are_apart_along_the_normal_where_they_cross() -> None:
    weave = pattern()
    bodies, met = ribbon_bodies(weave), weave.ribbons.crossings
    for crossing in (0, len(met) // 2, len(met) - 1):
        centres, ups = [], []
        for k in range(2):
            body = bodies[met.curves[crossing, k]]
            section = np.abs(body.at - met.arclength[crossing, k]).argmin()
            centres.append(body.centre[section])
            ups.append(body.up[section])
        top = weave.interlacing.over[crossing]
        rise = (centres[top] - centres[1 - top]) @ (ups[0] + ups[1]) / 2
        assert CLEAR * weave.thickness * 0.99 < rise < 5 * weave.thickness


def test_strips_have_the_section_of_the_rod() -> None:
    made = viz.bands(far_apart(), np.array([0]))
    assert len(made.quads) == len(made.points)  # closed: no caps
    radius = np.linalg.norm(made.points[:, :2], axis=1)
    # between vertices on the circle the strip is smooth, to a thousandth of the radius
    np.testing.assert_allclose(np.unique(np.sign(radius - 1.0)), [-1, 1])
    np.testing.assert_allclose(np.abs(radius - 1.0), 0.025, atol=1e-3)
    np.testing.assert_allclose(np.abs(made.points[:, 2]), 0.1, atol=1e-9)
    assert set(made.segments) == set(range(24))


def test_strips_are_closed_solids_turned_outwards() -> None:
    made = viz.bands(far_apart(), np.array([0, 1]))
    corners = made.points[made.quads]
    # divergence theorem: a third of the flux of x through the outside is the volume
    area = 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    volume = (area * corners.mean(axis=1)).sum() / 3.0
    assert volume == pytest.approx(0.2 * 0.05 * (2 * np.pi + 4.0), rel=0.01)
    owners = np.sort(np.concatenate([made.quads[:, [0, 1]], made.quads[:, [1, 2]], made.quads[:, [2, 3]],
                                     made.quads[:, [3, 0]]]), axis=1)  # fmt: skip
    assert (np.unique(owners, axis=0, return_counts=True)[1] == 2).all()


def test_rods_laid_on_a_surface_part_where_they_cross() -> None:
    rods = ring()
    under, over = (viz.bands(rods, np.array([r])).points for r in (0, 1))
    outwards = rods.directors[0]
    place = rods.points[24 + 2]
    near = [points[np.linalg.norm(points - place, axis=1) < 0.2] @ outwards for points in (under, over)]
    assert near[0].max() < near[1].min()
    # the middles are at least that far apart, and each rod moves by half of it
    assert near[1].mean() == pytest.approx(place @ outwards + 0.5 * CLEAR * 0.05, abs=1e-3)


def test_no_rods_make_no_solid() -> None:
    assert viz.bands(ring(), np.zeros(0, dtype=np.int64)).quads.shape == (0, 4)
