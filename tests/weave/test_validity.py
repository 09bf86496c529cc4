"""A valid weave breaks no rule, and each rule is broken by one change."""

from __future__ import annotations

from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest

from geoweave.curves.curve_crossings import Crossings
from geoweave.curves.curves import Curves
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh
from geoweave.weave.design import Weave, weave_pattern
from geoweave.weave.ribbons import Cutting, Ribbons
from geoweave.weave.validity import violations
from geoweave.wording import counted


@cache
def pattern() -> Weave:
    return weave_pattern(shapes.square(faces=2000))


def changed(ribbons: Ribbons, pick: np.ndarray, **values: np.ndarray) -> Ribbons:
    """Ribbons with some of their crossings, and some of these crossings' values others."""
    met = ribbons.crossings
    parts = {name: np.array(getattr(met, name)[pick]) for name in (each.name for each in fields(met))}
    return replace(ribbons, crossings=Crossings(**(parts | values)))


def everything(ribbons: Ribbons) -> np.ndarray:
    return np.arange(len(ribbons.crossings))


def test_a_weave_as_it_is_made_breaks_no_rule() -> None:
    weave = pattern()
    assert len(weave.ribbons.crossings) > 50
    assert violations(weave.ribbons, weave.interlacing.over) == []


def test_a_crossing_taken_away_is_missed() -> None:
    ribbons = pattern().ribbons
    (sentence,) = violations(changed(ribbons, everything(ribbons)[np.arange(len(ribbons.crossings)) != 20]))
    assert sentence.startswith("1 place is not listed though ribbons cross there")


@pytest.mark.parametrize(("apart", "missed"), [(0.05, 0), (0.3, 2)])
def test_ribbons_that_cross_back_within_a_tail_touch(apart: float, missed: int) -> None:
    """A line in one face, and another that passes over it and back; no crossing is listed."""
    mesh = TriMesh(np.array([[0.0, 0, 0], [10, 0, 0], [0, 10, 0]]), np.array([[0, 1, 2]]))
    line = [[1.0, 1, 0], [5, 1, 0]]
    hook = [[2.0, 0.5, 0], [2, 2, 0], [2 + apart, 2, 0], [2 + apart, 0.5, 0]]
    points = np.array(line + hook)
    count = len(points)
    curves = Curves(
        mesh,
        points,
        np.zeros(count, dtype=np.int64),
        np.zeros(count),
        np.zeros(count, dtype=bool),
        np.array([0, 2, 6]),
        np.zeros(2, dtype=bool),
    )
    nothing = np.zeros((0, 2))
    none = Crossings(
        nothing.astype(np.int64),
        nothing.astype(np.int64),
        nothing,
        np.zeros((0, 3)),
        np.zeros(0, dtype=np.int64),
        np.zeros(0),
    )
    found = violations(Ribbons(curves, none, np.arange(2), 1.0, Cutting(tail=0.1)))
    unlisted = [sentence for sentence in found if "not listed" in sentence]
    said = f"{counted(missed, 'place', 'is are')} not listed though ribbons cross there"
    sentence = f"{said}, first number 0 at (2, 1, 0)"
    assert unlisted == [sentence] * bool(missed)


def test_an_end_without_its_last_crossing_hangs_loose() -> None:
    """Of a ribbon that ends off the boundary, the outermost crossing goes."""
    ribbons = weave_with_open_ends()
    curves, met = ribbons.curves, ribbons.crossings
    tail = ribbons.cutting.tail * ribbons.spacing
    near = met.arclength.min(axis=1) <= tail * (1 + 1e-9)
    first = int(np.flatnonzero(near & ~curves.closed[met.curves].any(axis=1))[0])
    found = violations(changed(ribbons, np.delete(everything(ribbons), first)))
    assert any("loose" in sentence for sentence in found)


@cache
def weave_with_open_ends() -> Ribbons:
    return weave_pattern(shapes.sphere(faces=2000)).ribbons


def test_crossings_off_their_ribbons_are_found() -> None:
    ribbons = pattern().ribbons
    met, pick = ribbons.crossings, everything(pattern().ribbons)
    points = np.array(met.points)
    points[7] += 0.01
    (away, missed) = violations(changed(ribbons, pick, points=points))
    assert away.startswith("1 crossing is not where their ribbons are, first number 7 at (")
    assert "not listed" in missed
    arclength = np.array(met.arclength)
    arclength[3, 1] = 1000.0
    assert "beyond the end" in violations(changed(ribbons, pick, arclength=arclength))[0]
    curves = np.array(met.curves)
    curves[3, 1] = len(ribbons)
    assert "not there" in violations(changed(ribbons, pick, curves=curves))[0]


def test_a_crossing_listed_twice_is_found_also_the_other_way_round() -> None:
    ribbons = pattern().ribbons
    twice = np.append(everything(ribbons), 5)
    other = changed(ribbons, twice)
    assert "listed twice" in violations(other)[0]
    met = other.crossings
    curves, arclength = np.array(met.curves), np.array(met.arclength)
    curves[-1], arclength[-1] = curves[-1, ::-1].copy(), arclength[-1, ::-1].copy()
    turned = changed(ribbons, twice, curves=curves, arclength=arclength)
    assert "listed twice" in violations(turned)[0]


def test_ribbons_with_few_crossings_or_none_are_found() -> None:
    ribbons = pattern().ribbons
    number = np.bincount(ribbons.crossings.curves.ravel(), minlength=len(ribbons))
    middle = int(np.median(number)) + 1
    (sentence,) = violations(replace(ribbons, cutting=replace(ribbons.cutting, fewest=middle)))
    count = int((number < middle).sum())
    assert count >= len(ribbons) // 2
    assert sentence.startswith(f"{count} ribbons have fewer than {middle} crossings")
    alone = changed(ribbons, (ribbons.crossings.curves != 2).all(axis=1))
    assert any("1 ribbon crosses nothing, first number 2" in sentence for sentence in violations(alone))


@pytest.mark.parametrize("wrong", [2, -1])
def test_a_crossing_without_a_ribbon_over_is_found(wrong: int) -> None:
    weave = pattern()
    over = np.array(weave.interlacing.over)
    over[4] = wrong
    (sentence,) = violations(weave.ribbons, over)
    assert sentence.startswith("1 crossing has no ribbon over, first number 4")
    assert "do not fit" in violations(weave.ribbons, over[1:])[0]
