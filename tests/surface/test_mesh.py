from __future__ import annotations

import numpy as np
import pytest
from surfaces import ALL, surface

from geoweave.errors import MeshError
from geoweave.surface.mesh import TriMesh

TETRAHEDRON = (
    np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]),
    np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]),
)


@pytest.mark.parametrize("name", ALL)
def test_angle_defects_sum_to_the_euler_characteristic(name):
    mesh = surface(name)
    assert mesh.angle_defects.sum() == pytest.approx(2 * np.pi * mesh.euler_characteristic, abs=1e-9)


@pytest.mark.parametrize("name", ALL)
def test_transport_round_a_vertex_is_its_angle_defect(name):
    """Parallel transport round an interior vertex turns a vector by the angle defect (Section 4.1)."""
    mesh = surface(name)
    angle = np.angle(mesh.transport)
    tail, head = mesh.edges[mesh.interior_edges].T
    # Going round the head counter-clockwise the edge is crossed from i to j, round the tail from j to i.
    around = np.bincount(head, angle, mesh.n_vertices) - np.bincount(tail, angle, mesh.n_vertices)
    inside = ~mesh.boundary_vertices
    np.testing.assert_allclose(
        np.exp(1j * around[inside]), np.exp(1j * mesh.angle_defects[inside]), atol=1e-9
    )


@pytest.mark.parametrize("name", ALL)
def test_transport_unfolds_the_shared_edge(name):
    mesh = surface(name)
    edges = mesh.interior_edges
    i, j = mesh.edge_faces[edges].T
    along_i, along_j = (
        np.einsum("ex,eax->ea", mesh.edge_vectors[edges], mesh.frames[faces]) @ [1, 1j] for faces in (i, j)
    )
    np.testing.assert_allclose(mesh.transport * along_i, along_j, atol=1e-12)


@pytest.mark.parametrize("name", ALL)
def test_half_edges_close_each_triangle_and_bound_its_area(name):
    mesh = surface(name)
    h = mesh.halfedge_vectors
    np.testing.assert_allclose(h.sum(axis=1), 0, atol=1e-14)
    np.testing.assert_allclose((h[:, 0].conj() * h[:, 1]).imag / 2, mesh.face_areas, rtol=1e-10)
    np.testing.assert_allclose(mesh.corner_angles.sum(axis=1), np.pi, atol=1e-10)


def test_planar_and_ambient_are_inverse():
    mesh = surface("jagged sphere")
    values = np.random.default_rng(0).normal(size=(mesh.n_faces, 2)) @ [1, 1j]
    np.testing.assert_allclose(mesh.planar(mesh.ambient(values)), values, atol=1e-12)
    assert np.abs(np.einsum("fx,fx->f", mesh.ambient(values), mesh.face_normals)).max() < 1e-12


def test_normalized_has_mean_zero_and_radius_one():
    mesh = surface("jagged sphere")
    moved = TriMesh(mesh.vertices * 37.0 + [5.0, -1.0, 2.0], mesh.faces)
    normal, placement = moved.normalized()
    np.testing.assert_allclose(normal.vertices, mesh.vertices, atol=1e-12)
    np.testing.assert_allclose(placement.undo(normal.vertices), moved.vertices, atol=1e-12)
    assert np.linalg.norm(normal.vertices, axis=1).max() == pytest.approx(1)


def test_arrays_are_read_only():
    mesh = surface("torus")
    for array in (mesh.vertices, mesh.faces, mesh.edges, mesh.transport, mesh.face_areas):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def refused(vertices, faces, match):
    with pytest.raises(MeshError, match=match):
        TriMesh(np.asarray(vertices, float), np.asarray(faces))


def test_refusals_name_numbers_and_places():
    vertices, faces = TETRAHEDRON
    assert TriMesh(vertices, faces).euler_characteristic == 2
    refused(vertices[:, :2], faces, r"\(4, 2\)")
    refused(vertices, faces[:0], r"\(0, 3\)")
    refused(np.where(np.arange(4)[:, None] == 2, np.nan, vertices), faces, "vertex 2")
    refused(vertices, np.where(faces == 3, 9, faces), "outside 0..3")
    refused(np.vstack([vertices, [[5, 5, 5]]]), faces, "vertex 4 belongs to no face")
    refused(np.vstack([vertices, [[5, 5, 5]]]), np.vstack([faces, [[0, 1, 4]]]), "shared by more than two")
    refused(vertices, np.vstack([faces[:3], faces[3:, ::-1]]), "opposite orientation")
    line = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]])
    refused(line, [[0, 1, 2], [1, 0, 3]], "no area")
    second = vertices[1:] - 2 * (vertices[1:] - vertices[0]) @ np.eye(3)
    both = np.vstack([vertices, second])
    mirrored = np.where(faces > 0, faces + 3, 0)[:, ::-1]
    refused(both, np.vstack([faces, mirrored[:, ::-1]]), "vertex 0")
