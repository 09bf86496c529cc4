from __future__ import annotations

import numpy as np
import pytest
from surfaces import ALL, CLOSED, surface

from geoweave.fields.face_field import FaceField, random_field
from geoweave.fields.rosy import smoothest_field
from geoweave.fields.singularities import (
    boundary_indices,
    circulation,
    index_sum,
    rotation_across,
    singular_vertices,
    vertex_indices,
)


def planar_field(mesh, power, turn=1.0):
    """The field ``turn * (x + iy)^power`` on a flat mesh: index ``power`` at the origin."""
    x, y, _ = mesh.barycenters.T
    w = turn * (x + 1j * y) ** power if power >= 0 else turn * ((x - 1j * y) ** -power)
    return FaceField.from_ambient(mesh, np.stack([w.real, w.imag, 0 * x], axis=1))


@pytest.mark.parametrize("name", ALL)
def test_indices_sum_to_the_euler_characteristic(name):
    mesh = surface(name)
    for field in (random_field(mesh, 0), smoothest_field(mesh)):
        assert index_sum(field) == mesh.euler_characteristic


@pytest.mark.parametrize("name", CLOSED)
def test_on_a_closed_surface_the_vertices_alone_sum_to_it(name):
    mesh = surface(name)
    assert vertex_indices(smoothest_field(mesh)).sum() == mesh.euler_characteristic
    assert len(boundary_indices(smoothest_field(mesh))) == 0


@pytest.mark.parametrize("power", [-2, -1, 1, 2])
def test_a_known_singularity_is_found_with_its_index(power):
    mesh = surface("disk")
    field = planar_field(mesh, power)
    # A zero of higher order may fall into several of lower order: the sum is what the mesh must keep.
    assert vertex_indices(field).sum() == power
    near = np.linalg.norm(mesh.vertices[singular_vertices(field)], axis=1)
    assert near.max() < 2.5 * mesh.mean_edge
    assert boundary_indices(field).tolist() == [1 - power]


def test_constant_and_radial_fields_have_none():
    disk, ring = surface("disk"), surface("annulus")
    assert not vertex_indices(planar_field(disk, 0)).any()
    assert boundary_indices(planar_field(disk, 0)).tolist() == [1]
    assert not vertex_indices(planar_field(ring, 1)).any()
    assert boundary_indices(planar_field(ring, 1)).tolist() == [0, 0]


def test_the_turn_changes_sign_with_the_field_seen_in_a_mirror():
    mesh = surface("disk")
    a, b = rotation_across(planar_field(mesh, 1)), rotation_across(planar_field(mesh, -1))
    np.testing.assert_allclose(a, -b, atol=1e-9)


def test_circulation_tells_a_vortex_from_a_source():
    mesh = surface("disk")
    center = singular_vertices(planar_field(mesh, 1))
    vortex = planar_field(mesh, 1, 1j).normalized()
    source = planar_field(mesh, 1).normalized()
    assert circulation(vortex, center) == pytest.approx(1, abs=0.05)
    assert circulation(source, center) == pytest.approx(0, abs=0.02)


@pytest.mark.parametrize("rings", [1, 2, 4])
def test_circulation_is_the_curl_inside_the_path(rings):
    """Stokes: for a gradient it is zero round any path; the field (-y, x) has 2 area / length."""
    mesh = surface("disk")
    middle = np.argsort(np.linalg.norm(mesh.vertices, axis=1))[:3]
    gradient = planar_field(mesh, 0)
    np.testing.assert_allclose(circulation(gradient, middle, rings=rings), 0, atol=1e-12)
    turning = circulation(planar_field(mesh, 1, 1j), middle, rings=rings)
    radius = rings * mesh.mean_edge
    # A hexagon has 2 area / length = 0.87 r; the faces' centres lie up to a third of an edge further in.
    expected = 0.87 * radius - mesh.mean_edge * np.sqrt(3) / 6
    np.testing.assert_allclose(turning, expected, rtol=0.15)
