"""Marks stand on the lines of their partners, inside the strip, and do not touch each other."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from laidflat import NAMES, patterns

from geoweave.fabrication.pieces import Making, pieces_of
from geoweave.fabrication.strip_canvas import StripCanvas
from geoweave.fabrication.strip_marks import SHRUNK, place_marks
from geoweave.fabrication.stroke_font import boxes_overlap


def canvases(name: str) -> list[StripCanvas]:
    pattern, making = patterns()[name], Making()
    return [StripCanvas(pattern, piece, making) for piece in pieces_of(pattern, making)]


@pytest.mark.parametrize("name", NAMES)
def test_marks_lie_inside_the_strip_and_apart(name: str) -> None:
    for canvas in canvases(name):
        placed = [spot for spot in place_marks(canvas) if spot is not None]
        assert placed
        assert all(abs(spot.y) + spot.radius <= canvas.inside + 1e-9 for spot in placed)
        assert not any(boxes_overlap(one.box, other.box) for one, other in combinations(placed, 2))
        assert len([figure for figure in canvas.figures if figure.role in ("hollow", "solid")]) == len(placed)


@pytest.mark.parametrize("name", NAMES)
def test_a_mark_stands_on_the_line_of_its_partner(name: str) -> None:
    for canvas in canvases(name):
        for each, spot in zip(canvas.passages, place_marks(canvas), strict=True):
            if spot is None or abs(each.angle) < 45 or abs(each.angle) > 135:
                continue  # a shallow line leaves the strip too far from the crossing
            angle = np.radians(each.angle)
            across = (spot.x - each.at) * np.sin(angle) - spot.y * np.cos(angle)
            assert across == pytest.approx(0.0, abs=1e-9)


def test_marks_shrink_only_where_they_must() -> None:
    (first, *_) = canvases("flat")
    assert {spot.radius for spot in place_marks(first) if spot is not None} == {first.radius}
    sizes = [share * canvas.radius for canvas in canvases("often") for share in SHRUNK]
    for canvas in canvases("often"):
        for spot in place_marks(canvas):
            assert spot is None or min(abs(spot.radius - size) for size in sizes) < 1e-12
