import numpy as np
import pytest
from meshfiles import FORMATS, fin, moebius_strip, octahedron, sheet, soup, sphere, write

from geoweave.errors import MeshError
from geoweave.meshing.prepare import prepare_arrays, read_mesh
from geoweave.meshing.report import RepairReport

CLEAN = RepairReport()


def repairs(report):
    return {key: count for key, count in report.as_dict().items() if count}


def test_a_clean_mesh_is_taken_as_it_is():
    for points, faces in (octahedron(), sphere(2), sheet(3)):
        prepared = prepare_arrays(points, faces)
        np.testing.assert_array_equal(prepared.mesh.vertices, points)
        np.testing.assert_array_equal(prepared.mesh.faces, faces)
        assert prepared.report == CLEAN
        assert prepared.report.sentences() == []


@pytest.mark.parametrize("kind", FORMATS)
def test_every_format_gives_the_same_surface(kind, tmp_path):
    points, faces = sphere(2)
    prepared = read_mesh(write(tmp_path, "sphere", kind, points, faces))
    mesh = prepared.mesh
    assert (mesh.n_vertices, mesh.n_faces, mesh.genus, len(mesh.boundary_loops)) == (66, 128, 0, 0)
    np.testing.assert_allclose(mesh.vertices[mesh.faces], points[faces], rtol=1e-6, atol=1e-7)
    expected = {"welded_vertices": 3 * 128 - 66} if kind.startswith("stl") else {}
    assert repairs(prepared.report) == expected


def test_unused_vertices_are_dropped_even_if_not_finite():
    points, faces = octahedron()
    more = np.concatenate([[[np.nan] * 3], points, [[1e300, 0, 0]]])
    prepared = prepare_arrays(more, faces + 1)
    np.testing.assert_array_equal(prepared.mesh.vertices, points)
    assert repairs(prepared.report) == {"unreferenced_vertices": 2}


@pytest.mark.parametrize("distance", [0.0, 1e-9])
def test_seams_are_welded(distance):
    points, faces = sphere(2)
    rng = np.random.default_rng(0)
    corners = points[faces].reshape(-1, 3) + distance * rng.uniform(-1, 1, (faces.size, 3))
    prepared = prepare_arrays(corners, np.arange(faces.size).reshape(-1, 3))
    assert (prepared.mesh.n_vertices, len(prepared.mesh.boundary_loops)) == (66, 0)
    assert repairs(prepared.report) == {"welded_vertices": faces.size - 66}


def test_degenerate_and_duplicate_faces_are_dropped():
    points, faces = octahedron()
    more = np.concatenate([faces, [[0, 2, 0], [3, 3, 3]], faces[2:4, [1, 2, 0]], faces[5:6, ::-1]])
    prepared = prepare_arrays(points, more)
    np.testing.assert_array_equal(prepared.mesh.faces, faces)
    assert repairs(prepared.report) == {"degenerate_faces": 2, "duplicate_faces": 3}
    assert prepared.report.sentences() == [
        "dropped 2 faces without area",
        "dropped 3 faces with the vertices of another",
    ]


def test_needles_collapse_and_caps_are_flipped_so_that_the_surface_stays_closed():
    points, faces = octahedron()
    # vertex 0 becomes two at the same place, with a needle on either side of the side between them
    split = np.array([[6, 2, 4], [2, 6, 5], [0, 6, 4], [6, 0, 5]])
    needles = np.concatenate([faces[[1, 2, 3, 5, 6, 7]], split])
    prepared = prepare_arrays(np.concatenate([points, points[:1]]), needles)
    assert (prepared.mesh.n_vertices, prepared.mesh.euler_characteristic) == (6, 2)
    assert len(prepared.mesh.boundary_loops) == 0
    assert repairs(prepared.report) == {"welded_vertices": 1, "degenerate_faces": 2}

    cap = np.concatenate([faces[1:], [[0, 6, 4], [6, 2, 4], [0, 2, 6]]])
    prepared = prepare_arrays(np.concatenate([points, points[[0, 2]].mean(axis=0)[None]]), cap)
    assert (prepared.mesh.n_vertices, prepared.mesh.euler_characteristic) == (7, 2)
    assert len(prepared.mesh.boundary_loops) == 0
    assert repairs(prepared.report) == {"flipped_edges": 1}


