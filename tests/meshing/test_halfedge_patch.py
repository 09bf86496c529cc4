import numpy as np
import pytest

from geoweave.meshing.halfedge_patch import (
    FREE,
    LOCKED,
    ON_CURVE,
    ROOM,
    Guide,
    area_vector,
    corners_around,
    following,
    may_move,
    preceding,
    slide,
)
from geoweave.meshing.remesh import opened_patch
from geoweave.models import shapes
from geoweave.surface.closest_point import segment_tree, triangle_tree
from geoweave.surface.mesh import TriMesh

SQUARE = TriMesh(
    np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 0]]),
    np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]]),
)


def guide_of(mesh: TriMesh) -> Guide:
    rims = segment_tree(mesh.vertices[mesh.edges[mesh.boundary_edges]])
    return Guide(triangle_tree(mesh.vertices[mesh.faces]), rims, segment_tree(np.zeros((0, 2, 3))))


def nothing() -> np.ndarray:
    return np.zeros(0, dtype=np.int64)


def test_corners_go_round_their_face() -> None:
    assert [following(h) for h in (6, 7, 8)] == [7, 8, 6]
    assert [preceding(h) for h in (6, 7, 8)] == [8, 6, 7]


@pytest.mark.parametrize("name", ["torus", "disk"])
def test_the_ring_of_every_vertex_is_its_faces_in_order(name: str) -> None:
    mesh = getattr(shapes, name)(faces=300)
    patch, ring = opened_patch(mesh, nothing(), 0.1), np.empty(ROOM, dtype=np.int64)
    for vertex in range(mesh.n_vertices):
        count, closed = corners_around(patch, vertex, ring)
        corners = ring[:count]
        assert closed != mesh.boundary_vertices[vertex]
        assert set(corners // 3) == set(np.flatnonzero((mesh.faces == vertex).any(axis=1)))
        # the side that leads from one face is the side that comes into the next
        lead = [patch.at[preceding(c)] for c in corners]
        come = [patch.at[following(c)] for c in corners]
        assert lead[:-1] == come[1:]
        assert (lead[-1] == come[0]) == closed


def test_quality_is_one_for_equilateral_and_zero_for_flat() -> None:
    a, b, c = np.zeros(3), np.array([1.0, 0, 0]), np.array([0.5, np.sqrt(0.75), 0])
    x, y, z, quality = area_vector(a, b, c)
    assert (x, y) == (0.0, 0.0)
    assert z == pytest.approx(np.sqrt(0.75))
    assert quality == pytest.approx(1.0)
    assert area_vector(a, b, 2 * b)[3] == 0.0


def test_kinds_of_vertices() -> None:
    patch = opened_patch(SQUARE, nothing(), 0.5)
    np.testing.assert_array_equal(patch.kind, [LOCKED] * 4 + [FREE])
    rim = opened_patch(shapes.disk(faces=600), nothing(), 0.1).kind
    assert set(rim) == {FREE, ON_CURVE}


def test_a_vertex_may_not_cross_the_side_before_it() -> None:
    patch, ring = opened_patch(SQUARE, nothing(), 0.5), np.empty(ROOM, dtype=np.int64)
    count, _ = corners_around(patch, 4, ring)
    for place, allowed in (([0.6, 0.5, 0], True), ([0.5, -0.2, 0], False), ([0.5, 0.001, 0], False)):
        assert may_move(patch, ring, count, 4, np.array(place, dtype=float), -1, 1.0) == allowed


def test_a_vertex_slides_to_the_middle_and_locked_ones_stay() -> None:
    shifted = TriMesh(SQUARE.vertices + np.array([[0.0] * 3] * 4 + [[0.2, 0.1, 0]]), SQUARE.faces)
    patch, ring = opened_patch(shifted, nothing(), 0.5), np.empty(ROOM, dtype=np.int64)
    for _ in range(30):
        assert slide(patch, guide_of(shifted), 4, ring)
    np.testing.assert_allclose(patch.points[4], [0.5, 0.5, 0.0], atol=1e-3)
    assert not slide(patch, guide_of(shifted), 0, ring)


def test_a_rim_vertex_stays_on_the_rim() -> None:
    mesh = shapes.annulus(faces=300)
    patch, ring = opened_patch(mesh, nothing(), 0.1), np.empty(ROOM, dtype=np.int64)
    guide = guide_of(mesh)
    for vertex in np.flatnonzero(mesh.boundary_vertices):
        assert slide(patch, guide, vertex, ring)
    side = mesh.edge_lengths[mesh.boundary_edges].max()
    out = np.linalg.norm(patch.points, axis=1)[mesh.boundary_vertices]
    sagitta = side**2 / (8 * 0.4)
    assert np.minimum(np.abs(out - 0.4), np.abs(out - 1.0)).max() < 1.01 * sagitta
