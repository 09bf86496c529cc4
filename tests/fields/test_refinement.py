"""Fields on meshes whose factors lose digits: long flat strips, anisotropic grids, scans with slivers."""

from __future__ import annotations

import numpy as np
import pytest

import geoweave as gw
from geoweave.errors import FieldError
from geoweave.fields.closed_projection import ClosedProjection, ordering_of
from geoweave.fields.face_field import edge_curl, random_field, total_curl
from geoweave.fields.geodesic import geodesic_field
from geoweave.fields.operators import ClosedFields
from geoweave.fields.rosy import smoothest_field
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh


def grid(columns: int, rows: int, width: float, height: float) -> TriMesh:
    """A flat rectangle of so many cells, each cut along its diagonal, at bounding radius 1."""
    x, y = np.meshgrid(np.linspace(0, width, columns + 1), np.linspace(0, height, rows + 1))
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    up = corner + columns + 1
    lower, upper = np.stack([corner, corner + 1, up + 1], 1), np.stack([corner, up + 1, up], 1)
    return TriMesh(vertices, np.concatenate([lower, upper])).normalized()[0]


def with_slivers(height: float, count: int = 30) -> TriMesh:
    """A sphere in which vertices were moved to so small a height over an edge of theirs."""
    ball = shapes.sphere(faces=1280)
    vertices = ball.vertices.copy()
    for face in np.random.default_rng(0).choice(ball.n_faces, count, replace=False):
        a, b, c = ball.faces[face]
        vertices[a] = (vertices[b] + vertices[c]) / 2 + height * (vertices[a] - vertices[b])
    return TriMesh(vertices, ball.faces).normalized()[0]


@pytest.mark.parametrize(
    ("columns", "rows", "width", "height"),
    [(20, 40, 40.0, 1.0), (240, 2, 120.0, 1.0), (12, 12, 1000.0, 1.0), (400, 1, 100.0, 1.0)],
)
def test_flat_rectangles_keep_their_constant_field(columns, rows, width, height):
    """Triangles of 80:1, a strip of 120:1, a grid of 1000:1: the constant field is exact, and stays."""
    mesh = grid(columns, rows, width, height)
    solve = geodesic_field(smoothest_field(mesh))
    assert solve.converged
    assert total_curl(solve.field) < 1e-8
    np.testing.assert_allclose(
        solve.field.ambient, solve.field.ambient[:1].repeat(mesh.n_faces, 0), atol=1e-6
    )


@pytest.mark.parametrize("height", [1e-3, 1e-5, 1e-6])
def test_slivers_do_not_spoil_the_field(height):
    """The curl is that of the same sphere with less flat triangles."""
    mesh = with_slivers(height)
    solve = geodesic_field(smoothest_field(mesh))
    assert total_curl(solve.field) < 0.7 * total_curl(solve.initial)
    assert np.abs(edge_curl(solve.field + solve.delta)).max() < 1e-7
    plain = geodesic_field(smoothest_field(with_slivers(1e-2)))
    assert total_curl(solve.field) < 1.2 * total_curl(plain.field)


def test_refined_and_plain_projections_agree_on_a_good_mesh():
    fields = ClosedFields(shapes.torus(faces=600))
    w = random_field(fields.mesh, 0).values
    plain, refined = (ClosedProjection(fields, 0.01, ordering_of(fields)) for _ in range(2))
    assert refined.refine()
    assert not refined.refine()
    for one, other in zip(plain(w), refined(w), strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-8, atol=1e-8)


def test_refined_projections_keep_their_handles():
    mesh = grid(240, 2, 120.0, 1.0)
    handles = gw.Handles.from_ambient(mesh, [3, 477], [[0.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    solve = geodesic_field(smoothest_field(mesh), handles=handles)
    np.testing.assert_allclose(solve.field.ambient[[3, 477]], [[0, 1, 0], [0, 1, 0]], atol=1e-12)
    assert total_curl(solve.field) < 1e-6


def test_triangles_that_are_too_flat_are_refused_with_a_remedy_that_works():
    mesh = with_slivers(1e-9)
    with pytest.raises(FieldError, match="times as long as high") as refusal:
        geodesic_field(smoothest_field(mesh))
    assert "remesh" in str(refusal.value)
    even = gw.isotropic_remesh(mesh, 1280)
    solve = geodesic_field(smoothest_field(even))
    assert total_curl(solve.field) < total_curl(solve.initial)
