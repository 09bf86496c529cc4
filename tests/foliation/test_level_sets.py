"""Level sets: straight in every face, none lost, none doubled, whatever vertex the level passes through."""

from __future__ import annotations

import numpy as np
import pytest
from surfaces import ALL, surface

from geoweave.curves.curves import Curves, lifted
from geoweave.errors import FieldError
from geoweave.fields.face_field import FaceField
from geoweave.fields.operators import differences
from geoweave.foliation.circle_function import TURN, CircleFunction
from geoweave.foliation.foliation import foliate
from geoweave.foliation.level_sets import isolines
from geoweave.models import shapes
from geoweave.surface.mesh import TriMesh
from geoweave.surface.submesh import part_of


def real_valued(mesh: TriMesh, values: np.ndarray) -> CircleFunction:
    return CircleFunction(mesh, values, differences(mesh) @ values)


def random_circle(mesh: TriMesh, turns: float, seed: int) -> CircleFunction:
    """Angles and changes along edges without rhyme: dislocations almost everywhere."""
    rng = np.random.default_rng(seed)
    theta, change = rng.uniform(-9, 9, mesh.n_vertices), rng.normal(0, turns * TURN, mesh.n_edges)
    return CircleFunction.nearest(mesh, theta, change)


def polar(mesh: TriMesh, times: int = 1) -> CircleFunction:
    angle = np.arctan2(mesh.vertices[:, 1], mesh.vertices[:, 0])
    return CircleFunction.nearest(mesh, times * angle, np.zeros(mesh.n_edges))


def crossings_of_edges(circle: CircleFunction, level: float) -> np.ndarray:
    """How often each edge crosses the level, by counting integers between the values at its ends."""
    start = (circle.theta[circle.mesh.edges[:, 0]] - level) / TURN
    return np.abs(np.floor(start + circle.jumps / TURN) - np.floor(start)).astype(int)


def tips(curves: Curves) -> np.ndarray:
    """Points at the ends of the open curves."""
    return np.concatenate([curves.offsets[:-1][~curves.closed], curves.offsets[1:][~curves.closed] - 1])


@pytest.fixture(scope="module")
def uneven() -> TriMesh:
    """A flat square of uneven triangles."""
    flat = shapes.square(faces=800)
    inner = ~flat.boundary_vertices[:, None]
    shake = np.random.default_rng(2).uniform(-0.03, 0.03, flat.vertices.shape) * [1, 1, 0]
    return TriMesh(flat.vertices + inner * shake, flat.faces)


def test_linear_functions_give_straight_lines_at_their_places(uneven):
    slope = np.array([9.0, 5.0, 0.0])
    for times in (1.0, 8.0, 40.0):  # up to five turns along an edge
        curves = isolines(real_valued(uneven, times * uneven.vertices @ slope), (0.3,))
        turns = (times * curves.points @ slope - 0.3) / TURN
        assert np.abs(turns - np.rint(turns)).max() < 1e-12 * times
        number = np.rint(turns[curves.offsets[:-1]])
        assert np.array_equal(np.repeat(number, np.diff(curves.offsets)), np.rint(turns))
        # the square's corners see -14 times to 14 times; each level between them once
        reach = 14 * times / TURN
        assert sorted(number) == list(range(int(np.ceil(-reach - 0.3 / TURN)), int(reach - 0.3 / TURN) + 1))
        assert not curves.closed.any()
        assert np.abs(curves.turning).max() < 1e-6  # of the shortest segments; rounding
        assert curves.segment_lengths[curves.following > np.arange(len(curves.points))].min() > 0
        straight = np.linalg.norm(
            curves.points[curves.offsets[1:] - 1] - curves.points[curves.offsets[:-1]], axis=1
        )
        np.testing.assert_allclose(curves.lengths, straight, rtol=1e-12)


@pytest.mark.parametrize("name", ALL)
def test_segments_lie_in_their_faces_and_theta_grows_to_their_right(name):
    mesh = surface(name)
    circle = real_valued(mesh, 30.0 * mesh.vertices @ [0.3, -0.5, 0.8])
    curves = isolines(circle, (1.0, 2.5))
    running = curves.segment_lengths > 1e-6
    face, step = curves.faces[running], curves.segments[running]
    field = 1j * circle.gradient[face]  # w, with grad theta its clockwise quarter turn
    frames = mesh.frames[face]
    heading = np.einsum("px,px->p", step, frames[:, 0]) + 1j * np.einsum("px,px->p", step, frames[:, 1])
    assert np.abs(np.angle(heading / field)).max() < 1e-8
    for points in (curves.points, curves.points[curves.following]):
        off = np.einsum("px,px->p", points - mesh.barycenters[curves.faces], mesh.face_normals[curves.faces])
        assert np.abs(off).max() < 1e-12


