from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse
from surfaces import ALL, surface

from geoweave.fields import operators as op
from geoweave.fields.face_field import edge_curl, random_field
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh


def face_sums(mesh):
    """(F, E) sum of a 1-form around each face."""
    rows = np.repeat(np.arange(mesh.n_faces), 3)
    return sparse.csr_array(
        (mesh.face_edge_signs.ravel(), (rows, mesh.face_edges.ravel())), shape=(mesh.n_faces, mesh.n_edges)
    )


@pytest.mark.parametrize("name", ALL)
def test_gradient_of_a_linear_function_is_its_slope(name):
    mesh = surface(name)
    slope = np.array([0.3, -1.2, 0.7])
    field = op.as_complex(op.gradient(mesh) @ (mesh.vertices @ slope))
    np.testing.assert_allclose(field, mesh.planar(np.broadcast_to(slope, (mesh.n_faces, 3))), atol=1e-10)


@pytest.mark.parametrize("name", ALL)
def test_curl_of_gradient_is_zero_and_curl_agrees_with_the_jumps(name):
    mesh = surface(name)
    C, G = op.curl(mesh), op.gradient(mesh)
    assert C.shape == (len(mesh.interior_edges), 2 * mesh.n_faces)
    assert abs(C @ G).max() < 1e-12
    field = random_field(mesh, 2)
    np.testing.assert_allclose(C @ op.as_real(field.values), edge_curl(field), atol=1e-13)


@pytest.mark.parametrize("name", ALL)
def test_sharp_of_a_difference_is_the_gradient(name):
    mesh = surface(name)
    gap = op.sharp(mesh) @ op.differences(mesh) - op.gradient(mesh)
    assert abs(gap).max() < 1e-9 / mesh.edge_lengths.min()


@pytest.mark.parametrize("name", ALL)
def test_laplacians_are_symmetric_positive_semidefinite_and_kill_what_they_should(name):
    mesh = surface(name)
    L = op.face_laplacian(mesh)
    assert np.abs(L @ np.ones(mesh.n_faces)).max() < 1e-10
    K = op.connection_laplacian(mesh)
    assert abs(K - K.conj().T).max() < 1e-13
    rng = np.random.default_rng(0)
    for _ in range(5):
        s = rng.normal(size=mesh.n_faces)
        assert s @ L @ s > 0
        u = random_field(mesh, rng).values
        assert (u.conj() @ K @ u).real > 0


@pytest.mark.parametrize("name", ALL)
def test_dirichlet_energy_has_three_equal_forms(name):
    """|grad u|^2 of Appendix B: as a sum over edges, through L, and through real differences."""
    mesh = surface(name)
    u = random_field(mesh, 3).values
    energy = op.dirichlet_energy(mesh, u)
    assert (u.conj() @ op.connection_laplacian(mesh) @ u).real == pytest.approx(energy, rel=1e-12)
    jumps = op.transport_differences(mesh) @ op.as_real(u)
    assert np.repeat(op.dual_weights(mesh), 2) @ jumps**2 == pytest.approx(energy, rel=1e-12)


def test_connection_laplacian_of_a_power_acts_on_powers():
    """An N-RoSy w^N is parallel where w is: the operator of degree N kills what parallel transport makes."""
    mesh = surface("disk")
    constant = mesh.planar(np.broadcast_to([1.0, 0, 0], (mesh.n_faces, 3)))
    for degree in (1, 4, 6):
        residual = op.connection_laplacian(mesh, degree) @ constant**degree
        assert np.abs(residual).max() < 1e-11


@pytest.mark.parametrize("name", ALL)
def test_cotan_laplacian_is_gradient_mass_gradient(name):
    """L = G' M G against cotangents computed from the angles."""
    mesh = surface(name)
    G = op.gradient(mesh)
    L = G.T @ op.field_mass(mesh) @ G
    cotan = 0.5 / np.tan(mesh.corner_angles)
    weight = np.bincount(mesh.face_edges.ravel(), cotan.ravel(), mesh.n_edges)
    d = op.differences(mesh)
    assert abs(L - d.T @ sparse.diags_array(weight) @ d).max() < 1e-8 * abs(L).max()


