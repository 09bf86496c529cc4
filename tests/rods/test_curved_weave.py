from functools import cache

import numpy as np
import pytest

from geoweave.errors import RodError
from geoweave.models import shapes
from geoweave.rods import curved_weave
from geoweave.rods.curved_weave import STRIPS, curved
from geoweave.rods.holding_at_rest import HoldingAtRest
from geoweave.rods.slid_weave import elastic_rods, slide
from geoweave.rods.slide_and_relax import Springs
from geoweave.rods.strip_fitting import Fitting, optimal_strips
from geoweave.rods.weave_at_rest import relax
from geoweave.weave.design import weave_pattern


@cache
def slid():
    return slide(elastic_rods(weave_pattern(shapes.torus(faces=1500), ribbons=20)))


@cache
def at_rest(strips):
    return relax(curved(slid(), strips, numbers=Fitting(most_steps=10)))


def test_each_kind_of_strips_lies_nearer_than_the_one_before():
    far = [at_rest(strips).departure.to_surface.mean for strips in STRIPS[:3]]
    assert far[1] < 0.8 * far[0]
    assert far[2] < 0.8 * far[1]


def test_straight_strips_are_those_of_the_paper():
    cut = curved(slid(), "straight").cut
    assert not cut.natural.any()
    np.testing.assert_array_equal(cut.rest, slid().cut.rest)


def test_designed_strips_cost_no_edgewise_energy_on_the_surface():
    cut = curved(slid(), "designed").cut
    np.testing.assert_allclose(cut.natural, cut.geodesic)
    assert at_rest("designed").left.steps[0].energies["geodesic curvature"] < 1e-20


def test_the_report_says_how_strips_are_cut():
    assert "curved_strips" not in at_rest("straight").metrics()
    assert at_rest("designed").metrics()["curved_strips"]["kind"] == "designed"
    said = at_rest("optimal").metrics()["curved_strips"]
    assert said["history"][0]["rms"] > said["history"][-1]["rms"]
    assert said["sharpest"] <= 1.01
    assert "curve" in at_rest("optimal").seconds


def test_an_unknown_kind_is_refused():
    with pytest.raises(RodError, match="straight, designed, optimal"):
        curved(slid(), "bent")


def test_holding_strips_press_as_their_weave_type_makes_them(monkeypatch):
    """Of two weaves that differ in over and under alone, each is judged by its own type."""
    asked = []

    def found(start, surface, *, numbers, pattern, **others):
        asked.append(HoldingAtRest(start, Springs(), numbers.hold, pattern).unit)
        return optimal_strips(start, surface, numbers=Fitting(most_steps=1), pattern=pattern, **others)

    monkeypatch.setattr(curved_weave, "optimal_strips", found)
    for pattern in ("plain", "twill"):
        woven = weave_pattern(shapes.cone(faces=400), ribbons=9, pattern=pattern, symmetry=4)
        curved(slide(elastic_rods(woven), rounds=1), "holding")
    assert asked[0] == pytest.approx(8 * asked[1], rel=0.2)


def test_holding_strips_need_less_friction_and_still_lie_near():
    """Of the two weaves whose strips were fitted, fewer crossings of this one need a fastener."""
    near, holding = at_rest("optimal"), at_rest("holding")
    assert holding.metrics()["curved_strips"]["kind"] == "holding"
    assert np.median(holding.forces.sliding) < 0.6 * np.median(near.forces.sliding)
    assert len(holding.fasten()) < len(near.fasten())
    assert holding.departure.to_surface.mean < at_rest("straight").departure.to_surface.mean
