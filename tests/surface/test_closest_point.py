import numpy as np
import pytest

from geoweave.models import shapes
from geoweave.surface.closest_point import closest_points, nearest, segment_tree, triangle_tree


def scattered(seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    triangles = rng.normal(size=(120, 1, 3)) + 0.3 * rng.normal(size=(120, 3, 3))
    return triangles, 1.5 * rng.normal(size=(80, 3))


def project_onto(points: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    """Distances to one triangle by another road: the plane where the foot is inside, else the three sides."""
    a, b, c = triangle
    basis = np.stack([b - a, c - a], axis=1)
    weights = np.linalg.lstsq(basis, (points - a).T, rcond=None)[0]
    inside = (weights >= 0).all(axis=0) & (weights.sum(axis=0) <= 1)
    best = np.where(inside, np.linalg.norm(points - a - (basis @ weights).T, axis=1), np.inf)
    for p, q in ((a, b), (b, c), (c, a)):
        along = np.clip((points - p) @ (q - p) / ((q - p) @ (q - p)), 0.0, 1.0)
        best = np.minimum(best, np.linalg.norm(points - p - along[:, None] * (q - p), axis=1))
    return best


@pytest.mark.parametrize("seed", [0, 1])
def test_triangles_agree_with_all_pairs(seed: int) -> None:
    triangles, points = scattered(seed)
    found, pieces = closest_points(triangle_tree(triangles), points)
    distance = np.linalg.norm(found - points, axis=1)
    every = np.stack([project_onto(points, triangle) for triangle in triangles])
    np.testing.assert_allclose(distance, every.min(axis=0), rtol=1e-9)
    np.testing.assert_allclose(every[pieces, np.arange(len(points))], distance, rtol=1e-9)


def test_segments_are_flat_triangles() -> None:
    triangles, points = scattered(2)
    segments = triangles[:, :2]
    found, _ = closest_points(segment_tree(segments), points)
    p, q = segments[None, :, 0], segments[None, :, 1]
    side = q - p
    along = np.clip(
        np.einsum("nsx,nsx->ns", points[:, None] - p, side + 0 * p) / (side**2).sum(axis=2), 0.0, 1.0
    )
    every = np.linalg.norm(points[:, None] - p - along[..., None] * side, axis=2)
    np.testing.assert_allclose(np.linalg.norm(found - points, axis=1), every.min(axis=1), rtol=1e-9)


def test_vertices_of_a_mesh_are_their_own_closest_points() -> None:
    mesh = shapes.torus(faces=600)
    found, pieces = closest_points(triangle_tree(mesh.vertices[mesh.faces]), mesh.vertices)
    np.testing.assert_allclose(found, mesh.vertices, atol=1e-14)
    assert (mesh.faces[pieces] == np.arange(mesh.n_vertices)[:, None]).any(axis=1).all()


def test_the_far_side_of_a_thin_sheet_is_passed_over() -> None:
    upper = np.array([[0.0, 0, 0.01], [1, 0, 0.01], [0, 1, 0.01]])
    tree = triangle_tree(np.stack([upper, upper[[0, 2, 1]] - [0.0, 0, 0.01]]))
    place, found = np.array([0.2, 0.2, 0.002]), np.empty(3)
    assert nearest(tree, place, np.array([0.0, 0, 1]), found) == 0
    assert found[2] == pytest.approx(0.01)
    assert nearest(tree, place, np.zeros(3), found) == 1
    assert nearest(tree, place, np.array([0.0, 0, -1]), found) == 1
    assert found[2] == pytest.approx(0.0)


def test_nothing_is_found_in_no_pieces() -> None:
    tree = triangle_tree(np.zeros((0, 3, 3)))
    assert nearest(tree, np.zeros(3), np.zeros(3), np.empty(3)) == -1
