"""A request to cut: what is given comes before the preset, and that before what holds without one."""

from __future__ import annotations

import pytest

from geoweave.errors import FieldError
from geoweave.pipeline.cut_request import PLAIN, CutRequest


def test_what_is_given_comes_before_the_preset() -> None:
    plain, preset = CutRequest(), CutRequest(preset="polypropylene-laser")
    assert plain.bench("a").making.kerf == PLAIN["kerf"] == 0
    assert preset.bench("a").making.kerf == 0.25
    assert CutRequest(preset="polypropylene-laser", kerf=0.0).bench("a").making.kerf == 0
    assert preset.bench("a").density == 0.905
    assert preset.bench("a").title == "a"
    assert CutRequest(title="b").bench("a").title == "b"


def test_the_document_holds_what_was_asked_for() -> None:
    assert CutRequest().document() == {}
    assert CutRequest(preset="bristol-a4", holes=2.0, papers=("a3",), mirror=True, end=0.0).document() == {
        "preset": "bristol-a4",
        "holes": 2.0,
        "papers": ["a3"],
        "mirror": True,
        "end": 0.0,
    }


def test_colours_are_a_style_or_those_of_families() -> None:
    assert CutRequest().bench("a").colours.style == "laser"
    assert CutRequest(colours="paper").bench("a").colours.style == "paper"
    bench = CutRequest(colours="#112233, #445566").bench("a")
    assert bench.colours.families == bench.paper_colours.families == ("#112233", "#445566")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"kerf": float("nan")}, "kerf is nan"),
        ({"width": 0.0}, "width is 0.0; give a positive number"),
        ({"end": -1.0}, "end is -1.0"),
        ({"stock_length": 1e9}, "stock_length is 1000000000.0"),
        ({"overlap": 0.2}, "1 mm or more"),
        ({"sheet": "big"}, "WIDTHxHEIGHT"),
        ({"papers": ("b5",)}, "no paper 'b5'"),
        ({"labels": "gilded"}, "engraved, printed, none"),
    ],
)
def test_what_is_out_of_range_is_refused_at_once(options: dict[str, object], words: str) -> None:
    with pytest.raises(FieldError, match=words):
        CutRequest(**options)  # type: ignore[arg-type]
