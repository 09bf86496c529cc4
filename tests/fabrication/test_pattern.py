"""A pattern says what the weave says: lengths, places, angles, over and under, and no place in space."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from laidflat import NAMES, UP, bow_tie, circles, cone, flat, patterns

from geoweave.errors import FieldError
from geoweave.fabrication.marks import MARKS
from geoweave.fabrication.pattern import Pattern, bow_and_turning, pattern_of


@pytest.mark.parametrize("name", NAMES)
def test_every_crossing_is_on_two_strips_that_agree(name: str) -> None:
    pattern = patterns()[name]
    seen = {}
    for r, passages in enumerate(pattern.passages):
        assert [each.at for each in passages] == sorted(each.at for each in passages)
        for each in passages:
            seen.setdefault(each.crossing, []).append((r, each))
    assert sorted(seen) == list(range(len(pattern.ribbons)))
    for both in seen.values():
        (r, one), (q, other) = both
        assert (one.partner, other.partner) == (q, r)
        assert one.over != other.over
        assert one.mark == other.mark
        assert one.label.split("/")[1:] == other.label.split("/")[1:]
        assert one.angle == pytest.approx(-other.angle) or one.angle == other.angle == 180


@pytest.mark.parametrize("name", NAMES)
def test_label_and_mark_name_one_crossing_of_a_strip(name: str) -> None:
    pattern = patterns()[name]
    for passages in pattern.passages:
        keys = [(each.label, each.mark, each.crossing) for each in passages]
        assert len({key[:2] for key in keys}) == len(set(keys))


def test_pairs_that_cross_often_count_their_rounds() -> None:
    pattern = patterns()["often"]
    assert pattern.round.max() == 19 // len(MARKS) == 2
    assert {each.label for each in pattern.passages[0]} == {"B1", "B1/2", "B1/3"}


def test_lines_in_the_plane_cross_at_sixty_degrees() -> None:
    pattern = patterns()["flat"]
    families = np.array([strip.family for strip in pattern.strips])[pattern.ribbons]
    np.testing.assert_allclose(pattern.angle, 60.0 * (families[:, 1] - families[:, 0]))
    assert all(strip.bow < 1e-9 and strip.turning < 1e-9 for strip in pattern.strips)
    assert [strip.length for strip in pattern.strips] == pytest.approx([150.0] * 12)


def test_great_circles_are_straight_and_cross_at_right_angles() -> None:
    pattern = patterns()["circles"]
    around = pattern.strips[0].length
    assert around == pytest.approx(2 * np.pi * 60, rel=2e-4)
    # A chord of the circle stands for an arc of 3 degrees, and the angle is measured on the chord.
    np.testing.assert_allclose(np.abs(pattern.angle), 90.0, atol=0.05)
    assert sorted(np.sign(pattern.angle[pattern.ribbons[:, 0] == 0])) == [-1, 1]
    assert all(strip.closed and strip.bow < 1e-9 for strip in pattern.strips)


def test_a_ribbon_may_cross_itself() -> None:
    pattern = patterns()["bow tie"]
    one, other = pattern.passages[0]
    assert (one.partner, other.partner, one.label) == (0, 0, "A1")
    assert (one.over, other.over) == (False, True)
    assert (one.angle, other.angle) == pytest.approx((90.0, -90.0))
    assert pattern.strips[0].turning == pytest.approx(270.0)


def test_bow_of_an_arc_in_the_plane() -> None:
    radius, angle = 500.0, np.radians(np.linspace(0, 20, 401))
    points = radius * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    bow, turning = bow_and_turning(points, np.broadcast_to(UP, points.shape), False)
    assert bow == pytest.approx(radius * (1 - np.cos(np.radians(10))), rel=1e-4)
    assert turning == pytest.approx(20, rel=5e-3)


def test_bow_of_a_circle_of_latitude_is_that_of_the_cone_that_touches_it() -> None:
    """Laid flat, a parallel at the latitude b of the unit sphere is an arc of radius cot b."""
    latitude, angle = np.radians(50), np.radians(np.linspace(0, 40, 2001))
    middle = angle + 0.5 * (angle[1] - angle[0])
    ring = [np.cos(latitude) * np.cos(angle), np.cos(latitude) * np.sin(angle), 0 * angle + np.sin(latitude)]
    up = [np.cos(latitude) * np.cos(middle), np.cos(latitude) * np.sin(middle), 0 * angle + np.sin(latitude)]
    bow, turning = bow_and_turning(np.stack(ring, axis=1), np.stack(up, axis=1), False)
    swept = np.radians(40) * np.sin(latitude)
    assert turning == pytest.approx(np.degrees(swept), rel=2e-3)
    assert bow == pytest.approx((1 - np.cos(swept / 2)) / np.tan(latitude), rel=2e-3)


def test_a_solved_weave_keeps_its_lengths_angles_and_turning() -> None:
    weave, pattern = cone(), patterns()["cone"]
    curves, met, unit = weave.ribbons.curves, weave.ribbons.crossings, weave.placement.scale
    np.testing.assert_allclose([strip.length for strip in pattern.strips], curves.lengths * unit)
    np.testing.assert_allclose(pattern.at, met.arclength * unit)
    np.testing.assert_allclose(pattern.angle, np.degrees(met.angle), atol=1e-4)
    np.testing.assert_array_equal(pattern.over, weave.interlacing.over)
    for r, strip in enumerate(pattern.strips):
        own = slice(curves.offsets[r], curves.offsets[r + 1])
        heading = np.concatenate([[0.0], np.cumsum(curves.turning[own][1:-1])])
        assert strip.turning == pytest.approx(np.degrees(np.ptp(heading)), abs=0.02)


@pytest.mark.parametrize("name", NAMES)
def test_what_is_written_is_read(name: str) -> None:
    pattern = patterns()[name]
    text = json.dumps(pattern.document(), allow_nan=False)
    again = Pattern.from_document(json.loads(text))
    assert json.dumps(again.document()) == text
    np.testing.assert_allclose(again.at, pattern.at, atol=6e-5)


def test_the_file_knows_no_place_in_space() -> None:
    text = json.dumps(patterns()["flat"].document())
    for word in ("point", "normal", "vertices"):
        assert word not in text


def test_refusals() -> None:
    with pytest.raises(FieldError, match="lengths in mm"):
        pattern_of({**flat(), "units": "mesh"})
    with pytest.raises(FieldError, match=r"other\.json: is not a geoweave-weave"):
        pattern_of({"format": "geoweave-report"}, "other.json")
    with pytest.raises(FieldError, match="missing or wrong"):
        pattern_of({**flat(), "ribbons": [{}]})
    broken = circles()
    broken["crossings"][0]["arclength"][0] = 1e4
    with pytest.raises(FieldError, match="crossing 0 is 10000 mm along A1"):
        pattern_of(broken)
    with pytest.raises(FieldError, match="is not a geoweave-pattern"):
        Pattern.from_document({})
    document = patterns()["flat"].document()
    del document["crossings"][0]["mark"]
    with pytest.raises(FieldError, match="missing or wrong"):
        Pattern.from_document(document)
    pattern = patterns()["often"]
    with pytest.raises(FieldError, match="same mark"):
        replace(pattern, mark=np.zeros_like(pattern.mark))
    with pytest.raises(FieldError, match="width of the strips"):
        pattern_of({**bow_tie(), "width": 0.0})
