"""A weave is found on an even mesh of as many triangles as its ribbons need."""

import numpy as np
import pytest

from geoweave.errors import MeshError
from geoweave.meshing import weaving_mesh
from geoweave.meshing.prepare import prepare_arrays
from geoweave.meshing.weaving_mesh import COARSEST, FINEST, UNEVEN, evened, faces_to_weave_on, smallest_angles
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh


def arrays_of(mesh):
    return mesh.vertices, mesh.faces


def grid(columns, rows):
    """A tube of squares with diagonals, all one way."""
    angle, height = np.meshgrid(np.arange(columns), np.arange(rows + 1), indexing="ij")
    turn = 2 * np.pi * angle.ravel() / columns
    points = np.stack([np.cos(turn), np.sin(turn), 2 * np.pi / columns * height.ravel()], axis=1)
    a = (np.arange(columns)[:, None] * (rows + 1) + np.arange(rows)).ravel()
    b = (a + rows + 1) % len(points)
    return TriMesh(points, np.concatenate([np.stack([a, b, b + 1], 1), np.stack([a, b + 1, a + 1], 1)]))


def test_a_regular_grid_is_remeshed_though_its_edges_are_even():
    tube = grid(72, 40)
    side = np.sqrt(4.0 * tube.face_areas.sum() / (np.sqrt(3.0) * tube.n_faces))
    assert tube.edge_lengths.max() < UNEVEN * side
    assert smallest_angles(tube).mean() == pytest.approx(45, abs=0.1)
    found = evened(prepare_arrays(*arrays_of(tube)), ribbons=36)
    assert found.report.remeshed_from == tube.n_faces
    assert smallest_angles(found.mesh).mean() > 52
    assert len(found.mesh.boundary_loops) == 2


def test_more_ribbons_ask_for_more_triangles_and_a_fine_mesh_is_made_coarser():
    surface = prepare_arrays(*arrays_of(shapes.torus(faces=6000)))
    assert evened(surface, ribbons=60) is surface
    finer = evened(surface, ribbons=140).mesh
    assert finer.n_faces == pytest.approx(faces_to_weave_on(finer, 140), rel=0.02)
    scan = prepare_arrays(*arrays_of(shapes.torus(faces=20_000)))
    assert evened(scan, ribbons=40).mesh.n_faces == pytest.approx(COARSEST, rel=0.02)
    assert faces_to_weave_on(scan.mesh, 5_000) == FINEST


def test_angles_are_the_smallest_of_each_face():
    mesh = TriMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 0.2, 1]], [[0, 1, 2], [1, 0, 3]])
    np.testing.assert_allclose(smallest_angles(mesh)[0], 45.0)
    corners = mesh.vertices[mesh.faces[1]]
    angles = []
    for k in range(3):
        u, v = corners[(k + 1) % 3] - corners[k], corners[(k + 2) % 3] - corners[k]
        angles.append(np.degrees(np.arccos(u @ v / np.linalg.norm(u) / np.linalg.norm(v))))
    assert smallest_angles(mesh)[1] == pytest.approx(min(angles))


def test_only_uneven_or_few_triangles_are_remeshed_for_a_weave():
    even = prepare_arrays(*arrays_of(shapes.torus(faces=2400)))
    assert evened(even) is even
    # stretched to six times its length, the same torus has long triangles
    points, faces = arrays_of(shapes.torus(faces=2400))
    stretched = prepare_arrays(points * [6.0, 1.0, 1.0], faces)
    coarse = prepare_arrays(*arrays_of(shapes.torus(faces=300)))
    for prepared in (stretched, coarse):
        found = evened(prepared)
        assert found.mesh.genus == 1
        assert abs(found.mesh.n_faces - COARSEST) <= 2
        assert found.report.remeshed_from == prepared.mesh.n_faces
        side = np.sqrt(4.0 * found.mesh.face_areas.sum() / (np.sqrt(3.0) * found.mesh.n_faces))
        assert found.mesh.edge_lengths.max() < UNEVEN * side
        assert found.mesh.face_areas.sum() == pytest.approx(prepared.mesh.face_areas.sum(), rel=0.02)


def test_the_largest_of_several_components_gets_enough_triangles():
    points, faces = arrays_of(shapes.torus(faces=900))
    two = prepare_arrays(
        np.concatenate([points, 0.5 * points + 5.0]), np.concatenate([faces, faces + len(points)])
    )
    found = evened(two).mesh
    # four fifths of the area
    assert np.bincount(found.face_components).max() == pytest.approx(COARSEST, rel=0.02)
    assert found.n_components == 2


def test_a_topology_that_asks_for_more_triangles_gets_them(monkeypatch):
    asked = []

    def refusing(prepared, faces, *, name):
        asked.append(faces)
        raise MeshError(f"{name}: too few")

    monkeypatch.setattr(weaving_mesh, "remeshed", refusing)
    with pytest.raises(MeshError, match="blob: too few"):
        evened(prepare_arrays(*arrays_of(shapes.sphere(faces=320))), name="blob")
    assert asked == [COARSEST, 2 * COARSEST, 4 * COARSEST]
