"""Colours and words of pictures: maps are even and centred, numbers are written as people write them."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import to_rgb

from geoweave.viz import style


def test_numbers_in_captions() -> None:
    shown = {0.0: "0", 1e-8: "10⁻⁸", 2.5e-6: "2.5 · 10⁻⁶", 1e-3: "10⁻³", 0.05: "0.05", 1e3: "1,000"}
    assert {value: style.scientific(value) for value in shown} == shown


def test_maps_are_uniform_and_centred() -> None:
    at = np.linspace(0, 1, 64)
    lab = style._to_oklab(style.sequential()(at)[:, :3])
    assert (np.diff(lab[:, 0]) > 0).all()
    steps = np.linalg.norm(np.diff(lab, axis=0), axis=1)
    # the path turns at its stops, where a chord is a little shorter than the arc
    assert steps.max() < 1.4 * steps.min()
    signed = style.diverging()
    assert np.allclose(signed(0.5)[:3], to_rgb(style.SURFACE), atol=0.02)
    ends = style._to_oklab(np.array([signed(0.0)[:3], signed(1.0)[:3]]))
    assert abs(ends[0, 0] - ends[1, 0]) < 0.03
    assert np.allclose(style._from_oklab(style._to_oklab(signed(at)[:, :3])), signed(at)[:, :3], atol=1e-6)


def test_edges_have_the_hue_of_what_they_belong_to() -> None:
    for colour in style.FAMILIES:
        plain, dark = (
            style._to_oklab(np.array([to_rgb(each)]))[0] for each in (colour, style.darker(colour))
        )
        assert dark[0] < 0.6 * plain[0]
        assert np.allclose(np.arctan2(*dark[1:]), np.arctan2(*plain[1:]), atol=0.1)
