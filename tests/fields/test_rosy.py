from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import spsolve
from surfaces import ALL, surface

from geoweave.errors import FieldError
from geoweave.fields.face_field import FaceField, edge_curl, total_curl
from geoweave.fields.operators import connection_laplacian, dirichlet_energy
from geoweave.fields.rosy import (
    RoSyField,
    diffused_field,
    smoothest_eigenfield,
    smoothest_field,
    smoothest_rosy,
)
from geoweave.fields.singularities import boundary_indices, singular_vertices, vertex_indices
from geoweave.models import catalogue, shapes
from geoweave.surface.mesh import TriMesh


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


@pytest.mark.parametrize("name", ["jagged sphere", "torus", "genus 5"])
def test_diffused_field_is_like_the_smoothest(name):
    """Section 4.1.3: Eq. 5 without the curl constraint gives fields "qualitatively similar" to the global
    optimum: as smooth, to 5 %, and with as many singularities. A random field has 40 times the energy, one
    step of the flow leaves twice the energy."""
    mesh = surface(name)
    field, smoothest = diffused_field(mesh), smoothest_field(mesh)
    np.testing.assert_allclose(field.norms, 1)
    least = dirichlet_energy(mesh, smoothest.values)
    assert dirichlet_energy(mesh, field.values) < 1.05 * least
    assert dirichlet_energy(mesh, diffused_field(mesh, iterations=1).values) > 1.5 * least
    assert len(singular_vertices(field)) == len(singular_vertices(smoothest))


def test_diffused_field_on_a_torus_is_the_smoothest_but_for_a_rotation():
    mesh = surface("torus")
    turn = diffused_field(mesh).values / smoothest_field(mesh).values
    np.testing.assert_allclose(turn, turn[0], atol=1e-3)


def test_diffused_field_stands_still():
    """One more step of the flow does not move it."""
    mesh, smoothness = surface("jagged sphere"), 0.3
    w = diffused_field(mesh, smoothness).values
    system = sparse.diags_array(mesh.face_areas) + smoothness * connection_laplacian(mesh)
    v = spsolve(system.tocsc(), mesh.face_areas * w)
    change = np.average(np.abs(v / np.abs(v) - w) ** 2, weights=mesh.face_areas)
    assert np.sqrt(change) < 2e-6  # the tolerance is 1e-6


def index_sum(rosy: RoSyField) -> int:
    return int(rosy.index_numerators.sum() + rosy.boundary_numerators.sum())


@pytest.mark.parametrize("degree", [2, 5, 6])
@pytest.mark.parametrize("name", ["jagged sphere", "two pieces", "Schwarz-P"])
def test_rosy_is_the_converged_smallest_eigenvector(name, degree):
    mesh = surface(name)
    mu, field = smoothest_eigenfield(mesh, 0, degree)
    laplacian = connection_laplacian(mesh, degree)
    residual = laplacian @ field.values - mu[mesh.face_components] * mesh.face_areas * field.values
    assert np.abs(residual).max() < 1e-9
    seeded = smoothest_rosy(mesh, degree, phase="seeded").values
    np.testing.assert_allclose(seeded, field.values / np.abs(field.values), atol=1e-12)
    turn = smoothest_rosy(mesh, degree).values * seeded.conj()
    for component in range(mesh.n_components):
        own = turn[mesh.face_components == component]
        np.testing.assert_allclose(own, own[0], atol=1e-6)


@pytest.mark.parametrize("degree", [2, 5, 6])
def test_rosy_eigenvalue_is_the_smallest_of_a_dense_solver(degree):
    mesh = shapes.torus(faces=300)
    root = 1 / np.sqrt(mesh.face_areas)
    dense = root[:, None] * connection_laplacian(mesh, degree).toarray() * root
    mu, _ = smoothest_eigenfield(mesh, 0, degree)
    assert mu[0] == pytest.approx(np.linalg.eigvalsh(dense)[0], abs=1e-9)


@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5, 6, 7])
@pytest.mark.parametrize("name", ALL)
def test_rosy_indices_sum_to_the_euler_characteristic(name, degree):
    """Hopf: the numerators sum to N chi, whatever the RoSy; a random one has hundreds of branch points."""
    mesh = surface(name)
    smooth = smoothest_rosy(mesh, degree)
    angle = np.random.default_rng(degree).uniform(0, 2 * np.pi, mesh.n_faces)
    for rosy in (smooth, RoSyField(mesh, degree, np.exp(1j * angle))):
        assert index_sum(rosy) == degree * mesh.euler_characteristic
        assert set(rosy.branch_points) <= set(np.flatnonzero(rosy.index_numerators))


def test_degree_one_is_a_vector_field():
    mesh = surface("Schwarz-P")
    rosy = smoothest_rosy(mesh, 1)
    field = FaceField(mesh, rosy.values)
    np.testing.assert_array_equal(rosy.index_numerators, vertex_indices(field))
    np.testing.assert_array_equal(rosy.boundary_numerators, boundary_indices(field))
    assert not len(rosy.branch_points)


