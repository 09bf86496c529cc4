"""Ribbons: ends hold, what bends or is short goes."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import chain

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse import csgraph
from surfaces import lines_on_square

import geoweave as gw
from geoweave.curves.curves import Curves, geodesic_curvature
from geoweave.curves.nearest_curve import nearest_curves
from geoweave.curves.straightest_geodesics import straightest
from geoweave.curves.stretch import stretches
from geoweave.errors import FieldError
from geoweave.fields.rosy import smoothest_rosy
from geoweave.foliation.foliation import foliate
from geoweave.foliation.level_sets import isolines
from geoweave.models import shapes
from geoweave.weave.cover import branched_cover
from geoweave.weave.ribbons import Cutting, Ribbons, _cut, expected_number, ribbons


@cache
def level_sets(name: str) -> Curves:
    mesh = {
        "torus": lambda: shapes.torus(faces=3000),
        "sphere": lambda: shapes.sphere(faces=3000),
        "square": lambda: shapes.square(faces=2000),
        "genus 3": lambda: shapes.genus_g(3, faces=3000),
    }[name]()
    cover = branched_cover(smoothest_rosy(mesh.normalized()[0], degree=6))
    quotient = cover.quotient
    field = gw.geodesic_field(quotient.field, smoothness=[quotient.mesh.mean_edge**2]).field
    return cover.project(isolines(quotient.lifted(foliate(field, scale=0.7))))


@cache
def made(name: str) -> Ribbons:
    return ribbons(level_sets(name))


NAMES = ("torus", "sphere", "square", "genus 3")


@pytest.mark.parametrize("name", NAMES)
def test_every_end_is_held_and_every_ribbon_has_four_crossings(name: str) -> None:
    found, numbers = made(name), Cutting()
    curves, tail = found.curves, numbers.tail * found.spacing
    open_ones = ~curves.closed
    assert np.bincount(found.crossings.curves.ravel(), minlength=len(found)).min() >= 4
    at = [np.full(len(found), np.inf), np.full(len(found), -np.inf)]
    np.minimum.at(at[0], found.crossings.curves.ravel(), found.crossings.arclength.ravel())
    np.maximum.at(at[1], found.crossings.curves.ravel(), found.crossings.arclength.ravel())
    rim = np.linalg.norm(curves.mesh.vertices[curves.mesh.edges[curves.mesh.boundary_edges]], axis=2)
    for c in np.flatnonzero(open_ones):
        first, last = curves.points[curves.offsets[c]], curves.points[curves.offsets[c + 1] - 1]
        for tip, away in ((first, at[0][c]), (last, curves.lengths[c] - at[1][c])):
            # The square's boundary is where a coordinate is extreme.
            at_rim = len(rim) and np.isclose(np.abs(tip[:2]).max(), np.abs(curves.mesh.vertices[:, :2]).max())
            assert at_rim or away <= tail * (1 + 1e-6), f"ribbon {c} hangs loose"


@pytest.mark.parametrize("name", NAMES)
def test_segments_lie_in_their_faces(name: str) -> None:
    curves = made(name).curves
    mesh = curves.mesh
    running = curves.segment_lengths > 0
    for points in (curves.points, curves.points + curves.segments):
        offset = points[running] - mesh.barycenters[curves.faces[running]]
        normal = mesh.face_normals[curves.faces[running]]
        assert np.abs((offset * normal).sum(axis=1)).max() < 1e-9
        assert (np.linalg.norm(offset, axis=1) < mesh.edge_lengths.max()).all()


@pytest.mark.parametrize("name", NAMES)
def test_crossings_are_those_of_three_families(name: str) -> None:
    """Sixty degrees in the median, as ribbons of a triaxial weave cross."""
    met = made(name).crossings
    angle = np.degrees(np.abs(met.angle))
    assert np.median(np.minimum(angle, 180 - angle)) == pytest.approx(60, abs=6)


@pytest.mark.parametrize("name", NAMES)
def test_little_is_lost_and_ribbons_are_as_straight_as_level_sets(name: str) -> None:
    before, after = level_sets(name), made(name).curves
    assert after.lengths.sum() > 0.9 * before.lengths.sum()
    bending = [
        np.average(np.abs(geodesic_curvature(each)), weights=each.segment_lengths) for each in (before, after)
    ]
    assert bending[1] < 1.05 * bending[0]


def test_what_bends_too_much_is_cut_out() -> None:
    """Of two circles on a diameter the one of curvature 1 / 0.15 goes, that of 1 / 0.6 stays closed."""
    mesh = shapes.disk(faces=4000)
    radius = np.linalg.norm(mesh.vertices, axis=1)
    tail, head = mesh.edges.T
    circles = isolines(gw.CircleFunction(mesh, radius, radius[head] - radius[tail]), [0.15, 0.6])
    assert circles.closed.tolist() == [True, True]
    middle = int(np.argmin(np.linalg.norm(mesh.barycenters, axis=1)))
    both = Curves.concatenate(
        mesh, chain(circles, straightest(mesh, [middle], [[1.0, 0.1, 0.0]], 0.7, behind=0.7))
    )
    spacing = float(mesh.face_areas.sum() / both.lengths.sum())
    numbers = Cutting(sharpest=3.0 * spacing, shortest=1.0, fewest=1, reach=0.2, tail=0.1, bare=1e9)
    found = ribbons(both, families=1, cutting=numbers)
    assert found.origin.tolist() == [1, 2]
    assert found.curves.closed.tolist() == [True, False]
    assert found.curves.lengths[0] == pytest.approx(2 * np.pi * 0.6, rel=0.01)
    # The diameter is trimmed to the circle it crosses twice, and a tail at either end.
    assert found.curves.lengths[1] == pytest.approx(1.2 + 0.2 * spacing, rel=0.01)
    assert len(found.crossings) == 2


@pytest.mark.parametrize("faces", [500, 8000])
@pytest.mark.parametrize(("half", "pieces"), [(10.0, 1), (20.0, 2)])
def test_a_kink_is_cut_by_its_angle_on_a_coarse_mesh_and_on_a_fine_one(
    faces: int, half: float, pieces: int
) -> None:
    """Level sets that turn by 20 or 40 degrees at x = 0; sharpest 1 / d over d / 2 is 29 degrees."""
    mesh = shapes.square(faces=faces)
    x, y, _ = mesh.vertices.T
    value = y + np.tan(np.radians(half)) * np.abs(x)
    tail, head = mesh.edges.T
    bent = isolines(gw.CircleFunction(mesh, value, value[head] - value[tail]), [0.1])
    assert len(bent) == 1
    spacing = 0.4
    found, _ = _cut(bent, Cutting().sharpest / spacing, Cutting().window * spacing, 0.2)
    assert len(found) == pieces
    assert found.lengths.sum() == pytest.approx(bent.lengths.sum(), abs=0.5 * spacing)


@pytest.mark.parametrize(("lens", "met"), [(0.4, 10), (0.04, 8)])
def test_lines_that_touch_do_not_cross(lens: float, met: int) -> None:
    """A line and an arch that meets it twice, so far to the left and right: if near, neither lies above."""
    mesh = shapes.square(faces=8000)
    level = [(-0.8, y, 0.8, y) for y in (-0.4, 0.0, 0.4)]
    frame = lines_on_square(*level, (-0.7, -0.5, -0.7, 0.5), (0.7, -0.5, 0.7, 0.5), mesh=mesh)
    x, y, _ = mesh.vertices.T
    height = y - 0.3 * (lens**2 - x**2)
    tail, head = mesh.edges.T
    arch = isolines(gw.CircleFunction(mesh, height, height[head] - height[tail]), [0.0])
    both = Curves.concatenate(mesh, chain(frame, arch))
    spacing = float(mesh.face_areas.sum() / both.lengths.sum())
    lengths = {"shortest": 0.5, "reach": 0.1, "tail": 0.1, "beside": 1e-4}
    lengths = {name: length / spacing for name, length in lengths.items()}
    numbers = Cutting(sharpest=1e3, fewest=1, shallowest=30.0, bare=1e9, **lengths)
    found = ribbons(both, families=1, cutting=numbers)
    assert len(found) == 6
    assert len(found.crossings) == met


@pytest.mark.parametrize("name", NAMES)
def test_nothing_is_bare_and_the_weave_hangs_together(name: str) -> None:
    found = made(name)
    mesh = found.curves.mesh
    distance, _ = nearest_curves(found.curves, mesh.barycenters, mesh.face_normals)
    # a place with no room for a ribbon may stay bare; there is none of a hundredth of the area here
    assert mesh.face_areas[distance > found.spacing].sum() < 0.01 * mesh.face_areas.sum()
    links = sparse.csr_array(
        (np.ones(len(found.crossings)), tuple(found.crossings.curves.T)), (len(found),) * 2
    )
    assert csgraph.connected_components(links, directed=False)[0] == 1


def test_two_parts_are_joined_or_the_smaller_one_goes() -> None:
    """Two grids that do not cross: joined if a ribbon reaches both, else the smaller one goes."""
    near = _two_grids(apart=0.25)
    joined = ribbons(near, 2, LOOSE)
    assert len(joined) == len(near) + 1
    assert sorted(joined.origin.tolist()) != list(range(len(near)))  # it has the family of a neighbour
    far = _two_grids(apart=0.9)
    assert ribbons(far, 2, LOOSE).origin.tolist() == list(range(10))


LOOSE = Cutting(shortest=0.1, fewest=2, reach=0.06, tail=0.05, beside=1e-3, bare=1e9)
"""For short lines that do not grow."""


def _two_grids(apart: float) -> Curves:
    """Five lines by five on the left, four by four on the right, a tenth from each other."""
    lines = []
    for first, count in ((-0.9, 5), (-0.5 + apart, 4)):
        last = first + 0.1 * (count - 1)
        for k in range(count):
            at = 0.1 * k + 0.013
            lines += [
                (first - 0.02, at, last + 0.02, at),
                (first + 0.1 * k, -0.007, first + 0.1 * k, last - first + 0.033),
            ]
    return lines_on_square(*lines, mesh=shapes.square(faces=4000))


def test_where_no_ribbon_has_four_crossings_fewer_will_do() -> None:
    """Three lines by three: each crosses three others."""
    lines = [(x, -0.4, x, 0.4) for x in (-0.3, 0.013, 0.3)] + [(-0.4, y, 0.4, y) for y in (-0.3, 0.013, 0.3)]
    found = ribbons(lines_on_square(*lines, mesh=shapes.square(faces=4000)), 2, replace(LOOSE, fewest=4))
    assert np.bincount(found.crossings.curves.ravel()).tolist() == [3] * 6
    assert found.cutting.fewest == 3
    with pytest.raises(FieldError, match="none crosses another"):
        ribbons(lines_on_square(*lines[:3], mesh=shapes.square(faces=4000)), 2, LOOSE)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(FieldError, match="degrees"):
        Cutting(shallowest=90.0)
    with pytest.raises(FieldError, match="'reach'"):
        Cutting(reach=0.0)
    with pytest.raises(FieldError, match="tail"):
        Cutting(tail=5.0)
    with pytest.raises(FieldError, match="'apart'"):
        Cutting(apart=(0.5, 0.0))
    with pytest.raises(FieldError, match="larger scale"):
        ribbons(stretches(level_sets("torus"), np.zeros(0, dtype=np.int64)))
    with pytest.raises(FieldError, match="shorter than"):
        ribbons(level_sets("torus"), cutting=Cutting(shortest=1e6))


def test_numbers_seen_from_another_spacing_are_the_same_lengths() -> None:
    given = Cutting(fewest=6)
    seen = given.seen_from(1.5)
    for name, value in vars(given).items():
        if name in ("shallowest", "beside"):  # an angle, and what is judged at the spacing that is there
            assert getattr(seen, name) == value
        else:
            power = -1.0 if name == "sharpest" else 1.0
            np.testing.assert_allclose(getattr(seen, name), np.multiply(value, 1.5**power))
    assert given.seen_from(1e-3).fewest == 1
    # What stands for closer level sets would all be bare, and a ribbon laid through each place of it.
    assert given.seen_from(0.1).bare == given.bare


def test_as_many_are_expected_at_the_same_spacing_and_about_half_at_half_the_number() -> None:
    leaves, number = level_sets("sphere"), len(made("sphere"))
    assert expected_number(leaves, 3, Cutting(), 1.0) == number
    assert 0.3 * number < expected_number(leaves, 3, Cutting(), 0.5) < 0.7 * number
    assert expected_number(leaves, 3, Cutting(), 1e-3) == 0.0


def test_a_dense_weave_is_expected_without_filling_what_lies_between_level_sets() -> None:
    """Twice, and a million times, the level sets are as many times the ribbons, or a little more."""
    leaves, number = level_sets("sphere"), len(made("sphere"))
    for share in (2.0, 1e6):
        assert number <= expected_number(leaves, 3, Cutting(), share) / share < 1.5 * number
