"""A folder that is edited: the strips change as the edits say, and the report says what else did."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoweave.errors import FieldError, MeshError
from geoweave.meshing.write import write_mesh
from geoweave.models import shapes
from geoweave.pipeline.design import weave_file
from geoweave.pipeline.editing import differences, edit_folder
from geoweave.pipeline.request import WeaveRequest
from geoweave.pipeline.source import MeshSource
from geoweave.weave import Edits, Flip, Singularity, design_key

CONE = shapes.cone(faces=600)
REQUEST = WeaveRequest(ribbons=8, size=120.0, relax=False, formats=("json", "pattern"))


@pytest.fixture(scope="module")
def woven(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("edited")
    write_mesh(CONE, folder / "cone.obj")
    weave_file(MeshSource(str(folder / "cone.obj"), faces="given"), folder / "woven", REQUEST)
    return folder / "woven"


def document(folder: Path, name: str = "weave.json") -> dict[str, Any]:
    return json.loads((folder / name).read_text(encoding="utf-8"))


def test_dropped_and_flipped_in_the_strips(woven: Path, tmp_path: Path) -> None:
    before = document(woven)
    labels = [each["label"] for each in before["ribbons"]]
    x = next(x for x, each in enumerate(before["crossings"]) if 0 not in each["ribbons"])
    pair = before["crossings"][x]
    names = tuple(labels[r] for r in pair["ribbons"])
    edits = Edits(design_key(before), "mm", (labels[0],), (Flip(x, names, 1 - pair["over_index"]),))
    made = edit_folder(woven, edits, tmp_path / "one")
    strips = document(tmp_path / "one", "pattern.json")
    assert [each["label"] for each in strips["strips"]] == labels[1:]
    after = document(tmp_path / "one")
    there = next(each for each in after["crossings"] if np.allclose(each["point"], pair["point"]))
    assert after["ribbons"][there["over"]]["label"] == names[1 - pair["over_index"]]
    assert made.differs["ribbons"] == (len(labels), len(labels) - 1)
    assert made.differs["crossings"][0] > made.differs["crossings"][1]
    assert made.differs["total_length"][0] > made.differs["total_length"][1]
    assert made.made.verdict is not None
    first = {name: (tmp_path / "one" / name).read_bytes() for name in ("weave.json", "report.json")}
    # The folder says how it was made, and can be edited again.
    second = Edits(design_key(after), "mm", (labels[1],))
    again = edit_folder(tmp_path / "one", second)
    # The field was solved once: the design is beside the first change, and the second begins there.
    assert "field" in made.made.seconds
    assert "field" not in again.made.seconds
    assert again.made.files["design.npz"].is_file()
    assert [each["label"] for each in document(tmp_path / "one")["ribbons"]] == labels[2:]
    # Designed anew with both changes one after the other it is the same weave.
    (tmp_path / "two").mkdir()
    for name in ("weave.json", "report.json"):
        (tmp_path / "two" / name).write_bytes(first[name])
    edit_folder(tmp_path / "two", second)
    kept = document(tmp_path / "one")["metrics"]
    solved = document(tmp_path / "two")
    solved["metrics"] = {name: solved["metrics"][name] for name in kept}
    assert solved == document(tmp_path / "one")
    # But a weave of another design has other ribbons.
    third = Edits(design_key(document(tmp_path / "one")), "mm", align=((0.0, 0.0, 1.0),))
    with pytest.raises(FieldError, match="edit the weave as it was before that"):
        edit_folder(tmp_path / "one", third)


def test_a_branch_point_moves_and_a_family_follows(woven: Path, tmp_path: Path) -> None:
    before = document(woven)
    (tip,) = before["surface"]["singularities"]
    line = np.array(before["ribbons"][3]["points"])
    goal = line[len(line) // 2]
    edits = Edits(
        design_key(before),
        "mm",
        singularities=(Singularity(tuple(goal.tolist()), tip["index"]),),
        align=((0.0, 0.0, 1.0),),
    )
    made = edit_folder(woven, edits, tmp_path / "moved")
    (there,) = document(tmp_path / "moved")["surface"]["singularities"]
    assert there["index"] == tip["index"]
    # It goes to the nearest vertex.
    inside = CONE.vertices[~CONE.boundary_vertices] * 120.0 / np.ptp(CONE.vertices, axis=0).max()
    nearest = inside[np.linalg.norm(inside - goal, axis=1).argmin()]
    assert there["point"] == pytest.approx(nearest, abs=1e-6)
    assert np.linalg.norm(nearest - tip["point"]) > 10.0
    assert made.differs["aligned_deg"][0] is None
    assert made.document()["designed_anew"] is True


def test_what_cannot_be_is_refused(woven: Path, tmp_path: Path) -> None:
    with pytest.raises(FieldError, match="the edits are of another weave than that in"):
        edit_folder(woven, Edits("0" * 16, drop=("A1",)))
    with pytest.raises(FieldError, match=r"holds no weave.json"):
        edit_folder(tmp_path, Edits("0" * 16))
    key = design_key(document(woven))
    with pytest.raises(MeshError, match=r"none\.obj"):
        edit_folder(woven, Edits(key), tmp_path / "other", mesh=str(tmp_path / "none.obj"))
    (woven.parent / "bare").mkdir()
    (woven.parent / "bare" / "weave.json").write_bytes((woven / "weave.json").read_bytes())
    with pytest.raises(FieldError, match="does not say what it was made from"):
        edit_folder(woven.parent / "bare", Edits(key))


def test_differences_are_named_and_equal_numbers_are_not() -> None:
    one = {"ribbons": 8, "alternation": {"fraction": 1.0}, "verdict": {"word": "make it"}}
    other = {"ribbons": 7, "alternation": {"fraction": 1.0}}
    assert differences(one, other) == {"ribbons": (8, 7), "verdict.word": ("make it", None)}
