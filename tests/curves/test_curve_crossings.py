"""Crossings of curves: all of them, once each, with their places and angles."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import scattered, surface, uneven_square

from geoweave.curves.curve_crossings import crossings
from geoweave.curves.curves import Curves
from geoweave.curves.straightest_geodesics import straightest
from geoweave.foliation.circle_function import TURN, CircleFunction
from geoweave.foliation.level_sets import isolines
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh


def test_all_crossings_of_lines_in_a_plane():
    curves = scattered(uneven_square(), 60, 1.0, seed=3, behind=0.4)
    found = crossings(curves)
    a, b = curves.points[curves.offsets[:-1], :2], curves.points[curves.offsets[1:] - 1, :2]
    expected = []
    for i in range(60):
        for j in range(i + 1, 60):
            s, t = np.linalg.solve(np.stack([b[i] - a[i], a[j] - b[j]], axis=1), a[j] - a[i])
            if 0 < s < 1 and 0 < t < 1:
                turn = np.cross(np.append(b[i] - a[i], 0), np.append(b[j] - a[j], 0))[2]
                expected.append(
                    (i, j, s * np.linalg.norm(b[i] - a[i]), t * np.linalg.norm(b[j] - a[j]), turn)
                )
    assert len(expected) > 200
    listed = sorted(zip(*found.curves.T, *found.arclength.T, found.angle, strict=True))
    assert [each[:2] for each in listed] == [each[:2] for each in expected]
    np.testing.assert_allclose([each[2:4] for each in listed], [each[2:4] for each in expected], atol=1e-6)
    assert np.array_equal(np.sign([each[4] for each in listed]), np.sign([each[4] for each in expected]))
    direction = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
    cosine = np.einsum("nx,nx->n", direction[found.curves[:, 0]], direction[found.curves[:, 1]])
    np.testing.assert_allclose(np.cos(found.angle), cosine, atol=1e-6)
    np.testing.assert_allclose(
        found.points[:, :2],
        a[found.curves[:, 0]] + found.arclength[:, :1] * direction[found.curves[:, 0]],
        atol=1e-6,
    )


def test_crossings_on_an_edge_count_once():
    mesh = shapes.square(faces=800)  # edges on the lines x = 0.1 k
    near = [
        int(np.argmin(np.linalg.norm(mesh.barycenters - [x, y, 0], axis=1))) for x, y in ((0, 0), (0, 0.1))
    ]
    way = np.array([0.1, 0.043, 0.0]) - mesh.barycenters[near]
    curves = straightest(mesh, near, way, 0.3)
    found = crossings(curves)
    assert len(found) == 1
    np.testing.assert_allclose(found.points[0], [0.1, 0.043, 0.0], atol=1e-12)
    np.testing.assert_allclose(found.arclength[0], np.linalg.norm(way, axis=1), atol=1e-12)


def test_a_geodesic_of_a_torus_crosses_itself():
    mesh = shapes.torus(1.0, 0.4, faces=6000)
    curves = straightest(mesh, [0], [[0.3, 1.0, 1.0]], 30.0)
    found = crossings(curves)
    assert len(found) > 5
    assert (found.curves == 0).all()
    assert (found.arclength[:, 0] < found.arclength[:, 1]).all()
    assert (np.diff(found.arclength[:, 0]) >= 0).all()
    # the same place from either arc length
    for k in (0, 1):
        share = (found.arclength[:, k] - curves.arclength[found.segments[:, k]]) / curves.segment_lengths[
            found.segments[:, k]
        ]
        place = curves.points[found.segments[:, k]] + share[:, None] * curves.segments[found.segments[:, k]]
        np.testing.assert_allclose(place, found.points, atol=1e-9)


def test_great_circles_cross_twice():
    ball = shapes.sphere(faces=20480)
    curves = scattered(ball, 80, TURN - 0.3, seed=8)
    count = np.zeros((80, 80), dtype=int)
    other = crossings(curves).curves
    other = other[other[:, 0] != other[:, 1]]
    np.add.at(count, tuple(other.T), 1)
    upper = count[np.triu_indices(80, 1)]
    # a gap of 0.3 each hides about a tenth of the crossings; facets add hardly any
    assert upper.mean() == pytest.approx(2 * (1 - 0.3 / TURN) ** 2, abs=0.05)
    assert upper.max() <= 3


@pytest.mark.parametrize("name", ["jagged sphere", "genus 5", "disk"])
def test_level_sets_never_cross_not_even_in_dislocated_faces(name):
    mesh = surface(name)
    rng = np.random.default_rng(9)
    theta, change = rng.uniform(0, TURN, mesh.n_vertices), rng.normal(0, 12.0, mesh.n_edges)
    circle = CircleFunction.nearest(mesh, theta, change)
    assert circle.dislocated.mean() > 0.3
    assert len(crossings(isolines(circle, (1.0,)))) == 0


def test_nothing_crosses_where_there_is_nothing():
    mesh = surface("disk")
    none = isolines(CircleFunction(mesh, np.zeros(mesh.n_vertices), np.zeros(mesh.n_edges)))
    assert len(crossings(none)) == 0


def test_a_crossing_at_the_seam_of_a_closed_curve_lies_there():
    """Where a closed curve begins again, its arc length is set back to zero; the place and the face stay."""
    mesh = TriMesh([[0, 0, 0], [4, 0, 0], [0, 4, 0]], [[0, 1, 2]])
    loop, before_seam = [[1, 1, 0], [1.5, 1, 0], [1.5, 1.5, 0], [1, 1.5, 0]], 1.0 + 1e-9
    line = [[0.5, before_seam, 0], [1.2, before_seam, 0]]
    flat, count = np.zeros(6), np.array([0, 4, 6])
    closed = np.array([True, False])
    found = crossings(
        Curves(mesh, np.array(loop + line), flat.astype(np.int64), flat, flat > 0, count, closed)
    )
    assert found.curves.tolist() == [[0, 1]]
    np.testing.assert_allclose(found.points, [[1.0, 1.0, 0.0]], atol=1e-8)
    np.testing.assert_allclose(found.arclength, [[0.0, 0.5]], atol=1e-8)
    assert found.segments.tolist() == [[0, 4]]
