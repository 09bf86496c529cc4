"""An attempt judges the strips exactly as they are written; where it fails, remedies are tried in order."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from twinned import twin, woven

from geoweave.errors import FieldError
from geoweave.fabrication.pattern import Pattern
from geoweave.meshing.prepare import Prepared, prepare_arrays
from geoweave.models import shapes
from geoweave.pipeline import attempt as module
from geoweave.pipeline.attempt import Attempt, attempted, with_remedy
from geoweave.pipeline.request import WeaveRequest
from geoweave.pipeline.source import MeshSource
from geoweave.pipeline.verdict import BUT, DO_NOT, MAKE, Verdict
from geoweave.twin.pattern_surface import surface_of

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

    def fake(
        prepared: Prepared, seed: int, request: WeaveRequest, cut: bool, *rest: Any, trial: bool
    ) -> Attempt:
        assert trial
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
    monkeypatch.setattr(module, "_flat_reasons", lambda *_: ("it has a hole too many",))
    found = with_remedy(bad, failed, surface(), MeshSource("cone"), REQUEST, lambda text: None)
    order = ["--no-relax", "--width", "--ribbons", "--faces"]
    assert tried == (order[: order.index(helps) + 1] if helps else order)
    assert (found.word, found.reasons) == (bad.word, bad.reasons)
    if helps:
        assert found.remedy.startswith(helps)
        assert "then the verdict is 'make it, but'" in found.remedy
    else:
        assert found.remedy.startswith("Tried in vain: strips of the design")


def test_strips_with_another_shape_are_made_with_a_word_on_it(monkeypatch: pytest.MonkeyPatch) -> None:
    made = twin("cone")
    near = made.compared(woven("cone").relaxed)
    far = near._replace(crossings=replace(near.crossings, largest=0.2))
    monkeypatch.setattr(module, "put_together", lambda *_: (replace(made, alone=far), {"woven": near}))
    found = attempted(surface(), 0, REQUEST, True, {}, lambda text: None, first().weave).verdict
    assert found is not None
    assert found.word == BUT
    assert found.reasons[0].startswith("the strips can also rest in another shape")
    assert f"{0.2 * near.diagonal:.3g} mm from its place" in found.reasons[0]


def test_a_finer_mesh_is_no_remedy_for_a_design_that_is_right(monkeypatch: pytest.MonkeyPatch) -> None:
    bad = Verdict(DO_NOT, ("put together, the object has another shape",), "")
    tried: list[str] = []

    def vain(prepared: Prepared, *rest: Any, trial: bool) -> Attempt:
        assert prepared is surface()
        return replace(first(), verdict=bad)

    monkeypatch.setattr(module, "attempted", vain)
    found = with_remedy(bad, first(), surface(), MeshSource("cone"), REQUEST, tried.append)
    assert tried[0] == "trying strips of the design, not as at rest"
    assert "trying a finer mesh" not in tried
    assert "finer" not in found.remedy


def test_a_trial_that_fails_on_paper_is_not_relaxed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_flat_reasons", lambda *_: ("it has a hole too many",))
    monkeypatch.setattr(module, "_relaxed", None)
    made = attempted(surface(), 0, REQUEST, True, {}, lambda text: None, first().weave, trial=True)
    assert made.verdict == Verdict(DO_NOT, ("it has a hole too many",), "")
    assert (made.relaxed, made.cut) == (None, None)


def test_strips_are_judged_before_they_are_put_together() -> None:
    made = first()
    assert made.cut is not None
    weave, strips, seen = made.weave, made.cut.pattern, made.inspection
    assert module._flat_reasons(weave, strips, seen) == ()
    split = replace(strips, strips=(strips.strips[0]._replace(openings=(0, 1)), *strips.strips[1:]))
    assert "1 opening, not 2" in module._flat_reasons(weave, split, seen)[0]
    inner = int(np.argmax((surface_of(strips).partner.reshape(-1, 4) >= 0).all(axis=1)))
    wrong = strips.angle.copy()
    wrong[inner] *= -1
    (sentence,) = module._flat_reasons(weave, replace(strips, angle=wrong), seen)
    assert sentence.startswith("the pattern contradicts itself")
    assert "--no-relax" not in sentence
