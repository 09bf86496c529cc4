"""What the paper says of weaves at rest, on weaves that relax in under a second."""

from __future__ import annotations

from functools import cache

import pytest

from geoweave import shapes
from geoweave.relaxed import relaxed_weave
from geoweave.weave import WeaveField, weave_field


@cache
def field(name: str) -> WeaveField:
    return weave_field({"saddle": shapes.saddle(faces=1000), "bumpy box": shapes.bumpy_box(faces=2500)}[name])


@pytest.mark.parametrize("ribbons", [8, 12])
def test_an_open_surface_whose_boundary_is_held_keeps_its_shape_better(ribbons: int) -> None:
    """The saddle is the paper's kind of surface that departs: with its rim held it stays twice as near."""
    weave = field("saddle").pattern(ribbons=ribbons)
    free, held = (relaxed_weave(weave, fixed_boundary=fixed) for fixed in (False, True))
    assert free.converged
    assert held.converged
    assert held.metrics()["mean"] < 0.5 * free.metrics()["mean"]
    assert held.metrics()["hausdorff_held"] < 0.03  # of the bounding diagonal


def test_more_and_thinner_ribbons_follow_a_shape_more_closely() -> None:
    """The width is a share of the spacing; three times the ribbons more than halve the mean distance."""
    found = []
    for ribbons in (8, 12, 19, 29):
        weave = field("bumpy box").pattern(ribbons=ribbons)
        rest = relaxed_weave(weave)
        assert rest.converged
        found.append((len(weave.ribbons), weave.width, rest.metrics()["mean"]))
    counts, widths, distances = zip(*found, strict=True)
    assert list(counts) == sorted(counts)
    assert list(widths) == sorted(widths, reverse=True)
    assert list(distances) == sorted(distances, reverse=True)
    assert distances[-1] < 0.5 * distances[0]
