"""Stages are told by their names and timed, over all the times that they are entered."""

from __future__ import annotations

import pytest

from geoweave.weave import stages


def test_stages_are_told_and_their_seconds_are_summed(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter([0.0, 1.0, 3.0, 6.0, 10.0])
    monkeypatch.setattr(stages.time, "perf_counter", lambda: next(clock))
    told: list[str] = []
    course = stages.Stages(told.append, {"first": 0.5})
    course.begin("first", ": again")
    course.begin("second")
    course.begin("first")
    course.begin("")
    assert told == ["first: again", "second", "first"]
    assert course.seconds == {"first": 0.5 + 2.0 + 4.0, "second": 3.0}
