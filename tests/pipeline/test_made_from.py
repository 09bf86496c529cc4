"""A report says what its weave was made from, and that is read back as it was."""

from __future__ import annotations

import json

import pytest

from geoweave.errors import FieldError
from geoweave.pipeline.made_from import made_from, read_made_from
from geoweave.pipeline.request import WeaveRequest
from geoweave.pipeline.source import MeshSource
from geoweave.weave import Edits, Flip, Singularity

REQUESTS = {
    "plain": WeaveRequest(),
    "all": WeaveRequest(
        symmetry=6,
        phase="free",
        ribbons=40,
        size=300.0,
        width=5.0,
        thickness=0.4,
        formats=("json", "pattern"),
        relax=True,
        strips="optimal",
        singularities=(Singularity((0.0, 1.0, 2.0), 1),),
        align=((0.0, 0.0, 1.0),),
        merge=1.5,
        edits=(Edits("k", "mm", ("A1",), (Flip(3, ("A2", "B1"), 1),)),),
    ),
}


@pytest.mark.parametrize("name", REQUESTS)
def test_what_is_written_is_read_back(name: str) -> None:
    source = MeshSource("bunny", faces=2000, seed=3, repair=True, components="largest")
    report = json.loads(json.dumps({"made_from": made_from(source, REQUESTS[name])}))
    assert read_made_from(report, "woven") == (source, REQUESTS[name])
    assert read_made_from(report, "woven", "other.obj")[0].name == "other.obj"


def test_what_is_not_said_or_wrong_is_refused() -> None:
    said = json.loads(json.dumps(made_from(MeshSource("bunny"), WeaveRequest())))
    with pytest.raises(FieldError, match=r"woven: its report.json does not say .* weave it again"):
        read_made_from({}, "woven")
    for change, what in (
        ({"seed": ...}, "lacks 'seed'"),
        ({"request": said["request"] | {"colour": 1}}, "no 'colour' to be asked for"),
        ({"request": said["request"] | {"size": -1}}, "size is -1"),
        ({"request": said["request"] | {"size": "x"}}, "must be real number|not supported"),
        ({"edits": [{"format": "other"}]}, "format is"),
    ):
        other = {key: value for key, value in (said | change).items() if value is not ...}
        with pytest.raises(FieldError, match=f"woven: 'made_from' in its report.json: .*({what})"):
            read_made_from({"made_from": other}, "woven")
