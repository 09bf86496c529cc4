"""Ribbons become elastic rods and slide on the surface that was woven."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from geoweave.errors import RodError
from geoweave.models import shapes
from geoweave.rods.slid_weave import elastic_rods, slide
from geoweave.surface.mesh import TriMesh
from geoweave.weave.design import weave_pattern
from geoweave.weave.weave import Weave


@cache
def cone() -> Weave:
    return weave_pattern(shapes.cone(faces=1500), ribbons=12).sized(100.0)


def test_rods_take_a_width_in_the_unit_of_the_weave() -> None:
    made = elastic_rods(cone(), width=4.0, thickness=0.2)
    unit = cone().placement.scale
    np.testing.assert_allclose(made.rods.widths * unit, 4.0, rtol=1e-12)
    assert made.rods.material.thickness * unit == pytest.approx(0.2)
    assert made.weave.width == made.rods.widths[0]
    assert elastic_rods(cone()).weave is cone()


def test_the_surface_may_have_the_size_that_it_was_woven_in_or_that_of_the_weave() -> None:
    surface = shapes.cone(faces=400)
    rods = elastic_rods(weave_pattern(surface, ribbons=8).sized(size=300.0))
    extent = np.ptp(surface.vertices, axis=0).max()
    large = TriMesh(surface.vertices * 300.0 / extent, surface.faces)
    ends = [slide(rods, each).slid.steps[-1].energy for each in (surface, large, None)]
    assert ends == pytest.approx([ends[2]] * 3, rel=1e-6)


def test_a_surface_elsewhere_is_refused() -> None:
    weave = weave_pattern(shapes.cone(faces=400), ribbons=8)
    far = shapes.sphere(200)
    far = TriMesh(far.vertices + 5.0, far.faces)
    with pytest.raises(RodError, match="give the surface that was woven"):
        slide(elastic_rods(weave), far)


def test_strips_are_as_long_as_the_ribbons_where_they_slid_to_and_straight() -> None:
    slid = slide(elastic_rods(weave_pattern(shapes.cone(faces=400), ribbons=8)))
    np.testing.assert_array_equal(slid.cut.rest, slid.slid.rods.lengths)
    assert not slid.cut.natural.any()
