"""A hoop has the length of its opening, and every ribbon that ends there meets it."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from laidflat import circles, cone

from geoweave.errors import FieldError
from geoweave.fabrication.flattening import pattern_of
from geoweave.fabrication.hoops import hoop_normals, hooped
from geoweave.fabrication.strip_layout import layout
from geoweave.models import shapes
from geoweave.rods.weave_at_rest import relaxed_weave
from geoweave.weave.design import weave_pattern
from geoweave.weave.ribbon_ends import on_boundary
from geoweave.weave.weave import Weave


def tube() -> Weave:
    """Radius 40 mm, 120 mm high, open at both ends."""
    return weave_pattern(shapes.cylinder(faces=600), ribbons=10).sized(size=120.0)


def rims(weave: Weave) -> list[float]:
    unit, points = weave.placement.scale, weave.mesh.vertices
    steps = [points[np.append(loop, loop[0])] for loop in weave.mesh.boundary_loops]
    return [float(np.linalg.norm(np.diff(each, axis=0), axis=1).sum()) * unit for each in steps]


@pytest.mark.parametrize("make", [cone, tube], ids=["cone", "tube"])
def test_a_hoop_for_every_opening(make: Callable[[], Weave]) -> None:
    weave, allowance = make(), 9.0
    document = hooped(weave.document(), None, allowance)["weave.json"]
    pattern = pattern_of(document)
    ribbons, hoops = pattern.strips[: len(weave.ribbons)], pattern.strips[len(weave.ribbons) :]
    assert [each.length for each in hoops] == pytest.approx(rims(weave), abs=1e-6)
    assert all(each.hoop and each.closed for each in hoops)
    assert not any(each.hoop for each in ribbons)
    ends = on_boundary(weave.ribbons.curves) & ~weave.ribbons.curves.closed[:, None]
    more = len(pattern.ribbons) - len(weave.ribbons.crossings)
    assert more == ends.sum() > 6
    # what a maker measures: the strip ends the allowance beyond the middle of the hoop, and nowhere else
    length = weave.document()["ribbons"]
    for r, strip in enumerate(ribbons):
        at = sorted(each.at for each in pattern.passages[r] if pattern.strips[each.partner].hoop)
        wanted = [allowance] * int(ends[r, 0]) + [strip.length - allowance] * int(ends[r, 1])
        assert at == pytest.approx(wanted, abs=1e-6)
        assert strip.length == pytest.approx(length[r]["length"] + allowance * ends[r].sum(), abs=1e-6)


@pytest.mark.parametrize("make", [cone, tube], ids=["cone", "tube"])
def test_a_ribbon_leaves_by_the_side_that_is_measured(make: Callable[[], Weave]) -> None:
    document = hooped(make().document(), None, 9.0)["weave.json"]
    drawn = [
        {key: value for key, value in each.items() if key != "turn_deg"} for each in document["crossings"]
    ]
    known, measured = pattern_of(document).angle, pattern_of({**document, "crossings": drawn}).angle
    more = np.array(["turn_deg" in each for each in document["crossings"]])
    assert (np.sign(known[more]) == np.sign(measured[more])).all()
    assert np.abs(known - measured).max() < 15  # the hoop stands upright, and the surface of a cone leans


def test_ribbons_alternate_up_to_the_hoop() -> None:
    document = hooped(cone().document(), None, 9.0)["weave.json"]
    pattern = pattern_of(document)
    for r, strip in enumerate(pattern.strips):
        met = pattern.passages[r]
        if not strip.hoop and len(met) > 1 and pattern.strips[met[-1].partner].hoop:
            assert met[-1].over != met[-2].over


def test_places_on_the_hoop_are_those_of_the_ends() -> None:
    weave = tube()
    document = hooped(weave.document(), None, 9.0)["weave.json"]
    for each in document["crossings"][len(weave.ribbons.crossings) :]:
        hoop = document["ribbons"][each["ribbons"][1]]
        line = np.array([*hoop["points"], hoop["points"][0]])
        at = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        there = [np.interp(each["arclength"][1], at, line[:, axis]) for axis in range(3)]
        assert there == pytest.approx(each["point"], abs=1e-6)


def test_at_rest_the_hoop_goes_through_the_ends() -> None:
    """And has the length that it has in the design."""
    weave = cone()
    both = hooped(weave.document(), relaxed_weave(weave).document(), 9.0)
    rest, hoop = both["relaxed.json"], both["relaxed.json"]["ribbons"][-1]
    assert hoop["length"] == both["weave.json"]["ribbons"][-1]["length"]
    line = np.array([*hoop["points"], hoop["points"][0]])
    for each in rest["crossings"][len(weave.ribbons.crossings) :]:
        off = min(_distance(one, other, np.array(each["point"])) for one, other in pairwise(line))
        assert off < 0.01 * hoop["length"] / (2 * np.pi)


def _distance(one: np.ndarray, other: np.ndarray, place: np.ndarray) -> float:
    way = other - one
    share = np.clip((place - one) @ way / (way @ way), 0.0, 1.0)
    return float(np.linalg.norm(one + share * way - place))


def test_a_hoop_stands_upright_on_a_cone() -> None:
    """A straight strip cannot bend within the surface, as the rim of a cone does; it leans instead."""
    pattern = pattern_of(hooped(cone().document(), None, 9.0)["weave.json"])
    hoop = pattern.strips[-1]
    assert hoop.bow < 1e-3 * hoop.length
    flat = np.array([[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]])
    up = np.tile([0.0, 0.0, 1.0], (4, 1))
    assert hoop_normals(flat, up).tolist() == up.tolist()


def test_hoops_are_laid_in_last() -> None:
    laid = layout(hooped(tube().document(), None, 9.0)["weave.json"])
    order = [laid.pattern.strips[each.strip].hoop for each in laid.order]
    assert order == sorted(order)
    assert sum(order) == 2


def test_refusals() -> None:
    document = cone().document()
    with pytest.raises(FieldError, match=r"do not reach its edge; give --hoops \d"):
        hooped(document, None, 0.5)
    with pytest.raises(FieldError, match="weave it again for hoops"):
        hooped(circles(), None, 9.0)
    closed = document | {"surface": {"openings": []}}
    with pytest.raises(FieldError, match="no opening"):
        hooped(closed, None, 9.0)
    away = [{"points": [[0, 0, 1e3], [1, 0, 1e3], [0, 1, 1e3]], "normals": [[0, 0, 1]] * 3}]
    with pytest.raises(FieldError, match="no ribbon ends"):
        hooped(document | {"surface": {"openings": away}}, None, 9.0)
