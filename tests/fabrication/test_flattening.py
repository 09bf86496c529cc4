"""Laid flat, a ribbon keeps its length and its crossings; how far it is from straight is said."""

from __future__ import annotations

import numpy as np
import pytest
from laidflat import UP, circles, cone, flat, patterns

from geoweave.errors import FieldError
from geoweave.fabrication.flattening import bow_and_turning, free_end, pattern_of, trimmed, weave_document
from geoweave.fabrication.measured_strips import measured
from geoweave.fabrication.strip_layout import layout
from geoweave.rods.weave_at_rest import relaxed_weave


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
    np.testing.assert_allclose(pattern.angle, np.degrees(met.angle), atol=0.2)
    np.testing.assert_array_equal(pattern.over, weave.interlacing.over)
    for r, strip in enumerate(pattern.strips):
        own = slice(curves.offsets[r], curves.offsets[r + 1])
        heading = np.concatenate([[0.0], np.cumsum(curves.turning[own][1:-1])])
        assert strip.turning == pytest.approx(np.degrees(np.ptp(heading)), abs=0.02)


def test_whatever_has_the_document_of_a_weave_is_laid_flat() -> None:
    weave = cone()
    rest = relaxed_weave(weave, rounds=1)
    for each in (weave, rest):
        assert pattern_of(each).document() == pattern_of(each.document()).document()
    assert weave_document(flat()) == flat()
    with pytest.raises(FieldError, match="is not a geoweave-weave of version 1"):
        weave_document(patterns()["flat"])  # a pattern has a document too, but no place in space
    with pytest.raises(FieldError, match="is not a geoweave-weave of version 1"):
        weave_document(flat() | {"version": 2})


def test_refusals() -> None:
    with pytest.raises(FieldError, match="lengths in mm"):
        pattern_of({**flat(), "units": "mesh"})
    with pytest.raises(FieldError, match=r"other\.json: is not a geoweave-weave"):
        pattern_of({"format": "geoweave-report"}, "other.json")
    with pytest.raises(FieldError, match="missing or wrong"):
        pattern_of({**flat(), "ribbons": [{}]})


def test_ends_are_trimmed_to_what_is_allowed_and_all_else_stays() -> None:
    whole, short = pattern_of(flat()), pattern_of(flat(), end=10.0)
    for r, (before, after) in enumerate(zip(whole.strips, short.strips, strict=True)):
        places = [each.at for each in whole.passages[r]]
        first, last = places[0], before.length - places[-1]
        assert after.trimmed == pytest.approx((max(first - 10, 0), max(last - 10, 0)))
        assert after.length == pytest.approx(before.length - sum(after.trimmed))
        there = [each.at for each in short.passages[r]]
        assert there == pytest.approx([at - after.trimmed[0] for at in places])
        assert there[0] <= 10 + 1e-9
        assert after.length - there[-1] <= 10 + 1e-9
    np.testing.assert_allclose(short.angle, whole.angle)
    np.testing.assert_array_equal(short.mark, whole.mark)
    assert any(sum(strip.trimmed) > 0 for strip in short.strips)


def test_a_trimmed_weave_lies_where_it_lay() -> None:
    content = cone().document()
    short = pattern_of(content, end=3.0)
    shorter = trimmed(content, [strip.trimmed for strip in short.strips])
    for before, after, strip in zip(content["ribbons"], shorter["ribbons"], short.strips, strict=True):
        line = np.array(after["points"])
        steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
        assert steps.sum() == pytest.approx(after["length"], rel=1e-6)
        assert after["length"] == pytest.approx(strip.length)
        assert len(after["normals"]) == len(after["points"])
        # Its points are those of the ribbon, but for the two new ends, which lie on it.
        kept = {tuple(point) for point in before["points"]}
        assert all(tuple(point) in kept for point in after["points"][1:-1])
    assert pattern_of(shorter).document()["crossings"] == short.document()["crossings"]
    assert trimmed(content, [(0.0, 0.0)] * len(content["ribbons"])) is content


def test_nothing_is_trimmed_of_closed_ribbons_and_of_those_that_nothing_crosses() -> None:
    assert pattern_of(circles(), end=0.0).document() == pattern_of(circles()).document()
    alone = flat()
    alone["crossings"] = []
    assert pattern_of(alone, end=0.0).document() == pattern_of(alone).document()
    with pytest.raises(FieldError, match="keeps 0 mm or more"):
        pattern_of(flat(), end=-1.0)


def test_a_layout_keeps_four_widths_unless_told_otherwise() -> None:
    content = flat(reach=200.0)
    assert free_end(content) == 32.0
    assert measured(layout(content).pattern).free_ends[0] == pytest.approx(32.0)
    assert layout(content, end=np.inf).pattern.document() == pattern_of(content).document()
    # The guide and the GLB show the ribbons as they are cut.
    ((name, job),) = layout(content).files(".glb", "a").items()
    assert name == "a.glb"
    assert callable(job)