@pytest.mark.parametrize("seed", range(3))
def test_faces_are_turned_to_agree_and_to_face_outwards(seed):
    points, faces = sphere(2)
    turned = np.random.default_rng(seed).random(len(faces)) < 0.5
    prepared = prepare_arrays(points, np.where(turned[:, None], faces[:, ::-1], faces))
    mesh = prepared.mesh
    assert (np.einsum("fx,fx->f", mesh.face_normals, mesh.barycenters) > 0).all()
    assert repairs(prepared.report) == {"turned_faces": int(turned.sum())}


def test_an_open_surface_keeps_the_side_of_its_file():
    points, faces = sheet(3)
    assert prepare_arrays(points, faces[:, ::-1]).report == CLEAN


def test_fans_that_meet_in_a_vertex_are_split():
    points, faces = octahedron()
    # tip 0 of the first octahedron is tip 1 of the second
    second = np.array([6, 0, 7, 8, 9, 10])[faces]
    two = np.concatenate([points, points[[0, 2, 3, 4, 5]] + np.array([2.0, 0, 0])])
    prepared = prepare_arrays(two, np.concatenate([faces, second]))
    assert prepared.mesh.n_components == 2
    assert prepared.mesh.n_vertices == 12
    assert repairs(prepared.report) == {"split_vertices": 1}
    assert prepared.report.sentences() == ["added 1 vertex where separate fans of faces met in one"]


def test_components_are_kept_or_the_largest_by_area_is_chosen():
    points, faces = sphere(2)
    small, small_faces = sphere(3)
    both = np.concatenate([0.1 * small + 5.0, points])
    triangles = np.concatenate([small_faces, faces + len(small)])
    assert prepare_arrays(both, triangles).mesh.n_components == 2
    largest = prepare_arrays(both, triangles, components="largest")
    assert largest.mesh.n_faces == len(faces)
    assert repairs(largest.report) == {"dropped_components": 1}
    with pytest.raises(ValueError, match="'keep' or 'largest'"):
        prepare_arrays(both, triangles, components="smallest")


def test_the_largest_component_is_judged_without_the_others():
    points, faces = sphere(1)
    extra, triangles = fin()
    both = np.concatenate([points, 0.1 * extra + 5.0]), np.concatenate([faces, triangles + len(points)])
    with pytest.raises(MeshError, match="more than two faces"):
        prepare_arrays(*both)
    assert prepare_arrays(*both, components="largest").mesh.n_faces == len(faces)


def test_an_edge_of_three_faces_is_refused_or_cut():
    with pytest.raises(MeshError) as caught:
        prepare_arrays(*fin(), name="fin.obj")
    assert str(caught.value) == (
        "fin.obj: 1 edge is shared by more than two faces (first: vertices 0, 1 at (0.5, 0, 0)); "
        "split them in a mesh editor, or cut the surface apart there with --repair"
    )
    prepared = prepare_arrays(*fin(), cut=True)
    assert prepared.mesh.n_components == 3
    assert repairs(prepared.report) == {"cut_edges": 1, "split_vertices": 4}


def test_two_boxes_on_a_common_edge_are_cut_apart():
    points, faces = octahedron()
    # the second is the first turned half around the middle of its edge 0-2
    vertices = np.concatenate([points, points @ np.diag([-1.0, -1.0, 1.0]) + np.array([1.0, 1.0, 0.0])])
    joined = np.array([2, 7, 0, 9, 10, 11])[faces]
    with pytest.raises(MeshError, match="1 edge is shared by more than two faces"):
        prepare_arrays(vertices, np.concatenate([faces, joined]))
    mesh = prepare_arrays(vertices, np.concatenate([faces, joined]), cut=True).mesh
    assert (mesh.n_components, mesh.n_vertices) == (2, 12)


