"""Objects of a stated material: scaling laws and order, on a small cone."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from geoweave.errors import RodError
from geoweave.fabrication import material_of
from geoweave.models import shapes
from geoweave.pipeline.object_rigidity import Rigidity, rigidity
from geoweave.rods.weave_at_rest import Relaxed, relaxed_weave
from geoweave.surface import TriMesh
from geoweave.weave.design import weave_pattern
from geoweave.weave.weave import Weave


@cache
def ball() -> Weave:
    return weave_pattern(shapes.sphere(faces=800), ribbons=12, phase="free").sized(100.0)


@cache
def rest() -> Relaxed:
    return relaxed_weave(ball())


@cache
def of_vellum() -> Rigidity:
    return rigidity(rest(), "vellum")


def test_twice_the_modulus_gives_half_the_way() -> None:
    sheet = material_of("vellum")
    twice = rigidity(rest(), sheet._replace(young=2 * sheet.young))
    assert twice.own_weight == pytest.approx(0.5 * of_vellum().own_weight, rel=1e-6)
    assert twice.under_load == pytest.approx(0.5 * of_vellum().under_load, rel=1e-6)
    assert twice.stiffness == pytest.approx([2 * k for k in of_vellum().stiffness], rel=1e-6)
    assert twice.grams == of_vellum().grams


def test_the_way_under_a_load_is_linear_in_it_and_that_under_the_own_weight_in_the_density() -> None:
    sheet = material_of("vellum")
    found = rigidity(rest(), sheet._replace(density=3 * sheet.density), load=0.5)
    assert found.own_weight == pytest.approx(3 * of_vellum().own_weight)
    assert found.grams == pytest.approx(3 * of_vellum().grams)
    assert found.under_load == pytest.approx(0.5 * of_vellum().under_load, rel=1e-6)


def test_an_object_twice_as_large_in_all_sizes_sinks_four_times_as_far() -> None:
    """Stiffness grows with the length, weight with its cube: the ways go with the square, under 1 N half."""
    sheet = material_of("vellum")
    weave = ball()
    large = replace(rest(), weave=weave.sized(200.0))
    found = rigidity(large, sheet._replace(thickness=2 * sheet.thickness))
    assert found.height == pytest.approx(2 * of_vellum().height)
    assert found.own_weight == pytest.approx(4 * of_vellum().own_weight, rel=1e-6)
    assert found.under_load == pytest.approx(0.5 * of_vellum().under_load, rel=1e-6)
    assert found.stiffness == pytest.approx(of_vellum().stiffness, rel=1e-6)


def test_weight_is_that_of_the_strips() -> None:
    sheet, rods, unit = material_of("vellum"), rest().left.rods, ball().placement.scale
    volume = (rods.widths * rods.rest).sum() * unit**2 * sheet.thickness  # mm3
    assert of_vellum().grams == pytest.approx(volume * sheet.density / 1000)


def test_veneer_is_more_rigid_than_vellum() -> None:
    wood = rigidity(rest(), "birch veneer")
    assert wood.under_load < 0.2 * of_vellum().under_load
    assert wood.stiffness[0] > 5 * of_vellum().stiffness[0]
    assert set(wood.worst) <= set(ball().names)
    assert wood.document()["load"] == 1.0


def test_what_the_friction_of_the_material_does_not_hold_is_counted() -> None:
    sheet = material_of("vellum")
    slippery, rough = (rigidity(rest(), sheet._replace(friction=mu)).fasten for mu in (0.0, 1e9))
    assert slippery >= of_vellum().fasten >= rough < slippery
    # Without friction every contact gives way; with any, those stay that nothing presses together.
    assert slippery == len(rest().left.rods.contacts)


def test_what_is_asked_of_no_object_is_refused() -> None:
    plain = relaxed_weave(weave_pattern(shapes.cone(faces=400), ribbons=8))
    with pytest.raises(RodError, match="not in mm"):
        rigidity(plain, "vellum")
    with pytest.raises(RodError, match="three finite numbers"):
        rigidity(rest(), "vellum", up=np.zeros(3))
    with pytest.raises(RodError, match=r"20 mm thick, and the ribbons are only .* mm wide"):
        rigidity(rest(), material_of("vellum")._replace(thickness=20.0))


def test_it_stands_as_the_guide_shows_it() -> None:
    """A cone whose axis is y: the axis that is up is found, and can be named."""
    cone = shapes.cone(faces=400)
    lying = TriMesh(cone.vertices[:, [1, 2, 0]], cone.faces)
    rest = relaxed_weave(weave_pattern(lying, ribbons=8, phase="free").sized(100.0))
    found, named, tipped = (rigidity(rest, "vellum", up=up) for up in (None, "y", "-x"))
    assert found == named == rigidity(rest, "vellum", up=(0.0, 2.0, 0.0))
    assert tipped.own_weight != pytest.approx(found.own_weight, rel=0.05)
