"""Ends grow until they run into something, and then they are held."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import lines_on_square

from geoweave.curves.curve_crossings import crossings
from geoweave.curves.curves import Curves
from geoweave.curves.stretch import stretches
from geoweave.models import shapes
from geoweave.weave.growing_ends import Growth, lengthened
from geoweave.weave.ribbon_ends import extended, holding, loose_ends

TAIL = 0.02


def growth(lines: Curves, reach: float = 0.5) -> Growth:
    longer, spans = extended(lines, reach)
    return Growth.of(longer, spans, crossings(longer), 40.0)


def tips(given: Growth, kept: np.ndarray | None = None) -> np.ndarray:
    """(n, 4) first and last point of each grown curve."""
    all_of_them = np.ones(len(given.longer), dtype=bool) if kept is None else kept
    start, end = given.grown(all_of_them, TAIL)
    which = np.flatnonzero(all_of_them & (end > start))
    grown = stretches(given.longer, which, start[which], end[which])
    return np.hstack([grown.points[grown.offsets[:-1], :2], grown.points[grown.offsets[1:] - 1, :2]])


RAIL = [(x, -0.95, x, 0.95) for x in (-0.8, -0.7)]
"""What holds the left ends of horizontal lines, from end to end of the square."""


def test_two_ends_that_meet_hold_each_other() -> None:
    """One comes a fifth to the right, the other a tenth down; both end where they meet."""
    floor = [(-0.95, y, 0.95, y) for y in (-0.8, -0.7)]
    found = tips(growth(lines_on_square((-0.85, 0.0, 0.0, 0.0), (0.2, -0.85, 0.2, -0.1), *RAIL, *floor)))
    np.testing.assert_allclose(found[0, 2:], [0.2 + TAIL, 0], atol=1e-9)
    np.testing.assert_allclose(found[1, 2:], [0.2, TAIL], atol=1e-9)


def test_an_end_goes_on_as_far_as_another_needs_it() -> None:
    """The third line stops at the extension of the first, beyond where the second one comes to it."""
    floor = [(-0.95, y, 0.95, y) for y in (-0.8, -0.7)]
    wall = (0.31, -0.2, 0.31, 0.2)
    early = (0.25, -0.85, 0.25, -0.27)
    later = (0.1, -0.85, 0.1, -0.28)
    found = tips(growth(lines_on_square((-0.85, 0.0, 0.0, 0.0), early, later, *RAIL, *floor, wall)))
    # the first is stopped by the wall; the others come late, so it goes back to the last that holds to it
    np.testing.assert_allclose(found[0, 2:], [0.25 + TAIL, 0], atol=1e-9)
    np.testing.assert_allclose(found[1, 2:], [0.25, TAIL], atol=1e-9)
    np.testing.assert_allclose(found[2, 2:], [0.1, TAIL], atol=1e-9)


@pytest.mark.parametrize("rounding", [-1e-13, 0.0, 1e-13])
def test_rounding_does_not_decide_whether_an_end_touches_a_line(rounding: float) -> None:
    """It ends on the first line; what touches a line goes on to the next one, like what crosses it."""
    lines = lines_on_square((-0.85, 0.0, 0.0, 0.0), (0.0, -0.5, 0.0, 0.5), (0.3, -0.5, 0.3, 0.5), *RAIL)
    longer, spans = extended(lines, 0.5)
    met = crossings(longer)
    spans[0, 1] += rounding
    _, end = Growth.of(longer, spans, met, 40.0).grown(np.ones(len(longer), dtype=bool), TAIL)
    assert end[0] == pytest.approx(1.3 + TAIL, abs=1e-9)


def test_an_end_that_meets_nothing_goes_back_to_its_last_crossing() -> None:
    found = tips(growth(lines_on_square((-0.85, 0.0, 0.0, 0.0), *RAIL), reach=0.3))
    np.testing.assert_allclose(found[0], [-1.0, 0, -0.7 + TAIL, 0], atol=1e-9)


def test_a_shallow_crossing_stops_an_end_and_does_not_hold_it() -> None:
    """At 20 degrees nothing holds, and a tail stops half way to such a crossing."""
    slope = np.tan(np.radians(20.0))
    flat = (-0.2, -0.4 * slope, 0.5, 0.3 * slope)  # crosses y = 0 at x = 0.2
    wall = (0.4, -0.5, 0.4, 0.5)
    cross = (0.188, -0.5, 0.188, 0.5)
    lines = lines_on_square((-0.85, 0.0, 0.0, 0.0), flat, wall, *RAIL)
    np.testing.assert_allclose(tips(growth(lines))[0, 2:], [-0.7 + TAIL, 0], atol=1e-9)
    lines = lines_on_square((-0.85, 0.0, 0.0, 0.0), flat, wall, cross, *RAIL)
    np.testing.assert_allclose(tips(growth(lines))[0, 2:], [0.194, 0], atol=1e-9)


def test_an_end_on_the_boundary_stays_there() -> None:
    found = tips(growth(lines_on_square((-0.75, 0.0, 0.8, 0.0), *RAIL)))
    np.testing.assert_allclose(found[0], [-0.8 - TAIL, 0, 1.0, 0], atol=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_whichever_curves_are_kept_every_end_is_held(seed: int) -> None:
    rng = np.random.default_rng(seed)
    middle, way = rng.uniform(-0.6, 0.6, (40, 2)), rng.normal(size=(40, 2))
    half = 0.15 * way / np.linalg.norm(way, axis=1, keepdims=True)
    given = growth(
        lines_on_square(*np.hstack([middle - half, middle + half]), mesh=shapes.square(faces=2000))
    )
    for share in (1.0, 0.7, 0.4):
        start, end = given.grown(rng.uniform(size=40) < share, TAIL)
        which = np.flatnonzero(end > start)
        assert len(which) > 2
        grown = stretches(given.longer, which, start[which], end[which])
        met = crossings(grown)
        assert not loose_ends(grown, met.taken(holding(met, 40.0)), TAIL).any()


def test_the_nearest_end_joins_two_parts() -> None:
    """Of the two lines of the left part, one has 0.2 to go to the right part and one 0.3."""
    left = [(-0.5, 0.0, 0.0, 0.0), (-0.5, 0.1, -0.1, 0.1), (-0.4, -0.2, -0.4, 0.2)]
    lines = lines_on_square(*left, (0.2, -0.3, 0.2, 0.3))
    one = np.array([True, True, True, False])
    joined = lengthened(lines, one, 0.5, TAIL, 40.0)
    assert joined is not None
    assert joined.lengths - lines.lengths == pytest.approx([0.2 + TAIL, 0, 0, 0])
    assert lengthened(lines, one, 0.1, TAIL, 40.0) is None
    # a shallow crossing on the way is in the way of both
    slope = np.tan(np.radians(20.0))
    fence = lines_on_square(*left, (0.2, -0.3, 0.2, 0.3), (-0.05, -0.15 * slope, 0.6, 0.5 * slope))
    assert lengthened(fence, np.append(one, True), 0.25, TAIL, 40.0) is None


def test_a_tail_stops_half_way_to_a_crossing_that_holds_nothing() -> None:
    """Two upright lines a hundredth apart: the end stops at the first and does not cross the second."""
    lines = lines_on_square((-0.85, 0.0, 0.0, 0.0), (0.2, -0.5, 0.2, 0.5), (0.21, -0.5, 0.21, 0.5), *RAIL)
    np.testing.assert_allclose(tips(growth(lines))[0, 2:], [0.205, 0], atol=1e-9)