def test_vectors_are_evenly_turned_roots():
    rosy = smoothest_rosy(surface("jagged sphere"), 5)
    np.testing.assert_allclose(rosy.vectors**5, np.repeat(rosy.values[:, None], 5, axis=1), atol=1e-12)
    np.testing.assert_allclose(rosy.vectors[:, 1:] / rosy.vectors[:, :-1], np.exp(2j * np.pi / 5), atol=1e-12)


@pytest.mark.parametrize("degree", [3, 4])
def test_matching_is_the_best_of_all_permutations(degree):
    """Section 5.1: the permutation that minimises the sum of squared angles between matched vectors."""
    mesh = surface("torus")
    angle = np.random.default_rng(0).uniform(0, 2 * np.pi, mesh.n_faces)
    rosy = RoSyField(mesh, degree, np.exp(1j * angle))
    i, j = mesh.edge_faces[mesh.interior_edges].T
    unfolded = mesh.transport[:, None] * rosy.vectors[i]

    def cost(permutation):
        return (np.angle(np.take_along_axis(rosy.vectors[j], permutation, 1) * unfolded.conj()) ** 2).sum(1)

    everyone = np.ones((len(i), 1), dtype=int)
    best = np.min([cost(everyone * np.array(p)) for p in permutations(range(degree))], axis=0)
    ours = cost((np.arange(degree) + rosy.matching[:, None]) % degree)
    np.testing.assert_allclose(ours, best, rtol=1e-9)


def test_matchings_compose_round_a_vertex_to_its_numerator():
    """Walking once round each vertex by hand, sheet 0 ends on the sheet that the index says."""
    rosy = smoothest_rosy(surface("jagged sphere"), 6)
    mesh = rosy.mesh
    shift = np.zeros(mesh.n_edges, dtype=int)
    shift[mesh.interior_edges] = rosy.matching
    for vertex in [*rosy.branch_points, *range(20)]:
        start = face = int(np.flatnonzero((mesh.faces == vertex).any(axis=1))[0])
        sheet = 0
        while True:
            # counter-clockwise: leave over the edge that ends in the vertex
            k = int(np.flatnonzero(mesh.faces[face] == vertex)[0])
            side = (k + 1) % 3
            edge = mesh.face_edges[face, side]
            forward = mesh.edge_faces[edge, 0] == face
            sheet += shift[edge] if forward else -shift[edge]
            face = int(mesh.face_neighbors[face, side])
            if face == start:
                break
        assert (sheet - rosy.index_numerators[vertex]) % 6 == 0
        assert (sheet % 6 != 0) == (vertex in rosy.branch_points)


@pytest.mark.parametrize("degree", [4, 5, 6])
def test_sphere_has_the_fewest_branch_points(degree):
    """Fig. 21: a smoothest N-RoSy of a sphere has 2 N of them, of index 1 / N: 8, 10 and 12."""
    for seed in range(3):
        rosy = smoothest_rosy(surface("sphere"), degree, seed)
        assert len(rosy.branch_points) == 2 * degree
        np.testing.assert_array_equal(rosy.index_numerators[rosy.branch_points], 1)


@pytest.mark.parametrize("faces", [20, 720])
def test_icosahedron_branches_at_its_corners(faces):
    mesh = shapes.icosahedron(faces)
    rosy = smoothest_rosy(mesh, 6)
    assert len(rosy.branch_points) == 12
    np.testing.assert_allclose(mesh.angle_defects[rosy.branch_points], np.pi / 3, atol=1e-9)
    mu, _ = smoothest_eigenfield(mesh, 0, 6)
    # parallel along every face: no energy at all
    assert abs(mu[0]) < 1e-9


def test_flat_surfaces_need_no_branch_points():
    assert not len(smoothest_rosy(surface("annulus"), 6).branch_points)


def test_bunny_rosy_sums_to_twelve_sixths():
    rosy = smoothest_rosy(catalogue.load("bunny"), 6)
    assert index_sum(rosy) == rosy.index_numerators.sum() == 12
    assert set(np.abs(rosy.index_numerators)) <= {0, 1, 2}


@pytest.mark.parametrize("bad", [0, -6])
def test_degrees_that_cannot_be_are_refused(bad):
    with pytest.raises(FieldError, match="N >= 1"):
        smoothest_rosy(surface("disk"), bad)
    with pytest.raises(FieldError, match="N >= 1"):
        RoSyField(surface("disk"), bad, np.ones(surface("disk").n_faces))


def test_values_that_are_no_rosy_are_refused():
    mesh = surface("disk")
    with pytest.raises(FieldError, match="one number per face"):
        RoSyField(mesh, 6, np.ones(3))
    with pytest.raises(FieldError, match="modulus 2, not 1"):
        RoSyField(mesh, 6, np.full(mesh.n_faces, 2.0))
