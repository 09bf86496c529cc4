"""Straightest geodesics on planes, spheres, helices and corners; crossings against all pairs of segments."""

from __future__ import annotations

import numpy as np
import potpourri3d
import pytest
import trimesh
from surfaces import scattered, surface, uneven_square

from geoweave.curves.curves import Curves, geodesic_curvature
from geoweave.curves.straightest_geodesics import straightest
from geoweave.errors import FieldError
from geoweave.foliation.circle_function import TURN
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh

BOX = trimesh.creation.box()


def ends(curves: Curves) -> np.ndarray:
    return curves.points[curves.offsets[1:] - 1]


def test_in_a_plane_they_are_straight():
    rng = np.random.default_rng(1)
    faces = rng.integers(uneven_square().n_faces, size=60)
    heading = np.insert(rng.normal(size=(60, 2)), 2, rng.normal(size=60), axis=1)
    curves = straightest(uneven_square(), faces, heading, 0.5, behind=0.3)
    flat = heading * [1, 1, 0] / np.linalg.norm(heading[:, :2], axis=1, keepdims=True)
    start = uneven_square().barycenters[faces]
    off = np.cross(curves.points - start[curves.curve_of_point], flat[curves.curve_of_point])
    assert np.abs(off).max() < 1e-7  # passing within 1e-9 of a vertex moves a point aside
    whole = np.isclose(curves.lengths, 0.8)
    assert whole.mean() > 0.3
    np.testing.assert_allclose(ends(curves)[whole], (start + 0.5 * flat)[whole], atol=1e-7)
    np.testing.assert_allclose(
        curves.points[curves.offsets[:-1]][whole], (start - 0.3 * flat)[whole], atol=1e-7
    )
    # the others end at the boundary
    tips = np.abs(np.concatenate([curves.points[curves.offsets[:-1]], ends(curves)])[:, :2]).max(axis=1)
    assert np.isclose(tips.reshape(2, -1).max(axis=0)[~whole], 1.0).all()


def test_segments_lie_in_their_faces():
    for name in ("jagged sphere", "genus 5", "disk", "two pieces"):
        mesh = surface(name)
        curves = scattered(mesh, 40, 2.0, behind=1.0)
        for points in (curves.points, curves.points[curves.following]):
            off = np.einsum("px,px->p", points - mesh.barycenters[curves.faces], curves.normals)
            assert np.abs(off).max() < 1e-9
        assert (curves.segment_lengths > 0).sum() == len(curves.points) - len(curves)
        assert np.abs(geodesic_curvature(curves)).max() == 0.0


@pytest.mark.parametrize("name", ["jagged sphere", "torus", "genus 5", "Schwarz-P", "disk"])
def test_they_are_those_of_a_library(name):
    mesh = surface(name)
    rng = np.random.default_rng(0)
    faces, heading = rng.integers(mesh.n_faces, size=40), rng.normal(size=(40, 3))
    normal = mesh.face_normals[faces]
    heading -= np.einsum("nx,nx->n", heading, normal)[:, None] * normal
    heading /= np.linalg.norm(heading, axis=1, keepdims=True)
    curves = straightest(mesh, faces, heading, 2.0)
    tracer = potpourri3d.GeodesicTracer(mesh.vertices, mesh.faces)
    for curve, face, way in zip(curves, faces, heading, strict=True):
        path = tracer.trace_geodesic_from_face(int(face), np.full(3, 1 / 3), 2.0 * way)
        np.testing.assert_allclose(curve.points, path, atol=1e-9)


def test_great_circles_of_a_sphere_converge():
    errors = []
    for faces in (1280, 5120, 20480):
        ball = shapes.sphere(faces=faces)
        rng = np.random.default_rng(4)
        start, heading = rng.integers(ball.n_faces, size=100), rng.normal(size=(100, 3))
        curves = straightest(ball, start, heading, np.pi)
        pole = np.cross(
            ball.barycenters[start], ball.ambient(ball.planar(np.zeros((ball.n_faces, 3))))[start] + heading
        )
        pole /= np.linalg.norm(pole, axis=1, keepdims=True)
        off = np.einsum("px,px->p", curves.points, pole[curves.curve_of_point])
        errors.append(np.sqrt(np.mean(off**2)))
    assert errors[0] < 0.03
    assert errors[1] < errors[0] / 2
    assert errors[2] < errors[1] / 2


