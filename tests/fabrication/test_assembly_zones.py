"""Consecutive steps are near each other, zones are runs of them, and what a report says is measured."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from laidflat import bow_tie, circles, cone, crossing, document, flat, ribbon

from geoweave.errors import FieldError
from geoweave.fabrication.assembly_order import LATEST, assembly
from geoweave.fabrication.assembly_zones import (
    _runs,
    assembly_numbers,
    crossing_places,
    work_places,
    zoned_assembly,
)
from geoweave.fabrication.flattening import pattern_of


def rings(count: int = 10, lines: int = 8) -> dict[str, object]:
    """A tube 300 mm long: closed rings and lines along it, over and under by turns."""
    radius, angles = 40.0, 2 * np.pi * np.arange(120) / 120
    out = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(120)])
    heights = np.linspace(15.0, 285.0, count)
    made = [ribbon(f"A{k + 1}", 0, radius * out + (0, 0, z), out, closed=True) for k, z in enumerate(heights)]
    for k in range(lines):
        way = out[120 // lines * k]
        made.append(ribbon(f"B{k + 1}", 1, [radius * way, radius * way + (0, 0, 300.0)], way))
    met = [
        crossing(r, count + k, (made[0]["length"] * k / lines, float(z)), (r + k) % 2)
        for r, z in enumerate(heights)
        for k in range(lines)
    ]
    return document(made, met)


def test_crossings_are_where_the_weave_has_them() -> None:
    woven = cone().document()
    known = np.array([each["point"] for each in woven["crossings"]])
    assert np.abs(crossing_places(woven) - known).max() < 0.05 * woven["width"]
    np.testing.assert_allclose(crossing_places(circles())[0], (0, 0, 60.0), atol=0.1)
    np.testing.assert_allclose(crossing_places(bow_tie()), 0.0, atol=1e-9)


@pytest.mark.parametrize("each", [8, 16])
def test_consecutive_strips_are_near_each_other(each: int) -> None:
    """Far nearer than in the order that takes what crosses most, and with the same backbone."""
    woven = flat(each, spacing=18.0, reach=150.0)
    pattern = pattern_of(woven)
    near, most = zoned_assembly(pattern, woven), assembly(pattern)
    assert sorted(step.strip for step in near) == list(range(len(pattern.strips)))
    assert sorted(x for step in near for x in step.crossings) == list(range(len(pattern.at)))
    far = [assembly_numbers(pattern, order, woven)["mean_step"] for order in (near, most)]
    assert far[0] < 0.6 * far[1]
    assert far[0] < 40.0
    assert sum(step.backbone for step in near) == sum(step.backbone for step in most)
    # Nothing dangles: after the first cross each strip is held at two places or more.
    assert all(len(step.crossings) >= 2 for step in near[2:])


def test_closed_strips_come_while_they_can_be_slipped_in() -> None:
    woven = rings()
    pattern = pattern_of(woven)
    steps = zoned_assembly(pattern, woven)
    there: set[int] = set()
    for step in steps:
        strip = pattern.strips[step.strip]
        if there and not strip.closed and not step.backbone:
            for r, other in enumerate(pattern.strips):
                if r in there or not other.closed:
                    continue
                held = sum(each.partner in there for each in pattern.passages[r])
                assert held < LATEST * len(pattern.passages[r])
        there.add(step.strip)
    numbers = assembly_numbers(pattern, steps, woven)
    assert numbers["closed"] == 10
    assert numbers["closed_threaded"] == 0


def test_what_is_threaded_late_is_counted() -> None:
    woven = rings()
    pattern = pattern_of(woven)
    last = [*range(10, 18), *range(10)]
    there: set[int] = set()
    steps = []
    for strip in last:
        there.add(strip)
        held = tuple(each.crossing for each in pattern.passages[strip] if each.partner in there)
        steps.append(assembly(pattern)[0]._replace(strip=strip, crossings=held))
    assert assembly_numbers(pattern, steps, woven)["closed_threaded"] == 10


def test_the_distance_is_that_between_the_means_of_the_crossings() -> None:
    woven = flat()
    pattern, places = pattern_of(woven), crossing_places(woven)
    steps = zoned_assembly(pattern, woven)
    means = [places[list(step.crossings)].mean(axis=0) for step in steps if step.crossings]
    far = [float(np.linalg.norm(b - a)) for a, b in itertools.pairwise(means)]
    numbers = assembly_numbers(pattern, steps, woven)
    assert numbers["mean_step"] == pytest.approx(np.mean(far), abs=0.01)
    assert numbers["longest_step"] == pytest.approx(max(far), abs=0.01)
    np.testing.assert_allclose(work_places(steps, places)[0], means[0])


def test_runs_have_the_least_sum_of_squares() -> None:
    """All ways to part nine places into three runs, tried one by one."""
    points = np.random.default_rng(3).normal(size=(9, 3))

    def spread(zones: list[int]) -> float:
        here = np.array(zones)
        return sum(((points[here == z] - points[here == z].mean(axis=0)) ** 2).sum() for z in set(zones))

    found = _runs(points, 3)
    others = [[0] * a + [1] * (b - a) + [2] * (9 - b) for a in range(1, 8) for b in range(a + 1, 9)]
    assert spread(found) == pytest.approx(min(map(spread, others)))
    assert _runs(points, 1) == [0] * 9


def test_another_weave_is_refused() -> None:
    pattern = pattern_of(flat())
    with pytest.raises(FieldError, match="other ribbons than the pattern"):
        zoned_assembly(pattern, circles())
    fewer = flat()
    fewer["crossings"].pop()
    with pytest.raises(FieldError, match="other crossings than the pattern"):
        zoned_assembly(pattern, fewer)
