"""Names and labels: near their places, inside where there is room, beside the strip where there is none."""

from __future__ import annotations

from dataclasses import replace

import pytest
from laidflat import NAMES, patterns

from geoweave.errors import FieldError
from geoweave.fabrication.pieces import Making, pieces_of
from geoweave.fabrication.strip_canvas import StripCanvas
from geoweave.fabrication.strip_labels import write_labels, write_names
from geoweave.fabrication.strip_marks import place_marks


def written(name: str, longest: float = 1e9, width: float | None = None) -> list[StripCanvas]:
    pattern, making = patterns()[name], Making()
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
def test_every_crossing_has_one_label_in_the_colour_of_its_partner(name: str) -> None:
    for canvas in written(name):
        labels = [(f.crossing, f.text, f.family) for f in canvas.figures if f.role == "label"]
        strips = canvas.pattern.strips
        wanted = [(p.crossing, p.label, strips[p.partner].family) for p in canvas.passages]
        assert sorted(labels) == sorted(wanted)


def test_pieces_are_numbered_and_matching_ends_have_one_name() -> None:
    texts = [[f.text for f in canvas.figures if f.role == "name"] for canvas in written("circles", 150.0)]
    first = [each for each in texts if each[0].startswith("A1 ")]
    assert [each[0] for each in first] == [f"A1 {k}/{len(first)} >" for k in range(1, len(first) + 1)]
    joins = [text for each in first for text in each if "=" in text]
    assert all(joins.count(text) == 2 for text in joins)


def test_what_has_no_room_inside_stands_beside_with_a_line_to_its_place() -> None:
    outside = 0
    for canvas in written("cone", width=25.0):
        leaders = {f.crossing: f for f in canvas.figures if f.role == "leader"}
        for figure in canvas.figures:
            if figure.role == "label" and abs(figure.paths[0][:, 1]).min() > canvas.edge:
                outside += 1
                (bend,) = leaders[figure.crossing].paths
                places = [p.at for p in canvas.passages if p.crossing == figure.crossing]
                assert min(abs(bend[0, 0] - place) for place in places) < 1e-9
    assert outside


def test_too_dense_a_strip_is_refused_with_its_place() -> None:
    pattern = patterns()["often"]
    crowded = replace(
        pattern,
        strips=tuple(strip._replace(length=strip.length / 400) for strip in pattern.strips),
        at=pattern.at / 400,
    )
    making = Making(overlap=1.0)
    canvas = StripCanvas(crowded, pieces_of(crowded, making)[0], making)
    placed = place_marks(canvas)
    with pytest.raises(FieldError, match=r"strip A1 are too dense to be labelled near .* mm"):
        write_labels(canvas, placed)
