import numpy as np
import pytest

from geoweave.errors import MeshError
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh

# name -> builder, genus, boundary loops
TOPOLOGY = {
    "icosahedron": (shapes.icosahedron, 0, 0),
    "sphere": (lambda: shapes.sphere(faces=2_000), 0, 0),
    "torus": (lambda: shapes.torus(faces=2_000), 1, 0),
    "cylinder": (lambda: shapes.cylinder(faces=2_000), 0, 2),
    "disk": (lambda: shapes.disk(faces=2_000), 0, 1),
    "annulus": (lambda: shapes.annulus(faces=2_000), 0, 2),
    "square": (lambda: shapes.square(faces=2_000), 0, 1),
    "Schwarz-P": (lambda: shapes.schwarz_p(faces=3_000), 5, 24),
    "one cell": (lambda: shapes.schwarz_p(cells=1, faces=1_000), 0, 6),
    "genus 0": (lambda: shapes.genus_g(0, faces=1_000), 0, 0),
    "genus 2": (lambda: shapes.genus_g(2, faces=2_000), 2, 0),
    "genus 5": (lambda: shapes.genus_g(5, faces=3_000), 5, 0),
    "rocker arm": (lambda: shapes.rocker_arm(faces=3_000), 1, 0),
    "flat icosahedron": (lambda: shapes.icosahedron(faces=720), 0, 0),
    "cone": (lambda: shapes.cone(faces=2_000), 0, 1),
    "steep cone": (lambda: shapes.cone(half_angle=20.0, faces=2_000), 0, 1),
    "saddle": (lambda: shapes.saddle(faces=2_000), 0, 1),
    "bumpy box": (lambda: shapes.bumpy_box(faces=3_000), 0, 0),
    "vessel": (lambda: shapes.vessel(faces=3_000), 0, 3),
    "crown": (lambda: shapes.crown(faces=6_000), 0, 0),
}


def area(mesh: TriMesh) -> float:
    return float(mesh.face_areas.sum())


def volume(mesh: TriMesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return float(np.einsum("fx,fx->", np.cross(a, b), c) / 6.0)


@pytest.mark.parametrize("name", TOPOLOGY)
def test_topology(name: str) -> None:
    build, genus, loops = TOPOLOGY[name]
    mesh = build()
    assert (mesh.n_components, mesh.genus, len(mesh.boundary_loops)) == (1, genus, loops)
    assert mesh.euler_characteristic == 2 - 2 * genus - loops


@pytest.mark.parametrize("name", TOPOLOGY)
def test_triangles_are_good_and_even(name: str) -> None:
    mesh = TOPOLOGY[name][0]()
    angles = np.degrees(mesh.corner_angles)
    assert angles.min() > 20
    assert np.quantile(angles, 0.02) > 32
    assert mesh.edge_lengths.std() < 0.35 * mesh.edge_lengths.mean()


@pytest.mark.parametrize("name", [name for name, (_, _, loops) in TOPOLOGY.items() if loops == 0])
def test_closed_surfaces_have_their_normals_outside(name: str) -> None:
    assert volume(TOPOLOGY[name][0]()) > 0


@pytest.mark.parametrize("name", ["cone", "saddle"])
def test_graphs_look_up(name: str) -> None:
    assert TOPOLOGY[name][0]().face_normals[:, 2].min() > 0


@pytest.mark.parametrize("name", ["disk", "annulus", "square"])
def test_flat_surfaces_look_up(name: str) -> None:
    np.testing.assert_allclose(TOPOLOGY[name][0]().face_normals[:, 2], 1.0, rtol=1e-12)


@pytest.mark.parametrize("faces", [1_000, 4_000])
@pytest.mark.parametrize(
    "build",
    [shapes.sphere, shapes.disk, shapes.square, shapes.rocker_arm],
    ids=lambda build: build.__name__,
)
def test_the_wanted_number_of_faces(build, faces: int) -> None:
    assert build(faces=faces).n_faces == pytest.approx(faces, rel=0.08)


def test_the_sphere_of_fig_7() -> None:
    mesh = shapes.sphere(subdivisions=5)
    assert mesh.n_faces == 20_480
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), 1.0, rtol=1e-14)
    assert area(mesh) == pytest.approx(4 * np.pi, rel=1e-3)
    assert volume(mesh) == pytest.approx(4 * np.pi / 3, rel=1e-3)


def test_the_icosahedron_is_regular() -> None:
    mesh = shapes.icosahedron()
    assert (mesh.n_vertices, mesh.n_edges, mesh.n_faces) == (12, 30, 20)
    np.testing.assert_allclose(mesh.corner_angles, np.pi / 3, rtol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices, axis=1), 1.0, rtol=1e-14)
    assert volume(mesh) == pytest.approx(2.536150, rel=1e-6)


@pytest.mark.parametrize(("major", "minor"), [(1.0, 0.4), (3.0, 0.5)])
def test_the_torus(major: float, minor: float) -> None:
    mesh = shapes.torus(major, minor, faces=6_000)
    x, y, z = mesh.vertices.T
    np.testing.assert_allclose(np.hypot(np.hypot(x, y) - major, z), minor, rtol=1e-12)
    assert area(mesh) == pytest.approx(4 * np.pi**2 * major * minor, rel=5e-3)
    # twice as far off as the area: the cross section is a polygon of about twenty sides
    assert volume(mesh) == pytest.approx(2 * np.pi**2 * major * minor**2, rel=2e-2)


