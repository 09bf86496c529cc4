"""A pattern says what the weave says: lengths, places, angles, over and under, and no place in space."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from laidflat import NAMES, bow_tie, circles, patterns

from geoweave.errors import FieldError
from geoweave.fabrication.flattening import pattern_of
from geoweave.fabrication.marks import MARKS
from geoweave.fabrication.pattern import Pattern


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


def test_a_ribbon_may_cross_itself() -> None:
    pattern = patterns()["bow tie"]
    one, other = pattern.passages[0]
    assert (one.partner, other.partner, one.label) == (0, 0, "A1")
    assert (one.over, other.over) == (False, True)
    assert (one.angle, other.angle) == pytest.approx((90.0, -90.0))
    assert pattern.strips[0].turning == pytest.approx(270.0)


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
