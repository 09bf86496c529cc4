"""How faces hang together: genus, loops and neighbours, whatever the positions of the vertices."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import ALL, surface

from geoweave.surface.connectivity import corner_after

GENUS_AND_LOOPS = {
    "sphere": (0, 0),
    "torus": (1, 0),
    "genus 5": (5, 0),
    "disk": (0, 1),
    "annulus": (0, 2),
    "cylinder": (0, 2),
    "Schwarz-P": (5, 24),
    "two pieces": (1, 1),
}


@pytest.mark.parametrize("name", GENUS_AND_LOOPS)
def test_topology(name):
    mesh = surface(name)
    assert (mesh.genus, len(mesh.boundary_loops)) == GENUS_AND_LOOPS[name]
    assert mesh.n_components == (2 if name == "two pieces" else 1)


@pytest.mark.parametrize("name", ALL)
def test_neighbours_are_mutual(name):
    mesh = surface(name)
    rows, corners = np.nonzero(mesh.face_neighbors >= 0)
    there = mesh.face_neighbors[rows, corners]
    assert (mesh.face_neighbors[there] == rows[:, None]).any(axis=1).all()
    assert (mesh.face_neighbors < 0).sum() == len(mesh.boundary_edges)


def test_boundary_loops_follow_the_faces_beside_them():
    mesh = surface("annulus")
    directed = {
        (int(a), int(b)) for loop in mesh.boundary_loops for a, b in zip(loop, np.roll(loop, -1), strict=True)
    }
    assert directed == {(int(a), int(b)) for a, b in mesh.edges[mesh.boundary_edges]}


@pytest.mark.parametrize("name", ALL)
def test_corners_across_an_edge_are_its_ends_in_both_faces(name):
    mesh = surface(name)
    here, there = mesh.corners_across(mesh.interior_edges)
    ends = mesh.edges[mesh.interior_edges]
    for corners, side in ((here, 0), (there, 1)):
        np.testing.assert_array_equal(mesh.faces.ravel()[corners], ends)
        np.testing.assert_array_equal(corners[:, 0] // 3, mesh.edge_faces[mesh.interior_edges, side])


def test_three_corners_on_is_the_corner_itself():
    halfedges = np.arange(12)
    np.testing.assert_array_equal(corner_after(halfedges, 3), halfedges)
    np.testing.assert_array_equal(corner_after(corner_after(halfedges, 1), 2), halfedges)
    np.testing.assert_array_equal(corner_after(halfedges, 1) // 3, halfedges // 3)