@pytest.mark.parametrize("name", ALL)
def test_every_crossing_of_every_edge_is_used_once(name):
    mesh = surface(name)
    circle = real_valued(mesh, 150.0 * mesh.vertices @ [0.3, -0.5, 0.8])
    count = crossings_of_edges(circle, 0.7)
    assert count.max() > 1
    curves = isolines(circle, (0.7,))
    assert len(curves.points) == count.sum()
    assert len(np.unique(curves.points, axis=0)) == count.sum()
    # a face that sees n crossings holds n / 2 segments
    segments = curves.following != np.arange(len(curves.points))
    per_face = np.bincount(curves.faces[segments], minlength=mesh.n_faces)
    np.testing.assert_array_equal(2 * per_face, count[mesh.face_edges].sum(axis=1))
    # without a boundary and without dislocations lines close; else they end at the boundary
    assert len(tips(curves)) == count[mesh.boundary_edges].sum()


def test_meridians_of_a_cylinder_and_circles_of_a_torus():
    mesh = shapes.cylinder(1.0, 2.0, faces=1200)
    curves = isolines(polar(mesh, 7))
    assert len(curves) == 7
    assert not curves.closed.any()
    # the staggered rows lean: a prism's meridians would be 2 long
    np.testing.assert_allclose(curves.lengths, 2.0, rtol=1e-3)
    assert np.abs(curves.turning).max() < 1e-9
    errors = []
    for faces in (1000, 4000, 16000):
        ring = shapes.torus(1.0, 0.4, faces=faces)
        curves = isolines(polar(ring, 6), (0.2,))
        assert len(curves) == 6
        assert curves.closed.all()
        errors.append(np.abs(curves.lengths - 0.8 * np.pi).max())
    assert errors[2] < errors[1] / 3 < errors[0] / 9


def test_rays_and_circles_of_an_annulus():
    errors = []
    for faces in (900, 3600):
        mesh = shapes.annulus(0.4, 1.0, faces=faces)
        rays = isolines(polar(mesh, 8), np.arange(20) * TURN / 20)
        direction = 20 * 8 * np.arctan2(rays.points[:, 1], rays.points[:, 0])
        off = (direction + np.pi) % TURN - np.pi
        radius = np.linalg.norm(mesh.vertices, axis=1)
        circles = isolines(real_valued(mesh, 40 * np.log(radius)), (0.1,))
        assert len(rays) == 8 * 20
        assert circles.closed.all()
        level = np.rint((40 * np.log(np.linalg.norm(circles.points, axis=1)) - 0.1) / TURN)
        exact = np.exp((TURN * level + 0.1) / 40)[circles.offsets[:-1]]
        # log r grows outwards, to the right: the circles run counter-clockwise
        area = np.cross(circles.points, circles.points[circles.following])[:, 2]
        assert (np.add.reduceat(area, circles.offsets[:-1]) > 0).all()
        errors.append((np.abs(off).max(), np.abs(circles.lengths / (TURN * exact) - 1).max()))
    # half the edge, a quarter of the error, but for where the levels happen to fall between the vertices
    assert errors[1][0] < errors[0][0] / 3
    assert errors[1][1] < errors[0][1] / 3


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_levels_through_vertices_lose_and_double_nothing(sign):
    mesh = shapes.square(faces=800)  # vertices at multiples of 0.1
    across = isolines(real_valued(mesh, sign * TURN * 10 * mesh.vertices[:, 0]), (0.0,))
    # every grid line once but the one on the side where no face lies below
    np.testing.assert_allclose(across.lengths, 2.0, rtol=1e-12)
    assert len(across) == 20
    assert np.abs(across.turning).max() < 1e-7
    slanted = isolines(
        real_valued(mesh, sign * TURN * 10 * (mesh.vertices[:, 0] + mesh.vertices[:, 1])), (0.0,)
    )
    assert len(slanted) == 39
    assert slanted.lengths.sum() == pytest.approx(np.sqrt(2) * 2 * 0.1 * (2 * sum(range(1, 20)) + 20) / 2)
    for curves in (across, slanted):
        running = curves.following != np.arange(len(curves.points))
        assert curves.segment_lengths[running].min() > 0.04
        ends = np.linalg.norm(
            curves.points[curves.offsets[1:] - 1] - curves.points[curves.offsets[:-1]], axis=1
        )
        np.testing.assert_allclose(curves.lengths, ends, rtol=1e-12)