def test_dual_weight_is_the_reciprocal_cotan_on_equilateral_triangles():
    mesh = surface("disk")
    weights = op.dual_weights(mesh)
    assert (weights > 0).all()
    from geoweave.surface.mesh import TriMesh

    h = np.sqrt(3) / 2
    pair = TriMesh(
        np.array([[0, 0, 0], [1, 0, 0], [0.5, h, 0], [0.5, -h, 0]]), np.array([[0, 1, 2], [1, 0, 3]])
    )
    cotan = 2 * 0.5 / np.tan(np.pi / 3)
    assert op.dual_weights(pair) == pytest.approx(1 / cotan)


@pytest.mark.parametrize("name", ALL)
def test_generators_are_closed_independent_and_not_exact(name):
    mesh = surface(name)
    forms = op.harmonic_generators(mesh)
    assert forms.shape == (mesh.n_edges, mesh.bundle.betti_numbers.sum())
    if not forms.shape[1]:
        assert name in ("sphere", "jagged sphere", "disk")
        return
    assert set(np.unique(forms.data)) <= {-1.0, 1.0}
    assert abs(face_sums(mesh) @ forms).max() == 0
    d = op.differences(mesh)
    together = sparse.hstack([d[:, op.ClosedFields(mesh).free_vertices], forms])
    # Independent columns have a definite Gram matrix; its entries are small integers, so this is exact.
    gram = (together.T @ together).toarray()
    assert np.linalg.eigvalsh(gram)[0] > 1e-6


@pytest.mark.parametrize("name", ALL)
def test_closed_fields_span_the_kernel_of_the_curl(name):
    """B has as many independent columns as the kernel of C has dimensions, and C B = 0."""
    mesh = surface(name)
    fields = op.ClosedFields(mesh)
    C = op.curl(mesh)
    assert abs(C @ fields.basis).max() < 1e-12
    bounded = np.unique(mesh.vertex_components[mesh.boundary_vertices]).size
    rank_of_curl = len(mesh.interior_edges) - (mesh.n_components - bounded)
    assert fields.basis.shape[1] == 2 * mesh.n_faces - rank_of_curl


def test_rank_of_the_curl_is_what_the_count_assumes():
    for name, mesh in (("disk", shapes.disk(faces=200)), ("sphere", shapes.sphere(faces=320))):
        rank = np.linalg.matrix_rank(op.curl(mesh).toarray())
        assert rank == len(mesh.interior_edges) - (name == "sphere")


@pytest.mark.parametrize("name", ["torus", "annulus", "two pieces"])
def test_reduced_matrices_are_the_quadratic_forms(name):
    mesh = surface(name)
    fields = op.ClosedFields(mesh)
    x = np.random.default_rng(1).normal(size=fields.basis.shape[1])
    v = op.as_complex(fields.basis @ x)
    assert x @ (fields.mass @ x) == pytest.approx(mesh.face_areas @ np.abs(v) ** 2, rel=1e-10)
    assert x @ (fields.smoothness @ x) == pytest.approx(op.dirichlet_energy(mesh, v), rel=1e-10)


@pytest.mark.parametrize("name", ["jagged sphere", "Schwarz-P"])
def test_all_fields_carry_the_same_forms_without_a_basis(name):
    mesh = surface(name)
    fields = op.AllFields(mesh)
    values = random_field(mesh, 4).values
    x = op.as_real(values)
    np.testing.assert_array_equal(fields.basis @ x, x)
    np.testing.assert_array_equal(fields.basis_transposed @ x, x)
    assert x @ fields.mass @ x == pytest.approx(mesh.face_areas.sum())
    assert x @ fields.smoothness @ x == pytest.approx(op.dirichlet_energy(mesh, values))


def test_a_single_triangle_has_operators_of_real_numbers():
    """Without an interior edge there is nothing to sum, and the sums are zeros that are no integers."""
    mesh = TriMesh([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    for operator in (op.connection_laplacian(mesh), op.face_laplacian(mesh)):
        assert operator.shape == (1, 1)
        assert operator.dtype.kind in "fc"
        assert abs(operator).sum() == 0
