"""The picture of one weave: as designed on its surface, or at rest over a veil."""

from __future__ import annotations

import numpy as np
import pytest
from pictures import near

from geoweave import viz
from geoweave.errors import RodError
from geoweave.models import shapes
from geoweave.rods.weave_at_rest import relaxed_weave
from geoweave.surface.mesh import TriMesh
from geoweave.viz import style
from geoweave.weave.design import weave_pattern

SURFACE = shapes.cone(faces=400)


def test_a_weave_is_drawn_on_its_surface_and_at_rest_over_a_veil() -> None:
    woven = weave_pattern(SURFACE, ribbons=8)
    designed = viz.weave(woven, on=SURFACE, view="cone", title="a cone", width=400)
    at_rest = viz.weave(relaxed_weave(woven, rounds=1), on=SURFACE, view="cone", width=400)
    assert designed.pixels.shape[1] == at_rest.pixels.shape[1] == 400
    assert designed.alt.endswith("on its surface")
    assert at_rest.alt.endswith("at rest")
    for picture in (designed, at_rest):
        assert all(near(picture.pixels, hue, 60).mean() > 0.01 for hue in style.FAMILIES[:3])
    # without a surface, that of the weave is drawn
    assert (viz.weave(woven, view="cone", title="a cone", width=400).pixels == designed.pixels).mean() > 0.99


def test_another_surface_is_refused() -> None:
    woven = weave_pattern(SURFACE, ribbons=8)
    away = TriMesh(SURFACE.vertices + np.array([5.0, 0.0, 0.0]), SURFACE.faces)
    with pytest.raises(RodError, match="give the surface that was woven"):
        viz.weave(woven, on=away)
