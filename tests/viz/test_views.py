"""Views: the eye stands where its angles say, and only kept names are looked up."""

from __future__ import annotations

import numpy as np
import pytest

from geoweave.errors import RenderError
from geoweave.viz.views import FROM_ABOVE, VIEWS, View, view_of


@pytest.mark.parametrize("up", ["x", "y", "z", "-z"])
def test_the_axes_of_a_view_are_a_right_handed_frame(up: str) -> None:
    axes = View(azimuth=37.0, elevation=21.0, up=up).axes
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    # the eye is the elevation above the horizon
    height = axes[2]["xyz".index(up[-1])] * (-1 if up.startswith("-") else 1)
    assert height == pytest.approx(np.sin(np.radians(21.0)))


def test_from_above_has_x_to_the_right_and_y_up() -> None:
    np.testing.assert_allclose(FROM_ABOVE.axes, np.eye(3), atol=1e-12)


def test_a_view_is_given_or_named() -> None:
    own = View(azimuth=1.0)
    assert view_of(own) is own
    assert view_of("bunny") is VIEWS["bunny"]
    with pytest.raises(RenderError, match="no view is kept for 'nessie': give a View, or one of armadillo"):
        view_of("nessie")
    with pytest.raises(RenderError, match="up axis"):
        _ = View(up="w").axes
