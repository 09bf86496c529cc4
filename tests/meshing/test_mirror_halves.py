"""One half of a surface and its image make a surface that is exactly its own image."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from geoweave.errors import MeshError
from geoweave.meshing.mirror_halves import mirrored_half
from geoweave.meshing.weaving_mesh import smallest_angles
from geoweave.models import datasets, shapes
from geoweave.surface.mesh import TriMesh
from geoweave.surface.mirror_symmetry import MirrorPlane, mirror_plane


def is_its_own_image(mesh: TriMesh, plane: MirrorPlane) -> bool:
    """Whether every vertex and every face has its image among the others, turned over."""
    off, image = KDTree(mesh.vertices).query(plane.image(mesh.vertices))
    faces = {tuple(np.roll(face, -int(np.argmin(face)))) for face in mesh.faces.tolist()}
    turned = {tuple(np.roll(face, -int(np.argmin(face)))) for face in image[mesh.faces[:, ::-1]]}
    return off.max() < 1e-12 and faces == turned


@pytest.mark.parametrize("name", ["spot", "camel"])
def test_a_scan_becomes_its_own_image_and_stays_what_it_was(name: str) -> None:
    scan = datasets.load(name)
    plane = mirror_plane(scan)
    both = mirrored_half(scan, plane)
    assert not is_its_own_image(scan, plane)
    assert is_its_own_image(both, plane)
    assert (both.euler_characteristic, both.n_components) == (scan.euler_characteristic, 1)
    assert both.face_areas.sum() == pytest.approx(scan.face_areas.sum(), rel=0.01)
    assert both.n_faces == pytest.approx(scan.n_faces, rel=0.05)
    assert np.quantile(smallest_angles(both), 0.01) > 10.0  # degrees: no slivers along the plane


def test_it_does_not_matter_where_the_surface_lies() -> None:
    turn = Rotation.random(rng=2)
    spot = datasets.load("spot")
    moved = TriMesh(turn.apply(np.array(spot.vertices)) + [1.0, 2.0, 3.0], spot.faces)
    one, other = (mirrored_half(each, mirror_plane(each)) for each in (spot, moved))
    assert one.n_faces == pytest.approx(other.n_faces, rel=0.01)
    assert one.face_areas.sum() == pytest.approx(other.face_areas.sum(), rel=1e-3)


def test_an_open_surface_with_vertices_in_the_plane() -> None:
    disk = shapes.disk(faces=400)
    plane = MirrorPlane(np.array([0.0, 1.0, 0.0]), 0.0, 0.0)
    both = mirrored_half(disk, plane)
    assert is_its_own_image(both, plane)
    assert len(both.boundary_loops) == 1
    assert both.face_areas.sum() == pytest.approx(disk.face_areas.sum(), rel=0.01)


def test_halves_that_do_not_make_the_surface_again_are_refused() -> None:
    """The plane runs beside the hole of a torus, so that there would be two."""
    torus = shapes.torus(major=1.0, minor=0.4, faces=2_000)
    beside = MirrorPlane(np.array([1.0, 0.0, 0.0]), -0.2, 0.0)
    assert mirrored_half(torus, MirrorPlane(np.array([1.0, 0.0, 0.0]), 0.0, 0.0)).genus == 1
    with pytest.raises(MeshError, match="a surface of another topology"):
        mirrored_half(torus, MirrorPlane(np.array([1.0, 0.0, 0.0]), 1.1, 0.0))
    assert mirrored_half(torus, beside).genus == 1
