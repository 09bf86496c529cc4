"""The order of assembly: a backbone of medium length, then always what crosses most of what is there."""

from __future__ import annotations

import numpy as np
import pytest
from laidflat import NAMES, UP, crossing, document, flat, patterns, ribbon

from geoweave.fabrication.assembly_order import BACKBONE, MEDIUM, assembly
from geoweave.fabrication.flattening import pattern_of
from geoweave.fabrication.pattern import Pattern


def meets(pattern: Pattern, one: int, others: set[int]) -> int:
    return sum(each.partner in others and each.partner != one for each in pattern.passages[one])


@pytest.mark.parametrize("name", NAMES)
def test_every_strip_comes_once_and_brings_its_crossings(name: str) -> None:
    pattern = patterns()[name]
    steps = assembly(pattern)
    assert sorted(step.strip for step in steps) == list(range(len(pattern.strips)))
    seen = [x for step in steps for x in step.crossings]
    assert sorted(seen) == list(range(len(pattern.ribbons)))
    there: set[int] = set()
    for step in steps:
        there.add(step.strip)
        for x in step.crossings:
            assert set(pattern.ribbons[x].tolist()) <= there
            assert step.strip in pattern.ribbons[x]


@pytest.mark.parametrize("name", ["flat", "cone"])
def test_each_crosses_as_much_as_any_could(name: str) -> None:
    pattern = patterns()[name]
    steps = assembly(pattern)
    lengths = np.array([strip.length for strip in pattern.strips])
    rank = np.argsort(np.argsort(lengths, kind="stable"), kind="stable")
    low, high = (round(share * len(lengths)) for share in MEDIUM)
    there: set[int] = set()
    for step in steps:
        free = set(range(len(lengths))) - there
        if step.backbone:
            assert low <= rank[step.strip] < high
            free = {r for r in free if low <= rank[r] < high}
        if there:
            most = max(meets(pattern, r, there) for r in free)
            assert meets(pattern, step.strip, there) == most > 0
        there.add(step.strip)
    backbone = [step.backbone for step in steps]
    assert backbone == sorted(backbone, reverse=True)
    assert sum(backbone) == max(3, -int(-BACKBONE * len(lengths) // 1))


def test_the_backbone_is_neither_the_longest_nor_the_shortest() -> None:
    content = flat()
    longest = content["ribbons"][0]
    longest["points"][0][0] -= 400.0
    longest["length"] += 400.0
    for each in content["crossings"]:
        for side in (0, 1):
            if each["ribbons"][side] == 0:
                each["arclength"][side] += 400.0
    steps = assembly(pattern_of(content))
    assert 0 not in {step.strip for step in steps if step.backbone}


def test_pieces_that_do_not_touch_follow_each_other() -> None:
    lines = [
        ribbon(f"A{k}", 0, [(0, 40.0 * k + 20 * t, 0), (100 + k, 40.0 * k + 20 * t + way, 0)], UP)
        for k in range(2)
        for t, way in ((0, 20), (1, -20))
    ]
    content = document(lines, [crossing(0, 1, (51, 51), 0), crossing(2, 3, (51, 51), 1)])
    steps = assembly(pattern_of(content))
    assert [len(step.crossings) for step in steps] == [0, 1, 0, 1]
    assert {steps[0].strip, steps[1].strip} in ({0, 1}, {2, 3})
