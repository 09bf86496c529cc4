"""Streamlines: exact in every face, evenly apart, ending where they must; the curvature of known curves."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from geoweave.curves.curve_crossings import crossings
from geoweave.curves.curves import Curves, geodesic_curvature
from geoweave.curves.tracing import streamlines
from geoweave.errors import FieldError
from geoweave.fields.face_field import FaceField, random_field
from geoweave.surface.mesh import TriMesh


def sphere(subdivisions: int) -> TriMesh:
    ball = trimesh.creation.icosphere(subdivisions)
    # Turned by no special angle, so that no vertex, edge or face is level or upright.
    turn = trimesh.transformations.euler_matrix(0.3, 0.7, 1.1)[:3, :3]
    return TriMesh(ball.vertices @ turn.T, ball.faces)


def grid(columns: int, rows: int, place) -> TriMesh:
    """A triangulated strip of quads, wrapped in the first direction, put in space by ``place(u, v)``."""
    u, v = np.meshgrid(np.arange(columns), np.arange(rows + 1), indexing="ij")
    points = place(u.ravel() / columns, v.ravel() / rows)
    a = (u[:, :-1] * (rows + 1) + v[:, :-1]).ravel()
    b = (((u[:, :-1] + 1) % columns) * (rows + 1) + v[:, :-1]).ravel()
    return TriMesh(points, np.concatenate([np.stack([a, b, b + 1], 1), np.stack([a, b + 1, a + 1], 1)]))


def annulus(inner: float = 0.3, columns: int = 120, rows: int = 36) -> TriMesh:
    def place(u, v):
        r, angle = inner + (1 - inner) * v, -2 * np.pi * u
        # A wobble keeps the grid lines from being field lines.
        angle = angle + 0.08 * np.sin(7 * r)
        return np.stack([r * np.cos(angle), r * np.sin(angle), 0 * r], axis=1)

    return grid(columns, rows, place)


def cylinder(columns: int = 60, rows: int = 50) -> TriMesh:
    def place(u, v):
        return np.stack(
            [np.cos(2 * np.pi * u), np.sin(2 * np.pi * u), 3 * v + 0.05 * np.sin(6 * np.pi * u)], axis=1
        )

    return grid(columns, rows, place)


def around_axis(mesh: TriMesh) -> FaceField:
    return FaceField.from_ambient(mesh, np.cross([0.0, 0.0, 1.0], mesh.barycenters))


def away_from_axis(mesh: TriMesh) -> FaceField:
    return FaceField.from_ambient(mesh, mesh.barycenters * [1.0, 1.0, 0.0])


def towards_pole(mesh: TriMesh) -> FaceField:
    return FaceField.from_ambient(mesh, np.tile([0.0, 0.0, 1.0], (mesh.n_faces, 1)))


def poles(mesh: TriMesh) -> np.ndarray:
    """The face round each pole holds the singularity of these fields: flag its corners."""
    flags = np.zeros(mesh.n_vertices, dtype=bool)
    for end in (np.argmin, np.argmax):
        flags[mesh.faces[end(mesh.barycenters[:, 2])]] = True
    return flags


def wavy(mesh: TriMesh) -> FaceField:
    """A field with sources, sinks and shear on any surface."""
    x, y, z = (mesh.barycenters / np.abs(mesh.vertices).max()).T
    return FaceField.from_ambient(
        mesh, np.stack([np.sin(3 * y) + 0.4, np.cos(2 * z), np.sin(4 * x + y)], axis=1)
    )


def barycentric(mesh: TriMesh, faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    corners = mesh.vertices[mesh.faces[faces]]
    normal = mesh.face_normals[faces]
    double = 2 * mesh.face_areas[faces]
    parts = [
        np.einsum("px,px->p", np.cross(corners[:, (k + 2) % 3] - corners[:, (k + 1) % 3],
                                       points - corners[:, (k + 1) % 3]), normal)
        for k in range(3)
    ]  # fmt: skip
    return np.stack(parts, axis=1) / double[:, None]


FIELDS = {
    "rotation on a sphere": lambda: around_axis(sphere(3)),
    "height on a sphere": lambda: towards_pole(sphere(3)),
    "waves on a sphere": lambda: wavy(sphere(4)),
    "rotation on an annulus": lambda: around_axis(annulus()),
    "rays on an annulus": lambda: away_from_axis(annulus()),
    "waves on a cylinder": lambda: wavy(cylinder()),
    "noise on a sphere": lambda: random_field(sphere(3), 4),
}


@pytest.fixture(params=FIELDS, scope="module")
def traced(request) -> tuple[FaceField, Curves]:
    field = FIELDS[request.param]()
    return field, streamlines(field, share=0.05, shortest=0.5)


def test_every_segment_lies_in_its_face(traced):
    field, curves = traced
    mesh = field.mesh
    for points in (curves.points, curves.points[curves.following]):
        offset = np.einsum(
            "px,px->p", points - mesh.barycenters[curves.faces], mesh.face_normals[curves.faces]
        )
        assert np.abs(offset).max() < 1e-9
        assert barycentric(mesh, curves.faces, points).min() > -1e-7


def test_segments_follow_the_field_and_slides_follow_edges_between_vectors(traced):
    field, curves = traced
    mesh = field.mesh
    # Directions of segments much shorter than an edge drown in rounding.
    long = curves.segment_lengths > 1e-4 * mesh.mean_edge
    direction = curves.segments[long] / curves.segment_lengths[long, None]
    cosine = np.einsum("px,px->p", direction, field.normalized().ambient[curves.faces[long]])
    sliding = curves.sliding[long]
    last = np.zeros(len(curves.points), dtype=bool)
    last[curves.offsets[1:] - 1] = True  # a closing segment may miss the field's direction by the closing gap
    assert cosine[~sliding & ~last[long]].min() > 1 - 1e-10
    if sliding.any():
        on_edge = barycentric(mesh, curves.faces[long][sliding], curves.points[long][sliding])
        assert np.abs(on_edge).min(axis=1).max() < 1e-7
        # both vectors point to the edge with less than 60 degrees between: neither is far from it
        assert cosine[sliding].min() > np.cos(np.pi / 3)


def test_turning_is_the_angle_between_unfolded_segments(traced):
    field, curves = traced
    mesh = field.mesh
    before = np.flatnonzero(curves.following != np.arange(len(curves.points)))
    after = curves.following[before]
    sides = np.sort(mesh.face_neighbors[curves.faces[before]] == curves.faces[after, None], axis=1)
    # Only ordinary crossings: one shared edge, neither segment too short to have a direction.
    usual = sides[:, 2] & ~curves.sliding[before] & ~curves.sliding[after]
    usual &= np.minimum(curves.segment_lengths[before], curves.segment_lengths[after]) > 1e-4 * mesh.mean_edge
    usual &= (after > before) & (curves.following[after] > after)
    before, after = before[usual], after[usual]
    corner = np.argmax(mesh.face_neighbors[curves.faces[before]] == curves.faces[after, None], axis=1)
    edge = mesh.edge_vectors[mesh.face_edges[curves.faces[before], corner]]
    edge = edge / np.linalg.norm(edge, axis=1, keepdims=True)

    def heading(points):
        segment, normal = curves.segments[points], mesh.face_normals[curves.faces[points]]
        return np.arctan2(
            np.einsum("px,px->p", np.cross(edge, segment), normal), np.einsum("px,px->p", edge, segment)
        )

    turned = np.angle(np.exp(1j * (heading(after) - heading(before))))
    assert np.abs(turned - curves.turning[after]).max() < 1e-8


def test_lines_keep_apart_and_cover(traced):
    field, curves = traced
    mesh = field.mesh
    center = mesh.vertices.mean(axis=0)
    separation = 0.05 * np.linalg.norm(mesh.vertices - center, axis=1).max()
    # Resample finely; nearest sample of another line, on the same side of the surface.
    step = 0.1 * separation
    points, lines = [], []
    for number, curve in enumerate(curves):
        closing = [curve.points[:1]] if curve.closed else []
        path = np.concatenate([curve.points, *closing])
        arc = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
        at = np.arange(0, arc[-1], step)
        points.append(np.stack([np.interp(at, arc, path[:, x]) for x in range(3)], axis=1))
        lines.append(np.full(len(at), number))
    cloud, line = np.concatenate(points), np.concatenate(lines)
    tree = cKDTree(cloud)
    pairs = tree.query_pairs(0.4 * separation, output_type="ndarray")
    # half a separation is kept between samples a fifth apart, so 0.4 is left between any two points
    assert (line[pairs[:, 0]] == line[pairs[:, 1]]).all()


def test_lines_cross_neither_each_other_nor_themselves(traced):
    _, curves = traced
    assert len(crossings(curves)) == 0


SMOOTH = ["rotation on a sphere", "height on a sphere", "rotation on an annulus", "rays on an annulus"]


@pytest.mark.parametrize("name", SMOOTH)
def test_smooth_fields_are_covered(name):
    field = FIELDS[name]()
    curves = streamlines(field, separation=0.08, shortest=1.0)
    distance = cKDTree(curves.points).query(field.mesh.barycenters)[0]
    assert np.quantile(distance, 0.99) < 1.2 * 0.08


def test_circles_of_latitude_close_and_have_the_curvature_of_their_polar_angle():
    mesh = sphere(5)
    curves = streamlines(around_axis(mesh), separation=0.06, singular=poles(mesh))
    assert curves.closed.mean() > 0.95
    polar = np.arccos(np.clip(mesh.vertices @ [0, 0, 1], -1, 1))
    polar = np.arccos(curves.points[:, 2] / np.linalg.norm(curves.points, axis=1))
    away = np.abs(np.cos(polar)) < 0.9
    expected = np.cos(polar) / np.sin(polar)
    curvature = geodesic_curvature(curves)
    # the counter-clockwise circle seen from the north pole bends left on the northern half
    assert np.abs(curvature - expected)[away].max() < 0.08
    assert np.abs(np.median(curvature[away] - expected[away])) < 0.005


def test_curvature_of_latitude_circles_converges_for_a_fixed_window():
    errors = []
    for subdivisions in (3, 4, 5):
        curves = streamlines(around_axis(sphere(subdivisions)), separation=0.2)
        cosine = curves.points[:, 2] / np.linalg.norm(curves.points, axis=1)
        away = np.abs(cosine) < 0.7
        error = geodesic_curvature(curves, window=0.3) - cosine / np.sqrt(1 - cosine**2)
        errors.append(np.sqrt(np.mean(error[away] ** 2)))
    # the turning is piecewise constant data: half the edge, at least about half the error
    assert errors[1] < 0.6 * errors[0]
    assert errors[2] < 0.6 * errors[1]


def test_meridians_are_straight_and_end_at_the_poles():
    mesh = sphere(5)
    flags = poles(mesh)
    curves = streamlines(towards_pole(mesh), separation=0.06, singular=flags)
    assert not curves.closed.any()
    cosine = curves.points[:, 2] / np.linalg.norm(curves.points, axis=1)
    curvature = geodesic_curvature(curves)
    assert np.abs(curvature[np.abs(cosine) < 0.9]).max() < 0.35
    assert np.abs(np.mean(curvature)) < 0.01
    longest = int(np.argmax(curves.lengths))
    assert curves.lengths[longest] > 0.97 * np.pi
    tips = curves[longest].points[[0, -1]]
    to_pole = np.linalg.norm(tips[:, None] - mesh.vertices[flags], axis=2).min(axis=1)
    assert to_pole.max() < 1.5 * mesh.mean_edge


def test_lines_end_at_the_guard_of_a_singular_vertex():
    disk = annulus(inner=0.05)
    center = len(disk.vertices)
    loop = next(each for each in disk.boundary_loops if np.linalg.norm(disk.vertices[each[0]]) < 0.5)
    fan = np.stack([np.full(len(loop), center), np.roll(loop, -1), loop], axis=1)
    mesh = TriMesh(np.vstack([disk.vertices, [[0.0, 0.0, 0.0]]]), np.vstack([disk.faces, fan]))
    flags = np.zeros(mesh.n_vertices, dtype=bool)
    flags[center] = True
    curves = streamlines(away_from_axis(mesh), separation=0.02, singular=flags, guard=0.25)
    nearest = np.linalg.norm(curves.points, axis=1).min()
    assert nearest == pytest.approx(0.25 * 0.05, rel=1e-6)
    free = streamlines(away_from_axis(mesh), separation=0.02, singular=np.zeros_like(flags))
    assert np.linalg.norm(free.points, axis=1).min() < 0.5 * nearest


def test_plane_fields_give_circles_and_rays():
    mesh = annulus()
    circles = streamlines(around_axis(mesh), separation=0.05)
    radius = np.linalg.norm(circles.points, axis=1)
    inside = (radius > 0.4) & (radius < 0.9)
    curvature = geodesic_curvature(circles, window=0.15)
    assert circles.closed.mean() > 0.8
    error = (curvature * radius - 1)[inside & circles.closed[circles.curve_of_point]]
    # a faceted field wobbles from face to face; the mean over the window is what must be right
    assert np.sqrt(np.mean(error**2)) < 0.03
    assert abs(np.mean(error)) < 0.005
    rays = streamlines(away_from_axis(mesh), separation=0.05)
    direction = np.arctan2(rays.points[:, 1], rays.points[:, 0])
    for c in range(len(rays)):
        own = np.unwrap(direction[rays.offsets[c] : rays.offsets[c + 1]])
        assert np.ptp(own) < 0.05
    assert np.abs(np.mean(geodesic_curvature(rays))) < 0.02


def test_helices_on_a_cylinder_are_straight():
    mesh = cylinder()
    across = np.cross(mesh.face_normals, [0.0, 0.0, 1.0])
    curves = streamlines(FaceField.from_ambient(mesh, across + np.array([0.0, 0.0, 0.6])), separation=0.1)
    assert len(curves) > 10
    for curve in curves:
        angle = np.unwrap(np.arctan2(curve.points[:, 1], curve.points[:, 0]))
        slope = np.polyfit(angle, curve.points[:, 2], 1)
        assert abs(slope[0]) == pytest.approx(0.6, rel=0.01)
    # a cylinder of triangles unfolds to the plane, and the field with it, to rounding
    assert np.abs(geodesic_curvature(curves)).max() < 1e-8


def test_a_constant_field_on_a_flat_annulus_gives_straight_chords():
    mesh = annulus()
    curves = streamlines(
        FaceField.from_ambient(mesh, np.tile([1.0, 0.3, 0.0], (mesh.n_faces, 1))), separation=0.05
    )
    assert np.abs(curves.turning).max() < 1e-9
    ends = curves.points[np.concatenate([curves.offsets[:-1], curves.offsets[1:] - 1])]
    radius = np.linalg.norm(ends, axis=1)
    # the boundary is a polygon: its edges lie inside the circle; lines too close together end early
    on_boundary = (np.abs(radius - 0.3) < 0.02) | (radius > 0.98)
    assert on_boundary.mean() > 0.9


def test_walls_end_lines_and_gentle_sinks_are_followed():
    # a strip of squares cut along x = 0; the vectors on both sides lean to the cut
    x, y = np.meshgrid([-1.0, 0.0, 1.0], np.linspace(0, 4, 9), indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    a = (np.arange(2)[:, None] * 9 + np.arange(8)).ravel()
    mesh = TriMesh(points, np.concatenate([np.stack([a, a + 9, a + 10], 1), np.stack([a, a + 10, a + 1], 1)]))
    lean = -np.sign(mesh.barycenters[:, :1])
    gentle = streamlines(FaceField.from_ambient(mesh, lean * [0.2, 0, 0] + [0.0, 1.0, 0.0]), separation=0.4)
    sharp = streamlines(FaceField.from_ambient(mesh, lean * [1.0, 0, 0] + [0.0, 1.0, 0.0]), separation=0.4)
    assert gentle.sliding.any()
    assert np.abs(gentle.points[gentle.sliding, 0]).max() < 1e-12
    assert not sharp.sliding.any()
    ends = sharp.points[sharp.offsets[1:] - 1]
    assert np.abs(ends[:, 0]).min() == 0.0
    # the turning of a slide sums to the turn from the field to the edge
    first = int(np.flatnonzero(gentle.sliding)[0])
    assert abs(gentle.turning[first]) == pytest.approx(np.arctan(0.2), abs=1e-12)


def test_the_same_arguments_give_the_same_lines_at_any_scale():
    field = wavy(sphere(4))
    once, again = streamlines(field, seed=3), streamlines(field, seed=3)
    assert np.array_equal(once.points, again.points)
    assert not np.array_equal(once.offsets, streamlines(field, seed=4).offsets)
    for scale in (2.0**-40, 2.0**40):
        small = TriMesh(field.mesh.vertices * scale, field.mesh.faces)
        lines = streamlines(FaceField(small, field.values), seed=3)
        assert np.allclose(lines.points / scale, once.points, rtol=0, atol=1e-9)


def test_what_cannot_be_traced_is_refused():
    field = around_axis(sphere(1))
    with pytest.raises(FieldError, match="positive length"):
        streamlines(field, separation=0.0)
    with pytest.raises(FieldError, match="share of the separation"):
        streamlines(field, stop=1.5)
    with pytest.raises(FieldError, match="flags of singular vertices"):
        streamlines(field, singular=np.zeros(3, dtype=bool))
    with pytest.raises(FieldError, match="no streamline"):
        streamlines(FaceField(field.mesh, np.zeros(field.mesh.n_faces)), separation=0.1)
    with pytest.raises(FieldError, match="window"):
        geodesic_curvature(streamlines(field), window=-1.0)
