"""What is said of strips is measured on them: known answers in the plane, and the design where it is cut."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from laidflat import NAMES, UP, circles, cone, crossing, document, flat, patterns, ribbon

from geoweave.fabrication.flattening import pattern_of
from geoweave.fabrication.measured_strips import beside, measured


def test_a_triaxial_weave_in_the_plane() -> None:
    found = measured(patterns()["flat"])
    np.testing.assert_allclose(found.as_cut.crossing_angles, 60.0)
    # Lines of one family are 30 apart, so each meets those of another family every 30 / sin 60.
    step = 30.0 / np.sin(np.radians(60))
    near = found.as_cut.neighbours
    same = [found.pattern.strips[a].family == found.pattern.strips[b].family for a, b in near.others.tolist()]
    np.testing.assert_allclose(near.distance[same], step)
    assert found.document()["crossing_angle_deg"]["median"] == pytest.approx(60.0)
    assert found.document()["near_parallel"] == 0


def test_great_circles_alternate_and_have_no_end() -> None:
    found = measured(patterns()["circles"])
    assert len(found.free_ends) == 0
    assert len(found.as_cut.neighbours.distance) == 2 * len(
        found.pattern.at
    )  # also over the start of a closed strip
    np.testing.assert_allclose(found.as_cut.neighbours.distance, found.pattern.strips[0].length / 4)
    assert found.as_cut.share_that_fits == 1.0


def alternating(count: int) -> dict:
    """A line that goes over and under lines 20 apart in turn."""
    lines = [ribbon("A1", 0, [(-10, 0, 0), (20 * count, 0, 0)], UP)]
    lines += [ribbon(f"B{k + 1}", 1, [(20 * k, -30, 0), (20 * k, 40, 0)], UP) for k in range(count)]
    return document(lines, [crossing(0, k + 1, (20.0 * k + 10, 30.0), k % 2) for k in range(count)])


def test_alternation_counts_the_neighbours_between_which_a_strip_changes_sides() -> None:
    content = alternating(6)
    assert measured(pattern_of(content)).alternation == 1.0
    content["crossings"][5]["over_index"] = 0  # one of the five pairs of neighbours no longer alternates
    assert measured(pattern_of(content)).alternation == pytest.approx(4 / 5)


def test_free_ends_are_measured_from_the_outermost_crossing() -> None:
    found = measured(pattern_of(alternating(4)))
    assert found.free_ends.tolist() == pytest.approx([40.0] * 4 + [30.0] * 4 + [20.0, 10.0])
    assert found.document()["free_ends"]["longest"] == pytest.approx(40.0)


def test_what_is_trimmed_is_said() -> None:
    pattern = pattern_of(alternating(4), end=15.0)
    said = measured(pattern).document()["free_ends"]
    assert said["longest"] == pytest.approx(15.0)
    assert said["trimmed"] == 1 + 2 * 4
    assert said["trimmed_length"] == pytest.approx(5.0 + 4 * (15.0 + 25.0))


def test_crowded_neighbours_are_placed() -> None:
    wide = replace(pattern_of(alternating(4)), width=25.0)
    found = measured(wide)
    assert found.as_cut.share_that_fits == 0.0
    places = [each for each in found.places() if each["kind"] == "crowded"]
    assert len(places) == found.document()["crowded"] == 3
    assert places[0]["strips"][0] == "A1"
    assert places[0]["value"] == pytest.approx(20.0)  # so wide may strips be that cross it at right angles
    assert measured(pattern_of(alternating(4))).as_cut.share_that_fits == 1.0


def test_strips_of_a_design_are_what_the_design_says() -> None:
    weave = cone()
    found, said = measured(pattern_of(weave)), weave.metrics()
    assert found.alternation == said["alternation"]["fraction"]
    assert found.document()["total_length"] == pytest.approx(said["total_length"])
    np.testing.assert_allclose(found.as_cut.crossing_angles, weave.crossing_angles, atol=0.2)


@pytest.mark.parametrize("name", NAMES)
def test_a_pattern_does_not_differ_from_itself_as_written(name: str) -> None:
    pattern = patterns()[name]
    again = type(pattern).from_document(pattern.document())
    assert beside(measured(pattern), measured(again)) == {}


def test_what_differs_stands_side_by_side() -> None:
    content = alternating(6)
    designed = measured(pattern_of(content))
    content["crossings"][5]["over_index"] = 0
    content["crossings"][5]["arclength"][0] += 5.0
    differs = beside(designed, measured(pattern_of(content)))
    assert differs["alternation"] == (1.0, pytest.approx(4 / 5))
    assert "apart.smallest" not in differs
    assert "crossing_angle_deg.median" not in differs
    assert beside(designed, designed) == {}


def test_a_strip_that_nothing_crosses_is_all_free() -> None:
    content = flat()
    content["crossings"] = [each for each in content["crossings"] if 0 not in each["ribbons"]]
    found = measured(pattern_of(content))
    assert found.free_ends[:2].tolist() == [150.0, 150.0]
    assert [each["strips"] for each in found.places() if each["kind"] == "free_end"] == [["A1"]]
    assert circles()["units"] == "mm"
