import numpy as np
import pytest

from geoweave.implicit import level_set, rocker_arm, schwarz_p


def ball(x: np.ndarray) -> np.ndarray:
    return np.linalg.norm(x, axis=-1) - 1.0


def test_a_ball_is_round_and_looks_out() -> None:
    mesh = level_set(ball, [-1.2] * 3, [1.2] * 3, 2_000, resolution=32)
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), 1.0, atol=1e-9)
    assert mesh.n_faces == pytest.approx(2_000, rel=0.05)
    assert (mesh.genus, len(mesh.boundary_loops)) == (0, 0)
    assert np.einsum("fx,fx->f", mesh.face_normals, mesh.barycenters).min() > 0


def test_a_ball_cut_by_its_box_has_a_flat_rim() -> None:
    mesh = level_set(ball, [-1.2, -1.2, -1.2], [1.2, 1.2, 0.3], 1_500, resolution=32)
    rim = mesh.vertices[mesh.boundary_vertices]
    assert len(mesh.boundary_loops) == 1
    np.testing.assert_allclose(rim[:, 2], 0.3, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), 1.0, atol=1e-9)
    cap = 2 * np.pi * 1.3
    assert mesh.face_areas.sum() == pytest.approx(cap, rel=5e-3)


def test_schwarz_p_lies_on_its_level_set_and_its_loops_on_the_block() -> None:
    mesh = schwarz_p(faces=6_800)
    assert mesh.n_faces == pytest.approx(6_800, rel=0.05)
    assert (mesh.genus, len(mesh.boundary_loops)) == (5, 24)
    centred = np.abs(np.cos(mesh.vertices).sum(axis=1)), np.abs(np.cos(mesh.vertices + np.pi).sum(axis=1))
    assert min(values.max() for values in centred) < 1e-8
    half = 2 * np.pi
    assert np.abs(mesh.vertices).max() == pytest.approx(half, rel=1e-9)
    for loop in mesh.boundary_loops:
        points = mesh.vertices[loop]
        flat = (np.ptp(points, axis=0) < 1e-8) & np.isclose(np.abs(points).max(axis=0), half)
        assert flat.sum() == 1
    # the surface meets the block's sides at right angles, so that copies of it join smoothly
    rim = mesh.vertex_normals[mesh.boundary_vertices]
    wall = np.abs(np.abs(mesh.vertices[mesh.boundary_vertices]) - half) < 1e-8
    assert np.abs(rim[wall]).max() < 0.3


def test_schwarz_p_is_nearly_minimal() -> None:
    # one cell of Schwarz's P has area 2.3451 a^2; the level set of the cosines is within half a percent
    mesh = schwarz_p(cells=1, faces=6_000)
    assert mesh.face_areas.sum() == pytest.approx(2.3451 * (2 * np.pi) ** 2, rel=1e-2)


def test_the_rocker_arm_is_bored_through() -> None:
    mesh = rocker_arm(faces=4_000)
    assert (mesh.genus, len(mesh.boundary_loops), mesh.n_components) == (1, 0, 1)
    assert np.linalg.norm(mesh.vertices[:, :2], axis=1).min() > 0.2
    assert np.ptp(mesh.vertices, axis=0).argmax() == 0
