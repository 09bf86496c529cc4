"""Odd fields and functions: signs that can be gauged away change nothing, others change the topology."""

from __future__ import annotations

import numpy as np
import pytest

from geoweave.fields.face_field import FaceField, edge_curl, integrated_curl, random_field
from geoweave.fields.operators import (
    ClosedFields,
    as_real,
    connection_laplacian,
    curl,
    differences,
    dirichlet_energy,
    face_laplacian,
    gradient,
    harmonic_generators,
    sharp,
    transport_differences,
)
from geoweave.fields.singularities import vertex_indices
from geoweave.foliation.circle_function import CircleFunction
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh
from geoweave.surface.submesh import part_of
from geoweave.surface.twisted_mesh import TwistedMesh

SURFACES = {
    "torus": lambda: shapes.torus(faces=300),
    "genus 2": lambda: shapes.genus_g(2, faces=500),
    "annulus": lambda: shapes.annulus(faces=300),
    "one cell": lambda: shapes.schwarz_p(cells=1, faces=400),
    "two pieces": lambda: _beside(shapes.torus(faces=300), shapes.annulus(faces=200)),
}


def _beside(one: TriMesh, two: TriMesh) -> TriMesh:
    return TriMesh(
        np.concatenate([one.vertices, two.vertices + [4.0, 0.0, 0.0]]),
        np.concatenate([one.faces, two.faces + one.n_vertices]),
    )


def twisted(mesh: TriMesh, classes: list[int], seed: int = 0) -> TwistedMesh:
    """A mesh whose values change sign round the loops that the given generators count, modulo 2.

    Each face and each vertex has a random sign of its own on top, which changes nothing.
    """
    plain, _, _ = gauged(mesh, seed)
    form = harmonic_generators(mesh)[:, classes].sum(axis=1)
    crossed = 1.0 - 2.0 * (np.rint(form[mesh.face_edges]).astype(int) % 2)
    # from its first corner a face reaches the second along the edge opposite the third, and so on
    along = np.stack([np.ones(mesh.n_faces), crossed[:, 2], crossed[:, 1]], axis=1)
    return TwistedMesh(mesh.vertices, mesh.faces, signs=plain.signs * along)


def gauged(mesh: TriMesh, seed: int = 0) -> tuple[TwistedMesh, np.ndarray, np.ndarray]:
    """Signs that can be undone: one of the vertex times one of the face."""
    rng = np.random.default_rng(seed)
    of_vertex = np.where(rng.integers(0, 2, mesh.n_vertices), 1.0, -1.0)
    of_face = np.where(rng.integers(0, 2, mesh.n_faces), 1.0, -1.0)
    signs = of_vertex[mesh.faces] * of_face[:, None]
    return TwistedMesh(mesh.vertices, mesh.faces, signs=signs), of_vertex, of_face


def form_gauge(mesh: TriMesh, of_face: np.ndarray) -> np.ndarray:
    """A form's value on an edge is what the first face sees."""
    return of_face[mesh.edge_faces[:, 0]]


CASES = [
    ("torus", [0], 1),
    ("torus", [1], 1),
    ("torus", [0, 1], 1),
    ("genus 2", [0], 1),
    ("genus 2", [1, 2], 1),
    ("annulus", [0], 1),
    ("one cell", [0], 1),
    ("one cell", [1, 3, 4], 1),
    ("two pieces", [0], 1),
    ("two pieces", [2], 1),
    ("two pieces", [0, 2], 2),
]


@pytest.mark.parametrize(("name", "classes", "count"), CASES)
def test_closed_fields_are_all_that_have_no_curl(name, classes, count):
    """C B = 0, the columns of B are independent, and there are as many as the kernel of C has dimensions."""
    mesh = twisted(SURFACES[name](), classes)
    assert mesh.bundle.twisted_components.sum() == count
    fields = ClosedFields(mesh)
    operator, basis = curl(mesh).toarray(), fields.basis.toarray()
    assert np.abs(operator @ basis).max() < 1e-12
    assert fields.generators.shape[1] == mesh.bundle.betti_numbers.sum()
    kernel = 2 * mesh.n_faces - np.linalg.matrix_rank(operator)
    assert basis.shape[1] == kernel == np.linalg.matrix_rank(basis)


