"""Walks from face to face: straight lines stay straight, vertices and ends of edges are passed in order."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from geoweave.curves.face_walk import (
    around_vertex,
    ground,
    in_space,
    leave,
    on_edge_in_space,
    straight_walk,
    unfold,
)
from geoweave.surface.mesh import TriMesh


def still(mesh: TriMesh):
    """A ground without a field."""
    return ground(mesh, np.zeros(mesh.n_faces, dtype=np.complex128), np.zeros(mesh.n_vertices))


@pytest.fixture(scope="module")
def ball() -> TriMesh:
    shape = trimesh.creation.icosphere(4)
    return TriMesh(shape.vertices, shape.faces)


@pytest.fixture(scope="module")
def plane() -> TriMesh:
    x, y = np.meshgrid(np.arange(9.0), np.arange(9.0), indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    rng = np.random.default_rng(1)
    inner = (x.ravel() % 8 > 0) & (y.ravel() % 8 > 0)
    points[inner, :2] += rng.uniform(-0.3, 0.3, (inner.sum(), 2))
    a = (np.arange(8)[:, None] * 9 + np.arange(8)).ravel()
    return TriMesh(points, np.concatenate([np.stack([a, a + 9, a + 10], 1), np.stack([a, a + 10, a + 1], 1)]))


def centre(mesh: TriMesh, face: int) -> complex:
    sides = mesh.halfedge_vectors[face]
    return complex((sides[2] - sides[1]) / 3)


def test_crossings_agree_from_both_sides(ball):
    g = still(ball)
    one, other = np.empty(3), np.empty(3)
    for face, k in ((0, 0), (17, 1), (230, 2)):
        across = int(g.across[face, k])
        assert g.across[across // 3, across % 3] == 3 * face + k
        on_edge_in_space(g, face, k, 0.3, one)
        on_edge_in_space(g, across // 3, across % 3, 0.7, other)
        assert np.array_equal(one, other)
        turn = unfold(g, face, k)
        assert turn * g.sides[face, k] == pytest.approx(-g.sides[across // 3, across % 3])


def test_unfolding_is_the_transport_of_the_mesh(ball):
    g = still(ball)
    along = ball.edge_halfedges[ball.interior_edges, 0]
    for edge in (0, 100, 1000):
        assert unfold(g, int(along[edge] // 3), int(along[edge] % 3)) == pytest.approx(ball.transport[edge])


def test_a_line_leaves_by_the_side_it_points_to(plane):
    g = still(plane)
    for face in (0, 11, 60):
        start = centre(plane, face)
        for k in range(3):
            a, b = (k + 1) % 3, (k + 2) % 3
            corners = np.array([0, g.sides[face, 2], -g.sides[face, 1]])
            target = 0.75 * corners[a] + 0.25 * corners[b]
            way = (target - start) / abs(target - start)
            side, share = leave(g, face, start, way, -1)
            assert side == k
            assert share == pytest.approx(0.25)
            # through a corner it passes to one side
            way = (corners[k] - start) / abs(corners[k] - start)
            side, share = leave(g, face, start, way, -1)
            assert side != k
            assert 0 < share < 1
            assert min(share, 1 - share) < 1e-8


def test_straight_walks_in_a_plane_are_straight_lines(plane):
    g = still(plane)
    face = int(np.argmin(np.linalg.norm(plane.barycenters - [4, 4, 0], axis=1)))
    begin, end = np.empty(3), np.empty(3)
    in_space(g, face, centre(plane, face), begin)
    for angle in np.linspace(0.1, 6.1, 13):
        way = np.exp(1j * angle)
        frame = plane.frames[face]
        heading = way.real * frame[0] + way.imag * frame[1]
        last, place, arrived = straight_walk(g, face, centre(plane, face), way, 2.5)
        assert arrived
        in_space(g, last, place, end)
        assert end == pytest.approx(begin + 2.5 * heading, abs=1e-7)
    last, place, arrived = straight_walk(g, face, centre(plane, face), 1 + 0j, 50.0)
    assert not arrived
    in_space(g, last, place, end)
    assert np.isclose(np.abs(end[:2] - 4).max(), 4.0)


def test_straight_walks_on_a_sphere_are_great_circles(ball):
    g = still(ball)
    begin, end = np.empty(3), np.empty(3)
    for face in (3, 777, 4000):
        in_space(g, face, centre(ball, face), begin)
        heading = ball.frames[face, 0]
        last, place, arrived = straight_walk(g, face, centre(ball, face), 1 + 0j, 0.5 * np.pi)
        assert arrived
        in_space(g, last, place, end)
        # a quarter of a great circle ends where it headed, up to the facets' excess
        assert end / np.linalg.norm(end) == pytest.approx(heading, abs=0.03)


def test_a_line_at_a_vertex_goes_on_straight(plane):
    vertex = 4 * 9 + 4
    for angle in (0.3, 2.0, 4.4):
        heading = np.array([np.cos(angle), np.sin(angle), 0.0])
        values = plane.planar(np.tile(heading, (plane.n_faces, 1)))
        g = ground(plane, values, np.zeros(plane.n_vertices))
        for face, c in np.argwhere(plane.faces == vertex):
            # along the edge into the vertex from its tail: half-edge opposite corner c + 1
            k = (int(c) + 1) % 3
            came = plane.vertices[vertex] - plane.vertices[plane.faces[face, (k + 1) % 3]]
            came /= np.linalg.norm(came)
            expected = np.arctan2(np.cross(came, heading)[2], came @ heading)
            kind, onward, corner, turning = around_vertex(g, int(face), k, 1.0)
            if abs(expected) < 0.5 * np.pi:
                assert kind == 0
                assert plane.faces[onward, corner] == vertex
                assert turning == pytest.approx(expected, abs=1e-9)
                ahead = plane.vertices[vertex] + 0.01 * heading
                corners = plane.vertices[plane.faces[onward]]
                inside = np.cross(np.roll(corners, -1, 0) - corners, ahead - corners)[:, 2]
                assert (inside > 0).all()
            else:
                assert kind == -1
