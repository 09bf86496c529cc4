"""A design that is read back is the design that was written, number by number."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from laidflat import cone

from geoweave.errors import FieldError
from geoweave.pipeline.design_file import design_job, read_design
from geoweave.weave import Edits, Weave, design_key, edited

OF_THE_FOLIATION = ("deviation_deg", "dislocations")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    design_job(cone())(tmp_path / "design.npz")
    return tmp_path / "design.npz"


def said(weave: Weave) -> dict[str, Any]:
    """The document without what only a foliation knows."""
    document = weave.document()
    document["metrics"] = {k: v for k, v in document["metrics"].items() if k not in OF_THE_FOLIATION}
    return document


def test_what_is_written_is_read_back(file: Path) -> None:
    weave, again = cone(), read_design(file)
    assert said(again) == said(weave)
    for part in ("curves", "crossings"):
        one, other = getattr(weave.ribbons, part), getattr(again.ribbons, part)
        for each in fields(one):
            if each.name != "mesh":
                assert np.array_equal(getattr(one, each.name), getattr(other, each.name)), each.name
    assert np.array_equal(again.mesh.vertices, weave.mesh.vertices)
    assert again.ribbons.cutting == weave.ribbons.cutting
    assert again.interlacing.proven == weave.interlacing.proven
    assert said(again.sized(200.0, 5.0)) == said(weave.sized(200.0, 5.0))


def test_edits_of_it_are_those_of_the_design_and_are_kept_with_their_names(file: Path) -> None:
    weave = cone()
    edits = Edits(design_key(weave.document()), drop=(weave.names[2],))
    less = edited(read_design(file), edits)
    assert said(less) == said(edited(weave, edits))
    design_job(less)(file)
    assert read_design(file).names == less.names


def test_the_same_weave_gives_the_same_bytes(file: Path, tmp_path: Path) -> None:
    design_job(cone())(tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == file.read_bytes()


def test_what_is_no_design_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "design.npz"
    for write in (
        lambda: file.write_bytes(b"no archive"),
        lambda: np.savez(file, vertices=np.zeros((3, 3))),
        lambda: np.savez(file, about=np.array('{"format": "other", "version": 1}')),
    ):
        write()
        with pytest.raises(FieldError, match=r"^design.npz: holds no design .*; delete it"):
            read_design(file)