def test_helices_of_a_cylinder():
    mesh = shapes.cylinder(1.0, 4.0, faces=8000)
    start = np.argsort(mesh.barycenters[:, 2])[len(mesh.faces) // 2 - 20 :: 40][:8]
    around = np.cross([0, 0, 1.0], mesh.barycenters[start])
    around /= np.linalg.norm(around, axis=1, keepdims=True)
    curves = straightest(mesh, start, around + 0.2 * np.array([0, 0, 1.0]), 6.0)
    for curve in curves:
        angle = np.unwrap(np.arctan2(curve.points[:, 1], curve.points[:, 0]))
        slope, height = np.polyfit(angle, curve.points[:, 2], 1)
        assert slope == pytest.approx(0.2, rel=5e-3)
        # within a face the angle is not linear along a straight line
        assert np.abs(curve.points[:, 2] - slope * angle - height).max() < 2e-3


@pytest.mark.parametrize("side", [1, -1])
def test_equators_of_a_torus_run_through_vertices(side):
    mesh = shapes.torus(1.0, 0.4, faces=2000)
    radius = 1.0 + 0.4 * side
    level = np.isclose(mesh.vertices[:, 2], 0) & np.isclose(
        np.linalg.norm(mesh.vertices, axis=1), radius, rtol=0.02
    )
    corner_count = level[mesh.faces].sum(axis=1)
    face = int(np.flatnonzero(corner_count == 2)[0])
    a, b = mesh.vertices[mesh.faces[face][level[mesh.faces[face]]]]
    whole = level.sum() * np.linalg.norm(b - a)
    # from the middle of an edge once round, equal angles at every vertex: by mirror symmetry it closes
    curves = straightest(mesh, [face], [b - a], whole, points=[0.5 * (a + b)])
    assert np.abs(curves.points[:, 2]).max() < 1e-9
    np.testing.assert_allclose(curves.points[-1], 0.5 * (a + b), atol=1e-9)
    assert len(curves.points) in (level.sum() + 1, level.sum() + 2)


@pytest.mark.parametrize(
    "mesh",
    [shapes.icosahedron(), TriMesh(BOX.vertices, BOX.faces), surface("genus 5")],
    ids=["icosahedron", "cube", "genus 5"],
)
def test_a_corner_is_passed_with_equal_angles(mesh):
    """Of the total angle T around the corner, T / 2 lies on either side, summed face by face."""
    rng = np.random.default_rng(0)
    for _ in range(20):
        face, k = int(rng.integers(mesh.n_faces)), int(rng.integers(3))
        vertex = mesh.faces[face, k]
        weights = rng.uniform(0.2, 1.0, 3)
        start = weights @ mesh.vertices[mesh.faces[face]] / weights.sum()
        way = mesh.vertices[vertex] - start
        curves = straightest(mesh, [face], [way], np.linalg.norm(way) + 0.1 * mesh.mean_edge, points=[start])
        assert len(curves.points) == 3
        np.testing.assert_allclose(curves.points[1], mesh.vertices[vertex], atol=1e-12)
        left, right = angles_beside(mesh, vertex, curves.faces[:2], curves.points)
        assert left == pytest.approx(right, abs=1e-9)
        assert left + right == pytest.approx(TURN - mesh.angle_defects[vertex])


def angles_beside(mesh, vertex, faces, points) -> tuple[float, float]:
    """Angles between the ways back and onward round a vertex, to the left and to the right of the line."""

    def corner(face: int) -> int:
        return int(np.flatnonzero(mesh.faces[face] == vertex)[0])

    def from_first_side(face: int, point: np.ndarray) -> float:
        side = mesh.vertices[mesh.faces[face, (corner(face) + 1) % 3]] - mesh.vertices[vertex]
        ray = point - mesh.vertices[vertex]
        return float(np.arccos(side @ ray / np.linalg.norm(side) / np.linalg.norm(ray)))

    # Counter-clockwise from the way back, which is to the right of a line that goes on.
    right, face = -from_first_side(faces[0], points[0]), int(faces[0])
    while face != faces[1]:
        right += mesh.corner_angles[face, corner(face)]
        face = int(mesh.face_neighbors[face, (corner(face) + 1) % 3])
    right += from_first_side(face, points[2])
    return TURN - mesh.angle_defects[vertex] - right, right


def test_what_cannot_be_traced_is_refused():
    mesh = surface("disk")
    up, along = [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]]
    with pytest.raises(FieldError, match="no part in the plane"):
        straightest(mesh, [0], up, 1.0)
    with pytest.raises(FieldError, match="outside 0"):
        straightest(mesh, [mesh.n_faces], along, 1.0)
    with pytest.raises(FieldError, match="need shape"):
        straightest(mesh, [0, 1], along, 1.0)
    with pytest.raises(FieldError, match="must be positive"):
        straightest(mesh, [0], along, 0.0)
    with pytest.raises(FieldError, match="not in its face"):
        straightest(mesh, [0], along, 1.0, points=mesh.barycenters[[5]])
    rim = int(mesh.boundary_edges[0])
    face, middle = mesh.edge_faces[rim, 0], mesh.vertices[mesh.edges[rim]].mean(axis=0)
    with pytest.raises(FieldError, match="heads outwards"):
        straightest(mesh, [face], [middle], 1.0, points=[middle])
