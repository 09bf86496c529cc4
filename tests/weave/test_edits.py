"""Changes of a weave: what is dropped is gone, what is flipped is flipped, and all else is as it was."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from laidflat import cone

from geoweave.curves import crossings
from geoweave.errors import FieldError
from geoweave.weave.edits import Edits, Flip, design_key, edited, read_edits
from geoweave.weave.interlacing import judged, optimal
from geoweave.weave.steering import Singularity, Steering
from geoweave.weave.validity import violations
from geoweave.weave.weave import Weave


def key() -> str:
    return design_key(cone().document())


def flip_of(x: int) -> Flip:
    weave = cone()
    one, other = (weave.names[r] for r in weave.passages.ribbons[x])
    return Flip(x, (one, other), 1 - int(weave.interlacing.over[x]))


# -- the key ------------------------------------------------------------------------------------------------


def test_the_key_is_that_of_the_design_whatever_its_size() -> None:
    one, other = cone().document(), cone().sized(size=300.0, width=5.0).document()
    assert design_key(one) == design_key(other)
    assert len(design_key(one)) == 16


def test_another_order_or_side_is_another_design() -> None:
    document = cone().document()
    for change in (
        lambda d: d["crossings"].pop(),
        lambda d: d["crossings"][0].update(over_index=1 - d["crossings"][0]["over_index"]),
        lambda d: d["ribbons"][0].update(label="Z9"),
    ):
        other = copy.deepcopy(document)
        change(other)
        assert design_key(other) != design_key(document)


# -- dropping and flipping ----------------------------------------------------------------------------------


@pytest.fixture
def dropped() -> Weave:
    weave = cone()
    return edited(weave, Edits(key(), drop=(weave.names[1], weave.names[4])))


def test_dropped_ribbons_are_gone_and_the_others_keep_names_and_places(dropped: Weave) -> None:
    before = {each["label"]: each for each in cone().document()["ribbons"]}
    gone = {cone().names[1], cone().names[4]}
    assert set(before) - set(dropped.names) == gone
    for each in dropped.document()["ribbons"]:
        old = before[each["label"]]
        assert each["points"] == old["points"]
        assert (each["family"], each["closed"]) == (old["family"], old["closed"])
        assert each["length"] == pytest.approx(old["length"])


def test_crossings_of_what_is_left_are_those_that_geometry_has(dropped: Weave) -> None:
    """Found anew among the ribbons that stay, and on the segments that the crossings name."""
    met, curves = dropped.ribbons.crossings, dropped.ribbons.curves
    anew = crossings(curves)
    there = {(*pair, *np.round(at, 6)) for pair, at in zip(anew.curves.tolist(), anew.arclength, strict=True)}
    for pair, at in zip(met.curves.tolist(), met.arclength, strict=True):
        assert (*pair, *np.round(at, 6)) in there
    for side in (0, 1):
        assert (
            np.searchsorted(curves.offsets, met.segments[:, side], "right") - 1 == met.curves[:, side]
        ).all()
    assert violations(dropped.ribbons, dropped.interlacing.over) == []


def test_over_and_under_are_as_good_as_can_be_and_change_little(dropped: Weave) -> None:
    best = optimal(dropped.passages)
    assert dropped.interlacing.alternation == best.alternation
    assert judged(dropped.passages, dropped.interlacing.over).broken.sum() == best.broken.sum()
    # The cone is symmetric: only their places in space tell its crossings apart.
    before, now = cone().document(), dropped.document()
    was = np.array([each["point"] for each in before["crossings"]])
    same = []
    for each in now["crossings"]:
        old = before["crossings"][int(np.linalg.norm(was - each["point"], axis=1).argmin())]
        same.append(before["ribbons"][old["over"]]["label"] == now["ribbons"][each["over"]]["label"])
    assert np.mean(same) >= 0.5


def test_a_flip_changes_one_side_and_is_counted() -> None:
    weave = cone()
    found = edited(weave, Edits(key(), flip=(flip_of(5),)))
    assert np.flatnonzero(found.interlacing.over != weave.interlacing.over).tolist() == [5]
    assert found.interlacing.alternation < weave.interlacing.alternation
    assert found.interlacing.alternation_bound == weave.interlacing.alternation_bound
    assert found.document()["crossings"][5]["over_index"] == flip_of(5).over
    # Flipped back it is the same weave.
    back = Edits(
        design_key(found.document()), flip=(flip_of(5)._replace(over=int(weave.interlacing.over[5])),)
    )
    assert design_key(edited(found, back).document()) == key()


def test_what_is_flipped_stays_so_when_over_and_under_are_chosen_anew() -> None:
    weave = cone()
    out = weave.names[0]
    kept = [x for x, pair in enumerate(weave.passages.ribbons) if 0 not in pair]
    for x in (kept[0], kept[-1]):
        found = edited(weave, Edits(key(), drop=(out,), flip=(flip_of(x),)))
        document, flip = found.document(), flip_of(x)
        at = weave.document()["crossings"][x]["point"]
        (there,) = [each for each in document["crossings"] if np.allclose(each["point"], at)]
        assert found.names[there["over"]] == flip.ribbons[flip.over]


def test_wrong_changes_are_refused() -> None:
    weave = cone()
    with pytest.raises(FieldError, match="of another weave"):
        edited(weave, Edits("0" * 16, drop=("A1",)))
    with pytest.raises(FieldError, match="no ribbon Q7"):
        edited(weave, Edits(key(), drop=("Q7",)))
    with pytest.raises(FieldError, match="no crossing 9999"):
        edited(weave, Edits(key(), flip=(Flip(9999, ("A1", "B1"), 0),)))
    with pytest.raises(FieldError, match="no crossing is left"):
        edited(weave, Edits(key(), drop=tuple(weave.names[1:])))
    with pytest.raises(FieldError, match="one after the other"):
        Edits(key(), drop=("A1",), align=((0.0, 0.0, 1.0),))


# -- the file -----------------------------------------------------------------------------------------------


def written(folder: Path, document: Any) -> Path:
    path = folder / "edits.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "edits",
    [
        Edits("k", "mm", ("A1", "B2"), (Flip(3, ("A1", "C4"), 1),)),
        Edits("k", singularities=(Singularity((0.0, 1.0, 2.0), -1),), align=((0.0, 0.0, 1.0),)),
    ],
)
def test_the_file_says_all_of_it(tmp_path: Path, edits: Edits) -> None:
    assert read_edits(written(tmp_path, edits.document())) == edits


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"format": "other"}, "holds no edits"),
        ({"version": 2}, "version is 2"),
        ({"drop": "A1"}, "drop is"),
        ({"flip": [{"crossing": 0, "ribbons": ["A1"], "over": 0}]}, r"flip\[0\].ribbons"),
        ({"flip": [{"crossing": 0, "ribbons": ["A1", "B1"], "over": 2}]}, r"flip\[0\].over"),
        ({"singularities": [{"point": [0, 1], "index": 1}]}, r"singularities\[0\].point"),
        ({"singularities": [{"point": [0, 1, 2], "index": 0.5}]}, r"singularities\[0\].index"),
        ({"align": [[0, 0]]}, "align is not a list"),
        ({"units": "inch"}, "units is"),
    ],
)
def test_a_slip_is_named(tmp_path: Path, change: dict[str, Any], said: str) -> None:
    with pytest.raises(FieldError, match=rf"^edits.json: {said}.*; save it again"):
        read_edits(written(tmp_path, Edits("k").document() | change))


def test_steering_is_in_the_coordinates_of_the_mesh() -> None:
    edits = Edits("k", "mm", singularities=(Singularity((20.0, 0.0, 10.0), 2),), align=((0.0, 30.0, 0.0),))
    asked = edits.steering(Steering(merge=1.0), 0.1)
    assert asked.singularities == (Singularity((2.0, 0.0, 1.0), 2),)
    assert asked.align == ((0.0, 3.0, 0.0),)
    assert asked.merge == 0.0
    assert Edits("k").steering(Steering(merge=1.0), 0.1) == Steering(merge=1.0)
