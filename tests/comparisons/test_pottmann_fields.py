from __future__ import annotations

import numpy as np
import pytest
from surfaces import ALL, CLOSED, surface

from geoweave.comparisons import field_baselines
from geoweave.comparisons.field_baselines import (
    anti_holomorphic_field,
    conformal_energy,
    fitted_curl,
    pottmann_field,
    sharpened_field,
    spectral_field,
)
from geoweave.curves.curves import geodesic_curvature
from geoweave.curves.tracing import streamlines
from geoweave.errors import FieldError
from geoweave.fields.face_field import FaceField, total_curl
from geoweave.fields.operators import as_real, field_mass, gradient
from geoweave.fields.rosy import smoothest_field
from geoweave.fields.singularities import index_sum
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh


def energy(form, values) -> float:
    return float((values.conj() @ (form @ values)).real)


def in_the_plane(mesh: TriMesh, function) -> np.ndarray:
    """Values of a field on a flat mesh, given as a function of z = x + iy."""
    frame = mesh.frames[:, 0, 0] + 1j * mesh.frames[:, 0, 1]
    z = mesh.barycenters[:, 0] + 1j * mesh.barycenters[:, 1]
    return function(z) / frame


# -- anti-holomorphic -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ALL)
def test_energy_is_linear_in_its_balance_and_never_negative(name):
    mesh = surface(name)
    low, middle, high = (conformal_energy(mesh, s) for s in (-1.0, 0.0, 1.0))
    assert abs(low + high - 2 * middle).max() < 1e-9
    assert abs(conformal_energy(mesh, 0.3) - 0.35 * low - 0.65 * high).max() < 1e-9
    assert abs(low - low.conj().T).max() < 1e-9
    rng = np.random.default_rng(0)
    for form in (low, high):
        values = rng.normal(size=mesh.n_faces) + 1j * rng.normal(size=mesh.n_faces)
        assert energy(form, values) > 0


def test_linear_fields_of_the_plane_have_their_exact_energy():
    """u = z has only du/dz = 1, and E_A = 2 |du/dz|^2 per area; its conjugate has none of it."""
    disk = surface("disk")
    holomorphic, conjugate = in_the_plane(disk, lambda z: z), in_the_plane(disk, np.conj)
    low, high = (conformal_energy(disk, s) for s in (-1.0, 1.0))
    total = 4 * disk.face_areas.sum()
    assert energy(low, holomorphic) == pytest.approx(total)
    assert energy(high, conjugate) == pytest.approx(total)
    assert abs(energy(low, conjugate)) < 1e-12 * total
    assert abs(energy(high, holomorphic)) < 1e-12 * total


def test_holomorphic_fields_of_the_plane_have_no_energy_in_the_limit():
    shares = []
    for faces in (500, 2000, 8000):
        disk = shapes.disk(faces=faces)
        low, middle, high = (conformal_energy(disk, s) for s in (-1.0, 0.0, 1.0))
        cubic = in_the_plane(disk, lambda z: z**3)
        shares.append(energy(high, cubic) / energy(middle, cubic))
        mirrored = energy(low, in_the_plane(disk, lambda z: z.conj() ** 3)) / energy(middle, cubic)
        assert mirrored == pytest.approx(shares[-1], rel=1e-6)
    # second order in the edge length: four times the faces, a quarter of the error
    assert shares[1] < 0.35 * shares[0]
    assert shares[2] < 0.35 * shares[1]
    assert shares[2] < 0.01


def linear_in_space(mesh: TriMesh, normals: np.ndarray, seed: int) -> np.ndarray:
    """A linear field of space, projected to the smooth surface with these normals, then to the faces."""
    rng = np.random.default_rng(seed)
    vectors = mesh.barycenters @ rng.normal(size=(3, 3)).T + rng.normal(size=3)
    return mesh.planar(vectors - np.einsum("fx,fx->f", vectors, normals)[:, None] * normals)


