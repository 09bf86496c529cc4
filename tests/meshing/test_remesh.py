import numpy as np
import pytest

from geoweave.errors import MeshError
from geoweave.meshing.prepare import read_mesh
from geoweave.meshing.remesh import isotropic_remesh
from geoweave.models import datasets, shapes
from geoweave.surface.closest_point import closest_points, segment_tree, triangle_tree
from geoweave.surface.mesh import TriMesh

SURFACES = {
    "armadillo": lambda: datasets.load("armadillo"),
    "camel": lambda: datasets.load("camel"),
    "genus 3": lambda: shapes.genus_g(3, faces=3_000),
    "rocker arm": lambda: shapes.rocker_arm(faces=4_000),
    "Schwarz-P": lambda: shapes.schwarz_p(faces=4_000),
    "annulus": lambda: shapes.annulus(faces=3_000),
    "cylinder": lambda: shapes.cylinder(faces=3_000),
}


def topology(mesh: TriMesh) -> tuple[int, int, int]:
    return mesh.n_components, mesh.genus, len(mesh.boundary_loops)


def distance_to(mesh: TriMesh, points: np.ndarray) -> float:
    found, _ = closest_points(triangle_tree(mesh.vertices[mesh.faces]), points)
    return float(np.linalg.norm(found - points, axis=1).max() / np.ptp(mesh.vertices, axis=0).max())


def box() -> TriMesh:
    """A unit cube of two triangles a side."""
    corners = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return TriMesh(corners, np.array([[q[0], q[i], q[i + 1]] for q in quads for i in (1, 2)]))


@pytest.mark.parametrize("faces", [1_500, 6_000])
@pytest.mark.parametrize("name", SURFACES)
def test_count_topology_place_and_quality(name: str, faces: int) -> None:
    mesh = SURFACES[name]()
    even = isotropic_remesh(mesh, faces)
    assert abs(even.n_faces - faces) <= 3
    assert topology(even) == topology(mesh)
    assert distance_to(mesh, even.vertices) < 1e-12
    angles = np.degrees(even.corner_angles)
    assert angles.min() > 15
    assert np.quantile(angles, 0.01) > 38
    assert even.edge_lengths.std() < 0.15 * even.edge_lengths.mean()
    six = np.bincount(even.faces.ravel())[~even.boundary_vertices] == 6
    assert six.mean() > 0.6


@pytest.mark.parametrize("name", ["Schwarz-P", "annulus", "cylinder"])
def test_rims_stay_rims(name: str) -> None:
    mesh = SURFACES[name]()
    even = isotropic_remesh(mesh, 2_500)
    rims = segment_tree(mesh.vertices[mesh.edges[mesh.boundary_edges]])
    points = even.vertices[even.boundary_vertices]
    found, _ = closest_points(rims, points)
    np.testing.assert_allclose(points, found, atol=1e-12 * np.ptp(mesh.vertices))
    before, after = (m.edge_lengths[m.boundary_edges].sum() for m in (mesh, even))
    assert after == pytest.approx(before, rel=0.03)


def test_corners_and_flat_area_stay() -> None:
    even = isotropic_remesh(shapes.square(faces=8), 1_000)
    assert even.face_areas.sum() == pytest.approx(4.0, rel=1e-12)
    for corner in ([-1, -1, 0], [-1, 1, 0], [1, -1, 0], [1, 1, 0]):
        assert np.linalg.norm(even.vertices - corner, axis=1).min() < 1e-12


def test_creases_stay_where_they_are_asked_for() -> None:
    sharp = isotropic_remesh(box(), 1_200, feature_angle=40)
    assert sharp.face_areas.sum() == pytest.approx(6.0, rel=1e-12)
    assert np.degrees(sharp.corner_angles.min()) > 20
    worn = isotropic_remesh(box(), 1_200)
    assert worn.face_areas.sum() < 5.95


def test_a_fan_of_needles_becomes_even() -> None:
    turn = 2.0 * np.pi * np.arange(500) / 500
    points = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    rim = np.arange(500)
    faces = np.stack([rim, np.roll(rim, -1), np.full(500, 500)], axis=1)
    cone = TriMesh(np.concatenate([points, [[0.0, 0.0, 0.7]]]), faces)
    even = isotropic_remesh(cone, 1_500)
    assert abs(even.n_faces - 1_500) <= 3
    # The needles had 0.7 degrees. Measured 23 to 27, by platform: the order of edits follows the last digit.
    assert np.degrees(even.corner_angles.min()) > 18
    assert np.bincount(even.faces.ravel()).max() < 12


def test_refining_and_coarsening_are_both_fine() -> None:
    mesh = shapes.sphere(faces=320)
    fine = isotropic_remesh(mesh, 20_000)
    assert abs(fine.n_faces - 20_000) <= 3
    assert distance_to(mesh, fine.vertices) < 1e-12
    coarse = isotropic_remesh(fine, 100)
    assert abs(coarse.n_faces - 100) <= 3
    assert topology(coarse) == topology(mesh)


@pytest.mark.parametrize("scale", [2.0**-30, 1.0, 2.0**30])
def test_the_same_input_at_any_scale_gives_the_same_mesh(scale: float) -> None:
    mesh = shapes.torus(faces=600)
    once = isotropic_remesh(mesh, 900)
    again = isotropic_remesh(TriMesh(scale * mesh.vertices, mesh.faces), 900)
    np.testing.assert_array_equal(once.faces, again.faces)
    np.testing.assert_allclose(scale * once.vertices, again.vertices, rtol=1e-12, atol=1e-12 * scale)


def test_components_stay_apart() -> None:
    ball, ring = shapes.sphere(faces=320), shapes.torus(faces=600)
    both = TriMesh(
        np.concatenate([ball.vertices, ring.vertices + np.array([3.0, 0.0, 0.0])]),
        np.concatenate([ball.faces, ring.faces + ball.n_vertices]),
    )
    assert topology(isotropic_remesh(both, 500)) == (2, 1, 0)


@pytest.mark.parametrize(
    ("faces", "says"),
    [(3, "at least 4"), (12, "ask for at least")],
    ids=["senseless", "too few for the topology"],
)
def test_what_cannot_be_is_refused(faces: int, says: str) -> None:
    with pytest.raises(MeshError, match=says):
        isotropic_remesh(shapes.genus_g(3, faces=2_000), faces)


@pytest.mark.parametrize("faces", [5_000_001, 1_000_000_000, 10**18])
def test_more_faces_than_memory_holds_are_refused_before_any_work(faces, tmp_path):
    with pytest.raises(MeshError, match=r"cannot remesh to [0-9,]+ faces: they would take [0-9,]+ GB"):
        isotropic_remesh(shapes.icosahedron(), faces)
    with pytest.raises(MeshError, match=r"^nowhere.obj: cannot remesh to .*at most 5,000,000$"):
        read_mesh("nowhere.obj", faces=faces)
