"""Covers: what topology says of them, their symmetries, and what lies on them seen from below."""

from __future__ import annotations

import time

import numpy as np
import pytest

from geoweave import shapes
from geoweave.cover import Cover, branched_cover
from geoweave.curves import geodesic_curvature
from geoweave.errors import FieldError, MeshError
from geoweave.fields import total_curl
from geoweave.rosy import RoSyField, smoothest_rosy
from geoweave.singularities import rotation_across
from geoweave.tracing import streamlines
from tests.surfaces import ALL, surface


def cover_of(name: str, degree: int = 6) -> Cover:
    return branched_cover(smoothest_rosy(surface(name), degree))


@pytest.mark.parametrize("degree", [1, 2, 3, 4, 5, 6])
@pytest.mark.parametrize("name", ALL)
def test_riemann_and_hurwitz(name: str, degree: int) -> None:
    """chi(C) = N chi of the punctured surface; each puncture is covered by the cycles of its shift."""
    cover = cover_of(name, degree)
    assert cover.mesh.euler_characteristic == degree * cover.part.mesh.euler_characteristic
    assert cover.mesh.n_faces == degree * cover.part.mesh.n_faces
    assert cover.mesh.n_edges == degree * cover.part.mesh.n_edges


@pytest.mark.parametrize("name", ALL)
def test_faces_lie_on_the_faces_below(name: str) -> None:
    cover = cover_of(name)
    below = cover.rosy.mesh
    np.testing.assert_array_equal(cover.vertices[cover.mesh.faces], below.faces[cover.faces])
    np.testing.assert_array_equal(cover.mesh.vertices, below.vertices[cover.vertices])
    np.testing.assert_array_equal(cover.mesh.frames, below.frames[cover.faces])
    ambient = below.frames[cover.faces]
    vector = cover.field.values
    np.testing.assert_array_equal(
        cover.field.ambient, vector.real[:, None] * ambient[:, 0] + vector.imag[:, None] * ambient[:, 1]
    )
    np.testing.assert_allclose(vector**6, cover.rosy.values[cover.faces], atol=1e-12)


@pytest.mark.parametrize("name", ALL)
def test_away_from_its_rim_the_cover_looks_like_the_surface(name: str) -> None:
    """Every interior vertex above has the same faces round it, in number and in angle, as the one below."""
    cover = cover_of(name)
    inside = ~cover.mesh.boundary_vertices
    np.testing.assert_allclose(
        cover.mesh.angle_defects[inside], cover.rosy.mesh.angle_defects[cover.vertices[inside]], atol=1e-12
    )
    assert not np.intersect1d(cover.vertices[inside], cover.rosy.branch_points).size


@pytest.mark.parametrize("degree", [3, 6])
@pytest.mark.parametrize("name", ["jagged sphere", "genus 5", "two pieces"])
def test_glued_vectors_are_matched_vectors(name: str, degree: int) -> None:
    """Across every edge of the cover the field turns by at most half the angle between two vectors."""
    field = cover_of(name, degree).field
    assert np.abs(rotation_across(field)).max() <= np.pi / degree + 1e-9


@pytest.mark.parametrize("name", ALL)
def test_antipodes(name: str) -> None:
    """An involution without fixed points that keeps orientation and what lies below; the field is odd."""
    cover = cover_of(name)
    faces, vertices = cover.antipodes
    for permutation in (faces, vertices):
        everyone = np.arange(len(permutation))
        assert (permutation != everyone).all()
        np.testing.assert_array_equal(permutation[permutation], everyone)
    np.testing.assert_array_equal(cover.mesh.faces[faces], vertices[cover.mesh.faces])
    np.testing.assert_array_equal(cover.faces[faces], cover.faces)
    np.testing.assert_array_equal(cover.vertices[vertices], cover.vertices)
    np.testing.assert_allclose(cover.field.values[faces], -cover.field.values, atol=1e-15)


