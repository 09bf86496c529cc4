"""What Section 4.2 promises of s and theta, on all shipped models and on those of the paper at hand."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from claims.test_section_4_1 import SHIPPED, _look_nearby, cases

from geoweave.fields.face_field import FaceField
from geoweave.fields.geodesic import INTEGRABLE_END, geodesic_field, sharpening_schedule
from geoweave.fields.rosy import smoothest_field
from geoweave.fields.singularities import singular_vertices
from geoweave.foliation.foliation import Foliation, foliate, punctured
from geoweave.foliation.integrability import integrating_factor
from geoweave.models import catalogue, shapes


@cache
def foliation(name: str) -> Foliation:
    """What ``geoweave foliate`` finds."""
    surface = catalogue.load(name)
    schedule = sharpening_schedule(surface, finest=INTEGRABLE_END)
    return foliate(geodesic_field(smoothest_field(surface), smoothness=schedule, phases=4).field)


@pytest.mark.parametrize("name", cases(*SHIPPED, "rocker-arm", "cow", "fertility"))
def test_s_is_positive_on_every_model(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Eq. 6: "s(p) > 0", before theta is known and after."""
    _look_nearby(monkeypatch)
    found = foliation(name)
    assert found.s.min() > 0
    assert integrating_factor(found.field).s.min() > 0


@pytest.mark.parametrize("name", cases("rocker-arm", "fertility"))
def test_level_sets_follow_the_field_within_two_degrees(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Section 4.2: "a theta whose isolines are well-aligned to a given input direction field"."""
    _look_nearby(monkeypatch)
    assert foliation(name).alignment.median <= 2.0


@pytest.mark.parametrize("name", ["bunny", "armadillo", "rocker-arm-like"])
def test_singular_vertices_and_their_faces_are_gone(name: str) -> None:
    """Section 4.2.2: "deleting from it all singular vertices and their neighboring faces"."""
    found = foliation(name)
    part = found.part
    surface = part.whole
    schedule = sharpening_schedule(surface, finest=INTEGRABLE_END)
    field = geodesic_field(smoothest_field(surface), smoothness=schedule, phases=4).field
    singular = np.zeros(surface.n_vertices, dtype=bool)
    singular[singular_vertices(field)] = True
    np.testing.assert_array_equal(part.kept, ~singular[surface.faces].any(axis=1))
    assert not len(singular_vertices(found.field))


@pytest.mark.parametrize("name", ["bunny", "spot", "schwarz-p"])
def test_at_most_half_a_period_on_nearly_all_edges(name: str) -> None:
    """Footnote 4: "at most half a period per edge"; here on nearly all of them at scale 1."""
    found = foliation(name)
    assert np.mean(np.abs(found.circle.jumps) <= np.pi) > 0.9


def test_a_unit_field_and_its_quarter_turn_are_not_both_curl_free_on_a_sphere() -> None:
    """Section 4.2.1: s = 1 would make w harmonic and of unit length, "impossible except on" flat surfaces."""
    ball = shapes.sphere(faces=5120)
    whole = FaceField.from_ambient(ball, np.cross(np.cross(ball.barycenters, [0, 0, 1.0]), ball.barycenters))
    field, part = punctured(whole.normalized())
    s = integrating_factor(field).s
    polar = np.linalg.norm(part.mesh.barycenters[:, :2], axis=1)
    # from the equator to 30 degrees off the pole 1 / sin doubles
    near, far = np.median(s[np.abs(polar - 0.5) < 0.05]), np.median(s[polar > 0.97])
    assert near / far == pytest.approx(2.0, rel=0.1)
