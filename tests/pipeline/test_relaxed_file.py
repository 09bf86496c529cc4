"""The physics alone: rods of a file come to rest, and the file says so."""

import json
from pathlib import Path

import numpy as np
import pytest

from geoweave.files import OutputError
from geoweave.models import shapes
from geoweave.pipeline.relaxed_file import ELASTIC, relax_file
from geoweave.pipeline.weave_folder import write_weave
from geoweave.weave.design import weave_pattern


def test_numbers_are_those_of_the_rods_at_rest(tmp_path: Path) -> None:
    weave = weave_pattern(shapes.sphere(600), ribbons=10).sized(80.0)
    write_weave(weave, tmp_path / "woven")
    made = relax_file(tmp_path / "woven" / "weave.json", tmp_path / "rest")
    said = made.document()
    energies = made.rest.steps[-1].energies
    assert said["elastic_after"] == sum(energies[name] for name in ELASTIC)
    assert set(ELASTIC) < set(energies)
    assert said["energy_after"] < said["energy_before"]
    designed = json.loads((tmp_path / "woven" / "weave.json").read_text())
    corners = np.concatenate([ribbon["points"] for ribbon in designed["ribbons"]])
    # rods have fewer points than ribbons, so their box is a little smaller
    assert said["diagonal"] == pytest.approx(np.linalg.norm(np.ptp(corners, axis=0)), rel=0.02)
    assert json.loads((tmp_path / "rest" / "report.json").read_text())["relax"]["steps"] == said["steps"]
    write_weave(weave.sized(40.0), tmp_path / "other")
    with pytest.raises(OutputError, match="holds another weave"):
        relax_file(tmp_path / "woven" / "weave.json", tmp_path / "other")
