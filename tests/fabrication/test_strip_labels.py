"""Names and labels: near their places, inside where there is room, beside the strip where there is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from laidflat import NAMES, patterns

from geoweave.fabrication.pieces import Making, pieces_of
from geoweave.fabrication.strip_canvas import StripCanvas
from geoweave.fabrication.strip_labels import write_labels, write_names
from geoweave.fabrication.strip_marks import place_marks


def written(
    name: str, longest: float = 1e9, width: float | None = None, making: Making | None = None
) -> list[StripCanvas]:
    pattern, making = patterns()[name], making or Making()
    if width is not None:
        pattern = replace(pattern, width=width)
    found = []
    for piece in pieces_of(pattern, making, longest):
        canvas = StripCanvas(pattern, piece, making)
        placed = place_marks(canvas)
        write_names(canvas)
        write_labels(canvas, placed)
        found.append(canvas)
    return found


@pytest.mark.parametrize("name", NAMES)
def test_every_crossing_has_one_label_in_the_colour_of_its_partner_or_is_in_the_key(name: str) -> None:
    for canvas in written(name):
        labels = [(f.crossing, f.text, f.family) for f in canvas.figures if f.role == "label"]
        strips = canvas.pattern.strips
        wanted = [(p.crossing, p.label, strips[p.partner].family) for p in canvas.passages]
        assert set(labels) <= set(wanted)
        assert {each.crossing for each in canvas.passages} == {
            *(crossing for crossing, _, _ in labels),
            *(line.crossing for line in canvas.key),
        }
        assert len(canvas.key) == len(wanted) - len(labels)


def test_pieces_are_numbered_and_matching_ends_have_one_name() -> None:
    texts = [[f.text for f in canvas.figures if f.role == "name"] for canvas in written("circles", 150.0)]
    first = [each for each in texts if each[0].startswith("A1 ")]
    assert [each[0] for each in first] == [f"A1 {k}/{len(first)} >" for k in range(1, len(first) + 1)]
    joins = [text for each in first for text in each if "=" in text]
    assert all(joins.count(text) == 2 for text in joins)


@pytest.mark.parametrize("width", [2.5, 5.0, 25.0])
@pytest.mark.parametrize("name", NAMES)
def test_nothing_stands_beside_the_strip_and_nothing_is_too_small(name: str, width: float) -> None:
    """What would be cut off with the waste does not count as written; 1.8 mm is the smallest letter."""
    seen = 0
    for canvas in written(name, width=width):
        for figure in canvas.figures:
            if figure.role in ("label", "name", "hollow", "solid"):
                points = np.concatenate(figure.paths)
                assert np.abs(points[:, 1]).max() <= canvas.edge + 1e-9
                assert points[:, 0].min() >= -1e-9
                assert points[:, 0].max() <= canvas.length + 1e-9
            if figure.text:
                assert figure.spot is not None
                assert figure.spot.size >= 1.8
                seen += 1
    assert seen or width < 5


def test_most_names_find_room_where_crossings_are_apart() -> None:
    for canvas in written("flat"):
        assert len(canvas.key) <= 0.1 * len(canvas.passages)


def test_names_are_turned_where_they_do_not_fit_along_the_strip() -> None:
    turned = 0
    for canvas in written("often", width=12.0):
        for figure in canvas.figures:
            if figure.spot is not None and figure.spot.turn:
                size = np.ptp(np.concatenate(figure.paths), axis=0)
                assert size[1] > size[0]
                turned += 1
    assert turned


def test_without_names_all_crossings_are_in_the_key() -> None:
    for canvas in written("cone", making=Making(labels="none")):
        assert not [figure for figure in canvas.figures if figure.text]
        assert [line.crossing for line in canvas.key] == [each.crossing for each in canvas.passages]
        assert not canvas.named
