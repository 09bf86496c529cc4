"""Prescribed singularities are met exactly, on every kind of surface and for every N."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import ALL, CLOSED, surface

from geoweave.errors import FieldError
from geoweave.fields.connected_rosy import smallest_turns
from geoweave.fields.operators import dual_weights
from geoweave.fields.rosy import RoSyField, smoothest_rosy
from geoweave.fields.trivial_connection import prescribed_rosy
from geoweave.models import shapes


def scattered_indices(mesh, degree, seed=0, count=10):
    """Random indices that sum to what the surface asks for; on an open one to anything."""
    rng = np.random.default_rng(seed)
    inside = np.flatnonzero(~mesh.boundary_vertices)
    numerators = np.zeros(mesh.n_vertices, dtype=np.int64)
    places = rng.choice(inside, count, replace=False)
    numerators[places] = rng.integers(-1, 2, count)
    if not mesh.boundary_vertices.any():
        missing = degree * mesh.euler_characteristic - numerators.sum()
        free = np.setdiff1d(inside, places)
        numerators[rng.choice(free, abs(missing), replace=False)] = np.sign(missing)
    return numerators


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("degree", [3, 4, 6])
def test_indices_are_met_exactly(name, degree):
    mesh = surface(name)
    if mesh.n_components > 1:
        pytest.skip("one component each; several have a test of their own")
    numerators = scattered_indices(mesh, degree)
    rosy = prescribed_rosy(mesh, degree, numerators)
    assert (rosy.index_numerators == numerators).all()
    # The loops of the boundary take what is left: Poincaré and Hopf.
    assert numerators.sum() + rosy.boundary_numerators.sum() == degree * mesh.euler_characteristic


def test_large_indices_are_met_where_the_smallest_turn_would_lose_them():
    ball = surface("sphere")
    numerators = np.zeros(ball.n_vertices, dtype=np.int64)
    numerators[[ball.vertices[:, 2].argmax(), ball.vertices[:, 2].argmin()]] = 5, 7
    rosy = prescribed_rosy(ball, 6, numerators)
    assert (rosy.index_numerators == numerators).all()
    by_smallest_turn = RoSyField(ball, 6, rosy.values).index_numerators
    assert not (by_smallest_turn == numerators).all()
    # What it says of its turns is true of its values.
    assert np.allclose(np.exp(1j * smallest_turns(rosy)), np.exp(1j * rosy.turns))


def test_the_energy_is_that_of_a_minimum():
    mesh = surface("torus")
    rosy = prescribed_rosy(mesh, 6, scattered_indices(mesh, 6))
    weights, (i, j) = dual_weights(mesh), mesh.edge_faces[mesh.interior_edges].T
    # The gradient of the energy in the angle of each face.
    slope = np.bincount(j, weights * rosy.turns, mesh.n_faces) - np.bincount(
        i, weights * rosy.turns, mesh.n_faces
    )
    assert np.abs(slope).max() < 1e-8 * np.abs(weights * rosy.turns).max()


@pytest.mark.parametrize("name", CLOSED)
def test_with_the_same_singularities_it_is_no_rougher_than_the_smoothest(name):
    mesh = surface(name)
    smooth = smoothest_rosy(mesh, 6)
    rosy = prescribed_rosy(mesh, 6, smooth.index_numerators, like=smooth)
    weights = dual_weights(mesh)
    # The smoothest RoSy is so in another energy, that of its unnormalised eigenvector. Round the loops of the
    # surface other whole turns are tried too: were they chosen badly the energy would be many times as large.
    assert weights @ rosy.turns**2 <= weights @ smallest_turns(smooth) ** 2 + 1e-9
    assert np.abs((mesh.face_areas * rosy.values.conj()) @ smooth.values).real > 0


def test_a_parallel_field_stays_parallel():
    for name in ("disk", "annulus"):
        mesh = surface(name)
        rosy = prescribed_rosy(mesh, 4, np.zeros(mesh.n_vertices, dtype=int))
        assert np.abs(rosy.turns).max() < 1e-9


def test_a_missing_sum_is_said():
    ball = surface("sphere")
    numerators = np.zeros(ball.n_vertices, dtype=np.int64)
    numerators[:9] = 1
    with pytest.raises(FieldError, match=r"sum to 9/6.*12/6.*\+3/6 is missing"):
        prescribed_rosy(ball, 6, numerators)
    numerators[:20] = 1
    with pytest.raises(FieldError, match="-8/6 is missing"):
        prescribed_rosy(ball, 6, numerators)


def test_what_cannot_be_is_refused():
    disk = surface("disk")
    numerators = np.zeros(disk.n_vertices, dtype=np.int64)
    numerators[np.flatnonzero(disk.boundary_vertices)[0]] = 1
    with pytest.raises(FieldError, match="boundary"):
        prescribed_rosy(disk, 6, numerators)
    with pytest.raises(FieldError, match="one number per vertex"):
        prescribed_rosy(disk, 6, numerators[1:])
    with pytest.raises(FieldError, match="N >= 1"):
        prescribed_rosy(disk, 0, numerators)
    numerators[:] = 0
    middle = np.linalg.norm(disk.vertices, axis=1).argmin()
    numerators[middle] = 40
    with pytest.raises(FieldError, match=f"round vertex {middle} are too few for an index of 40/6"):
        prescribed_rosy(disk, 6, numerators)


def test_components_are_prescribed_one_by_one():
    from geoweave.surface.mesh import TriMesh

    ball = shapes.sphere(faces=320)
    two = TriMesh(
        np.concatenate([ball.vertices, ball.vertices + 3.0]),
        np.concatenate([ball.faces, ball.faces + ball.n_vertices]),
    )
    numerators = np.zeros(two.n_vertices, dtype=np.int64)
    numerators[[3, 80, ball.n_vertices + 7, ball.n_vertices + 90]] = 4
    with pytest.raises(FieldError, match=r"component 0.*[+]4/6 is missing"):
        prescribed_rosy(two, 6, numerators)
    numerators[[40, ball.n_vertices + 40]] = 4
    assert (prescribed_rosy(two, 6, numerators).index_numerators == numerators).all()