def round_surface(name: str, faces: int) -> tuple[TriMesh, np.ndarray]:
    """A sphere or a torus, and the normals of the smooth surface at its barycentres."""
    if name == "sphere":
        mesh = shapes.sphere(faces=faces)
        normals = mesh.barycenters
    else:
        mesh = shapes.torus(1.0, 0.4, faces=faces)
        spine = mesh.barycenters * [1, 1, 0]
        normals = mesh.barycenters - spine / np.linalg.norm(spine, axis=1, keepdims=True)
    return mesh, normals / np.linalg.norm(normals, axis=1, keepdims=True)


@pytest.mark.parametrize("name", ["sphere", "torus"])
def test_halves_differ_by_the_curvature(name):
    """E_A - E_H = integral K |u|^2 (Knöppel et al. 2013): here K comes from the angle defects."""
    mesh, normals = round_surface(name, 6000)
    vertex_areas = np.bincount(mesh.faces.ravel(), np.repeat(mesh.face_areas, 3)) / 3
    curvature = (mesh.angle_defects / vertex_areas)[mesh.faces].mean(axis=1)
    for seed in range(4):
        values = linear_in_space(mesh, normals, seed)
        low, high = (energy(conformal_energy(mesh, s), values) / 2 for s in (-1.0, 1.0))
        expected = mesh.face_areas @ (curvature * np.abs(values) ** 2)
        # measured up to 0.004
        assert low - high == pytest.approx(expected, abs=0.01 * (low + high))


@pytest.mark.parametrize("name", ["sphere", "torus"])
def test_anti_holomorphic_energy_is_divergence_and_curl(name):
    """Against a discretisation that shares nothing with it: weak divergence and curl at the vertices."""
    mesh, normals = round_surface(name, 6000)
    grad, mass = gradient(mesh), field_mass(mesh)
    vertex_areas = np.bincount(mesh.faces.ravel(), np.repeat(mesh.face_areas, 3)) / 3
    for seed in range(4):
        values = linear_in_space(mesh, normals, seed)
        weak = [(grad.T @ (mass @ as_real(turn * values))) ** 2 @ (1 / vertex_areas) for turn in (1, 1j)]
        # measured up to 0.005
        assert energy(conformal_energy(mesh, -1.0), values) == pytest.approx(sum(weak), rel=0.01)


def test_gradients_of_heights_on_the_sphere():
    """grad z has divergence -2z: E_A = 1/2 integral 4 z^2 = 8 pi / 3, its Dirichlet energy; E_H = 0."""
    ball, normals = round_surface("sphere", 5120)
    heights = normals[:, 2:]
    field = ball.planar([0.0, 0.0, 1.0] - heights * normals)
    assert energy(conformal_energy(ball, -1.0), field) / 2 == pytest.approx(8 * np.pi / 3, rel=2e-3)
    assert abs(energy(conformal_energy(ball, 1.0), field)) / 2 < 2e-3 * 8 * np.pi / 3


@pytest.mark.parametrize("name", CLOSED)
def test_anti_holomorphic_field_is_unit_and_its_indices_sum_to_chi(name):
    mesh = surface(name)
    field = anti_holomorphic_field(mesh)
    np.testing.assert_allclose(field.norms, 1)
    assert index_sum(field) == mesh.euler_characteristic


def test_harmonic_fields_are_found():
    """On a torus the anti-holomorphic fields are the harmonic ones: neither divergence nor curl."""
    ring = surface("torus")
    found = anti_holomorphic_field(ring, 1)
    x, y = ring.barycenters[:, 0], ring.barycenters[:, 1]
    around = ring.planar(np.stack([-y, x, 0 * x], axis=1))
    turn = found.values / around
    angle = np.angle(turn * np.conj(turn.sum()))
    assert np.degrees(np.abs(angle)).max() < 3