def test_one_sided_surfaces_are_refused():
    with pytest.raises(MeshError, match=r"^m.off: 24 faces form a one-sided surface .*; cut it open"):
        prepare_arrays(*moebius_strip(), name="m.off")


@pytest.mark.parametrize(
    ("points", "faces", "message"),
    [
        (octahedron()[0], np.empty((0, 3), int), r"holds 6 points and no faces \(a point cloud\); "),
        (np.empty((0, 3)), np.empty((0, 3), int), "holds no faces; "),
        (octahedron()[0][:5], octahedron()[1], "face 4 names vertex 5, but it has only 5 vertices"),
        (octahedron()[0], octahedron()[1] - 1, "face 0 names vertex -1"),
        (np.full((6, 3), np.inf), octahedron()[1], "vertex 0 has a coordinate that is not a finite number"),
        (octahedron()[0] * 1e120, octahedron()[1], r"its coordinates reach 1e\+120; scale it down"),
        (octahedron()[0] * 1e-120, octahedron()[1], "it is only 2e-120 long; scale it up"),
        (np.ones((6, 3)), octahedron()[1], "all vertices lie in one place"),
        (octahedron()[0] * [1, 0, 0], octahedron()[1], "no face has any area"),
        (*soup(), r"12 of its 12 triangles touch no other \(a soup of unconnected triangles\); merge"),
        (octahedron()[0][:, :2], octahedron()[1], r"vertices must be numbers of shape \(V, 3\)"),
        (octahedron()[0], octahedron()[1].astype(float), r"faces must be whole numbers of shape \(F, 3\)"),
    ],
)
def test_refusals(points, faces, message):
    with pytest.raises(MeshError, match=rf"^x\.off: {message}"):
        prepare_arrays(points, faces, name="x.off")


def test_one_triangle_is_a_surface():
    points, faces = soup()
    assert prepare_arrays(points[:3], faces[:1]).mesh.n_faces == 1


def damaged():
    """A sphere with seams, turned faces, a needle, a cap, duplicates and unused vertices."""
    points, faces = sphere(2)
    rng = np.random.default_rng(3)
    faces = np.where((rng.random(len(faces)) < 0.3)[:, None], faces[:, ::-1], faces)
    half = points[faces[:, 0], 0] > 0
    apart = np.concatenate([points, points])
    faces = np.where(half[:, None], faces + len(points), faces)
    middle = apart[faces[0, :2]].mean(axis=0)
    a, b, c = faces[0]
    n = len(apart)
    cap = [[a, n, c], [n, b, c], [a, b, n]]
    return np.concatenate([apart, [middle]]), np.concatenate([faces[1:], cap, faces[5:6], [[a, a, b]]])


@pytest.mark.parametrize(
    ("scale", "shift"),
    [(1e-9, 0.0), (1e9, 0.0), (1.0, 1e6), (1e-9, 1e-3), (1e9, -1e15), (1e55, 0), (1e-55, 0)],
)
def test_repairs_depend_on_neither_unit_nor_place(scale, shift):
    points, faces = damaged()
    reference = prepare_arrays(points, faces)
    assert reference.mesh.euler_characteristic == 2
    assert len(reference.mesh.boundary_loops) == 0
    assert set(repairs(reference.report)) >= {
        "welded_vertices",
        "flipped_edges",
        "turned_faces",
        "duplicate_faces",
    }
    moved = prepare_arrays(scale * points + shift, faces)
    np.testing.assert_array_equal(moved.mesh.faces, reference.mesh.faces)
    assert moved.report == reference.report


def test_remeshing_is_reported(tmp_path):
    prepared = read_mesh(write(tmp_path, "sphere", "off", *sphere(3)), faces=300)
    assert prepared.report.remeshed_from == 512
    assert prepared.mesh.n_faces == pytest.approx(300, rel=0.1)
    assert prepared.report.sentences() == ["remeshed, from 512 faces"]
    with pytest.raises(MeshError, match=r"sphere\.off: cannot remesh to 2 faces"):
        read_mesh(tmp_path / "sphere.off", faces=2)
