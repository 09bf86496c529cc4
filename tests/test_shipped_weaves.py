"""One click makes a valid weave of every model we ship, here at 1,500 triangles each (Schwarz-P: 3,000).

At their full size, and with scans out of packages, ``python -m benchmarks.scans`` weaves them.
"""

from __future__ import annotations

import numpy as np
import pytest

from geoweave.meshing.remesh import isotropic_remesh
from geoweave.models import datasets, shapes
from geoweave.models.catalogue import MODELS, load
from geoweave.surface.mesh import TriMesh
from geoweave.weave.design import weave_pattern
from geoweave.weave.validity import violations

FACES = {"schwarz-p": 3000}
"""Between its 24 openings fewer triangles leave no room for ribbons of three spacings."""

SMALL = {
    "bumpy-box": shapes.bumpy_box,
    "crown": lambda faces: shapes.crown(faces=faces),
    "genus-4": lambda faces: shapes.genus_g(4, faces=faces),
    "rocker-arm-like": shapes.rocker_arm,
    "vessel": shapes.vessel,
}
"""Those that take long to build at their full size."""


def small(name: str) -> TriMesh:
    faces = FACES.get(name, 1500)
    return SMALL[name](faces) if name in SMALL else isotropic_remesh(load(name), faces)


@pytest.mark.parametrize("name", MODELS)
def test_every_model_is_woven(name: str) -> None:
    if name in datasets.names() and not datasets.available(name):
        pytest.skip(f"{name} is not shipped, and not on this machine")
    weave = weave_pattern(small(name))
    assert violations(weave.ribbons, weave.interlacing.over) == []
    assert not weave.ribbons.loose.any()
    assert len(weave.ribbons.crossings) >= len(weave.ribbons) >= 4
    assert set(weave.families.tolist()) == {0, 1, 2}
    assert np.median(weave.crossing_angles) == pytest.approx(60, abs=6)