def test_seed_repeats_and_changes():
    mesh = surface("jagged sphere")
    a, b, c = (anti_holomorphic_field(mesh, seed).values for seed in (1, 1, 2))
    np.testing.assert_array_equal(a, b)
    assert np.abs(a - c).max() > 1e-3


def test_components_have_fields_of_their_own():
    ring = surface("torus")
    both = TriMesh(
        np.concatenate([ring.vertices, ring.vertices + [3.0, 0, 0]]),
        np.concatenate([ring.faces, ring.faces + ring.n_vertices]),
    )
    field = anti_holomorphic_field(both)
    alone = anti_holomorphic_field(ring)
    turn = field.values.reshape(2, -1) / alone.values
    np.testing.assert_allclose(turn, np.broadcast_to(turn[:, :1], turn.shape), atol=1e-4)


def test_anti_holomorphic_refusals():
    with pytest.raises(FieldError, match="2 boundary loops"):
        anti_holomorphic_field(surface("cylinder"))
    with pytest.raises(FieldError, match=r"not at 1\.5"):
        conformal_energy(surface("disk"), 1.5)


# -- Pottmann et al. ------------------------------------------------------------------------------------


def test_fitted_curl_is_exact_on_linear_fields_of_the_plane():
    disk = surface("disk")
    rng = np.random.default_rng(0)
    jacobian, offset = rng.normal(size=(2, 2)), rng.normal(size=2)
    plane = disk.barycenters[:, :2] @ jacobian.T + offset
    values = disk.planar(np.concatenate([plane, np.zeros((disk.n_faces, 1))], axis=1))
    curl = fitted_curl(disk) @ as_real(values)
    neighbors = (disk.face_neighbors >= 0).sum(axis=1)
    inner = neighbors == 3
    np.testing.assert_allclose(curl[inner], jacobian[1, 0] - jacobian[0, 1], atol=1e-9)
    np.testing.assert_allclose(curl[neighbors == 2], jacobian[1, 0] - jacobian[0, 1], atol=1e-9)


