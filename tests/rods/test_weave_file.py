"""A weave.json is read back as the same rods, and what is wrong with one is said in one sentence."""

from __future__ import annotations

import copy
import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoweave.errors import WeaveFileError
from geoweave.models import shapes
from geoweave.rods.rods import Rods
from geoweave.rods.slid_weave import elastic_rods
from geoweave.rods.weave_at_rest import relaxed_weave
from geoweave.rods.weave_file import at_rest, read_weave, rods_of_document
from geoweave.weave.design import weave_pattern
from geoweave.weave.weave import Weave


@cache
def weave() -> Weave:
    return weave_pattern(shapes.sphere(600), ribbons=10).sized(80.0)


def document() -> dict[str, Any]:
    return copy.deepcopy(weave().document())


def test_rods_read_back_are_those_of_the_weave(tmp_path: Path) -> None:
    weave().save(tmp_path / "weave.json")
    back, center, scale = rods_of_document(read_weave(tmp_path / "weave.json"))
    made = elastic_rods(weave()).rods
    assert len(back) == len(made)
    np.testing.assert_array_equal(back.layout.closed, made.layout.closed)
    np.testing.assert_array_equal(back.layout.offsets, made.layout.offsets)
    unit = weave().placement.scale
    here, there = back.points * scale + center, weave().placement.undo(made.points)
    np.testing.assert_allclose(here, there, atol=1e-6 * scale)
    np.testing.assert_allclose(back.widths * scale, made.widths * unit)
    assert back.material.thickness * scale == pytest.approx(made.material.thickness * unit)
    np.testing.assert_allclose(back.directors, made.directors, atol=1e-5)
    np.testing.assert_array_equal(back.contacts.segments, made.contacts.segments)
    np.testing.assert_array_equal(back.contacts.over, made.contacts.over)


def test_a_weave_that_did_not_move_is_the_same_weave() -> None:
    rods, center, scale = rods_of_document(document())
    rested = at_rest(document(), rods, rods.points * scale + center, np.zeros_like(rods.points), scale)
    before = document()
    assert [each["label"] for each in rested["ribbons"]] == [each["label"] for each in before["ribbons"]]
    for now, then in zip(rested["ribbons"], before["ribbons"], strict=True):
        assert now["length"] == pytest.approx(then["length"], rel=0.02)  # chords
    points = np.array([each["point"] for each in before["crossings"]])
    for crossing in rested["crossings"]:
        away = np.linalg.norm(points - crossing["point"], axis=1)
        then = before["crossings"][int(np.argmin(away))]
        assert away.min() < 0.02 * 80.0
        assert sorted(crossing["ribbons"]) == sorted(then["ribbons"])
        assert crossing["over"] == then["over"]


def test_what_is_no_weave_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.json"
    for text, words in (
        ("{", "x.json: is not JSON"),
        ("[]", "x.json: is no JSON object"),
        ("{}", "x.json: is not a weave"),
        ('{"format": "geoweave-pattern"}', "x.json: is not a weave"),
        ('{"format": "geoweave-weave", "version": 9}', "version 9"),
    ):
        path.write_text(text)
        with pytest.raises(WeaveFileError, match=words):
            read_weave(path)
    with pytest.raises(WeaveFileError, match=r"y.json: cannot be read"):
        read_weave(tmp_path / "y.json")


def test_points_that_do_not_fit_the_length_are_refused_before_the_work(tmp_path: Path) -> None:
    """One coordinate out of place would cut its ribbon into millions of segments."""
    wrong = json.loads(json.dumps(document()))
    wrong["ribbons"][1]["points"][0][2] = 2147483648
    path = tmp_path / "far.json"
    path.write_text(json.dumps(wrong))
    with pytest.raises(WeaveFileError, match=r"far\.json: ribbons\[1\] is .* long by its length"):
        read_weave(path)


