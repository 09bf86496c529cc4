"""The plane of symmetry is found wherever the surface lies, and a surface without one is refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from geoweave.errors import MeshError
from geoweave.models import datasets, shapes
from geoweave.surface.mesh import TriMesh
from geoweave.surface.mirror_symmetry import MirrorPlane, mirror_plane


def turned(mesh: TriMesh, turn: Rotation) -> TriMesh:
    return TriMesh(turn.apply(np.array(mesh.vertices)) + [3.0, -2.0, 5.0], mesh.faces)


def test_an_image_is_as_far_behind_the_plane() -> None:
    plane = MirrorPlane(np.array([0.6, 0.8, 0.0]), 2.0, 0.0)
    points = np.random.default_rng(0).normal(size=(20, 3))
    image = plane.image(points)
    np.testing.assert_allclose(0.5 * (points + image) @ plane.normal, 2.0)
    np.testing.assert_allclose(plane.image(image), points, atol=1e-12)
    np.testing.assert_allclose(plane.image_of_vectors(points[1:] - points[:-1]), np.diff(image, axis=0))


@pytest.mark.parametrize("seed", range(3))
def test_the_plane_of_a_symmetric_scan_is_found_wherever_it_lies(seed: int) -> None:
    """Spot is symmetric across x but for a thousandth of its size."""
    turn = Rotation.random(rng=seed)
    mesh = turned(datasets.load("spot"), turn)
    plane = mirror_plane(mesh)
    assert abs(plane.normal @ turn.apply([1.0, 0.0, 0.0])) > np.cos(np.radians(0.3))
    assert plane.residual < 2e-3


def test_fitting_mends_a_plane_that_the_axes_of_inertia_miss() -> None:
    """One half has a dent, which moves the centre; the rest still says where the plane is."""
    ball = shapes.sphere(faces=5120)
    points = np.array(ball.vertices) * [1.0, 1.6, 2.3]
    points[np.linalg.norm(points - [0.9, 0.3, 0.2], axis=1) < 0.25] *= 0.85
    plane = mirror_plane(TriMesh(points, ball.faces), "x")
    assert abs(plane.offset) < 4e-3
    assert plane.normal.tolist() == [1.0, 0.0, 0.0]


def test_a_surface_without_a_plane_is_refused() -> None:
    with pytest.raises(MeshError, match=r"no mirror plane: it is \d+\.\d% of its size off its image across"):
        mirror_plane(datasets.load("bunny"))
    with pytest.raises(MeshError, match=r"no mirror plane across y: .* 1% are allowed"):
        mirror_plane(datasets.load("spot"), "y")
    with pytest.raises(MeshError, match="no mirror axis 'w': auto, x, y, z"):
        mirror_plane(datasets.load("spot"), "w")  # type: ignore[arg-type]
