"""Ribbons as solids: as wide as asked, closed surfaces, above where they pass over."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from geoweave import shapes, viz
from geoweave.errors import RenderError
from geoweave.viz import weaves
from geoweave.weave import Weave, weave_pattern


@cache
def pattern() -> Weave:
    return weave_pattern(shapes.torus(faces=2500), scale=0.6)


def test_strips_are_closed_solids() -> None:
    made = weaves.strips(pattern(), 0)
    edges = np.concatenate([made.quads[:, [k, (k + 1) % 4]] for k in range(4)])
    forward = {tuple(edge) for edge in edges.tolist()}
    assert len(forward) == len(edges)  # no edge twice the same way
    assert all((b, a) in forward for a, b in forward)  # and every one back


def test_strips_are_as_wide_and_thick_as_asked() -> None:
    weave = pattern()
    made = weaves.strips(weave, 1, width=0.3, thickness=0.1)
    rings = made.points.reshape(-1, 4, 3)
    spacing = weave.ribbons.spacing
    np.testing.assert_allclose(np.linalg.norm(rings[:, 1] - rings[:, 0], axis=1), 0.3 * spacing, rtol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(rings[:, 3] - rings[:, 0], axis=1), 0.1 * spacing, rtol=1e-9)


def test_over_is_above_under() -> None:
    at, sides = np.array([0.3, 0.7]), np.array([1.0, -1.0])
    heights = weaves._heights(np.linspace(0, 1, 11), at, sides, 1.0, False)
    np.testing.assert_allclose(heights[[0, 3, 5, 7, 10]], [1, 1, 0, -1, -1], atol=1e-12)
    round_ = weaves._heights(np.array([0.0, 0.3, 0.7]), at, sides, 1.0, True)
    np.testing.assert_allclose(round_, [0, 1, -1], atol=1e-12)


def test_a_picture_has_all_three_hues() -> None:
    picture = viz.weave_gallery([("Torus", "three families", pattern(), viz.View(elevation=40))], width=700)
    pixels = picture.pixels.reshape(-1, 3).astype(float)
    colourful = pixels[np.ptp(pixels, axis=1) > 60]
    assert len(colourful) > 0.1 * len(pixels)
    with pytest.raises(RenderError, match="at least one"):
        viz.weave_gallery([])
    with pytest.raises(RenderError, match="positive width"):
        weaves.strips(pattern(), 0, width=0.0)
