"""What is cut is the weave that was designed: the order of its crossings, and what is said of them."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from geoweave.fabrication.flattening import pattern_of
from geoweave.fabrication.pattern import Pattern
from geoweave.meshing.remesh import isotropic_remesh
from geoweave.models import catalogue, shapes
from geoweave.pipeline.strips import CutStrips, strips_of
from geoweave.rods.weave_at_rest import Relaxed, relaxed_weave
from geoweave.weave.design import weave_pattern

SHAPES = {
    "cone": (lambda: shapes.cone(faces=800), 10),
    "torus": (lambda: shapes.torus(faces=1500), 12),
    "bunny": (lambda: isotropic_remesh(catalogue.load("bunny"), 1500), 30),
    "spot": (lambda: isotropic_remesh(catalogue.load("spot"), 1500), 30),
}


@cache
def relaxed(name: str) -> Relaxed:
    surface, ribbons = SHAPES[name]
    return relaxed_weave(weave_pattern(surface(), ribbons=ribbons).sized(200.0))


@cache
def cut(name: str) -> CutStrips:
    rest = relaxed(name)
    return strips_of(rest.weave, rest)


def partners(document: dict[str, Any]) -> list[list[str]]:
    """The names of the ribbons that each ribbon meets, in the order of weave.json, with over and under."""
    met: list[list[tuple[float, str]]] = [[] for _ in document["ribbons"]]
    for each in document["crossings"]:
        for side in (0, 1):
            ribbon, partner = each["ribbons"][side], each["ribbons"][1 - side]
            way = "over" if each["over_index"] == side else "under"
            met[ribbon].append((each["arclength"][side], f"{way} {document['ribbons'][partner]['label']}"))
    return [[name for _, name in sorted(each)] for each in met]


def passed(pattern: Pattern) -> list[list[str]]:
    return [
        [f"{'over' if each.over else 'under'} {pattern.strips[each.partner].label}" for each in along]
        for along in pattern.passages
    ]


def turned(one: list[str], closed: bool) -> list[list[str]]:
    """The same order, begun at any crossing of a closed ribbon."""
    return [one[k:] + one[:k] for k in range(max(len(one), 1))] if closed else [one]


@pytest.mark.parametrize("name", SHAPES)
def test_every_strip_meets_the_others_in_the_order_of_the_design(name: str) -> None:
    strips, design = cut(name), partners(relaxed(name).weave.document())
    for strip, along, wanted in zip(strips.pattern.strips, passed(strips.pattern), design, strict=True):
        assert wanted in turned(along, strip.closed)


@pytest.mark.parametrize("name", SHAPES)
def test_the_strips_alternate_as_the_report_says(name: str) -> None:
    said = relaxed(name).weave.metrics()["alternation"]["fraction"]
    assert cut(name).measured.alternation == pytest.approx(said, abs=1e-12)
    assert cut(name).document()["alternation"] == cut(name).measured.alternation
    assert "alternation" not in cut(name).differs


def test_what_slid_past_each_other_is_cut_as_designed_and_that_is_said() -> None:
    rest = relaxed("cone")
    lies = rest.document()
    first = min(lies["crossings"], key=lambda each: each["arclength"][0])
    # One crossing slides to the far end of its ribbon, past all others.
    ribbon = first["ribbons"][0]
    first["arclength"][0] = lies["ribbons"][ribbon]["length"]

    class Slipped:
        def document(self) -> dict[str, Any]:
            return lies

    strips = strips_of(rest.weave, Slipped())  # type: ignore[arg-type]
    assert strips.slipped == len(pattern_of(lies).reordered) >= 1
    assert (strips.source, strips.space) == ("weave.json", None)
    assert strips.document()["of"] == "weave.json"
    assert strips.pattern.document() == strips.designed.document()
    assert strips.differs == {}


def test_design_and_strips_stand_side_by_side_where_they_differ() -> None:
    strips = cut("cone")
    assert strips.source == "relaxed.json"
    named = strips.document()["differs"]
    assert named == {name: {"design": a, "strips": b} for name, (a, b) in strips.differs.items()}
    # Strips that are 2 % longer are longer in the report, and all that hangs on it.
    longer = replace(
        strips.designed,
        strips=tuple(each._replace(length=1.02 * each.length) for each in strips.designed.strips),
        at=1.02 * strips.designed.at,
    )
    found = CutStrips(longer, strips.designed, {}, 0).differs
    assert found["total_length"] == pytest.approx(
        (sum(each.length for each in strips.designed.strips), sum(each.length for each in longer.strips))
    )
    assert "alternation" not in found
    assert "crossing_angle_deg.median" not in found


def test_ends_that_hang_are_trimmed_in_the_strips_and_in_the_report() -> None:
    narrow = relaxed("cone").weave.sized(width=2.0)
    strips = strips_of(narrow, None)
    said = strips.document()["free_ends"]
    assert said["trimmed"] > 0
    assert said["longest"] == pytest.approx(8.0)  # four widths
    whole = sum(strip.length for strip in pattern_of(narrow).strips)
    assert strips.document()["total_length"] + said["trimmed_length"] == pytest.approx(whole)
