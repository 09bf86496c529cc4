"""Ends go on to a crossing that holds them, and are trimmed there."""

from __future__ import annotations

import numpy as np
from surfaces import lines_on_square

from geoweave.curves.curve_crossings import crossings
from geoweave.curves.straightest_geodesics import straightest
from geoweave.models import shapes
from geoweave.weave.ribbon_ends import (
    extended,
    holding,
    loose_ends,
    off_ideal,
    on_boundary,
    openings_reached,
)
from geoweave.weave.ribbons import Cutting, ribbons


def test_extended_lines_go_on_straight_at_both_ends() -> None:
    line = lines_on_square((-0.2, 0.1, 0.1, 0.2))
    longer, spans = extended(line, 0.3)
    direction = np.array([0.3, 0.1]) / np.hypot(0.3, 0.1)
    np.testing.assert_allclose(longer.points[0, :2], [-0.2, 0.1] - 0.3 * direction, atol=1e-9)
    np.testing.assert_allclose(longer.points[-1, :2], [0.1, 0.2] + 0.3 * direction, atol=1e-9)
    np.testing.assert_allclose(spans, [[0.3, 0.3 + line.lengths[0]]])
    np.testing.assert_allclose(longer.lengths, line.lengths + 0.6)
    # each segment lies in the face it names: both of its ends keep their distance from the face's corners
    corners = longer.mesh.vertices[longer.mesh.faces[longer.faces[:-1]]]
    for tip in (longer.points[:-1], longer.points[1:]):
        areas = [
            np.cross(corners[:, (k + 1) % 3] - corners[:, k], tip - corners[:, k])[:, 2] for k in range(3)
        ]
        assert np.min(areas) > -1e-9


def test_an_end_is_loose_off_the_boundary_and_beyond_its_last_crossing() -> None:
    lines = lines_on_square((-0.4, 0.0, 0.4, 0.0), (0.3, -0.3, 0.3, 0.3))
    met = crossings(lines)
    assert loose_ends(lines, met, 0.2).tolist() == [[True, False], [True, True]]
    assert loose_ends(lines, met, 0.31).tolist() == [[True, False], [False, False]]
    assert loose_ends(lines, met.taken(holding(met, 89.0)), 0.8).tolist() == [[False, False]] * 2
    assert not holding(crossings(lines_on_square((-0.4, 0, 0.4, 0), (-0.4, -0.1, 0.4, 0.1))), 20.0).any()


def test_a_shallow_crossing_holds_no_end() -> None:
    """The first line would be held at its left end by the last one, which it meets at 11 degrees."""
    across = [(x, -0.4, x, 0.4) for x in (-0.1, 0.1, 0.3)]
    across += [(-0.2, y, 0.4, y) for y in (-0.3, 0.3)]
    flat = (-0.4, -0.05, 0.1, 0.05)
    both = lines_on_square((-0.25, 0.0, 0.35, 0.0), *across, flat)
    spacing = float(both.mesh.face_areas.sum() / both.lengths.sum())
    lengths = {"shortest": 0.2, "reach": 0.02, "tail": 0.01, "beside": 0.001}
    lengths = {name: length / spacing for name, length in lengths.items()}
    numbers = Cutting(fewest=1, bare=1e9, **lengths)
    found = ribbons(both, families=1, cutting=numbers)
    ends = found.curves[int(np.flatnonzero(found.origin == 0)[0])].points[[0, -1], 0]
    np.testing.assert_allclose(ends, [-0.11, 0.31], atol=1e-9)
    loosely = Cutting(**{**vars(numbers), "shallowest": 5.0})
    found = ribbons(both, families=1, cutting=loosely)
    ends = found.curves[int(np.flatnonzero(found.origin == 0)[0])].points[[0, -1], 0]
    np.testing.assert_allclose(ends, [-0.16, 0.31], atol=1e-9)


def test_angles_are_compared_with_those_of_evenly_turned_families() -> None:
    angle = np.radians([60.0, -130.0, 90.0, 5.0, 180.0])
    np.testing.assert_allclose(off_ideal(angle, 3), [0, 10, 30, 55, 60], atol=1e-9)
    np.testing.assert_allclose(off_ideal(angle, 2), [30, 40, 0, 85, 90], atol=1e-9)


def test_the_ends_of_a_line_name_the_opening_that_they_reach() -> None:
    tube = shapes.cylinder(faces=400)
    rise = tube.vertices[tube.faces][:, :, 2].mean(axis=1)
    start = int(np.abs(rise).argmin())
    up = np.array([[0.0, 0.1, 1.0]])
    lines = [straightest(tube, [start], way, np.array([length])) for way, length in ((up, 0.1), (-up, 9.0))]
    found = [openings_reached(line).tolist()[0] for line in lines]
    top = [bool(tube.vertices[loop, 2].mean() > 0) for loop in tube.boundary_loops]
    assert found == [[-1, -1], [-1, top.index(False)]]
    longer, _ = extended(lines[0], 9.0)
    assert openings_reached(longer).tolist() == [[top.index(False), top.index(True)]]
    assert on_boundary(longer).tolist() == [[True, True]]