@pytest.mark.parametrize(
    ("spacing", "words"),
    [
        (0, "metrics.spacing is 0, not a finite number above 0"),
        (-1.0, "metrics.spacing is -1, not a finite number above 0"),
        (1e-9, "metrics.spacing is 1e-09, which would cut ribbons"),
    ],
)
def test_a_spacing_that_no_rod_has_is_refused_before_the_work(
    spacing: float, words: str, tmp_path: Path
) -> None:
    wrong = json.loads(json.dumps(document()))
    wrong["metrics"]["spacing"] = spacing
    path = tmp_path / "cut.json"
    path.write_text(json.dumps(wrong))
    with pytest.raises(WeaveFileError, match=rf"cut\.json: {words}"):
        read_weave(path)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda d: d.pop("width"), "its head: lacks 'width'"),
        (lambda d: d["ribbons"][2].pop("normals"), "ribbon 2: lacks 'normals'"),
        (lambda d: d["ribbons"][1].update(points=[[0, 0]]), "ribbon|dimensions"),
        (lambda d: d["crossings"][3].update(arclength=[1e6, 0]), "crossing 3: arc length 1e"),
        (lambda d: d["crossings"][0].update(ribbons=[0, 999]), "crossing 0"),
        (lambda d: d.update(thickness=0), "the weave: the thickness of the rods is 0"),
    ],
)
def test_a_slip_is_named(change: Any, words: str) -> None:
    wrong = json.loads(json.dumps(document()))
    change(wrong)
    with pytest.raises(WeaveFileError, match=words) as caught:
        rods_of_document(wrong, "mine.json")
    assert str(caught.value).startswith("mine.json: ")


def test_curved_strips_are_read_back_as_rods_of_that_curvature(tmp_path: Path) -> None:
    rest = relaxed_weave(weave(), strips="designed")
    rest.save(tmp_path / "relaxed.json")
    read = read_weave(tmp_path / "relaxed.json")
    assert all("curvature" in each for each in read["ribbons"])
    assert not any("curvature" in each for each in document()["ribbons"])
    again, cut = rods_of_document(read).rods, rest.left.rods
    # Segments may be others, but half of every strip turns as it did.
    for rods in (again, cut):
        assert len(rods) == len(weave().names)
    one, two = (half_turns(rods) for rods in (again, cut))
    assert np.abs(one).max() > 0.1
    np.testing.assert_allclose(one, two, atol=0.25 * np.abs(two).max())
    assert np.corrcoef(one, two)[0, 1] > 0.9


def half_turns(rods: Rods) -> Any:
    """By how much the first half of each strip turns, radians."""
    found = []
    for r in range(len(rods)):
        mine = np.flatnonzero(rods.layout.rod_of_segment[rods.layout.joints[:, 0]] == r)
        along = np.cumsum(rods.spans[mine])
        found.append(-2 * np.arctan(0.5 * rods.natural[mine][along < 0.5 * along[-1]]).sum())
    return np.array(found)


@pytest.mark.parametrize(
    ("curvature", "words"),
    [
        ([[0.0, 1e3]], r"ribbons\[1\].curvature is 1000 at its sharpest, where the edges .* cross"),
        ([[5.0, 0.0], [4.0, 0.0]], r"ribbons\[1\].curvature has places that do not increase"),
        ([[0.0]], r"ribbons\[1\].curvature\[0\] is a list of 1, not a list of 2"),
        ("left", r'ribbons\[1\].curvature is "left", not a list'),
    ],
)
def test_a_curvature_that_no_strip_has_is_refused(tmp_path: Path, curvature: Any, words: str) -> None:
    wrong = document()
    wrong["ribbons"][1]["curvature"] = curvature
    path = tmp_path / "x.json"
    path.write_text(json.dumps(wrong))
    with pytest.raises(WeaveFileError, match=words) as caught:
        read_weave(path)
    assert str(caught.value).startswith("x.json: ")
