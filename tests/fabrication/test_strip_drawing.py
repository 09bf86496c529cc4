"""On a drawn strip no text meets a mark or another text, and every crossing shows what it must."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from laidflat import NAMES, patterns

from geoweave.fabrication.marks import outline
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.pieces import Making, pieces_of
from geoweave.fabrication.strip_drawing import drawn
from geoweave.fabrication.strip_figures import ROLES, Drawn, Figure
from geoweave.fabrication.stroke_font import Box, boxes_overlap

PLAIN = Making()


def all_of(pattern: Pattern, making: Making = PLAIN, longest: float = math.inf) -> list[Drawn]:
    return [drawn(pattern, piece, making) for piece in pieces_of(pattern, making, longest)]


def box_of(figure: Figure) -> Box:
    points = np.concatenate(figure.paths)
    low, high = points.min(axis=0), points.max(axis=0)
    return Box(*low.tolist(), *high.tolist()).grown(0.5 * figure.pen)


def writing(drawing: Drawn) -> list[Box]:
    """Boxes of all texts and of all marks, as they are drawn."""
    return [box_of(f) for f in drawing.figures if f.role in ("label", "name", "hollow", "solid")]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("longest", [math.inf, 110.0])
def test_texts_and_marks_are_disjoint(name: str, longest: float) -> None:
    for drawing in all_of(patterns()[name], longest=longest):
        boxes = writing(drawing)
        assert len(boxes) > 2
        assert not any(boxes_overlap(one, other) for one, other in combinations(boxes, 2))


@pytest.mark.parametrize("width", [2.5, 4.0, 12.0, 25.0])
def test_they_are_disjoint_at_any_width(width: float) -> None:
    """Also where the ribbons are wider than their spacing, and most labels stand in the key."""
    for drawing in all_of(replace(patterns()["cone"], width=width)):
        boxes = writing(drawing)
        assert not any(boxes_overlap(one, other) for one, other in combinations(boxes, 2))


@pytest.mark.parametrize("name", NAMES)
def test_every_crossing_has_its_mark_its_label_and_its_guide(name: str) -> None:
    pattern = patterns()[name]
    for drawing in all_of(pattern):
        found = [(f.crossing, f.text) for f in drawing.figures if f.role == "label"]
        passages = pattern.passages[drawing.piece.strip]
        listed = [(line.crossing, line.label) for line in drawing.key]
        # What does not stand on the strip stands in the key.
        assert {*found, *listed} == {(each.crossing, each.label) for each in passages}
        assert len(found) + len(listed) >= len(passages)
        bare = {line.crossing for line in drawing.key if not line.marked}
        roles = {(f.crossing, f.role) for f in drawing.figures}
        for each in passages:
            assert (each.crossing, "hollow" if each.over else "solid") in roles or each.crossing in bare
            assert (each.crossing, "over" if each.over else "under") in roles
            assert each.over == ((each.crossing, "band") not in roles) or each.partner == drawing.piece.strip


def test_the_mark_is_the_one_of_the_crossing_and_upright() -> None:
    pattern = patterns()["flat"]
    for drawing in all_of(pattern):
        for figure in drawing.figures:
            if figure.role in ("hollow", "solid"):
                (path,) = figure.paths
                shape = outline(int(pattern.mark[figure.crossing]))
                scale = np.ptp(path[:, 0]) / np.ptp(shape[:, 0])
                np.testing.assert_allclose(path - path[0], scale * (shape - shape[0]), atol=1e-9)


@pytest.mark.parametrize("name", ["flat", "cone", "circles"])
def test_guides_lie_on_the_edges_of_the_partner(name: str) -> None:
    """Every drawn point of a guide is half a width from the partner's line, at the angle of the crossing."""
    pattern = patterns()[name]
    seen = 0
    for drawing in all_of(pattern):
        for figure in _of(drawing, "under", "over"):
            each = next(p for p in pattern.passages[drawing.piece.strip] if p.crossing == figure.crossing)
            angle = np.radians(each.angle)
            left = np.array([-np.sin(angle), np.cos(angle)])
            points = np.concatenate(figure.paths)
            turns = (0.0, pattern.strips[drawing.piece.strip].length)
            off = np.abs(np.stack([(points - [each.at + turn, 0.0]) @ left for turn in turns])).min(axis=0)
            inset = 0.0 if each.over else 0.6
            assert (off < 0.5 * pattern.width + 1e-6).all()
            assert (off > 0.5 * pattern.width - inset - 1e-3).all()
            seen += len(points)
    assert seen > 100


