"""The icosahedron cut into triangles: counts, places, orientation."""

import numpy as np
import pytest

from geoweave.models.icosahedral import cut_icosahedron
from geoweave.surface import TriMesh


@pytest.mark.parametrize("bent", [False, True])
@pytest.mark.parametrize("n", [1, 2, 5])
def test_the_points_of_the_sides_are_shared(n: int, bent: bool) -> None:
    mesh = TriMesh(*cut_icosahedron(n, bent=bent))
    assert (mesh.n_vertices, mesh.n_faces) == (10 * n * n + 2, 20 * n * n)
    assert (mesh.genus, mesh.boundary_loops) == (0, ())
    assert (np.einsum("fx,fx->f", mesh.face_normals, mesh.barycenters) > 0).all()


def test_flat_sides_are_cut_evenly() -> None:
    mesh = TriMesh(*cut_icosahedron(4))
    assert np.allclose(mesh.edge_lengths, mesh.edge_lengths[0])


def test_bent_sides_are_even_on_the_sphere() -> None:
    """The ratio of the largest to the smallest face on the sphere is the reason for bending."""

    def spread(bent: bool) -> float:
        points, faces = cut_icosahedron(8, bent=bent)
        areas = TriMesh(points / np.linalg.norm(points, axis=1, keepdims=True), faces).face_areas
        return float(areas.max() / areas.min())

    assert spread(True) < 1.35
    assert spread(False) > 1.7
