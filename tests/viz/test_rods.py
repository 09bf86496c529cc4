"""Elastic rods in pictures: strips with the sections of the rods, over and under, energies in colour."""

from functools import cache

import numpy as np
import pytest

from geoweave import viz
from geoweave.errors import RenderError
from geoweave.models import shapes
from geoweave.rods.departure import vertex_weights
from geoweave.rods.elastic_energies import energy_density
from geoweave.rods.rods import Contacts, Layout, Material, Rods
from geoweave.rods.weave_at_rest import Relaxed, relaxed_weave
from geoweave.viz.scales import Scale
from geoweave.weave.design import weave_pattern


def ring(n: int = 24, width: float = 0.2, thickness: float = 0.05) -> Rods:
    """A closed rod round the unit circle, thickness outwards, and a straight one across it on top."""
    turn = 2 * np.pi * np.arange(n) / n
    circle = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    middle = turn + np.pi / n
    outwards = np.column_stack([np.cos(middle), np.sin(middle), 0 * turn])
    bar = np.column_stack([np.full(5, np.cos(np.pi / n)), np.full(5, np.sin(np.pi / n)), [-2, -1, 0.0, 1, 2]])
    points = np.concatenate([circle, bar])
    layout = Layout(np.array([0, n, n + 5]), np.array([True, False]))
    lengths = np.linalg.norm(points[layout.ends[:, 1]] - points[layout.ends[:, 0]], axis=1)
    directors = np.concatenate([outwards, np.tile(outwards[0], (4, 1))])
    contacts = Contacts(np.array([[0, n + 2]]), np.array([[0.5, 0.0]]), np.array([1]))
    widths = np.full(layout.segments, width)
    return Rods(layout, points, directors, widths, lengths, contacts, Material(thickness))


@cache
def relaxed() -> Relaxed:
    return relaxed_weave(weave_pattern(shapes.cone(faces=1000), ribbons=9), rounds=1)


def test_strips_have_the_section_of_the_rod() -> None:
    made = viz.bands(ring(), np.array([0]))
    assert len(made.points) == 4 * 4 * 24
    assert len(made.quads) == len(made.points)  # closed: no caps
    radius = np.linalg.norm(made.points[:, :2], axis=1)
    # between vertices on the circle the strip is smooth, to a thousandth of the radius
    np.testing.assert_allclose(np.unique(np.sign(radius - 1.0)), [-1, 1])
    np.testing.assert_allclose(np.abs(radius - 1.0), 0.025, atol=1e-3)
    np.testing.assert_allclose(np.abs(made.points[:, 2]), 0.1, atol=1e-9)
    assert set(made.segments) == set(range(24))


def test_strips_are_closed_solids_turned_outwards() -> None:
    made = viz.bands(ring(), np.array([0, 1]))
    corners = made.points[made.quads]
    # divergence theorem: a third of the flux of x through the outside is the volume
    area = 0.5 * np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    volume = (area * corners.mean(axis=1)).sum() / 3.0
    assert volume == pytest.approx(0.2 * 0.05 * (2 * np.pi + 4.0), rel=0.01)
    owners = np.sort(np.concatenate([made.quads[:, [0, 1]], made.quads[:, [1, 2]], made.quads[:, [2, 3]],
                                     made.quads[:, [3, 0]]]), axis=1)  # fmt: skip
    assert (np.unique(owners, axis=0, return_counts=True)[1] == 2).all()


def test_lifted_rods_part_by_more_than_a_thickness_where_they_cross() -> None:
    rods = ring()
    under, over = (viz.bands(rods, np.array([r]), lifted=True).points for r in (0, 1))
    outwards = rods.directors[0]
    place = rods.points[24 + 2]
    near = [points[np.linalg.norm(points - place, axis=1) < 0.2] @ outwards for points in (under, over)]
    assert near[0].max() < near[1].min()
    flat = viz.bands(rods, np.array([1])).points
    assert near[1].mean() == pytest.approx((flat @ outwards).mean() + 0.55 * 0.05)


def test_rest_is_put_back_on_the_design() -> None:
    found = relaxed()
    placed, design = viz.at_rest(found), found.slid.rods
    np.testing.assert_allclose(placed.points, found.departure.points, atol=1e-9)
    for name, before in energy_density(found.left.rods).items():  # a rigid motion costs nothing
        np.testing.assert_allclose(energy_density(placed)[name], before, rtol=1e-6, atol=1e-6)
    weights = vertex_weights(placed)[:, None]
    here, there = (weights * placed.points).sum(axis=0), (weights * design.points).sum(axis=0)
    np.testing.assert_allclose(here, there, atol=1e-9)


def test_pictures() -> None:
    found = relaxed()
    values = np.sum(list(energy_density(found.left.rods).values()), axis=0)
    scale = viz.energy_scale([values], "N")
    assert scale.low == 0
    assert 0 < scale.high <= values.max()
    plain = viz.Sprung(found.slid.rods, found.weave.mesh, "slid", view="cone", lifted=True)
    coloured = viz.Sprung(viz.at_rest(found), found.weave.mesh, "at rest", values=values, opacity=0.3)
    pixels = [each.scene(scale).draw(120) for each in (plain, coloured)]
    assert all((picture < 200).any() for picture in pixels)
    # one hue against a map: the second has more colours
    assert np.ptp(pixels[1].reshape(-1, 3), axis=0).min() > 50
    picture = viz.rod_gallery([plain, coloured], scale=scale, width=600)
    assert "at rest" in picture.alt
    assert picture.colormaps == (scale.colormap,)


def test_bad_input_is_refused() -> None:
    with pytest.raises(RenderError, match="no rod has any energy"):
        viz.energy_scale([np.zeros(3)], "N")
    bent = viz.Sprung(ring(), shapes.sphere(80), "bent", values=np.ones(28))
    with pytest.raises(RenderError, match="'bent' has values"):
        viz.rod_gallery([bent])
    with pytest.raises(RenderError, match="at least one panel"):
        viz.rod_gallery([], scale=Scale(viz.style.sequential(), 0.0, 1.0, "N"))
    assert viz.bands(ring(), np.zeros(0, dtype=np.int64)).quads.shape == (0, 4)
