"""An attempt judges the strips exactly as they are written; where it fails, remedies are tried in order."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import pytest

from geoweave.errors import FieldError
from geoweave.fabrication.pattern import Pattern
from geoweave.meshing.prepare import Prepared, prepare_arrays
from geoweave.models import shapes
from geoweave.pipeline import attempt as module
from geoweave.pipeline.attempt import Attempt, attempted, with_remedy
from geoweave.pipeline.request import WeaveRequest
from geoweave.pipeline.source import MeshSource
from geoweave.pipeline.verdict import BUT, DO_NOT, MAKE, Verdict

REQUEST = WeaveRequest(ribbons=6, size=200.0)


@cache
def surface() -> Prepared:
    mesh = shapes.cone(faces=400)
    return prepare_arrays(mesh.vertices, mesh.faces, name="cone")


@cache
def first() -> Attempt:
    return attempted(surface(), 0, REQUEST, True, {}, lambda text: None)


def test_an_attempt_holds_what_it_is_judged_on() -> None:
    made, seconds = first(), dict[str, float]()
    assert made.verdict is not None
    assert made.cut is not None
    assert made.relaxed is not None
    assert made.verdict.word in {MAKE, BUT, DO_NOT}
    plain = attempted(surface(), 0, replace(REQUEST, relax=False), False, seconds, lambda text: None)
    assert (plain.cut, plain.verdict, plain.relaxed) == (None, None, None)
    assert {"inspection", "field"} <= seconds.keys()
    assert "twin" not in seconds


def test_the_strips_are_judged_as_they_are_written(monkeypatch: pytest.MonkeyPatch) -> None:
    judged: list[Pattern] = []

    def refused(pattern: Pattern, *_: Any) -> Any:
        judged.append(pattern)
        raise FieldError("the pattern contradicts itself; correct the place")

    monkeypatch.setattr(module, "put_together", refused)
    made = attempted(surface(), 0, REQUEST, True, {}, lambda text: None, first().weave)
    assert made.verdict == Verdict(DO_NOT, ("the pattern contradicts itself",), "")
    assert made.cut is not None
    assert judged[0].document() == made.cut.pattern.document()
    # places are rounded in the file, and so in what is judged
    assert judged[0].at.tolist() != made.cut.pattern.at.tolist()


@pytest.mark.parametrize("helps", ["--no-relax", "--width", "--ribbons", "--faces", ""])
def test_remedies_are_tried_in_their_order(helps: str, monkeypatch: pytest.MonkeyPatch) -> None:
    narrow = replace(first().inspection, suggested_width=1.5)
    assert first().cut is not None
    failed = replace(first(), inspection=narrow, cut=replace(first().cut, space={}))
    bad = Verdict(DO_NOT, ("it falls apart",), "")
    tried: list[str] = []

    def fake(prepared: Prepared, seed: int, request: WeaveRequest, cut: bool, *rest: Any) -> Attempt:
        ribbons = len(first().weave.ribbons)
        option = (
            "--no-relax"
            if not request.relax
            else "--width"
            if request.width == 1.5
            else "--ribbons"
            if request.ribbons is not None and request.ribbons < ribbons
            else "--faces"
        )
        tried.append(option)
        if option == "--faces":
            assert prepared.mesh.n_faces > 1.5 * surface().mesh.n_faces
        return replace(failed, verdict=Verdict(BUT, ("hard",), "") if option == helps else bad)

    monkeypatch.setattr(module, "attempted", fake)
    found = with_remedy(bad, failed, surface(), MeshSource("cone"), REQUEST, lambda text: None)
    order = ["--no-relax", "--width", "--ribbons", "--faces"]
    assert tried == (order[: order.index(helps) + 1] if helps else order)
    assert (found.word, found.reasons) == (bad.word, bad.reasons)
    if helps:
        assert found.remedy.startswith(helps)
        assert "then the verdict is 'make it, but'" in found.remedy
    else:
        assert found.remedy.startswith("Tried in vain: strips of the design")
