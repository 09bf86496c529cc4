"""The report says which axis is up and why, and every later command keeps to it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from laidflat import cone

from geoweave.errors import FieldError
from geoweave.fabrication.up_axes import AXES
from geoweave.models import shapes
from geoweave.pipeline.cut_request import CutRequest
from geoweave.pipeline.cutting import cut_folder
from geoweave.pipeline.design import weave_file
from geoweave.pipeline.request import WeaveRequest
from geoweave.pipeline.showing import show_folder
from geoweave.pipeline.source import MeshSource
from geoweave.pipeline.up_in_report import found_up, said_up
from geoweave.pipeline.weave_folder import earlier_report, write_weave


def page_up(path: Path) -> str:
    found = re.search(r'id="content" type="application/json">(.*?)</script>', path.read_text("utf-8"), re.S)
    assert found
    return AXES[json.loads(found[1])["up"]]


def test_asked_then_the_format_then_the_base() -> None:
    mesh = shapes.cone(faces=400)
    assert found_up(mesh, "cone.obj") == {"axis": "z", "by": "base"}
    assert found_up(mesh, "cone.GLB") == {"axis": "y", "by": "format"}
    assert found_up(mesh, "cone.glb", "-x") == {"axis": "-x", "by": "request"}
    with pytest.raises(FieldError, match="no axis 'up'"):
        found_up(mesh, "cone.obj", "up")
    with pytest.raises(FieldError, match="no axis"):
        WeaveRequest(up="w")
    with pytest.raises(FieldError, match="no axis"):
        CutRequest(up="w")


def test_a_report_without_it_says_nothing() -> None:
    assert said_up({}) is None
    assert said_up({"up": {"axis": "-y"}}) == "-y"


def test_what_weave_is_told_holds_for_cut_and_show(tmp_path: Path) -> None:
    from geoweave.meshing import write_mesh

    write_mesh(shapes.cone(faces=300), tmp_path / "cone.obj")
    request = WeaveRequest(scale=0.5, relax=False, size=100.0, formats=("guide", "glb"), up="-x")
    folder = tmp_path / "woven"
    weave_file(MeshSource(str(tmp_path / "cone.obj"), faces=300), folder, request)
    assert earlier_report(folder)["up"] == {"axis": "-x", "by": "request"}
    assert page_up(folder / "guide.html") == "-x"
    assert page_up(show_folder(folder).path) == "-x"
    assert page_up(show_folder(folder, tmp_path / "page.html", up="y").path) == "y"
    cut_folder(folder, tmp_path / "same", CutRequest(formats=("guide",)))
    assert page_up(tmp_path / "same" / "guide.html") == "-x"
    cut_folder(folder, request=CutRequest(formats=("guide", "glb"), up="y"))
    assert earlier_report(folder)["up"] == {"axis": "y", "by": "request"}
    assert page_up(show_folder(folder).path) == page_up(folder / "guide.html") == "y"
    assert b'"rotation":[0.0,0.0,0.0,1.0]' in (folder / "weave.glb").read_bytes()


def test_a_weave_without_a_report_stands_on_its_base(tmp_path: Path) -> None:
    write_weave(cone(), tmp_path / "cone")
    assert page_up(show_folder(tmp_path / "cone").path) == "z"
