"""Sheets over one place: their corners, what is left of them in a part, and their places in one order."""

from __future__ import annotations

import numpy as np
import pytest
from eq8 import three_sheets

from geoweave.errors import FieldError
from geoweave.fields.triples import Triples
from geoweave.foliation.integrability import vertices_and_faces
from geoweave.surface.submesh import part_of


def test_corners_are_the_vertices_over_one_another() -> None:
    field, triples = three_sheets()
    mesh, below = field.mesh, field.mesh.n_vertices // 3
    vertices, signs, mass = triples.corners
    assert len(vertices) == below
    np.testing.assert_array_equal(vertices % below, np.repeat(vertices[:, :1] % below, 3, axis=1))
    np.testing.assert_array_equal(signs, 1.0)
    assert mass.sum() == pytest.approx(mesh.face_areas.sum() / 3)


def test_places_and_groups() -> None:
    field, triples = three_sheets()
    mesh = field.mesh
    assert np.bincount(triples.places).tolist() == [3] * ((mesh.n_vertices + mesh.n_faces) // 3)
    assert mesh.n_components == 3
    assert triples.groups.tolist() == [0, 0, 0]


def test_what_lies_over_one_place_is_eliminated_together() -> None:
    field, triples = three_sheets()
    order = vertices_and_faces(field.mesh, triples.places).order
    assert order is not None
    np.testing.assert_array_equal(np.sort(order), np.arange(field.mesh.n_vertices + field.mesh.n_faces))
    place = triples.places[order].reshape(-1, 3)
    np.testing.assert_array_equal(place, np.repeat(place[:, :1], 3, axis=1))


def test_a_part_keeps_the_triples_that_are_whole() -> None:
    field, triples = three_sheets()
    mesh = field.mesh
    keep = np.ones(mesh.n_faces, dtype=bool)
    keep[triples.faces[7, 1]] = False
    part = part_of(mesh, keep)
    left = triples.on(part)
    assert len(left.faces) == len(triples.faces) - 1
    np.testing.assert_array_equal(part.faces[left.faces], np.delete(triples.faces, 7, axis=0))


def test_bad_triples_are_refused() -> None:
    field, triples = three_sheets()
    with pytest.raises(FieldError, match=r"shape \(T, 3\)"):
        Triples(field.mesh, triples.faces[:, :2], triples.signs[:, :2], 2)
    with pytest.raises(FieldError, match="1 or 2 ribbons, not 3"):
        Triples(field.mesh, triples.faces, triples.signs, 3)
    other, _ = three_sheets(200)
    with pytest.raises(FieldError, match="not one of the surface"):
        triples.on(part_of(other.mesh, np.ones(other.mesh.n_faces, dtype=bool)))
