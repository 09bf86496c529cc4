from __future__ import annotations

import numpy as np
import pytest
from surfaces import ALL, surface

from geoweave.fields import FaceField, edge_curl, total_curl
from geoweave.mesh import TriMesh
from geoweave.operators import connection_laplacian, dirichlet_energy
from geoweave.rosy import diffused_field, smoothest_eigenfield, smoothest_field
from geoweave.singularities import singular_vertices, vertex_indices


@pytest.mark.parametrize("name", ALL)
def test_eigenfield_is_converged(name):
    mesh = surface(name)
    mu, field = smoothest_eigenfield(mesh)
    assert len(mu) == mesh.n_components
    residual = (
        connection_laplacian(mesh) @ field.values - mu[mesh.face_components] * mesh.face_areas * field.values
    )
    assert np.abs(residual).max() < 1e-9


@pytest.mark.parametrize("name", ["sphere", "disk"])
def test_eigenvalue_is_the_smallest_of_a_dense_solver(name):
    mesh = surface(name)
    root = 1 / np.sqrt(mesh.face_areas)
    dense = root[:, None] * connection_laplacian(mesh).toarray() * root
    mu, _ = smoothest_eigenfield(mesh)
    assert mu[0] == pytest.approx(np.linalg.eigvalsh(dense)[0], abs=1e-9)


def test_flat_surfaces_get_the_constant_field():
    mesh = surface("disk")
    field = smoothest_field(mesh)
    ambient = field.ambient
    np.testing.assert_allclose(ambient, np.broadcast_to(ambient[0], ambient.shape), atol=1e-7)


def test_sphere_gets_two_singularities_of_index_one():
    """The smoothest fields of a sphere are a whole family, with two zeros anywhere: never more."""
    for seed in range(3):
        field = smoothest_field(surface("sphere"), seed)
        indices = vertex_indices(field)
        assert indices[singular_vertices(field)].tolist() == [1, 1]


def test_phase_is_free_for_the_energy_and_chosen_by_the_curl():
    mesh = surface("genus 5")
    seeded = smoothest_field(mesh, 3, phase="seeded")
    best = smoothest_field(mesh, 3)
    turned = [FaceField(mesh, best.values * np.exp(1j * a)) for a in np.linspace(0, np.pi, 40)]
    energies = [dirichlet_energy(mesh, field.values) for field in (*turned, seeded)]
    np.testing.assert_allclose(energies, energies[0], rtol=1e-7)
    least = np.sum(edge_curl(best) ** 2)
    assert least <= min(np.sum(edge_curl(field) ** 2) for field in (*turned, seeded)) * (1 + 1e-12)


def test_least_curl_does_not_depend_on_the_seed():
    mesh = surface("jagged sphere")
    curls = [total_curl(smoothest_field(mesh, seed)) for seed in range(3)]
    np.testing.assert_allclose(curls, curls[0], rtol=1e-6)


def test_seed_repeats_and_changes():
    mesh = surface("torus")
    a, b, c = (smoothest_field(mesh, seed, phase="seeded").values for seed in (1, 1, 2))
    np.testing.assert_array_equal(a, b)
    assert np.abs(a - c).max() > 1e-3


def test_each_component_has_a_field_of_its_own():
    mesh = surface("two pieces")
    field = smoothest_field(mesh)
    np.testing.assert_allclose(field.norms, 1)
    disk = mesh.face_components == mesh.face_components[-1]
    ambient = field.ambient[disk]
    np.testing.assert_allclose(ambient, np.broadcast_to(ambient[0], ambient.shape), atol=1e-7)


@pytest.mark.parametrize("factor", [1e-9, 1e9])
def test_scale_does_not_matter(factor):
    mesh = surface("jagged sphere")
    field = smoothest_field(TriMesh(mesh.vertices * factor, mesh.faces))
    np.testing.assert_allclose(field.values, smoothest_field(mesh).values, atol=1e-6)


def test_diffused_field_is_smooth_and_stands_still():
    """Table 1's start: Eq. 5 without the curl constraint, qualitatively like the global optimum."""
    mesh = surface("jagged sphere")
    field = diffused_field(mesh)
    np.testing.assert_allclose(field.norms, 1)
    smoothest = dirichlet_energy(mesh, smoothest_field(mesh).values)
    assert dirichlet_energy(mesh, field.values) < 1.5 * smoothest
    again = diffused_field(mesh, iterations=2000)
    np.testing.assert_allclose(again.values, field.values, atol=1e-3)
