from __future__ import annotations

import numpy as np
from surfaces import surface

from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh
from geoweave.surface.smooth_normal import smooth_normals


def test_at_a_vertex_they_are_its_normal_from_every_face():
    mesh = surface("torus")
    for k in range(3):
        found = smooth_normals(mesh, mesh.vertices[mesh.faces[:, k]], np.arange(mesh.n_faces))
        np.testing.assert_allclose(found, mesh.vertex_normals[mesh.faces[:, k]], atol=1e-9)


def test_they_agree_on_both_sides_of_an_edge_where_face_normals_jump():
    mesh = surface("torus")
    edges = mesh.interior_edges
    points = 0.3 * mesh.vertices[mesh.edges[edges, 0]] + 0.7 * mesh.vertices[mesh.edges[edges, 1]]
    i, j = mesh.edge_faces[edges].T
    np.testing.assert_allclose(smooth_normals(mesh, points, i), smooth_normals(mesh, points, j), atol=1e-9)
    assert np.abs(mesh.face_normals[i] - mesh.face_normals[j]).max() > 0.05


def test_points_off_the_face_still_get_a_unit_normal():
    mesh = shapes.sphere(faces=200)
    rng = np.random.default_rng(0)
    faces = rng.integers(0, mesh.n_faces, 50)
    found = smooth_normals(mesh, 1.5 * rng.normal(size=(50, 3)), faces)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0)


def test_where_vertex_normals_cancel_the_face_decides():
    """Two sheets joined along one edge and folded flat on each other: the edge's vertices have no normal."""
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1, 0]])
    mesh = TriMesh(vertices, np.array([[0, 1, 2], [1, 0, 3]]))
    found = smooth_normals(mesh, np.array([[0.5, 0.0, 0.0]]), np.array([0]))
    np.testing.assert_allclose(np.abs(found @ mesh.face_normals[0]), 1.0)
