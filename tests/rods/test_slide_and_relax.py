from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rodded import THIN, any_rotation, bar, circle, rods_of, three_great_circles

from geoweave.errors import RodError
from geoweave.models.shapes import sphere
from geoweave.rods.contact_places import replaced_contacts
from geoweave.rods.departure import fitted, held
from geoweave.rods.elastic_energies import edgewise_bending
from geoweave.rods.equilibrium import Stepping, minimized
from geoweave.rods.from_ribbons import rods_of_file
from geoweave.rods.rod_file import read_rods
from geoweave.rods.rods import DERIVED, Contacts
from geoweave.rods.slide_and_relax import (
    Springs,
    relax_rods,
    relaxing_terms,
    slide_rods,
    vertex_masses,
)
from geoweave.surface.closest_point import closest_points, triangle_tree

PEER = Path(__file__).resolve().parents[3] / "shared" / "peer"


def test_contacts_of_the_three_rings_are_where_they_cross():
    rods = three_great_circles()
    one, two = (rods.points[rods.layout.ends[rods.contacts.segments[:, k], 0]] for k in (0, 1))
    np.testing.assert_allclose(one, two, atol=1e-12)


def test_three_rings_relax_and_hold_their_shape():
    rods = three_great_circles(tilt=0.01)
    seen = []
    found = relax_rods(rods, callback=seen.append)
    assert found.converged
    assert found.gradient <= 1e-6
    assert found.steps == tuple(replace(step, rods=None) for step in seen)
    assert seen[-1].rods is not None
    np.testing.assert_array_equal(seen[-1].rods.points, found.rods.points)
    energies = np.array([step.energy for step in found.steps])
    assert (np.diff(energies) < 1e-12 * energies[0]).all()
    shifted = np.linalg.norm(fitted(found.rods, rods) - rods.points, axis=1)
    assert shifted.max() < 0.05 * 2 * np.sqrt(3)
    # what holds it: in each contact the ribbons lie flush
    pair = found.rods.directors[found.rods.contacts.segments]
    np.testing.assert_allclose((pair[:, 0] * pair[:, 1]).sum(1), 1, atol=1e-9)


def test_the_upper_ring_lies_a_thickness_above():
    found = relax_rods(three_great_circles())
    rods = found.rods
    start = rods.points[rods.layout.ends[rods.contacts.segments, 0]]
    height = ((start[:, 1] - start[:, 0]) * rods.directors[rods.contacts.segments[:, 0]]).sum(1)
    # the contact is a spring: it gives way to the bending of the rings by a share of the thickness
    assert (height > 0.5 * THIN.thickness).all()
    assert (height < 1.2 * THIN.thickness).all()
    stiff = relax_rods(three_great_circles(), springs=Springs(position=1e5)).rods
    start = stiff.points[stiff.layout.ends[stiff.contacts.segments, 0]]
    height = ((start[:, 1] - start[:, 0]) * stiff.directors[stiff.contacts.segments[:, 0]]).sum(1)
    np.testing.assert_allclose(height, THIN.thickness, rtol=0.02)


def test_nothing_pulls_to_a_surface_without_contacts():
    # without its contacts a ribbon unravels into a straight, flat strip (E.2)
    line = circle(20)[:14]
    rods = rods_of([line], line[:-1] + line[1:])
    found = relax_rods(rods)
    assert found.converged
    ends = found.rods.points[-1] - found.rods.points[0]
    assert np.linalg.norm(ends) == pytest.approx(rods.rest.sum(), rel=1e-6)


def test_weight_needs_something_to_stand_on():
    rods = three_great_circles()
    with pytest.raises(RodError, match="nothing holds the weave against gravity"):
        relax_rods(rods, gravity=[0, 0, -1.0])
    with pytest.raises(RodError, match="three finite numbers"):
        relax_rods(rods, gravity=[0, -1.0])
    assert relax_rods(rods, gravity=[0, 0, 0]).converged


def test_a_standing_weave_sinks_under_its_weight_and_its_feet_stay():
    rods = three_great_circles()
    feet = rods.points[:, 2] < -0.98
    still = relax_rods(rods, fixed=feet)
    heavy, heavier = (replace(rods, material=replace(THIN, density=rho)) for rho in (2e-2, 4e-2))
    found, more = (relax_rods(each, fixed=feet, gravity=[0, 0, -1.0]) for each in (heavy, heavier))
    assert still.converged
    assert found.converged
    assert more.converged
    np.testing.assert_array_equal(found.rods.points[feet], rods.points[feet])
    masses = vertex_masses(heavy)
    assert masses.sum() == pytest.approx(2e-2 * 0.002 * 0.04 * rods.rest.sum())
    share = masses / masses.sum()
    once, twice = (share @ (still.rods.points - each.rods.points)[:, 2] for each in (found, more))
    assert once > 1e-5
    assert twice == pytest.approx(2 * once, rel=0.01)


def test_fixed_vertices_are_flags():
    with pytest.raises(RodError, match="fixed vertices are 4 flags"):
        relax_rods(bar(3), fixed=np.array([0, 1]))


