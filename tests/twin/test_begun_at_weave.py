"""Of two shapes in which strips can rest, the one with less energy is the object's."""

from __future__ import annotations

from dataclasses import replace

import pytest
from twinned import twin, woven

from geoweave.twin.begun_at_weave import begun_at
from geoweave.twin.twin import Twin


def stuck(share: float) -> Twin:
    """The twin of a cone, as if it had come to rest too high, with a share of the energy of its start."""
    made = twin("cone")
    squeezed = replace(made.rods, points=made.rods.points * [1.0, 1.0, 0.3])
    high = made.rest.steps[0]
    energies = {name: share * value for name, value in high.energies.items()}
    steps = (replace(high, energies=energies),)
    return replace(made, rest=replace(made.rest, rods=squeezed, steps=steps))


def test_strips_that_keep_the_shape_of_the_weave_more_easily_have_it() -> None:
    weave, high = woven("cone").relaxed, stuck(1.0)
    assert not high.compared(weave).comes_back
    found = begun_at(high, weave)
    assert found is not None
    assert found.rest.steps[-1].energy < high.rest.steps[-1].energy
    assert found.compared(weave).comes_back
    assert found.alone is not None
    assert found.alone.crossings.largest == high.compared(weave).crossings.largest
    assert found.metrics()["alone"]["comes_back"] is False
    assert found.tried[-1] == pytest.approx(twin("cone").rest.steps[-1].energy, rel=1e-2)


def test_the_shape_of_the_weave_is_none_of_strips_that_rest_lower_elsewhere() -> None:
    assert begun_at(stuck(0.0), woven("cone").relaxed) is None


def test_a_twin_of_the_strips_alone_says_so() -> None:
    assert twin("cone").alone is None
    assert twin("cone").metrics()["alone"] is None
