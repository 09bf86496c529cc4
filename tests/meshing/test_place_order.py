"""A surface is remeshed to the same triangles however it is listed or turned."""

import numpy as np
import pytest

from benchmarks.invariance import mirrored, renumbered, turned
from geoweave.meshing.place_order import ordered_by_place
from geoweave.meshing.prepare import prepare_arrays
from geoweave.meshing.weaving_mesh import evened
from geoweave.models import catalogue


def test_renumbering_is_undone():
    spot = catalogue.load("spot")
    one, two = ordered_by_place(spot), ordered_by_place(renumbered(spot))
    np.testing.assert_array_equal(one.faces, two.faces)
    np.testing.assert_array_equal(one.vertices, two.vertices)


def test_the_surface_and_its_orientation_stay():
    spot = catalogue.load("spot")
    again = ordered_by_place(spot)
    one, two = (
        np.einsum("f,fx,fx->", each.face_areas, each.barycenters, each.face_normals) for each in (spot, again)
    )
    assert one > 0
    assert two == pytest.approx(one)
    distance = np.linalg.norm(
        again.vertices - np.average(again.barycenters, axis=0, weights=again.face_areas), axis=1
    )
    assert (np.diff(distance) >= 0).all()
    assert (again.faces[:, 0] == again.faces.min(axis=1)).all()


@pytest.mark.parametrize("change", [turned, renumbered, mirrored])
def test_remeshing_for_a_weave_gives_the_same_triangles(change):
    spot = catalogue.load("spot")

    def shape(mesh):
        return evened(prepare_arrays(mesh.vertices, mesh.faces), ribbons=150).mesh

    one, two = shape(spot), shape(change(spot))
    if change is mirrored:
        # The order in which edges of one face come is turned round; few edits notice.
        assert two.n_faces == pytest.approx(one.n_faces, rel=0.01)
        assert two.mean_edge == pytest.approx(one.mean_edge, rel=1e-3)
        return
    np.testing.assert_array_equal(one.faces, two.faces)
    np.testing.assert_allclose(np.sort(one.edge_lengths), np.sort(two.edge_lengths), rtol=1e-6)
