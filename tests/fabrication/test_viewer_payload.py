"""What the viewer holds is what the files of the weave say."""

from __future__ import annotations

import base64
import json

import numpy as np
import pytest
from laidflat import circles, cone, flat, ribbon

from geoweave.fabrication.colours import Colours
from geoweave.fabrication.glb import ribbon_bodies
from geoweave.fabrication.viewer_payload import sideways_bend, viewer_content
from geoweave.weave import inspected

UP = (0.0, 0.0, 1.0)


def content(weave: dict, rest: dict | None = None, report: dict | None = None) -> dict:
    return viewer_content(weave, rest, report or {}, "x", Colours("paper"))


def test_a_circle_in_the_plane_bends_by_its_radius_to_the_left() -> None:
    angle = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    points = 40 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    weave = flat(1)
    weave["ribbons"] = [ribbon("A1", 0, points, UP, closed=True)]
    weave["crossings"] = []
    (body,) = ribbon_bodies(weave)
    # The mean over an arc of two widths of 8: sin(0.2) / 0.2 of the curvature.
    assert sideways_bend(body) == pytest.approx(np.sin(0.2) / 0.2 / 40, rel=0.01)


def test_what_follows_the_surface_does_not_bend_sideways() -> None:
    for weave in (flat(), circles()):
        for body in ribbon_bodies(weave):
            assert np.abs(sideways_bend(body)).max() * weave["width"] < 0.02


def test_numbers_are_those_of_the_weave() -> None:
    weave = cone().document()
    found = content(weave)
    assert found["width"] == pytest.approx(weave["width"])
    assert [each[0] for each in found["strips"]] == [each["label"] for each in weave["ribbons"]]
    (state,) = found["states"]
    steps = np.frombuffer(base64.b64decode(state["bend"]["steps"]), dtype="<i2")
    assert len(steps) == sum(state["shape"]["counts"])
    for here, there in zip(state["crossings"], weave["crossings"], strict=True):
        lengths = [weave["ribbons"][r]["length"] for r in there["ribbons"]]
        assert here[:2] == there["ribbons"]
        assert np.multiply(here[2:4], lengths) == pytest.approx(there["arclength"], abs=1e-3)
        assert here[4] == there["over_index"]
    assert json.loads(json.dumps(found, allow_nan=False)) == found


def test_crossings_at_rest_know_those_of_the_design() -> None:
    """Two crossings of the design that are held together once belong to the one at rest; none is lost."""
    weave = flat()
    pair = weave["crossings"][0]["ribbons"]
    twin = dict(weave["crossings"][0], arclength=[s + 1.0 for s in weave["crossings"][0]["arclength"]])
    weave["crossings"].append(twin)
    rest = json.loads(json.dumps(weave))
    del rest["crossings"][-1]
    rest["crossings"][0] |= {"ribbons": pair[::-1], "arclength": twin["arclength"][::-1]}
    for each, design in zip(rest["crossings"], weave["crossings"], strict=False):
        each["designed"] = (
            design["arclength"] if each["ribbons"] == design["ribbons"] else design["arclength"][::-1]
        )
    designed, rested = content(weave, rest)["states"]
    assert [each[6] for each in designed["crossings"]] == [[x] for x in range(len(weave["crossings"]))]
    assert rested["crossings"][0][6] == [0, len(weave["crossings"]) - 1]
    assert sorted(x for each in rested["crossings"] for x in each[6]) == list(range(len(weave["crossings"])))


def test_hard_places_go_with_their_ribbons() -> None:
    weave = cone().document()
    rest = json.loads(json.dumps(weave))
    for each in rest["ribbons"]:
        each["points"] = (np.array(each["points"]) + [0.0, 0.0, 50.0]).tolist()
    report = inspected(cone()).document()
    found = content(weave, rest, report)
    assert len(found["places"]) == len(report["places"]) > 0
    assert found["kinds"] == report["kinds"]
    for place, said in zip(found["places"], report["places"], strict=True):
        assert place["at"][0] == pytest.approx(said["point"], abs=1e-4)
        if place["ribbons"]:
            off = np.subtract(place["at"][1], said["point"])
            # A place of two ribbons is between them.
            assert np.linalg.norm(off - [0, 0, 50]) < 2 * weave["metrics"]["spacing"]
            assert [weave["ribbons"][r]["label"] for r in place["ribbons"]] == said["ribbons"]
        else:
            assert place["at"][1] == place["at"][0]


def test_forces_are_those_of_the_crossings_at_rest() -> None:
    weave = flat()
    rest = json.loads(json.dumps(weave))
    for x, each in enumerate(rest["crossings"]):
        each["force"] = {"separation": -3.0 * x, "sliding": 4.0 * x, "friction": None}
        each["fasten"] = x == 7
    designed, rested = content(weave, rest)["states"]
    assert rested["force"] == pytest.approx([5.0 * x for x in range(len(weave["crossings"]))])
    assert rested["fasten"] == [7]
    assert designed["force"] is None