def test_one_neighbour_tells_no_curl():
    pair = TriMesh([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    assert abs(fitted_curl(pair)).max() == 0


def test_fitted_curl_of_a_rotating_sphere_converges():
    errors = []
    for faces in (1280, 5120):
        ball = shapes.sphere(faces=faces)
        values = ball.planar(np.cross([0.0, 0.0, 1.0], ball.barycenters))
        errors.append(np.abs(fitted_curl(ball) @ as_real(values) - 2 * ball.barycenters[:, 2]).max())
    # first order: neighbours do not lie symmetrically about a face
    assert errors[1] < 0.6 * errors[0]
    assert errors[1] < 0.01


def test_spectral_projection_is_one():
    mesh = surface("jagged sphere")
    start = smoothest_field(mesh, 1, phase="seeded")
    once = spectral_field(start, count=12)
    np.testing.assert_allclose(spectral_field(once, count=12).values, once.values, atol=1e-6)
    # orthogonal: what was taken away has no part in what is left
    inner = mesh.face_areas @ (once.values.conj() * (start.values - once.values)).real
    assert abs(inner) < 1e-8


@pytest.mark.parametrize("name", ["jagged sphere", "torus", "genus 5"])
def test_spectral_projection_lowers_the_energy_per_length(name):
    """Dropping the components of high energy lowers the mean, whatever the field."""
    mesh = surface(name)
    form, mass = field_baselines._geodesic_form(mesh, field_baselines.SPECTRAL_ROUGHNESS), field_mass(mesh)
    start = smoothest_field(mesh, phase="seeded")
    mean = [
        (x @ (form @ x)) / (x @ (mass @ x))
        for x in (as_real(w.values) for w in (start, spectral_field(start, count=20)))
    ]
    assert mean[1] < mean[0]


def whirl_patch() -> tuple[TriMesh, FaceField]:
    """A spherical cap without a singularity, and on it a field of parallels, far from geodesic."""
    disk = shapes.disk(faces=1500)
    x, y = 0.6 * disk.vertices[:, 0] + 0.5, 0.6 * disk.vertices[:, 1]
    cap = TriMesh(np.stack([np.sqrt(1.5 - x**2 - y**2), x, y], axis=1), disk.faces)
    if np.sum(cap.face_normals * cap.barycenters) < 0:
        cap = TriMesh(cap.vertices, cap.faces[:, [0, 2, 1]])
    return cap, FaceField.from_ambient(cap, np.cross([0.6, 0.8, 0.0], cap.barycenters)).normalized()


def test_a_patch_becomes_geodesic():
    """What the method is made for (Pottmann et al.): on a disk the leaves become nearly straight."""
    _, start = whirl_patch()
    found = pottmann_field(start)
    before, after = (
        np.average(np.abs(geodesic_curvature(lines)), weights=lines.segment_lengths)
        for lines in (streamlines(start), streamlines(found.field))
    )
    assert after < 0.1 * before
    assert total_curl(found.field) < 0.2 * total_curl(start)
    np.testing.assert_allclose(found.field.norms, 1)


def test_a_geodesic_field_stays():
    """Great circles through two poles off the patch: no curl, so nothing to gather."""
    cap, _ = whirl_patch()
    meridians = FaceField.from_ambient(cap, np.broadcast_to([0.0, 0.0, 1.0], (cap.n_faces, 3))).normalized()
    found, _ = sharpened_field(meridians)
    turn = np.abs(np.angle(found.values / meridians.values))
    assert np.degrees(np.average(turn, weights=cap.face_areas)) < 1


@pytest.mark.parametrize("name", ["jagged sphere", "annulus", "two pieces", "genus 5"])
def test_no_step_raises_the_energy(name):
    mesh = surface(name)
    found = pottmann_field(smoothest_field(mesh, phase="seeded"), count=12, steps=16)
    assert len(found.steps) == 16
    assert all(step.after <= step.before for step in found.steps)
    scales = np.array([step.scale for step in found.steps])
    assert (np.diff(scales) < 1e-12).all()
    assert found.steps[-1].after < found.steps[len(scales) // 2].before
    assert index_sum(found.field) == mesh.euler_characteristic


def test_sharpening_gathers_the_curl():
    """Within the patches the curl all but vanishes; a few faces hold what is left."""
    mesh = surface("jagged sphere")
    found = pottmann_field(smoothest_field(mesh, phase="seeded"))
    curl = fitted_curl(mesh)
    medians = [np.median(np.abs(curl @ as_real(w.values))) for w in (found.spectral, found.field)]
    assert medians[1] < 0.2 * medians[0]


def test_scale_does_not_matter():
    mesh = surface("jagged sphere")
    small = TriMesh(mesh.vertices * 1e-3, mesh.faces)
    found, same = (
        pottmann_field(smoothest_field(m, phase="seeded"), count=12, steps=6).field for m in (mesh, small)
    )
    np.testing.assert_allclose(same.values, found.values, atol=1e-5)


def test_pottmann_refusals():
    start = smoothest_field(surface("sphere"))
    with pytest.raises(FieldError, match=r"not 0\.01 and 0"):
        spectral_field(start, count=0)
    with pytest.raises(FieldError, match="positive"):
        spectral_field(start, roughness=0.0)
    with pytest.raises(FieldError, match="positive scales"):
        sharpened_field(start, scale=-1.0)
    with pytest.raises(FieldError, match="and 0"):
        sharpened_field(start, steps=0)


def test_constants_are_in_the_documented_units():
    ball = surface("sphere")
    start = smoothest_field(ball, phase="seeded")
    named = sharpened_field(
        start,
        scale=field_baselines.CURL_SCALE / ball.bounding_radius,
        smoothing=field_baselines.SMOOTHING * ball.mean_edge / ball.bounding_radius,
        steps=2,
    )[0]
    np.testing.assert_array_equal(named.values, sharpened_field(start, steps=2)[0].values)