@pytest.mark.parametrize("name", NAMES)
def test_guides_leave_room_for_texts_and_marks_inside(name: str) -> None:
    pattern = patterns()[name]
    for drawing in all_of(pattern):
        boxes = [box for box in writing(drawing) if abs(box.top + box.bottom) < pattern.width]
        for figure in _of(drawing, "under", "over", "fold"):
            middles = np.concatenate([0.5 * (path[:-1] + path[1:]) for path in figure.paths])
            for box in boxes:
                inside = (middles > box[:2]) & (middles < box[2:])
                assert not inside.all(axis=1).any()


def test_names_stand_at_both_ends_inside_the_strip() -> None:
    for name in ("flat", "cone", "circles"):
        pattern = patterns()[name]
        for drawing in all_of(pattern):
            label = f"{pattern.strips[drawing.piece.strip].label} >"
            ends = [box_of(figure) for figure in drawing.figures if figure.text == label]
            assert len(ends) == 2
            assert min(box.left for box in ends) < 0.25 * drawing.piece.length
            assert max(box.right for box in ends) > 0.75 * drawing.piece.length
            assert all(abs(y) <= 0.5 * pattern.width for box in ends for y in (box.bottom, box.top))


def test_pieces_say_where_they_match() -> None:
    drawings = all_of(patterns()["flat"], longest=110.0)
    for one, other in zip(drawings[::2], drawings[1::2], strict=True):
        texts = [{figure.text for figure in each.figures} for each in (one, other)]
        label = patterns()["flat"].strips[one.piece.strip].label
        assert f"{label}=1" in texts[0] & texts[1]
        assert {f"{label} 1/2 >"} <= texts[0]
        assert {f"{label} 2/2 >"} <= texts[1]
        # the line on each piece is where the other one ends
        (left,), (right,) = (
            {round(float(x), 6) for f in _of(each, "fold") for path in f.paths for x in path[:, 0]}
            for each in (one, other)
        )
        assert left == pytest.approx(other.piece.start - one.piece.start)
        assert right == pytest.approx(one.piece.end - other.piece.start)


def test_kerf_and_extra_widen_the_outline_only() -> None:
    pattern = patterns()["flat"]
    drawing = all_of(pattern, Making(kerf=0.3, extra=5.0))[0]
    (cut,) = (box_of(figure) for figure in _of(drawing, "outline"))
    assert cut.right - cut.left == pytest.approx(150 + 10 + 0.3)
    assert cut.top - cut.bottom == pytest.approx(pattern.width + 0.3)
    ends = {round(float(x), 6) for f in _of(drawing, "fold") for path in f.paths for x in path[:, 0]}
    assert ends == {5.0, 155.0}


@pytest.mark.parametrize("name", NAMES)
def test_nothing_reaches_beyond_the_ends(name: str) -> None:
    for drawing in all_of(patterns()[name], Making(kerf=0.2), 110.0):
        assert drawing.extent.left == pytest.approx(-0.1)
        assert drawing.extent.right == pytest.approx(drawing.piece.length + 0.1)


def test_letters_are_no_smaller_than_can_be_read() -> None:
    for name in NAMES:
        for drawing in all_of(patterns()[name]):
            for figure in _of(drawing, "label", "name"):
                assert figure.spot is not None
                assert figure.spot.size >= 1.8
                box = box_of(figure)
                assert max(box.top - box.bottom, box.right - box.left) > 1.8


def test_what_finds_no_place_stands_in_the_key() -> None:
    pattern = patterns()["often"]
    short = replace(
        pattern,
        strips=tuple(strip._replace(length=4.0) for strip in pattern.strips),
        at=np.full_like(pattern.at, 2.0),
    )
    for drawing in all_of(short):
        assert len(drawing.key) == len(pattern.passages[drawing.piece.strip])
        assert not drawing.named
        assert any(not line.marked for line in drawing.key)


def test_the_same_pattern_is_drawn_the_same() -> None:
    one, other = (all_of(patterns()["cone"]) for _ in range(2))
    for a, b in zip(one, other, strict=True):
        assert [figure.role for figure in a.figures] == [figure.role for figure in b.figures]
        for f, g in zip(a.figures, b.figures, strict=True):
            assert all(np.array_equal(p, q) for p, q in zip(f.paths, g.paths, strict=True))


def test_every_role_has_a_layer() -> None:
    roles = {figure.role for name in NAMES for d in all_of(patterns()[name]) for figure in d.figures}
    assert roles <= set(ROLES)
    assert len(roles) >= 10


def _of(drawing: Drawn, *roles: str) -> Iterator[Figure]:
    return (figure for figure in drawing.figures if figure.role in roles)
