"""The verdict follows from what was measured, and says it in a maker's words."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import pytest
from twinned import twin, woven

from geoweave.models import shapes
from geoweave.pipeline.verdict import BUT, DO_NOT, HOLDS, MAKE, WATCH, Verdict, rebuilt_reasons, verdict_of
from geoweave.weave.design import weave_pattern
from geoweave.weave.inspection import Inspection, inspected
from geoweave.weave.places import KINDS, Place


@cache
def sound() -> Inspection:
    """A weave of which there is nothing to say."""
    found = inspected(weave_pattern(shapes.cone(faces=400), ribbons=6).sized(200.0))
    return replace(found, places=(), violations=())


def strips(fit: float = 1.0, slipped: int = 0) -> Any:
    """Strips of which so many neighbouring crossings fit."""
    as_cut = SimpleNamespace(share_that_fits=fit)
    return SimpleNamespace(measured=SimpleNamespace(as_cut=as_cut), slipped=slipped)


def resting(**other: Any) -> Any:
    return SimpleNamespace(metrics=lambda: {"converged": True, "hausdorff": HOLDS / 2, "ending": ""} | other)


def test_nothing_to_say_is_make_it() -> None:
    assert verdict_of(sound(), strips(), None, ()) == Verdict(MAKE, (), "")
    assert verdict_of(sound(), strips(), resting(), ()).sentence == "make it"


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_place_is_told_of_or_told_by_the_width(kind: str) -> None:
    place = Place(kind, (0.0, 0.0, 0.0), ("A1", "B1"), 1.0)
    one, many = (verdict_of(replace(sound(), places=(place,) * n), strips(), None, ()) for n in (1, 3))
    if kind == "crowded":
        assert one.word == many.word == MAKE
        return
    assert one.word == many.word == BUT
    assert one.reasons == (WATCH[kind][0],)
    assert "3" in many.reasons[0] or kind == "lap"


def test_strips_that_are_too_wide_have_a_remedy_that_was_measured() -> None:
    found = verdict_of(replace(sound(), suggested_width=2.5), strips(fit=0.3), None, ())
    assert found.word == BUT
    assert "30%" in found.reasons[0]
    assert "--width 2.5" in found.remedy


def test_a_weave_that_leaves_its_shape_is_told_of() -> None:
    far = verdict_of(sound(), strips(), resting(hausdorff=2 * HOLDS), ())
    assert (far.word, "10.0% of the diagonal" in far.reasons[0]) == (BUT, True)
    unsettled = verdict_of(sound(), strips(), resting(converged=False, ending="too many steps"), ())
    assert "too many steps" in unsettled.reasons[0]
    assert "lengths of the design" in verdict_of(sound(), strips(slipped=2), resting(), ()).reasons[0]


def test_what_nobody_can_put_together_is_not_to_be_cut() -> None:
    broken = verdict_of(sound(), strips(), resting(), ("it falls apart",))
    assert (broken.word, broken.reasons) == (DO_NOT, ("it falls apart",))
    assert broken.sentence == "do not cut this: it falls apart"
    rules = verdict_of(replace(sound(), violations=("a ribbon has no length",)), strips(), None, ())
    assert rules.word == DO_NOT
    assert rules.document() == {"word": DO_NOT, "reasons": ["a ribbon has no length"], "remedy": ""}


def test_a_twin_with_another_surface_or_shape_does_not_come_back() -> None:
    made = twin("cone")
    target = made.compared(woven("cone").relaxed)
    genus, openings = made.surface.genus, made.surface.openings
    assert (genus, openings) == (0, 1)
    assert rebuilt_reasons(made, target, genus, openings) == ()
    assert rebuilt_reasons(made, None, None, None) == ()
    assert "0 holes through it, not 2" in rebuilt_reasons(made, target, 2, openings)[0]
    assert "1 opening, not 0" in rebuilt_reasons(made, target, genus, 0)[0]
    far = target._replace(crossings=replace(target.crossings, largest=0.2))
    (reason,) = rebuilt_reasons(made, far, genus, openings)
    assert "20.0% of the diagonal" in reason
