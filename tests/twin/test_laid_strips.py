"""Strips laid as rods: cut to length, contacts where the pattern says, flush at the start."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from twinned import pattern, twin

from geoweave.errors import RodError
from geoweave.twin.laid_strips import cut, laid
from geoweave.twin.pattern_surface import surface_of
from geoweave.twin.placement import net_of, placed


@pytest.mark.parametrize("name", ["cone", "sphere"])
def test_segments_are_equal_and_sum_to_the_strip(name: str) -> None:
    strips, pieces = pattern(name).strips, cut(pattern(name))
    for r, strip in enumerate(strips):
        own = pieces.rest[pieces.layout.segment_offsets[r] : pieces.layout.segment_offsets[r + 1]]
        assert own.sum() == pytest.approx(strip.length)
        np.testing.assert_allclose(own, own[0])
    before = np.cumsum(pieces.rest) - pieces.rest
    along = before - before[pieces.layout.segment_offsets[:-1]][pieces.layout.rod_of_segment]
    at = along[pieces.segments] + pieces.places * pieces.rest[pieces.segments]
    np.testing.assert_allclose(at, pattern(name).at, atol=1e-6)


def test_rods_are_laid_near_their_crossings_with_the_printed_side_out() -> None:
    surface = surface_of(pattern("sphere"))
    points = placed(surface, net_of(surface))[-1]
    start = laid(surface, points)
    rods, pair = start.rods, start.rods.contacts.segments
    middle = rods.points[rods.layout.ends].mean(axis=1)
    outward = (middle * rods.directors).sum(axis=1) / np.linalg.norm(middle, axis=1)
    assert outward.min() > 0.4  # a sphere about the origin
    agree = (rods.directors[pair[:, 0]] * rods.directors[pair[:, 1]]).sum(axis=1)
    assert agree.min() > 0.7
    radius = np.linalg.norm(points - points.mean(axis=0), axis=1).max()
    assert start.unit == pytest.approx(radius)
    assert rods.material.thickness * start.unit == pytest.approx(pattern("sphere").thickness)


def test_strips_that_lie_along_each_other_have_one_contact() -> None:
    sound = pattern("cone")
    again = replace(
        sound,
        ribbons=np.concatenate([sound.ribbons, sound.ribbons[:1]]),
        at=np.concatenate([sound.at, sound.at[:1] + 0.01 * sound.width]),
        angle=np.append(sound.angle, -sound.angle[0]),
        over=np.append(sound.over, 1 - sound.over[0]),
        mark=np.append(sound.mark, (sound.mark[0] + 1) % 8),
        round=np.append(sound.round, 5),
    )
    pieces = cut(again)
    assert pieces.contact[0] == pieces.contact[-1]
    assert len(pieces.stands) == len(sound.ribbons)


def test_too_thick_a_strip_is_refused() -> None:
    thick = replace(pattern("cone"), thickness=2 * pattern("cone").width)
    surface = surface_of(thick)
    with pytest.raises(RodError, match="not as wide as thick"):
        laid(surface, twin("cone").placed)
