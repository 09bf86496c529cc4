"""A weave as it is to be made: size, unit, names."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from geoweave.errors import FieldError
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh
from geoweave.weave.cover import family_count
from geoweave.weave.design import weave_pattern
from geoweave.weave.weave import Weave, default_width, labels


@cache
def pattern() -> Weave:
    ring = shapes.torus(faces=1500)
    return weave_pattern(TriMesh(7.0 * ring.vertices + [1.0, 2.0, 3.0], ring.faces), scale=0.6)


def test_a_size_scales_everything_about_the_origin() -> None:
    given, made = pattern(), pattern().sized(350.0)
    factor = 350.0 / float(np.ptp(given.placement.undo(given.mesh.vertices), axis=0).max())
    corners = made.placement.undo(made.mesh.vertices)
    assert np.ptp(corners, axis=0).max() == pytest.approx(350.0)
    np.testing.assert_allclose(corners, factor * given.placement.undo(given.mesh.vertices))
    old, new = given.document(), made.document()
    assert (old["units"], new["units"]) == ("mesh", "mm")
    for key in ("width", "thickness"):
        assert new[key] == pytest.approx(factor * old[key])
    for one, two in zip(old["ribbons"], new["ribbons"], strict=True):
        assert two["length"] == pytest.approx(factor * one["length"])
        np.testing.assert_allclose(two["points"], factor * np.array(one["points"]))
        assert two["normals"] == one["normals"]
    for one, two in zip(old["crossings"], new["crossings"], strict=True):
        np.testing.assert_allclose(two["arclength"], factor * np.array(one["arclength"]))
        assert (two["angle_deg"], two["over"]) == (one["angle_deg"], one["over"])
    assert "metres" not in given.metrics()
    assert made.metrics()["metres"] == pytest.approx(sum(r["length"] for r in new["ribbons"]) / 1000)
    assert new["surface"]["area"] == pytest.approx(factor**2 * old["surface"]["area"])


def test_width_and_thickness_are_in_the_unit_of_the_output() -> None:
    made = pattern().sized(350.0, width=9.0, thickness=0.6).document()
    assert (made["width"], made["thickness"]) == (pytest.approx(9.0), pytest.approx(0.6))
    wide = pattern().sized(width=0.5).document()
    assert (wide["units"], wide["width"], wide["thickness"]) == (
        "mesh",
        pytest.approx(0.5),
        pytest.approx(0.025),
    )
    plain = pattern().document()
    assert plain["width"] == pytest.approx(0.3 * plain["metrics"]["spacing"])
    assert plain["thickness"] == pytest.approx(plain["width"] / 20)
    assert pattern().sized().document() == plain
    for name in ("size", "width", "thickness"):
        for bad in (0.0, -1.0, np.nan, np.inf):
            with pytest.raises(FieldError, match=f"the {name} of a weave must be a positive number"):
                pattern().sized(**{name: bad})


def test_families_and_the_width_that_fits_them() -> None:
    assert [family_count(n) for n in (3, 4, 5, 6)] == [3, 2, 5, 3]
    assert default_width(1.0, 6) == pytest.approx(0.3)
    assert default_width(2.0, 4) == pytest.approx(0.9)


def test_names() -> None:
    assert labels(np.array([0, 1, 0, 2])) == ["A1", "B1", "A2", "C1"]
    assert labels(np.array([25, 26, 51, 52, 701, 702])) == ["Z1", "AA1", "AZ1", "BA1", "ZZ1", "AAA1"]
    many = labels(np.arange(2000))
    assert len(set(many)) == 2000
    assert all(name[:-1].isascii() and name[:-1].isupper() and name[:-1].isalpha() for name in many)
