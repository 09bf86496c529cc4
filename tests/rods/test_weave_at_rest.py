"""A weave is slid and relaxed whole, and relaxed.json holds what a maker measures."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from geoweave.errors import RodError
from geoweave.models import shapes
from geoweave.rods.slid_weave import boundary_ends, elastic_rods, slide
from geoweave.rods.weave_at_rest import Relaxed, relax, relaxed_weave
from geoweave.weave.design import weave_pattern
from geoweave.weave.weave import Weave


@cache
def cone() -> Weave:
    """The cone of Appendix F, as near as the search comes to ten ribbons of the paper."""
    return weave_pattern(shapes.cone(faces=1500), ribbons=12).sized(100.0)


@cache
def relaxed() -> Relaxed:
    return relaxed_weave(cone())


def test_it_converges_near_its_surface() -> None:
    found = relaxed()
    metrics = found.metrics()
    assert found.converged
    assert metrics["converged"]
    assert 0 < metrics["mean"] <= metrics["rms"] <= metrics["hausdorff"] < 0.05
    assert metrics["hausdorff_held"] <= metrics["hausdorff"]
    assert metrics["energy_after"] < metrics["energy_before"]
    assert metrics["worst"]["ribbon"] in cone().names
    assert set(found.seconds) == {"slide", "relax", "departure"}


def test_sliding_releases_edgewise_bending() -> None:
    """Ribbons turn on edge and move; that their lines become straighter on the surface is not claimed."""
    first, last = relaxed().slid.steps[0].energies, relaxed().slid.energies
    assert last["geodesic curvature"] < 0.1 * first["geodesic curvature"]


def test_document_holds_the_weave_where_it_rests(tmp_path: Path) -> None:
    found, weave = relaxed(), cone()
    found.save(tmp_path / "relaxed.json")
    document = json.loads((tmp_path / "relaxed.json").read_text())
    assert document["format"] == "geoweave-weave"
    assert document["units"] == "mm"
    assert [each["label"] for each in document["ribbons"]] == weave.names
    assert len(document["crossings"]) == len(found.left.rods.contacts)
    unit = weave.placement.scale
    for ribbon in document["ribbons"]:
        points = np.array(ribbon["points"])
        chords = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
        # ribbons hardly stretch
        assert chords == pytest.approx(ribbon["length"], rel=1e-3)
        np.testing.assert_allclose(np.linalg.norm(ribbon["normals"], axis=1), 1.0)
        # the cone's own normals point outwards, and so do the ribbons'
        outward = points * [1.0, 1.0, 0.0] - [*(points[:, :2].mean(axis=0) * 0), 0.0]
        assert (np.array(ribbon["normals"])[:, :2] * outward[:, :2]).sum(axis=1).mean() > 0
    before = {each["id"]: each for each in weave.document()["crossings"]}
    shifts = []
    for crossing in document["crossings"]:
        assert crossing["over"] == crossing["ribbons"][crossing["over_index"]]
        lengths = [document["ribbons"][r]["length"] for r in crossing["ribbons"]]
        assert all(
            0 <= at <= length * (1 + 1e-9) for at, length in zip(crossing["arclength"], lengths, strict=True)
        )
        shifts.append(
            min(np.linalg.norm(np.subtract(each["point"], crossing["point"])) for each in before.values())
        )
    assert max(shifts) < 0.5 * weave.ribbons.spacing * unit
    over = {tuple(sorted(each["ribbons"])): each["over"] for each in before.values()}
    assert all(each["over"] == over[tuple(sorted(each["ribbons"]))] for each in document["crossings"])


def test_gravity_needs_something_to_stand_on() -> None:
    with pytest.raises(RodError, match="gravity"):
        relaxed_weave(cone(), gravity=(0.0, 0.0, -1.0), rounds=1)


def test_a_fixed_boundary_stays() -> None:
    weave = cone()
    rods = elastic_rods(weave).rods
    fixed = boundary_ends(weave, rods)
    assert 0 < fixed.sum() <= 2 * len(rods)
    found = relaxed_weave(weave, fixed_boundary=True, rounds=1)
    np.testing.assert_allclose(found.left.rods.points[fixed], rods.points[fixed], atol=1e-9)
    # what is held is measured where it is
    np.testing.assert_array_equal(found.departure.points, found.left.rods.points)
    assert not boundary_ends(weave_pattern(shapes.sphere(500), ribbons=8), rods).any()


def test_step_by_step_is_the_one_call() -> None:
    """What the README shows: rods, then sliding on the surface as it was given, then relaxing."""
    surface = shapes.cone(faces=400)
    weave = weave_pattern(surface, ribbons=8)
    by_steps = relax(slide(elastic_rods(weave), surface, rounds=1))
    at_once = relaxed_weave(weave, rounds=1)
    np.testing.assert_array_equal(by_steps.left.rods.points, at_once.left.rods.points)
    assert by_steps.departure.to_surface == at_once.departure.to_surface
    assert by_steps.seconds.keys() == at_once.seconds.keys()


def test_what_needs_a_fastener_is_listed_with_its_place_and_force() -> None:
    """Greatest need first; numbers of crossings, places and forces are those of relaxed.json."""
    found = relaxed()
    document, listed = found.document(), found.fasten()
    assert found.metrics()["forces"]["fasten"] == len(listed) > 0
    assert [each["id"] for each in document["crossings"]] == list(range(len(document["crossings"])))
    lacks = []
    for each in listed:
        crossing = document["crossings"][each["crossing"]]
        assert crossing["fasten"]
        assert each["point"] == pytest.approx(crossing["point"])
        assert each["ribbons"] == [found.weave.names[r] for r in crossing["ribbons"]]
        assert {name: each[name] for name in ("separation", "sliding", "friction")} == crossing["force"]
        assert each["friction"] is None or each["friction"] > 0.3
        lacks.append(each["sliding"] + 0.3 * each["separation"])
    assert lacks == pytest.approx(sorted(lacks, reverse=True), rel=1e-9)
    assert sum(each["fasten"] for each in document["crossings"]) == len(listed)
    assert len(found.fasten(100.0)) < len(listed)


def test_forces_scale_with_the_area() -> None:
    """The same weave twice as large: the forces for a Young's modulus of one are four times as large."""
    double = relaxed_weave(cone().sized(200.0))
    one, two = (each.document()["crossings"] for each in (relaxed(), double))
    first, second = (np.array([each["force"]["sliding"] for each in some]) for some in (one, two))
    np.testing.assert_allclose(second, 4 * first, rtol=1e-3, atol=1e-3 * second.max())