@pytest.mark.parametrize(("name", "classes", "count"), CASES)
def test_generators_sum_to_zero_round_every_face(name, classes, count):
    mesh = twisted(SURFACES[name](), classes)
    forms = harmonic_generators(mesh)
    values = np.stack([forms.toarray()[mesh.face_edges[:, k]] for k in range(3)], axis=1)
    np.testing.assert_array_equal((values * mesh.bundle.forms[:, :, None]).sum(axis=1), 0.0)
    np.testing.assert_allclose(curl(mesh) @ (sharp(mesh) @ forms).toarray(), 0.0, atol=1e-12)


@pytest.mark.parametrize("name", SURFACES)
def test_signs_that_can_be_undone_change_nothing(name):
    plain = SURFACES[name]()
    mesh, of_vertex, of_face = gauged(plain)
    assert not mesh.bundle.twisted_components.any()
    assert mesh.bundle.betti_numbers.sum() == plain.bundle.betti_numbers.sum()
    rng = np.random.default_rng(1)
    w = random_field(plain, 2)
    odd = FaceField(mesh, of_face * w.values)
    f = rng.normal(size=plain.n_vertices)
    on_edge = form_gauge(plain, of_face)
    np.testing.assert_allclose(differences(mesh) @ (of_vertex * f), on_edge * (differences(plain) @ f))
    np.testing.assert_allclose(
        gradient(mesh) @ (of_vertex * f), np.repeat(of_face, 2) * (gradient(plain) @ f), atol=1e-12
    )
    np.testing.assert_allclose(
        sharp(mesh) @ (on_edge * (differences(plain) @ f)), gradient(mesh) @ (of_vertex * f), atol=1e-12
    )
    inner = on_edge[plain.interior_edges]
    np.testing.assert_allclose(edge_curl(odd), inner * edge_curl(w), atol=1e-12)
    np.testing.assert_allclose(curl(mesh) @ as_real(odd.values), edge_curl(odd), atol=1e-12)
    np.testing.assert_allclose(integrated_curl(odd), of_face * integrated_curl(w), atol=1e-12)
    assert dirichlet_energy(mesh, odd.values) == pytest.approx(dirichlet_energy(plain, w.values))
    np.testing.assert_allclose(
        connection_laplacian(mesh) @ odd.values, of_face * (connection_laplacian(plain) @ w.values), atol=1e-9
    )
    np.testing.assert_array_equal(face_laplacian(mesh).toarray(), face_laplacian(plain).toarray())
    np.testing.assert_array_equal(vertex_indices(odd), vertex_indices(w))


@pytest.mark.parametrize(("name", "classes", "count"), CASES)
def test_operators_agree_with_one_another(name, classes, count):
    """d then sharp is the gradient, which has no curl; the Laplacian is that of the transported jumps."""
    mesh = twisted(SURFACES[name](), classes)
    np.testing.assert_allclose((sharp(mesh) @ differences(mesh) - gradient(mesh)).toarray(), 0.0, atol=1e-12)
    np.testing.assert_allclose((curl(mesh) @ gradient(mesh)).toarray(), 0.0, atol=1e-12)
    w = random_field(mesh, 3).values
    jumps = transport_differences(mesh) @ as_real(w)
    assert np.abs(curl(mesh) @ as_real(w) - edge_curl(FaceField(mesh, w))).max() < 1e-12
    assert len(jumps) == 2 * len(mesh.interior_edges)
    assert dirichlet_energy(mesh, w) == pytest.approx(
        float((w.conj() @ (connection_laplacian(mesh) @ w)).real)
    )


def test_a_circle_valued_function_is_odd():
    mesh = twisted(shapes.annulus(faces=300), [0])
    theta = np.random.default_rng(0).uniform(-3, 3, mesh.n_vertices)
    circle = CircleFunction.nearest(mesh, theta, np.zeros(mesh.n_edges))
    seen = theta[mesh.faces] * mesh.bundle.corners
    change = seen[:, [2, 0, 1]] - seen[:, [1, 2, 0]] - circle.corner_jumps
    np.testing.assert_allclose(np.sin(0.5 * change), 0.0, atol=1e-12)


def test_a_part_keeps_its_signs():
    mesh = twisted(shapes.torus(faces=300), [0])
    keep = np.arange(mesh.n_faces) % 50 > 0
    part = part_of(mesh, keep)
    assert isinstance(part.mesh, TwistedMesh)
    np.testing.assert_array_equal(part.mesh.signs, mesh.signs[keep])
