import numpy as np
import pytest

from geoweave.models.implicit import bumpy_box, crown, level_set, rocker_arm, schwarz_p, vessel


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


def test_the_bumpy_box_bulges_on_all_sides_alike() -> None:
    mesh = bumpy_box(faces=3_000)
    for axis in range(3):
        top = mesh.vertices[:, axis]
        for side in (-1, 1):
            middle = mesh.vertices[np.argmax(side * top)]
            # the farthest point is the middle of a side, beyond its edges at 1
            assert np.abs(np.delete(middle, axis)).max() < 0.2
            assert abs(middle[axis]) == pytest.approx(1.3, abs=0.1)


def test_the_vessel_has_three_open_ends_and_a_sac() -> None:
    mesh = vessel(faces=4_000)
    heights = sorted(float(mesh.vertices[loop][:, 2].mean()) for loop in mesh.boundary_loops)
    np.testing.assert_allclose(heights, [-1.5, 1.5, 1.5], atol=1e-9)
    for loop in mesh.boundary_loops:
        np.testing.assert_allclose(
            mesh.vertices[loop][:, 2], heights[0 if mesh.vertices[loop[0], 2] < 0 else 1]
        )
        assert np.ptp(mesh.vertices[loop], axis=0)[:2].max() < 0.8
    away = np.linalg.norm(mesh.vertices - [0.05, 0.42, 0.42], axis=1)
    sac = np.abs(away - 0.52) < 1e-6
    # more than a third of a ball of that radius stands free
    assert mesh.face_areas[sac[mesh.faces].all(axis=1)].sum() > 4 * np.pi * 0.52**2 / 3


@pytest.mark.parametrize("prongs", [5, 9])
def test_the_crown_has_its_prongs(prongs: int) -> None:
    mesh = crown(prongs, faces=6_000)
    x, y, z = mesh.vertices.T
    high = np.flatnonzero(z > 1.0)
    sector = np.round(np.arctan2(y[high], x[high]) / (2 * np.pi / prongs)).astype(int) % prongs
    np.testing.assert_array_equal(np.unique(sector), np.arange(prongs))
    assert (mesh.genus, mesh.n_components, len(mesh.boundary_loops)) == (0, 1, 0)