def test_the_cylinder() -> None:
    mesh = shapes.cylinder(radius=0.5, height=3.0, faces=4_000)
    x, y, z = mesh.vertices.T
    np.testing.assert_allclose(np.hypot(x, y), 0.5, rtol=1e-12)
    np.testing.assert_allclose(np.abs(z[mesh.boundary_vertices]), 1.5, rtol=1e-12)
    assert area(mesh) == pytest.approx(3 * np.pi, rel=5e-3)
    outward = np.einsum("fx,fx->f", mesh.face_normals, mesh.barycenters * [1.0, 1.0, 0.0])
    assert outward.min() > 0


def test_flat_areas_and_round_rims() -> None:
    disk, ring, square = shapes.disk(faces=4_000), shapes.annulus(0.4, 1.0, faces=4_000), shapes.square()
    assert area(disk) == pytest.approx(np.pi, rel=2e-3)
    assert area(ring) == pytest.approx(np.pi * (1.0 - 0.16), rel=3e-3)
    assert area(square) == pytest.approx(4.0, rel=1e-12)
    np.testing.assert_allclose(np.linalg.norm(disk.vertices[disk.boundary_vertices], axis=1), 1.0, rtol=1e-12)
    out = np.linalg.norm(ring.vertices[ring.boundary_vertices], axis=1)
    np.testing.assert_allclose(np.minimum(np.abs(out - 0.4), np.abs(out - 1.0)), 0.0, atol=1e-12)


def test_the_flat_icosahedron_has_its_curvature_at_twelve_corners() -> None:
    mesh = shapes.icosahedron(faces=720)
    assert mesh.n_faces == 720
    curved = np.flatnonzero(np.abs(mesh.angle_defects) > 1e-9)
    assert len(curved) == 12
    np.testing.assert_allclose(mesh.angle_defects[curved], np.pi / 3, rtol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices[curved], axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(mesh.corner_angles, np.pi / 3, rtol=1e-9)


@pytest.mark.parametrize("half_angle", [15.0, 30.0, 60.0, 80.0])
def test_the_cone(half_angle: float) -> None:
    mesh = shapes.cone(half_angle, faces=4_000)
    assert mesh.n_faces == pytest.approx(4_000, rel=0.1)
    slope = np.radians(half_angle)
    out, down = np.hypot(*mesh.vertices.T[:2]), -mesh.vertices[:, 2]
    np.testing.assert_allclose(out, down * np.tan(slope), atol=1e-12)
    np.testing.assert_allclose(np.hypot(out, down)[mesh.boundary_vertices], 1.0, rtol=1e-12)
    # the rings are polygons, so the angle at the apex and the area are a little small on steep cones
    apex = int(np.argmin(down))
    assert mesh.vertices[apex].tolist() == [0.0, 0.0, 0.0]
    assert area(mesh) == pytest.approx(np.pi * np.sin(slope), rel=5e-3)
    assert mesh.face_normals[:, 2].min() > 0
    fine = np.zeros(mesh.n_vertices, dtype=bool)
    fine[np.argsort(down)[200:]] = True
    inside = ~mesh.boundary_vertices
    rest = mesh.angle_defects[inside & fine].sum()
    assert abs(rest) < 0.05
    near = mesh.angle_defects[inside & ~fine].sum()
    assert near == pytest.approx(2 * np.pi * (1 - np.sin(slope)), abs=0.05)


def test_the_saddle_is_negatively_curved() -> None:
    mesh = shapes.saddle(0.5, faces=4_000)
    x, y, z = mesh.vertices.T
    np.testing.assert_allclose(z, 0.5 * (x**2 - y**2), atol=1e-12)
    inside = ~mesh.boundary_vertices
    assert mesh.angle_defects[inside].max() < 0
    # integral of K dA = -4 depth^2 / (1 + 4 depth^2 r^2)^(3/2) dx dy over the disk
    d = 0.5
    total = -2 * np.pi * (1 - 1 / np.sqrt(1 + 4 * d**2))
    assert mesh.angle_defects[inside].sum() == pytest.approx(total, rel=0.05)


@pytest.mark.parametrize(
    "build",
    [
        lambda: shapes.torus(1.0, 1.0),
        lambda: shapes.torus(1.0, 0.0),
        lambda: shapes.annulus(1.0, 0.5),
        lambda: shapes.sphere(faces=4),
        lambda: shapes.disk(faces=2),
        lambda: shapes.genus_g(-1),
        lambda: shapes.schwarz_p(cells=0),
        lambda: shapes.icosahedron(faces=4),
        lambda: shapes.cone(90.0),
        lambda: shapes.cone(5.0),
        lambda: shapes.cone(faces=2),
        lambda: shapes.saddle(0.0),
        lambda: shapes.saddle(3.0),
        lambda: shapes.crown(prongs=2),
    ],
)
def test_shapes_that_cannot_be_are_refused(build) -> None:
    with pytest.raises(MeshError):
        build()
