from __future__ import annotations

import numpy as np
import pytest
from surfaces import ALL, CLOSED, surface

from geoweave.comparisons.anti_holomorphic_fields import anti_holomorphic_field, conformal_energy
from geoweave.errors import FieldError
from geoweave.fields.operators import as_real, field_mass, gradient
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