def test_the_turn_by_one_sheet_has_order_n() -> None:
    cover = cover_of("jagged sphere", 5)
    faces, vertices = cover.next_sheet
    np.testing.assert_array_equal(cover.mesh.faces[faces], vertices[cover.mesh.faces])
    np.testing.assert_allclose(
        cover.field.values[faces], cover.field.values * np.exp(2j * np.pi / 5), atol=1e-12
    )
    image = np.arange(cover.mesh.n_faces)
    for _ in range(5):
        image = faces[image]
    np.testing.assert_array_equal(image, np.arange(cover.mesh.n_faces))


def test_an_odd_cover_has_no_antipodes() -> None:
    with pytest.raises(FieldError, match="5 sheets has no antipodes"):
        _ = cover_of("disk", 5).antipodes


def test_without_branch_points_the_sheets_fall_apart() -> None:
    cover = cover_of("disk")
    assert cover.mesh.n_components == 6
    for component in range(6):
        # numbers of sheets are a matter of frames, so one component may take a face from each
        mine = cover.faces[cover.mesh.face_components == component]
        np.testing.assert_array_equal(np.sort(mine), np.arange(surface("disk").n_faces))


def test_components_below_stay_apart_above() -> None:
    cover = cover_of("two pieces")
    below = cover.rosy.mesh.face_components[cover.faces]
    above = cover.mesh.face_components
    assert all(len(np.unique(below[above == c])) == 1 for c in range(cover.mesh.n_components))
    # six copies of the flat disk, and at least one component above the torus
    assert cover.mesh.n_components >= 7


def test_the_icosahedron_of_figure_17() -> None:
    """Twelve branch points of index 1/6, each under one loop; the lifted field is curl-free to rounding."""
    cover = branched_cover(smoothest_rosy(shapes.icosahedron(720), 6))
    assert len(cover.rosy.branch_points) == 12
    assert len(cover.mesh.boundary_loops) == 12
    assert len(cover.part.mesh.boundary_loops) == 12
    # a loop above goes six times round its branch point
    below = len(cover.part.mesh.boundary_loops[0])
    assert all(len(loop) == 6 * below for loop in cover.mesh.boundary_loops)
    assert total_curl(cover.field) < 1e-11


def test_lines_on_the_cover_are_lines_on_the_surface() -> None:
    cover = cover_of("torus")
    above = streamlines(cover.field, separation=0.3)
    below = cover.project(above)
    assert below.mesh is cover.rosy.mesh
    np.testing.assert_array_equal(below.points, above.points)
    np.testing.assert_array_equal(below.normals, above.normals)
    np.testing.assert_array_equal(geodesic_curvature(below, 0.1), geodesic_curvature(above, 0.1))
    with pytest.raises(FieldError, match="on the mesh of the cover"):
        cover.project(below)


def test_a_surface_of_branch_points_only_is_refused() -> None:
    with pytest.raises(MeshError, match="none of the 20 faces"):
        branched_cover(smoothest_rosy(shapes.icosahedron(), 6))


def test_a_rough_rosy_has_a_cover_too() -> None:
    """Hundreds of branch points side by side: punctures merge, the rest is still a surface."""
    mesh = surface("jagged sphere")
    angle = np.random.default_rng(0).uniform(0.0, 2.0, mesh.n_faces)
    rosy = RoSyField(mesh, 6, np.exp(1j * angle))
    cover = branched_cover(rosy)
    assert len(rosy.branch_points) > 50
    assert cover.mesh.euler_characteristic == 6 * cover.part.mesh.euler_characteristic


def test_a_cover_of_thirty_thousand_faces_is_quick() -> None:
    rosy = smoothest_rosy(shapes.sphere(faces=30_000), 6)
    begin = time.process_time()
    branched_cover(rosy)
    # measured 0.9 s
    assert time.process_time() - begin < 2.5
