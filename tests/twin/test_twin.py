"""The object comes back from its pattern alone, and does not if the pattern is wrong."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import laidflat
import numpy as np
import pytest
from twinned import inner, pattern, twin, woven

from geoweave.errors import FieldError
from geoweave.fabrication.flattening import pattern_of
from geoweave.fabrication.pattern import Pattern
from geoweave.models import shapes
from geoweave.rods.weave_at_rest import relaxed_weave
from geoweave.rods.weave_file import read_weave, rods_of_document
from geoweave.twin.pattern_surface import surface_of
from geoweave.twin.twin import COMES_BACK, _least, assembled
from geoweave.weave.design import weave_pattern


@pytest.mark.parametrize("name", ["cone", "sphere", "torus"])
@pytest.mark.parametrize("state", ["designed", "relaxed"])
def test_the_object_comes_back(name: str, state: str) -> None:
    found = twin(name, state)
    like = found.compared(getattr(woven(name), state))
    assert like.missing == 0
    assert like.crossings.largest < COMES_BACK == 0.05
    assert like.comes_back
    assert like.crossings.mean <= like.crossings.rms <= like.crossings.largest
    assert like.ribbons.rms < 0.025
    # Tails are free, so that the shape as a whole may be off by more than the crossings.
    assert like.hausdorff < 0.09
    # The rods are nearly as long as they were cut.
    assert np.abs(found.rods.lengths / found.rods.rest - 1).max() < 0.01


@pytest.mark.parametrize("name", ["cone", "saddle"])
def test_of_two_tries_one_with_the_printed_side_out_is_taken(name: str) -> None:
    made = twin(name)
    image = made.rods.points * [1.0, 1.0, -1.0]
    inside_out = replace(made.rest, rods=replace(made.rods, points=image))
    tries, starts = (made.rest, inside_out), (made.start, made.start)
    assert _least(made.surface, starts, tries) == 0
    # A saddle has no outside, so that the energy alone decides, and then the order.
    assert _least(made.surface, starts, tries[::-1]) == (1 if name == "cone" else 0)


@pytest.mark.parametrize("name", ["cone", "sphere"])
def test_the_woven_object_comes_back_within_about_a_per_cent(name: str) -> None:
    """Of the weave at rest the twin knows all but where it was, so that only solving is between them."""
    like = twin(name).compared(woven(name).relaxed)
    assert like.crossings.largest < 0.011
    assert like.crossings.rms < 0.005


def test_an_object_of_curved_strips_comes_back_from_their_outlines() -> None:
    """Without their curvature the same strips make another shape."""
    weave = weave_pattern(shapes.torus(faces=1500), ribbons=20, phase="free").sized(200.0)
    rest = relaxed_weave(weave, strips="designed").document()
    exported = Pattern.from_document(pattern_of(rest).document())
    like = assembled(exported).compared(rest)
    assert like.crossings.mean < 0.0075
    assert like.crossings.largest < 0.03
    straight = replace(exported, strips=tuple(strip._replace(curvature=()) for strip in exported.strips))
    assert assembled(straight, anyway=True).compared(rest).crossings.largest > 2 * like.crossings.largest


@pytest.mark.parametrize("name", ["cone", "sphere"])
def test_a_mirrored_start_comes_back_too(name: str) -> None:
    found = twin(name, mirrored=True)
    assert found.outward > 0.5
    like = found.compared(woven(name).relaxed)
    assert like.crossings.largest < 0.011
    mirrored = json.loads(json.dumps(woven(name).relaxed))
    for each in (*mirrored["ribbons"], *mirrored["crossings"]):
        key = "points" if "points" in each else "point"
        each[key] = (np.array(each[key]) * [1.0, 1.0, -1.0]).tolist()
    # The fit turns and never reflects, so that a mirror image would be told.
    assert found.compared(mirrored).crossings.largest > 0.03


def test_a_saddle_has_two_mirror_images_and_one_is_woven() -> None:
    """Nothing in a pattern tells them apart: a saddle has no outside."""
    images = [twin("saddle", mirrored=mirrored) for mirrored in (False, True)]
    assert not any(found.side_known for found in images)
    off = sorted(found.compared(woven("saddle").relaxed).crossings.largest for found in images)
    assert off[0] < COMES_BACK
    assert off[1] > 0.1
    assert twin("cone").side_known
    assert twin("torus").side_known


def test_the_same_pattern_gives_the_same_twin() -> None:
    again = assembled(pattern("sphere"))
    assert np.array_equal(again.points, twin("sphere").points)


def test_the_twin_does_not_depend_on_where_the_weave_is() -> None:
    """No coordinate goes in: a weave moved elsewhere has the same pattern, to rounding."""
    q, _ = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))
    q *= np.sign(np.linalg.det(q))
    moved = json.loads(json.dumps(woven("cone").relaxed))
    for each in moved["ribbons"]:
        each["points"] = (np.array(each["points"]) @ q.T + [10.0, 20.0, 30.0]).tolist()
        each["normals"] = (np.array(each["normals"]) @ q.T).tolist()
    for each in moved["crossings"]:
        each["point"] = (np.array(each["point"]) @ q.T + [10.0, 20.0, 30.0]).tolist()
    assert pattern_of(moved).document() == pattern_of(woven("cone").relaxed).document()
    one, other = (twin("cone").compared(each) for each in (woven("cone").relaxed, moved))
    assert other.crossings.largest * other.diagonal == pytest.approx(one.crossings.largest * one.diagonal)


def test_a_wrong_sign_is_refused_by_name() -> None:
    sound = pattern("sphere")
    x = inner(surface_of(sound))[4]
    angle = sound.angle.copy()
    angle[x] *= -1
    wrong = replace(sound, angle=angle)
    with pytest.raises(FieldError, match=rf"contradicts itself: crossing {x} of .*; correct the place"):
        assembled(wrong)
    assert assembled(wrong, anyway=True).surface.genus == 1


def test_a_wrong_place_within_its_neighbours_shows_in_the_shape() -> None:
    """The order stays, so that the net is sound; the object is strained and departs where it is wrong."""
    sound = pattern("sphere")
    surface = surface_of(sound)
    forward = surface.edges[:, 0]
    here = int(forward[np.argmax(surface.stretch[forward])])
    x, side = divmod(here // 2, 2)
    at = sound.at.copy()
    at[x, side] += 0.8 * surface.stretch[here]
    wrong = assembled(replace(sound, at=at))
    assert not wrong.surface.tangled
    right, off = (each.compared(woven("sphere").relaxed) for each in (twin("sphere"), wrong))
    assert off.crossings.largest > 2 * right.crossings.largest
    assert wrong.rest.steps[-1].energy > 1.1 * twin("sphere").rest.steps[-1].energy


def test_pieces_are_refused() -> None:
    flat = laidflat.flat(each=3)
    both = laidflat.document(
        [*flat["ribbons"], *({**each, "label": "X" + each["label"]} for each in flat["ribbons"])],
        [
            *flat["crossings"],
            *({**each, "ribbons": [r + 9 for r in each["ribbons"]]} for each in flat["crossings"]),
        ],
    )
    with pytest.raises(FieldError, match="is in 2 pieces that no crossing holds together"):
        assembled(pattern_of(both))


def test_another_weave_is_not_compared_with() -> None:
    with pytest.raises(FieldError, match=r"other.json: has 10 ribbons where the pattern has"):
        twin("torus").compared(woven("cone").relaxed, "other.json")
    with pytest.raises(FieldError, match=r"weave.json: is not in mm"):
        twin("cone").compared(woven("cone").designed | {"units": "mesh"})


def test_the_document_is_a_weave(tmp_path: Path) -> None:
    found, target = twin("cone"), woven("cone").relaxed
    document = found.document(found.compared(target))
    path = tmp_path / "twin.json"
    path.write_text(json.dumps(document, allow_nan=False))
    again = read_weave(path)
    assert [each["label"] for each in again["ribbons"]] == [each["label"] for each in target["ribbons"]]
    assert set(again["crossings"][0]) >= {"id", "ribbons", "arclength", "point", "angle_deg", "over"}
    assert again["metrics"]["twin"]["topology"]["genus"] == 0
    # in the weave's own place
    there = np.array([each["point"] for each in again["crossings"]])
    here = np.array([each["point"] for each in target["crossings"]])
    assert np.linalg.norm(there - here, axis=1).max() < 0.01 * np.linalg.norm(np.ptp(here, axis=0))
    assert len(rods_of_document(again).rods) == len(found.pattern.strips)
    # and a pattern again: the lengths that went in, and the signs of the angles
    back = pattern_of(again)
    np.testing.assert_allclose(
        [strip.length for strip in back.strips], [strip.length for strip in found.pattern.strips], rtol=1e-2
    )
    assert np.array_equal(np.sign(back.angle), np.sign(found.pattern.angle))


def test_a_pattern_is_all_that_goes_in() -> None:
    """Its document holds no place in space (the tests' own patterns are written and read back)."""
    document = pattern_of(woven("cone").designed).document()
    assert Pattern.from_document(json.loads(json.dumps(document))).document() == document
    assert not {"points", "point", "normals"} & set(str(document).replace("'", " ").split())