def test_a_mirror_plane_through_vertices_is_straight():
    ball = shapes.sphere(faces=1280)
    for axis in range(3):
        circle = real_valued(ball, ball.vertices[:, axis])
        # the plane holds whole edges, passes through vertices with curvature, and is a symmetry of the mesh
        for turned in (circle, CircleFunction(ball, -circle.theta, -circle.jumps)):
            equator = isolines(turned, (0.0,))
            assert len(equator) == 1
            assert equator.closed.all()
            assert equator.lengths[0] == pytest.approx(TURN, rel=3e-3)
            assert np.abs(equator.turning).max() < 1e-9


def test_a_peak_at_the_level_is_left_out_and_a_plateau_has_no_line():
    mesh = shapes.disk(faces=600)
    height = -np.linalg.norm(mesh.vertices, axis=1)
    assert len(isolines(real_valued(mesh, height), (0.0,))) == 0
    assert len(isolines(real_valued(mesh, 0 * height), (0.0,))) == 0
    assert len(isolines(real_valued(mesh, height), ())) == 0


def test_a_vortex_is_where_one_line_ends():
    mesh = shapes.disk(faces=800)
    inside = int(np.argmin(np.linalg.norm(mesh.barycenters, axis=1)))
    x, y = (mesh.vertices - mesh.barycenters[inside]).T[:2]
    circle = CircleFunction.nearest(mesh, np.arctan2(y, x), np.zeros(mesh.n_edges))
    for level in (0.0, 0.5 * np.pi, 3.0):
        curves = isolines(circle, (level,))
        assert len(curves) == 1
        ends = curves.points[tips(curves)]
        inner = ends[np.argmin(np.linalg.norm(ends, axis=1))]
        assert np.linalg.norm(inner - mesh.barycenters[inside]) < mesh.mean_edge
        assert np.linalg.norm(ends, axis=1).max() > 0.98


@pytest.mark.parametrize("turns", [0.2, 1.0, 4.0])
@pytest.mark.parametrize("name", ["jagged sphere", "disk", "genus 5", "two pieces"])
def test_as_many_ends_as_dislocations_and_crossings_of_the_boundary(name, turns):
    mesh = surface(name)
    circle = random_circle(mesh, turns, seed=5)
    curves = isolines(circle, (2.0,))
    count = crossings_of_edges(circle, 2.0)
    assert np.abs(circle.dislocations).sum() > 100
    # a crossing between two dislocations, joined to neither, is no line; it has two of the ends
    alone = count.sum() - len(curves.points)
    expected = np.abs(circle.dislocations).sum() + count[mesh.boundary_edges].sum()
    assert len(tips(curves)) + 2 * alone == expected


def test_levels_are_kept_in_order_and_turning_round_reverses():
    mesh = surface("jagged sphere")
    circle = real_valued(mesh, 20 * mesh.vertices[:, 0])
    apart = [isolines(circle, (level,)) for level in (0.0, 2.0)]
    both = isolines(circle, (0.0, 2.0))
    assert np.array_equal(both.points, np.concatenate([each.points for each in apart]))
    assert np.array_equal(both.closed, np.concatenate([each.closed for each in apart]))
    back = isolines(CircleFunction(mesh, -circle.theta, -circle.jumps), (0.0,))
    np.testing.assert_allclose(np.sort(back.lengths), np.sort(apart[0].lengths))
    assert np.sort(back.turning) == pytest.approx(np.sort(-apart[0].turning), abs=1e-7)


def test_lines_on_a_part_are_lines_on_the_whole():
    mesh = surface("sphere")
    part = part_of(mesh, mesh.barycenters[:, 2] < 0.4)
    values = 20 * mesh.vertices[:, 0]
    curves = isolines(real_valued(part.mesh, values[part.vertices]))
    whole = lifted(curves, part)
    assert whole.mesh is mesh
    off = np.einsum("px,px->p", whole.points - mesh.barycenters[whole.faces], whole.normals)
    assert np.abs(off).max() < 1e-12
    assert set(whole.faces) <= set(np.flatnonzero(part.kept))
    with pytest.raises(FieldError, match="mesh of the part"):
        lifted(whole, part)


def test_leaves_of_a_foliation_lie_on_the_whole_surface():
    ball = shapes.sphere(faces=1280)
    upwards = FaceField.from_ambient(ball, np.tile([0.0, 0.0, 1.0], (ball.n_faces, 1)))
    foliation = foliate(upwards, alternations=2)
    assert foliation.part.mesh.n_faces < ball.n_faces
    leaves = isolines(foliation)
    assert leaves.mesh is ball
    apart = isolines(foliation.circle)
    assert np.array_equal(leaves.points, apart.points)
    assert np.array_equal(leaves.faces, foliation.part.faces[apart.faces])


def test_a_level_must_be_a_number():
    mesh = surface("disk")
    with pytest.raises(FieldError, match="levels of isolines"):
        isolines(real_valued(mesh, mesh.vertices[:, 0]), (0.0, np.nan))
