from __future__ import annotations

import numpy as np
import pytest

from geoweave.fields.least_bending import bending_directions, bending_power
from geoweave.fields.rosy import smoothest_rosy
from geoweave.models import catalogue, shapes
from geoweave.surface.mesh import TriMesh


def tube(inside_out: bool = False) -> TriMesh:
    """A cylinder of radius 1/2 without its ends."""
    mesh = shapes.cylinder(radius=0.5, height=3.0, faces=3_000)
    return TriMesh(mesh.vertices, mesh.faces[:, ::-1]) if inside_out else mesh


@pytest.mark.parametrize("inside_out", [False, True])
def test_a_tube_bends_round_its_axis_by_one_over_its_radius(inside_out):
    mesh = tube(inside_out)
    inner = np.abs(mesh.barycenters[:, 2] - mesh.barycenters[:, 2].mean()) < 1.0
    bends = bending_directions(mesh)
    round_it = mesh.planar(np.cross([0.0, 0.0, 1.0], mesh.barycenters))
    aligned = bends * (round_it / np.abs(round_it)).conj() ** 2
    mean = np.average(aligned[inner], weights=mesh.face_areas[inner])
    assert mean.real == pytest.approx(2.0, rel=0.02)
    assert abs(mean.imag) < 0.01 * mean.real


def test_a_boundary_is_where_the_surface_bends_most():
    mesh = shapes.square(faces=800)
    bends = bending_directions(mesh)
    open_sides = mesh.face_neighbors < 0
    on_boundary = open_sides.sum(axis=1) == 1
    assert (bends[~open_sides.any(axis=1)] == 0).all()
    side = open_sides[on_boundary].argmax(axis=1)
    edge = mesh.halfedge_vectors[np.flatnonzero(on_boundary), side]
    np.testing.assert_allclose(np.angle(-bends[on_boundary] / edge**2), 0.0, atol=1e-9)


@pytest.mark.parametrize("degree", [2, 4, 6])
def test_an_even_rosy_of_a_tube_has_vectors_along_it(degree):
    rosy = smoothest_rosy(tube(), degree)
    along = rosy.mesh.planar(np.broadcast_to([0.0, 0.0, 1.0], (rosy.mesh.n_faces, 3)))
    np.testing.assert_allclose(rosy.values * along.conj() ** degree, 1.0, atol=0.05)


@pytest.mark.parametrize("degree", [1, 2, 3, 5, 6])
def test_frames_do_not_matter(degree):
    """Turning the corners of a face turns its frame, and the N-th power by N times the angle."""
    mesh = catalogue.load("spot")
    again = TriMesh(mesh.vertices, np.roll(mesh.faces, 1, axis=1))
    (one, weight), (two, same) = bending_power(mesh, degree), bending_power(again, degree)
    turn = again.planar(mesh.frames[:, 0]) ** degree
    np.testing.assert_allclose(same, weight, rtol=1e-6)
    heavy = weight > 1e-3 * weight.max()
    np.testing.assert_allclose(two[heavy], (one * turn)[heavy], atol=1e-6)
