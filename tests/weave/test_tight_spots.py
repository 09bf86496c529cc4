"""Where ribbons get in each other's way is told once, with its place."""

from __future__ import annotations

import numpy as np
import pytest
from laidlines import SPACING, laid, of_kind, triaxial

from geoweave.weave.inspection import inspected


def test_where_three_ribbons_cross_in_a_point_each_triangle_is_one_place() -> None:
    shift = 0.1  # triangles whose incircle is a fifth of those above
    found = inspected(laid(triaxial(shift), width=0.3 * SPACING))
    crowded = of_kind(found, "crowded")
    assert len(crowded) == len({(place.ribbons, place.point) for place in crowded}) > 20
    assert all(len(set(place.ribbons)) == 3 for place in crowded)
    assert found.share_that_fits < 1.0
    values = np.array([place.value for place in crowded])
    assert (np.diff(values) >= 0).all()
    smaller = inspected(laid(triaxial(shift), width=0.99 * values[0]))
    assert not of_kind(smaller, "crowded")


def test_a_small_angle_is_told_once_with_its_place_in_the_unit_of_the_output() -> None:
    found = inspected(laid([(0, 0.013, 0.02), (5, 0.013, 0.02), (90, 0.4, 0.1), (90, -0.4, 0.1)], unit=100.0))
    (place,) = of_kind(found, "near_parallel")
    assert place.value == pytest.approx(5.0)
    assert place.point == pytest.approx((1.3, 2.0, 0.0), abs=1e-6)
    assert place.ribbons == ("A1", "A2")
    assert not of_kind(found, "alongside")


def test_ribbons_on_top_of_each_other_are_told_with_the_length_of_the_stretch() -> None:
    lines = [(0, 0.0, 0.02), (0, 0.0, 0.03), (0, 0.0, 0.2), (90, 0.31, 0.0), (90, -0.31, 0.0)]
    found = inspected(laid(lines, width=0.03))
    (place,) = of_kind(found, "alongside")
    assert place.value == pytest.approx(2.0, abs=0.02)
    assert place.ribbons == ("A1", "A2")
    assert place.point[1] == pytest.approx(0.025)
    assert not of_kind(inspected(laid(lines, width=0.009)), "alongside")


def test_ends_that_go_on_in_each_other_are_told_apart() -> None:
    lines = [(0, -0.56, 0.02), (0, 0.56, 0.022), (90, 0.31, 0.0), (90, -0.31, 0.0)]
    found = inspected(laid(lines, width=0.04, length=0.6))
    (place,) = of_kind(found, "lap")
    assert place.value == pytest.approx(0.08, abs=0.03)
    assert place.point == pytest.approx((0.0, 0.021, 0.0), abs=0.05)
    assert place.ribbons == ("A1", "A2")
    assert not of_kind(found, "alongside")


def test_short_ribbons_that_cross_each_other_are_a_knot() -> None:
    middle = [(0.0, 0.1, 0.5), (60.0, 0.1, 0.5), (120.0, 0.15, 0.45)]
    found = inspected(laid([*middle, (0.0, -0.5, -0.5), (90.0, -0.5, -0.5)], length=0.45))
    (knot,) = [each for each in found.places if each.kind == "knot"]
    assert knot.value == 3  # the two lines below cross each other too, but two are no knot
    assert len(set(knot.ribbons)) == 3
    assert np.linalg.norm(np.array(knot.point) - [0.12, 0.48, 0]) < 0.1
    assert not inspected(laid(middle, length=0.65)).counts["knot"], "1.3 is more than six spacings"
