"""The integrating factor: exact where it is known, positive, independent of scale and of components."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import surface

import geoweave as gw
from geoweave.comparisons.paper_systems import algorithm_2_step, constrained_power_step
from geoweave.errors import FieldError
from geoweave.fields.face_field import FaceField, edge_curl
from geoweave.foliation.foliation import punctured
from geoweave.foliation.integrability import Method, integrating_factor, perpendicular
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh
from geoweave.surface.submesh import part_of

METHODS: tuple[Method, ...] = ("logarithm", "eigenvector")


def relative_error(mesh: TriMesh, s: np.ndarray, truth: np.ndarray) -> float:
    """L2 distance to the truth after the best multiple, as a share of the truth."""
    best = mesh.face_areas @ (s * truth) / (mesh.face_areas @ s**2)
    return float(np.sqrt(mesh.face_areas @ (best * s - truth) ** 2 / (mesh.face_areas @ truth**2)))


def radial(mesh: TriMesh) -> FaceField:
    """The field pointing away from the z axis."""
    return FaceField.from_ambient(mesh, mesh.barycenters * [1.0, 1.0, 0.0]).normalized()


@pytest.mark.parametrize("method", METHODS)
def test_a_constant_field_in_the_plane_needs_no_factor(method: Method) -> None:
    mesh = surface("disk")
    field = FaceField.from_ambient(mesh, np.tile([0.6, 0.8, 0.0], (mesh.n_faces, 1)))
    found = integrating_factor(field, method=method)
    np.testing.assert_allclose(found.s, 1.0, atol=1e-9)
    np.testing.assert_allclose(found.integrable, perpendicular(field), atol=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_rays_on_an_annulus_spread(method: Method) -> None:
    """theta is the angle, so s = 1 / r; the error falls with the mesh."""
    errors = []
    for faces in (1000, 4000):
        mesh = shapes.annulus(0.4, 1.0, faces=faces)
        s = integrating_factor(radial(mesh), method=method).s
        assert s.min() > 0
        errors.append(relative_error(mesh, s, 1.0 / np.linalg.norm(mesh.barycenters, axis=1)))
    assert errors[1] < 0.03  # 1 / r varies by 2.5; smoothing with mu costs a little
    assert errors[1] < errors[0]


@pytest.mark.parametrize("method", METHODS)
def test_circles_on_an_annulus_are_spaced_evenly(method: Method) -> None:
    """theta is a function of the radius, any function; the smoothest s is constant but for the facets."""
    mesh = shapes.annulus(0.4, 1.0, faces=3000)
    field = FaceField(mesh, 1j * radial(mesh).values)
    s = integrating_factor(field, method=method).s
    assert relative_error(mesh, s, np.ones(mesh.n_faces)) < 0.04


def test_great_circles_on_the_sphere() -> None:
    """s = 1 / sin of the polar angle, to 5 % in the L2 norm, and positive everywhere."""
    ball = shapes.sphere(faces=20_480)
    whole = FaceField.from_ambient(ball, np.cross(np.cross(ball.barycenters, [0, 0, 1.0]), ball.barycenters))
    field, part = punctured(whole.normalized())
    truth = 1.0 / np.linalg.norm(part.mesh.barycenters[:, :2], axis=1)
    found = integrating_factor(field)
    assert found.s.min() > 0
    assert relative_error(part.mesh, found.s, truth) < 0.05
    assert np.corrcoef(found.s, truth)[0, 1] > 0.99


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", ["torus", "genus 5", "Schwarz-P", "jagged sphere"])
def test_what_comes_out_is_integrable_normalised_and_lower(name: str, method: Method) -> None:
    field, part = punctured(gw.smoothest_field(surface(name)))
    found = integrating_factor(field, method=method)
    closed = FaceField(part.mesh, found.integrable)
    assert np.abs(edge_curl(closed)).max() < 1e-9 * np.abs(found.integrable).max()
    np.testing.assert_allclose(part.mesh.component_means(np.abs(found.s)), 1.0)
    assert found.energies[-1] <= found.energies[0]
    assert (np.diff(found.energies) <= 1e-12).all()
    if method == "logarithm":
        assert (found.s > 0).all()


def test_components_do_not_see_each_other() -> None:
    """Appendix C runs its eigenproblem component by component; from s = 1 all at once is the same."""
    mesh = surface("two pieces")
    field, part = punctured(gw.smoothest_field(mesh))
    for method in METHODS:
        together = integrating_factor(field, method=method, smoothness=1e-4, steps=4).s
        for number in range(part.mesh.n_components):
            alone = part_of(part.mesh, part.mesh.face_components == number)
            radius = part.mesh.bounding_radius / alone.mesh.bounding_radius
            mu = 1e-4 * radius**2
            w = FaceField(alone.mesh, field.values[alone.faces])
            s = integrating_factor(w, method=method, smoothness=mu, steps=4).s
            # the line search and its end are common to all components, so the last step may differ a little
            tolerance = 1e-8 if method == "eigenvector" else 0.02
            np.testing.assert_allclose(together[alone.faces], s, rtol=tolerance)


@pytest.mark.parametrize("method", METHODS)
def test_neither_size_nor_orientation_matters(method: Method) -> None:
    mesh = surface("genus 5")
    field = gw.smoothest_field(mesh)
    s = integrating_factor(field, method=method).s
    large = TriMesh(1e3 * mesh.vertices, mesh.faces)
    np.testing.assert_allclose(
        integrating_factor(FaceField(large, field.values), method=method).s, s, rtol=1e-6
    )
    np.testing.assert_allclose(
        integrating_factor(FaceField(mesh, -field.values), method=method).s, s, rtol=1e-6
    )


def test_eq_7_is_the_constrained_problem_of_appendix_c() -> None:
    """One step without the constraint in (x, s) is one step of the constrained one in (delta, s)."""
    field, _ = punctured(gw.smoothest_field(shapes.sphere(faces=320)))
    s = np.ones(field.mesh.n_faces)
    delta = integrating_factor(field, method="eigenvector", steps=0).integrable - perpendicular(field)
    mu = 1e-4 * field.mesh.bounding_radius**2
    for steps in (1, 2, 3):
        delta, s = constrained_power_step(field, delta, s, mu)
        found = integrating_factor(field, method="eigenvector", steps=steps)
        scale = float(found.s @ s / (s @ s))
        np.testing.assert_allclose(found.s, scale * s, atol=1e-8)
        np.testing.assert_allclose(
            found.integrable - found.s * perpendicular(field), scale * delta, atol=1e-8
        )


def test_solve_then_project_is_another_iteration() -> None:
    """Algorithm 2 as printed stays on the constraint but misses the minimiser on it."""
    field, _ = punctured(gw.smoothest_field(shapes.sphere(faces=320)))
    mesh, mu = field.mesh, 1e-4 * field.mesh.bounding_radius**2
    s = np.ones(mesh.n_faces)
    delta = integrating_factor(field, method="eigenvector", steps=0).integrable - perpendicular(field)
    ours, printed = (delta, s), (delta, s)
    for _ in range(10):
        ours = constrained_power_step(field, *ours, mu)
        printed = algorithm_2_step(field, *printed, mu)
    closed = FaceField(mesh, printed[0] + printed[1] * perpendicular(field))
    assert np.abs(edge_curl(closed)).max() < 1e-8 * np.abs(printed[1]).max()
    quotients = []
    for delta, s in (ours, printed):
        smooth = s @ (gw.fields.face_laplacian(mesh) @ s)
        size = mesh.face_areas @ np.abs(delta) ** 2
        quotients.append((size + mu * smooth) / (size + mesh.face_areas @ s**2))
    assert quotients[1] > 1.01 * quotients[0]


def test_what_is_out_of_range_is_refused() -> None:
    field = gw.smoothest_field(surface("disk"))
    with pytest.raises(FieldError, match="must be positive"):
        integrating_factor(field, smoothness=0.0)
    with pytest.raises(FieldError, match="no method"):
        integrating_factor(field, method="guess")  # type: ignore[arg-type]
