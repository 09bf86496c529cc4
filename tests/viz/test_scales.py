"""Scales: limits from the values, bars that show the colours from one end to the other."""

from __future__ import annotations

import numpy as np
import pytest
from pictures import near

from geoweave.errors import RenderError
from geoweave.viz import style
from geoweave.viz.picture import Picture, sheet
from geoweave.viz.scales import (
    Scale,
    colour_bar,
    colour_bars,
    deviation_scale,
    energy_scale,
    factor_scale,
    heat_scale,
    rounded_up,
)


@pytest.mark.parametrize(("value", "rounded"), [(0.1234, 0.13), (99.1, 100.0), (7.0, 7.0), (0.0, 1.0)])
def test_limits_have_two_leading_digits(value: float, rounded: float) -> None:
    assert rounded_up(value) == pytest.approx(rounded)


def test_scales_end_at_a_percentile() -> None:
    values = np.arange(101.0)
    assert heat_scale(values, "x", 90.0).high == 90.0
    assert energy_scale([values[:50], values[50:]], "N", 98.0).high == 98.0
    assert heat_scale(np.zeros(3), "x").high == 1.0
    assert (factor_scale(0.5, 2.0).high, deviation_scale().high) == (2.0, 30.0)
    with pytest.raises(RenderError, match="no rod has any energy"):
        energy_scale([np.zeros(3)], "N")


def test_signed_scales_are_open_at_both_ends() -> None:
    assert Scale(style.diverging(), -1.0, 1.0, "x").ends == "both"
    assert Scale(style.sequential(), 0.0, 1.0, "x").ends == "max"


def test_two_bars_stand_side_by_side() -> None:
    figure = sheet(900, 200)
    colour_bars(
        figure, [Scale(style.sequential(), 0.0, 1.0, "one"), Scale(style.diverging(), -1.0, 1.0, "two")]
    )
    pixels = Picture(figure).pixels
    amber, blue = near(pixels, style.sequential()(0.98)[:3]), near(pixels, style.diverging()(0.02)[:3])
    assert amber[:, :450].any()
    assert not amber[:, 450:].any()
    assert blue[:, 450:].any()
    assert not blue[:, :450].any()


def test_a_bar_stands_or_lies_and_has_the_words_it_is_given() -> None:
    def drawn(upright: bool, words: str) -> np.ndarray:
        figure = sheet(300, 300)
        scale = Scale(style.heat(), 0.0, 1.0, "x", {0.0: "0", 1.0: words})
        box = (0.4, 0.2, 0.05, 0.6) if upright else (0.2, 0.4, 0.6, 0.05)
        colour_bar(figure, scale, box, 0.5, upright=upright)
        return Picture(figure).pixels

    rust = [np.nonzero(near(drawn(upright, "1"), style.heat()(0.98)[:3])) for upright in (False, True)]
    assert rust[0][1].min() > 200  # the high end lies to the right
    assert rust[1][0].max() < 100  # or stands at the top
    assert (drawn(False, "1") != drawn(False, "one full turn")).any()


def test_a_logarithmic_scale_puts_equal_ratios_equally_far_apart() -> None:
    scale = factor_scale(0.5, 8.0)
    assert np.allclose(scale.norm(np.array([0.5, 1.0, 2.0, 4.0, 8.0])), [0.0, 0.25, 0.5, 0.75, 1.0])
    with pytest.raises(RenderError, match="0 < low < high"):
        factor_scale(0.0, 1.0)
