"""Elastic rods in pictures: strips with the sections of the rods, over and under, energies in colour."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from pictures import ring

from geoweave import viz
from geoweave.errors import RenderError
from geoweave.models import shapes
from geoweave.rods.departure import vertex_weights
from geoweave.rods.elastic_energies import energy_density
from geoweave.rods.weave_at_rest import Relaxed, relaxed_weave
from geoweave.viz.scales import Scale
from geoweave.weave.design import weave_pattern


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
    even = viz.energy_scale([values], "N", decades=3)
    assert even.log
    assert even.low == even.high / 1000
    assert (coloured.scene(even).draw(120) != pixels[1]).any()
    # one hue against a map: the second has more colours
    assert np.ptp(pixels[1].reshape(-1, 3), axis=0).min() > 50
    picture = viz.rod_gallery([plain, coloured], scale=scale, width=600)
    assert "at rest" in picture.alt
    assert picture.colormaps == (scale.colormap,)


def test_panels_below_each_other_have_one_scale() -> None:
    found = relaxed()
    moved = replace(found.left.rods, points=2.0 * found.left.rods.points)  # at rest, much larger
    panels = [viz.Sprung(rods, found.weave.mesh, view="cone") for rods in (found.slid.rods, moved)]
    aspects = []
    for alike in (False, True):
        picture = viz.rod_gallery(panels, columns=1, width=300, columns_alike=alike)
        aspects.append([scene._frame()[3] for scene in picture.scenes])
    assert aspects[0][1] > 1.3 * aspects[0][0]
    assert aspects[1][1] == pytest.approx(aspects[1][0])
    assert aspects[1][1] == pytest.approx(aspects[0][1], rel=0.1)


def test_bad_input_is_refused() -> None:
    with pytest.raises(RenderError, match="no rod has any energy"):
        viz.energy_scale([np.zeros(3)], "N")
    bent = viz.Sprung(ring(), shapes.sphere(80), "bent", values=np.ones(28))
    with pytest.raises(RenderError, match="'bent' has values"):
        viz.rod_gallery([bent])
    with pytest.raises(RenderError, match="at least one panel"):
        viz.rod_gallery([], scale=Scale(viz.style.sequential(), 0.0, 1.0, "N"))
