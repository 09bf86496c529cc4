"""Ribbons that slid past each other are found, on open and on closed ribbons, and nothing else is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from laidflat import UP, circles, crossing, document, flat, ribbon

from geoweave.errors import FieldError
from geoweave.fabrication.crossing_order import order_sentence, reordered_crossings
from geoweave.fabrication.flattening import pattern_of
from geoweave.fabrication.maker_files import write
from geoweave.fabrication.strip_layout import layout


def at_rest(content: dict[str, Any], moved: dict[int, tuple[float, float]]) -> dict[str, Any]:
    """The document of a weave at rest whose crossings moved along their ribbons, by their numbers."""
    lengths = [each["length"] for each in content["ribbons"]]
    closed = [each["closed"] for each in content["ribbons"]]
    crossings = []
    for x, each in enumerate(content["crossings"]):
        there = [s + d for s, d in zip(each["arclength"], moved.get(x, (0.0, 0.0)), strict=True)]
        there = [s % lengths[r] if closed[r] else s for r, s in zip(each["ribbons"], there, strict=True)]
        crossings.append({**each, "designed": each["arclength"], "arclength": there})
    return {**content, "crossings": crossings}


def three() -> dict[str, Any]:
    """One line along x that meets three others at 20, 50 and 80."""
    lines = [ribbon("A1", 0, [(0, 0, 0), (100, 0, 0)], UP)]
    lines += [ribbon(f"B{k}", 1, [(x, -50, 0), (x, 50, 0)], UP) for k, x in ((1, 20), (2, 50), (3, 80))]
    return document(lines, [crossing(0, k, (30.0 * k - 10.0, 50.0), k % 2) for k in (1, 2, 3)])


@pytest.mark.parametrize("content", [flat(), circles(), three()], ids=["flat", "circles", "three"])
def test_a_design_and_a_weave_that_kept_its_order_have_nothing_to_say(content: dict[str, Any]) -> None:
    assert reordered_crossings(content) == ()
    assert reordered_crossings(at_rest(content, {})) == ()
    # Everything slides the same way, also over the start of a closed ribbon.
    moved = dict.fromkeys(range(len(content["crossings"])), (5.0, 5.0))
    assert reordered_crossings(at_rest(content, moved)) == ()


def test_two_neighbours_that_changed_places_are_named() -> None:
    (found,) = reordered_crossings(at_rest(three(), {0: (40.0, 0.0)}))
    assert (found.ribbon, found.first, found.second) == ("A1", "B1", "B2")
    assert found.back == pytest.approx(10.0)
    said = order_sentence((found,))
    assert "at one place" in said
    assert "on A1 the one with B2 now comes 10 mm before the one with B1" in said


def test_one_that_slid_past_two_others_is_found_by_its_next_neighbour() -> None:
    found = reordered_crossings(at_rest(three(), {0: (70.0, 0.0)}))
    assert [(each.first, each.second) for each in found] == [("B1", "B2")]
    assert found[0].back == pytest.approx(40.0)


@pytest.mark.parametrize("slid", [-1.0, 1.0])
def test_on_a_closed_ribbon_the_start_is_no_end(slid: float) -> None:
    content = circles()
    quarter = content["ribbons"][0]["length"] / 4
    # The first crossing of A1 moves on to its next one on A1, and a little past it.
    first = dict.fromkeys(range(6), (0.0, 0.0))
    assert content["crossings"][0]["ribbons"] == [0, 1]
    first[0] = (slid * 1.1 * quarter, 0.0)
    found = reordered_crossings(at_rest(content, first))
    assert [each.ribbon for each in found] == ["A1"]
    assert found[0].back == pytest.approx(0.1 * quarter)
    first[0] = (slid * 0.9 * quarter, 0.0)
    assert reordered_crossings(at_rest(content, first)) == ()


def test_strips_in_another_order_are_not_written(tmp_path: Path) -> None:
    slipped = at_rest(three(), {0: (40.0, 0.0)})
    pattern = pattern_of(slipped)
    assert len(pattern.reordered) == 1
    words = "those of another weave: at one place crossings stand in another order"
    with pytest.raises(FieldError, match=words):
        layout(slipped).save(tmp_path / "a.svg")
    for kind in ("svg", "pdf", "pattern", "csv"):
        with pytest.raises(FieldError, match=words):
            write(pattern, tmp_path / "new", [kind])
    assert list(tmp_path.iterdir()) == []
    layout(at_rest(three(), {0: (20.0, 0.0)})).save(tmp_path / "a.svg")
    assert (tmp_path / "a.svg").is_file()
