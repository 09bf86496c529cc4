from __future__ import annotations

import numpy as np
import pytest
from surfaces import surface

from geoweave.comparisons import pottmann_fields
from geoweave.comparisons.pottmann_fields import (
    fitted_curl,
    pottmann_field,
    sharpened_field,
    spectral_field,
)
from geoweave.curves.curves import geodesic_curvature
from geoweave.curves.tracing import streamlines
from geoweave.errors import FieldError
from geoweave.fields.face_field import FaceField, total_curl
from geoweave.fields.operators import as_real, field_mass
from geoweave.fields.rosy import smoothest_field
from geoweave.fields.singularities import index_sum
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh


def energy(form, values) -> float:
    return float((values.conj() @ (form @ values)).real)


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
    form, mass = pottmann_fields._geodesic_form(mesh, pottmann_fields.SPECTRAL_ROUGHNESS), field_mass(mesh)
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
        scale=pottmann_fields.CURL_SCALE / ball.bounding_radius,
        smoothing=pottmann_fields.SMOOTHING * ball.mean_edge / ball.bounding_radius,
        steps=2,
    )[0]
    np.testing.assert_array_equal(named.values, sharpened_field(start, steps=2)[0].values)
