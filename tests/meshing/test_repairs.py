import numpy as np
import pytest
from meshfiles import moebius_strip, octahedron, sheet, sphere

from geoweave.meshing import repairs
from geoweave.surface.mesh import TriMesh


def coincident(points, faces):
    return repairs.coincident(points, faces, repairs.Edges.of(faces), repairs.flat(points, faces))


def flip_caps(points, faces):
    return repairs.flip_caps(points, faces, repairs.Edges.of(faces), repairs.flat(points, faces))


def orientation(faces):
    return repairs.orientation(faces, repairs.Edges.of(faces))


def inside_out(points, faces):
    return repairs.inside_out(points, faces, repairs.Edges.of(faces))


def separated_fans(faces):
    return repairs.separated_fans(faces, repairs.Edges.of(faces))


def test_edges_and_pairs():
    _, faces = octahedron()
    edges = repairs.Edges.of(faces)
    assert edges.ends.shape == (12, 2)
    assert (edges.counts == 2).all()
    pairs = edges.manifold_pairs
    assert len(pairs) == 12
    np.testing.assert_array_equal(edges.of_halfedge[pairs[:, 0]], edges.of_halfedge[pairs[:, 1]])


def test_repeated_duplicate_and_flat_faces():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0], [1, 1e-14, 0]])
    faces = np.array([[0, 1, 2], [1, 2, 0], [2, 1, 0], [0, 1, 1], [0, 1, 3], [0, 3, 4], [1, 3, 2]])
    assert repairs.repeated(faces).tolist() == [False, False, False, True, False, False, False]
    assert repairs.duplicates(faces).tolist() == [False, True, True, False, False, False, False]
    for scale in (1e-9, 1.0, 1e9):
        assert repairs.flat(scale * points, faces).tolist() == [False] * 3 + [True] * 3 + [False]


def test_only_open_ends_are_welded():
    points, faces = octahedron()
    touching = np.concatenate([points, points + np.array([2.0, 0, 0])])  # one tip each in the same place
    both = np.concatenate([faces, faces + 6])
    assert (coincident(touching, both) == np.arange(12)).all()

    flat_points, cells = sheet(3)
    separate = np.concatenate([flat_points, flat_points + [3, 0, 0] * np.array([1.0, 0, 1])])
    target = coincident(separate, np.concatenate([cells, cells + 16]))
    assert (target != np.arange(32)).sum() == 1  # the two sheets share the corner with no height


@pytest.mark.parametrize("seed", range(4))
def test_orientation_undoes_any_turning(seed):
    points, faces = sphere(2)
    turned = np.random.default_rng(seed).random(len(faces)) < 0.4
    mixed = np.where(turned[:, None], faces[:, ::-1], faces)
    found, one_sided = orientation(mixed)
    assert not len(one_sided)
    # the majority decides; here most faces were left as they are
    np.testing.assert_array_equal(found, turned)
    assert not inside_out(points, np.where(found[:, None], mixed[:, ::-1], mixed)).any()
    assert inside_out(points + 1e6, faces[:, ::-1]).all()


def test_orientation_of_each_component_on_its_own():
    _, one = sphere(1)
    _, strip = moebius_strip()
    faces = np.concatenate([one[:, ::-1], strip + one.max() + 1, one + 1000])
    turn, one_sided = orientation(faces)
    assert not turn[: len(one)].any()
    assert not turn[-len(one) :].any()
    assert one_sided.tolist() == list(range(len(one), len(one) + len(strip)))


def test_a_tie_keeps_the_first_face():
    faces = np.array([[0, 1, 2], [1, 2, 3]])
    turn, _ = orientation(faces)
    assert turn.tolist() == [False, True]


def test_an_open_surface_is_never_inside_out():
    points, faces = sheet(3)
    assert not inside_out(points, faces).any()
    assert not inside_out(points, faces[:, ::-1]).any()


def test_separated_fans():
    points, faces = octahedron()
    joined = np.concatenate([faces, np.where(faces == 0, 0, faces + 6)])
    fixed, copies = separated_fans(joined)
    assert copies.tolist() == [0]
    mesh = TriMesh(*compact(np.concatenate([np.tile(points, (2, 1)), points[copies]]), fixed))
    assert mesh.n_components == 2
    unchanged, none = separated_fans(faces)
    np.testing.assert_array_equal(unchanged, faces)
    assert not len(none)


def compact(points, faces):
    used, faces = np.unique(faces, return_inverse=True)
    return points[used], faces.reshape(-1, 3)


def test_a_cap_is_flipped_away_without_opening_the_surface():
    points, faces = octahedron()
    # put a vertex exactly onto an edge of one face only: that face becomes two, and a cap closes the slit
    middle = points[[0, 2]].mean(axis=0)
    faces = np.concatenate([faces[1:], [[0, 6, 4], [6, 2, 4], [0, 2, 6]]])
    points = np.concatenate([points, [middle]])
    for scale, shift in ((1.0, 0.0), (1e-9, 0.0), (1e9, 0.0), (1.0, 1e3)):
        placed = scale * points + shift
        assert repairs.flat(placed, faces).sum() == 1
        flipped, count = flip_caps(placed, faces)
        assert count == 1
        assert not repairs.flat(placed, flipped).any()
        mesh = TriMesh(placed, flipped)
        assert (mesh.euler_characteristic, len(mesh.boundary_loops)) == (2, 0)
        assert mesh.face_areas.sum() == pytest.approx(TriMesh(*octahedron()).face_areas.sum() * scale**2)
