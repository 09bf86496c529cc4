"""A part of a surface is a surface, and remembers where it came from."""

import numpy as np
import pytest
from surfaces import ALL, surface

from geoweave.errors import MeshError
from geoweave.surface.submesh import part_of


@pytest.mark.parametrize("name", ALL)
def test_everything_kept_is_the_whole(name: str) -> None:
    mesh = surface(name)
    part = part_of(mesh, np.ones(mesh.n_faces, dtype=bool))
    np.testing.assert_array_equal(part.mesh.faces, mesh.faces)
    np.testing.assert_array_equal(part.mesh.vertices, mesh.vertices)
    assert part.kept.all()


@pytest.mark.parametrize("name", ALL)
def test_half_of_the_faces_at_random(name: str) -> None:
    mesh = surface(name)
    keep = np.random.default_rng(1).random(mesh.n_faces) < 0.5
    part = part_of(mesh, keep)  # building the mesh checks that no vertex joins two fans
    np.testing.assert_array_equal(part.kept, keep)
    np.testing.assert_array_equal(part.vertices[part.mesh.faces], mesh.faces[keep])
    np.testing.assert_allclose(part.mesh.frames, mesh.frames[keep], atol=1e-15)
    both_kept = keep[mesh.edge_faces[mesh.interior_edges]].all(axis=1)
    assert len(part.mesh.interior_edges) == both_kept.sum()


def test_a_puncture_opens_one_loop() -> None:
    mesh = surface("sphere")
    part = part_of(mesh, ~(mesh.faces == 5).any(axis=1))
    assert part.mesh.euler_characteristic == mesh.euler_characteristic - 1
    assert len(part.mesh.boundary_loops) == 1


def test_flags_that_do_not_fit_are_refused() -> None:
    mesh = surface("disk")
    with pytest.raises(MeshError, match="need shape"):
        part_of(mesh, np.ones(3, dtype=bool))
    with pytest.raises(MeshError, match="none of"):
        part_of(mesh, np.zeros(mesh.n_faces, dtype=bool))
