from dataclasses import replace

import numpy as np
import pytest
from rodded import circle

from geoweave.curves.curve_crossings import crossings
from geoweave.curves.curves import Curves
from geoweave.curves.straightest_geodesics import straightest
from geoweave.errors import RodError
from geoweave.models.shapes import sphere
from geoweave.rods.from_ribbons import ends_on, file_of_rods, rods_of_file, rods_of_ribbons
from geoweave.rods.rod_file import Rod, RodCrossing, RodFile, read_rods, write_rods
from geoweave.rods.slide_and_relax import relax_rods
from geoweave.weave.interlacing import optimal
from geoweave.weave.passages import Passages
from geoweave.weave.ribbons import Cutting, Ribbons


def bar(points, directors=None, **options):
    points = np.array(points, dtype=float)
    count = len(points) if options.get("closed") else len(points) - 1
    if directors is None:
        directors = np.tile([0.0, 0, 1], (count, 1))
    return Rod(points, directors, np.full(count, 0.1), **options)


def cross_of_two(**options):
    line = np.linspace(-1, 1, 5)
    one = np.column_stack([line, 0 * line, 0 * line])
    two = np.column_stack([0 * line, line, 0 * line])
    return RodFile(
        (bar(one, **options), bar(two)), (RodCrossing((0, 1), (1, 2), (0.75, 0.25)),), 0.01, 1e6, 1.0
    )


def ball_of_rings():
    """Four geodesics about a ball, open, with all their crossings."""
    ball = sphere(1280)
    faces = np.array([0, 200, 500, 900])
    headings = np.random.default_rng(0).normal(size=(4, 3))
    curves = straightest(ball, faces, headings, 5.0)
    met = crossings(curves)
    return ball, Ribbons(curves, met, np.arange(4), 0.5, Cutting())


def test_a_file_becomes_rods_and_a_file_again(tmp_path):
    file = cross_of_two()
    rods = rods_of_file(file, over=[1])
    again = file_of_rods(rods)
    assert again.crossings == file.crossings
    assert (again.thickness, again.young, again.density) == (0.01, 1e6, 1.0)
    for a, b in zip(again.rods, file.rods, strict=True):
        np.testing.assert_array_equal(a.centerline, b.centerline)
        np.testing.assert_allclose(abs((a.directors * b.directors).sum(1)), 1)
    write_rods(tmp_path / "relaxed.rod", file_of_rods(relax_rods(rods).rods))
    assert len(read_rods(tmp_path / "relaxed.rod").rods) == 2


def test_directors_of_a_file_are_lines():
    flipped = np.tile([0.0, 0, 1], (4, 1)) * np.array([1, -1, -1, 1])[:, None]
    line = np.linspace(-1, 1, 5)
    one = bar(np.column_stack([line, 0 * line, 0 * line]), flipped)
    file = replace(cross_of_two(), rods=(one, cross_of_two().rods[1]))
    rods = rods_of_file(file)
    np.testing.assert_allclose(rods.directors, rods.directors[:1].repeat(8, axis=0), atol=1e-12)
    np.testing.assert_allclose(rods.twists, 0, atol=1e-12)


def test_angles_of_a_file_turn_its_directors():
    rods = rods_of_file(cross_of_two(angles=np.full(4, 0.3)))
    angle = np.degrees(np.arccos(abs(rods.directors[0, 2])))
    assert angle == pytest.approx(np.degrees(0.3))


def test_the_side_that_a_file_does_not_say_is_the_best_one():
    file = cross_of_two()
    assert rods_of_file(file).contacts.over.tolist() == optimal(file.placed()).over.tolist()
    with pytest.raises(RodError, match="zeros and ones"):
        rods_of_file(file, over=[2])


def test_coinciding_vertices_and_spikes_are_merged_and_crossings_keep_their_place():
    line = [[-1, 0, 0], [-0.5, 0, 0], [-0.5 + 1e-9, 0, 0], [0, 0, 0], [0.4, 0, 0], [0.3, 0, 0], [1, 0, 0]]
    whole = cross_of_two()
    file = replace(
        whole, rods=(bar(line), whole.rods[1]), crossings=(RodCrossing((0, 1), (2, 2), (0.5, 0.0)),)
    )
    rods = rods_of_file(file)
    assert (rods.lengths > 1e-3).all()
    segment, place = rods.contacts.segments[0, 0], rods.contacts.places[0, 0]
    start, end = rods.points[rods.layout.ends[segment]]
    np.testing.assert_allclose((1 - place) * start + place * end, [-0.25, 0, 0], atol=1e-6)
    assert relax_rods(rods).converged


def test_a_rod_of_one_place_is_refused_by_name():
    tiny = bar([[0, 0, 0], [1e-3, 0, 0], [0, 0, 0]], closed=False)
    file = replace(cross_of_two(), rods=(cross_of_two().rods[0], tiny), crossings=())
    with pytest.raises(RodError, match="rod 1 is too short"):
        rods_of_file(file)
    with pytest.raises(RodError, match="no rod in the file"):
        rods_of_file(replace(file, rods=()))


def test_two_crossings_at_one_place_become_one():
    whole = cross_of_two()
    twice = replace(whole, crossings=(*whole.crossings, RodCrossing((0, 1), (1, 2), (0.78, 0.26))))
    rods = rods_of_file(twice)
    assert len(rods.contacts) == 1
    assert rods.contacts.group.tolist() == [0, 0]


def test_ribbons_become_equal_segments_on_the_surface():
    _, ribbons = ball_of_rings()
    rods = rods_of_ribbons(ribbons, np.zeros(len(ribbons.crossings)), 0.05, 0.002, segment=0.1)
    np.testing.assert_allclose(rods.rest, 0.1, rtol=0.01)
    assert (abs(np.linalg.norm(rods.points, axis=1) - 1) < 0.01).all()
    outward = rods.points[rods.layout.ends].mean(axis=1)
    outward /= np.linalg.norm(outward, axis=1)[:, None]
    assert ((outward * rods.directors).sum(1) > 0.99).all()
    assert len(rods.contacts) == len(ribbons.crossings) > 5
    start, end = rods.points[rods.layout.ends[rods.contacts.segments]].transpose(2, 0, 1, 3)
    place = rods.contacts.places[..., None]
    at = (1 - place) * start + place * end
    np.testing.assert_allclose(at[:, 0], ribbons.crossings.points, atol=0.01)
    np.testing.assert_allclose(at[:, 1], ribbons.crossings.points, atol=0.01)


def test_ribbons_relax_near_their_surface():
    ball, ribbons = ball_of_rings()
    met = ribbons.crossings
    sides = optimal(Passages(met.curves, met.arclength, ribbons.curves.closed)).over
    found = relax_rods(rods_of_ribbons(ribbons, sides, 0.05, 0.002, segment=0.15))
    assert found.converged
    assert isinstance(ribbons.curves, Curves)
    assert ball.n_faces == 1280


@pytest.mark.parametrize(("width", "words"), [(0.0, "width"), (np.nan, "width"), (0.001, "not as wide")])
def test_widths_that_make_no_ribbon_are_refused(width, words):
    _, ribbons = ball_of_rings()
    with pytest.raises(RodError, match=words):
        rods_of_ribbons(ribbons, np.zeros(len(ribbons.crossings)), width, 0.002)


def test_the_ends_on_a_boundary():
    rods = rods_of_file(cross_of_two())
    flags = ends_on(rods, np.array([[-1.0, 0, 0.01], [0, 1.0, 0]]), 0.05)
    assert np.flatnonzero(flags).tolist() == [0, 9]
    assert circle(3).shape == (3, 3)