def test_sliding_straightens_a_wobbly_arc_and_keeps_it_flush():
    ball = sphere(1280)
    angle = np.linspace(0, 4, 40)
    line = np.column_stack([np.cos(angle), np.sin(angle), 0.05 * np.sin(5 * angle)])
    tree = triangle_tree(ball.vertices[ball.faces])
    line, _ = closest_points(tree, line)
    rods = rods_of([line], 0.5 * (line[1:] + line[:-1]), width=0.04, material=THIN)
    edgewise = edgewise_bending(rods.layout)
    found = slide_rods(rods, ball, rounds=4)
    assert found.converged
    assert edgewise.energy(found.rods) < 0.1 * edgewise.energy(rods)
    near, faces = closest_points(tree, found.rods.points)
    assert np.linalg.norm(near - found.rods.points, axis=1).max() < 0.01
    assert ((found.rods.directors * ball.face_normals[faces[:-1]]).sum(1) > 0.98).all()


def test_ends_of_ribbons_do_not_slip_off_the_ribbons_on_which_they_end():
    # a bar that ends on two others, a hair beyond them: alone it would straighten and leave them
    ball = sphere(1280)
    tree = triangle_tree(ball.vertices[ball.faces])
    across = np.linspace(-0.6, 0.6, 25)
    up = np.linspace(-0.3, 0.3, 13)
    bent = np.column_stack([across, 0.1 * np.sin(5 * across), 1 + 0 * across])
    sides = [np.column_stack([0 * up + x, up, 1 + 0 * up]) for x in (-0.59, 0.59)]
    lines = [closest_points(tree, line)[0] for line in (bent, *sides)]
    normals = np.concatenate([line[1:] + line[:-1] for line in lines])
    free = rods_of(lines, normals, width=0.04, material=THIN)
    guess = Contacts([[0, 24 + 6], [23, 36 + 6]], np.full((2, 2), 0.5), [0, 1])
    rods = replace(free, contacts=guess)
    rods = replace(rods, contacts=replaced_contacts(rods))
    slid = slide_rods(rods, ball).rods
    start = slid.points[slid.layout.ends[slid.contacts.segments, 0]]
    at = start + slid.contacts.places[..., None] * slid.edges[slid.contacts.segments]
    assert np.linalg.norm(at[:, 0] - at[:, 1], axis=1).max() < 0.01


def test_a_surface_can_be_slid_on_for_so_many_rounds():
    with pytest.raises(RodError, match="one round or more"):
        slide_rods(three_great_circles(), sphere(80), rounds=0)


@pytest.mark.parametrize("name", ["normal", "tangential", "position", "orientation"])
def test_the_constants_are_the_papers_and_no_nonsense(name):
    assert (
        getattr(Springs(), name)
        == {"normal": 1e3, "tangential": 1, "position": 1e3, "orientation": 1e6}[name]
    )
    with pytest.raises(RodError, match=name):
        Springs(**{name: -1.0})


def test_terms_without_contacts_are_the_elastic_ones():
    assert [term.name for term in relaxing_terms(bar(3))] == [
        "stretching",
        "normal curvature",
        "geodesic curvature",
        "twist",
    ]
    assert len(relaxing_terms(three_great_circles())) == 7


def test_relaxing_commutes_with_rigid_motion():
    rods = three_great_circles(24, tilt=0.01)
    rotation, shift = any_rotation(), np.array([2.0, -1, 3])
    moved = replace(
        rods, points=rods.points @ rotation.T + shift, directors=rods.directors @ rotation.T, edges=DERIVED
    )
    one, two = relax_rods(rods), relax_rods(moved)
    np.testing.assert_allclose(two.rods.points, one.rods.points @ rotation.T + shift, atol=1e-4)


def test_soft_contacts_at_first_change_neither_the_end_nor_the_energies_told():
    rods = three_great_circles(24, tilt=0.01)
    terms = relaxing_terms(rods)
    found, direct = relax_rods(rods), minimized(rods, terms)
    assert found.converged
    assert direct.converged
    assert found.energies == pytest.approx(direct.energies, rel=1e-4, abs=1e-7)
    assert found.steps[0].energies == pytest.approx({term.name: term.energy(rods) for term in terms})
    assert [step.number for step in found.steps] == list(range(len(found.steps)))


def test_it_says_when_it_does_not_converge():
    assert not relax_rods(three_great_circles(tilt=0.01), stepping=Stepping(most_steps=1)).converged


@pytest.mark.skipif(not PEER.is_dir(), reason="RibbonSim's files are not beside the checkout")
@pytest.mark.parametrize("name", ["cone60", "torus7"])
def test_peers_relax_and_stay_near_their_shape(name):
    rods = rods_of_file(read_rods(PEER / f"{name}.rod"))
    found = relax_rods(rods)
    assert found.converged
    diagonal = np.linalg.norm(np.ptp(rods.points, axis=0))
    shifted = np.linalg.norm(fitted(found.rods, rods) - rods.points, axis=1) / diagonal
    # between the outermost crossings of each rod: torus7 has free tails of up to eight segments
    assert shifted[held(rods)].max() < 0.05
    assert shifted.mean() < 0.02
