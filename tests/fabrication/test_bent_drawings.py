"""Curved strips: outlines of constant width, marks that keep their shape, pieces that fit."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import laidflat
import numpy as np
import pytest

from geoweave.errors import FieldError
from geoweave.fabrication.bent_drawings import bent
from geoweave.fabrication.flattening import pattern_of
from geoweave.fabrication.nesting import Stock
from geoweave.fabrication.pattern import Pattern
from geoweave.fabrication.pieces import Making, pieces_of
from geoweave.fabrication.strip_drawing import drawn
from geoweave.fabrication.strip_layout import Bench, layout
from geoweave.fabrication.svg import read_svg

ARC = ((0.0, 0.01), (60.0, -0.004), (140.0, 0.02))


def curved(knots: Any = ARC, width: float = 8.0) -> Pattern:
    """Parallel lines in three families, all strips cut with the same curvature."""
    straight = pattern_of(laidflat.flat(width=width))
    return replace(straight, strips=tuple(strip._replace(curvature=knots) for strip in straight.strips))


def drawing(pattern: Pattern, strip: int = 0, making: Making | None = None) -> tuple[Any, Any]:
    how = making or Making()
    piece = next(each for each in pieces_of(pattern, how) if each.strip == strip)
    return drawn(pattern, piece, how), bent(drawn(pattern, piece, how), pattern, how)


def test_a_straight_strip_is_drawn_as_before() -> None:
    pattern = pattern_of(laidflat.flat())
    flat = drawn(pattern, pieces_of(pattern, Making())[0], Making())
    assert bent(flat, pattern, Making()) is flat


@pytest.mark.parametrize("kerf", [0.0, 0.4])
def test_the_outline_keeps_its_width_and_its_length(kerf: float) -> None:
    pattern = curved()
    _, sheet = drawing(pattern, making=Making(kerf=kerf))
    (outline,) = next(figure.paths for figure in sheet.figures if figure.role == "outline")
    assert sheet.spine is not None
    fine = np.concatenate(
        [np.linspace(a, b, 20) for a, b in zip(sheet.spine[:-1], sheet.spine[1:], strict=True)]
    )
    apart = np.linalg.norm(outline[:, None] - fine[None], axis=2).min(axis=1)
    half = 0.5 * (pattern.width + kerf)
    corners = np.abs(apart - half) > 0.02
    assert corners.sum() <= 4  # where the kerf adds to the length too
    middle = np.linalg.norm(np.diff(sheet.spine, axis=0), axis=1).sum()
    assert middle == pytest.approx(pattern.strips[0].length, rel=1e-4)


def test_marks_keep_their_shape_and_stand_square_to_the_middle_line() -> None:
    flat, sheet = drawing(curved())
    whole = [k for k, each in enumerate(flat.figures) if each.role in ("hollow", "solid", "name", "label")]
    assert len(whole) > 10
    for k in whole:
        for one, two in zip(flat.figures[k].paths, sheet.figures[k].paths, strict=True):
            np.testing.assert_allclose(
                np.linalg.norm(np.diff(two, axis=0), axis=1),
                np.linalg.norm(np.diff(one, axis=0), axis=1),
                atol=1e-9,
            )


def test_pieces_fit_on_their_sheets_and_do_not_lie_over_themselves() -> None:
    spiral = curved(((0.0, 0.09),), width=4.0)  # once round is 70 mm, the strips are longer
    stock = Stock(120.0, 100.0)
    laid = layout(spiral, Bench(stock=stock))
    assert len([each for sheet in laid.sheets for each in sheet.laid]) > len(spiral.strips)
    for sheet in laid.sheets:
        for each in sheet.laid:
            outlines = [path for figure in each.figures if figure.role == "outline" for path in figure.paths]
            points = np.concatenate(outlines)
            assert points.min() > stock.margin - 1e-6
            assert (points.max(axis=0) < np.array([120.0, 100.0]) - stock.margin + 1e-6).all()
            assert each.drawn.spine is not None
            spine = each.drawn.spine
            step = each.drawn.piece.length / (len(spine) - 1)
            apart = np.linalg.norm(spine[:, None] - spine[None], axis=2)
            along = step * abs(np.subtract.outer(np.arange(len(spine)), np.arange(len(spine))))
            assert (apart[along > 2.5 * spiral.width] > spiral.width).all()


def test_strips_too_curved_for_a_sheet_are_refused() -> None:
    with pytest.raises(FieldError, match="larger sheet"):
        _ = layout(curved(((0.0, 0.03),)), Bench(Making(overlap=60.0), Stock(250.0, 30.0))).sheets


def test_lengths_are_read_back_from_curved_outlines(tmp_path: Any) -> None:
    pattern = curved()
    lengths, marks = read_svg(layout(pattern).save(tmp_path / "a.svg")[0])
    for strip in pattern.strips:
        assert lengths[strip.label] == pytest.approx(strip.length, rel=1e-3)
    assert len(marks) == 2 * len(pattern.at)


def test_all_formats_of_a_curved_pattern_are_written_and_pattern_json_comes_back(tmp_path: Any) -> None:
    pattern = curved()
    laid = layout(pattern)
    for ending in (".svg", ".dxf", ".pdf", ".csv", ".json"):
        assert laid.save(tmp_path / f"a{ending}")[0].stat().st_size > 500
    again = Pattern.from_document(pattern.document())
    assert again.strips[0].curvature == ARC
    assert again.document() == pattern.document()


@pytest.mark.parametrize("knots", [[[0, 0.3]], [[5, 0.0], [4, 0.0]], [[0]], "x"])
def test_a_pattern_whose_edges_would_cross_is_refused(knots: Any) -> None:
    document = curved().document()
    document["strips"][0]["curvature"] = knots
    with pytest.raises(FieldError, match="curvature"):
        Pattern.from_document(document)


def test_seen_from_the_inside_a_strip_curves_the_other_way() -> None:
    pattern = curved(((0.0, 0.01),))
    _, outside = drawing(pattern)
    _, inside = drawing(pattern, making=Making(mirror=True))
    sag = [each.spine[len(each.spine) // 2, 1] - each.spine[0, 1] for each in (outside, inside)]
    assert sag[0] < -1.0
    assert sag[1] == pytest.approx(-sag[0], rel=1e-6)
