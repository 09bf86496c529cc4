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
    plain = viz.Sprung(found.slid.rods, found.weave.mesh, "slid", view="cone")
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
