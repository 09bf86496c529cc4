from __future__ import annotations

import numpy as np
import pytest
from surfaces import ALL, surface

from geoweave.errors import FieldError
from geoweave.fields.face_field import (
    FaceField,
    Handles,
    edge_curl,
    integrated_curl,
    random_field,
    signed_curl,
    total_curl,
)
from geoweave.fields.operators import as_complex, gradient


@pytest.mark.parametrize("name", ALL)
def test_a_gradient_has_no_curl(name):
    mesh = surface(name)
    potential = np.random.default_rng(0).normal(size=mesh.n_vertices)
    field = FaceField(mesh, as_complex(gradient(mesh) @ potential))
    scale = field.norms.max() * mesh.edge_lengths.max()
    assert np.abs(edge_curl(field)).max() < 1e-13 * scale
    assert total_curl(field) < 1e-12 * scale * mesh.n_faces


def test_a_rotating_field_on_the_plane_has_curl_two():
    """w = (-y, x) has curl 2; Appendix B.1 measures it at three edge midpoints, so nearly 3 x 2 / 3."""
    mesh = surface("disk")
    x, y, _ = mesh.barycenters.T
    field = FaceField.from_ambient(mesh, np.stack([-y, x, 0 * x], axis=1))
    inside = (mesh.face_neighbors >= 0).all(axis=1)
    mean = np.average(signed_curl(field)[inside], weights=mesh.face_areas[inside])
    # The edge jumps of B.1 add up (w_j - w_i).e over three edges: twice the area-weighted curl.
    assert mean == pytest.approx(2 * 2, rel=0.03)


def test_curl_does_not_depend_on_the_frames_or_the_edge_direction():
    mesh = surface("jagged sphere")
    field = random_field(mesh, 1)
    ambient = field.ambient
    i, j = mesh.edge_faces[mesh.interior_edges].T
    expected = np.einsum("ex,ex->e", ambient[j] - ambient[i], mesh.edge_vectors[mesh.interior_edges])
    np.testing.assert_allclose(edge_curl(field), expected, atol=1e-12)
    np.testing.assert_allclose(integrated_curl(field) / mesh.face_areas, signed_curl(field))


def test_random_field_is_unit_and_seeded():
    mesh = surface("torus")
    np.testing.assert_allclose(random_field(mesh, 5).norms, 1)
    np.testing.assert_array_equal(random_field(mesh, 5).values, random_field(mesh, 5).values)
    assert np.abs(random_field(mesh, 5).values - random_field(mesh, 6).values).max() > 0.1


def test_normalized_keeps_directions_and_replaces_zero():
    mesh = surface("disk")
    values = np.full(mesh.n_faces, 3.0 + 4.0j)
    values[7] = 0
    unit = FaceField(mesh, values).normalized().values
    assert unit[7] == 1
    np.testing.assert_allclose(np.delete(unit, 7), 0.6 + 0.8j)


def test_fields_of_the_wrong_size_or_not_finite_are_refused():
    mesh = surface("disk")
    with pytest.raises(FieldError, match="one vector per face"):
        FaceField(mesh, np.ones(3, complex))
    values = np.ones(mesh.n_faces, complex)
    values[4] = np.nan
    with pytest.raises(FieldError, match="face 4"):
        FaceField(mesh, values)


def test_handles_refuse_what_they_cannot_mean():
    mesh = surface("disk")
    with pytest.raises(FieldError, match="not one of"):
        Handles.from_ambient(mesh, [mesh.n_faces], [[1, 0, 0]])
    with pytest.raises(FieldError, match="named twice"):
        Handles.from_ambient(mesh, [1, 1], [[1, 0, 0], [0, 1, 0]])
    with pytest.raises(FieldError, match="no direction in its plane"):
        Handles.from_ambient(mesh, [1], mesh.face_normals[[1]])
    with pytest.raises(FieldError, match="2 handle faces but 1"):
        Handles.from_ambient(mesh, [1, 2], [[1, 0, 0]])
    np.testing.assert_allclose(np.abs(Handles.from_ambient(mesh, [1, 2], np.eye(3)[:2]).values), 1)
