from dataclasses import replace

import numpy as np
import pytest
from rodded import bar, crumpled, rods_of, three_great_circles

from geoweave.errors import RodError
from geoweave.rods.contact_energies import contact_position
from geoweave.rods.crossing_forces import ContactForces, contact_forces
from geoweave.rods.elastic_energies import elastic_terms
from geoweave.rods.rods import Contacts
from geoweave.rods.slide_and_relax import Springs, relax_rods, relaxing_terms


def tilted():
    """Three rings about a ball that bend within it, at rest."""
    rods = three_great_circles(tilt=0.01)
    found = relax_rods(rods)
    assert found.converged
    return found.rods


def on_rods(rods, forces):
    """(R, 3) sum of the forces of contacts on each rod."""
    sums = np.zeros((len(rods), 3))
    owner = rods.layout.rod_of_segment[rods.contacts.segments]
    for c, force in enumerate(forces.on_upper):
        over = rods.contacts.over[c]
        sums[owner[c, over]] += force
        sums[owner[c, 1 - over]] -= force
    return sums


def test_at_rest_the_forces_on_every_ribbon_sum_to_zero():
    rods = tilted()
    forces = contact_forces(rods)
    size = np.linalg.norm(forces.on_upper, axis=1)
    assert size.min() > 0
    assert np.abs(on_rods(rods, forces)).max() < 1e-4 * size.max()


def test_a_force_is_minus_the_elastic_gradient_of_its_ribbon_there():
    """Between two contacts nothing acts on a rod, so what its inner forces leave over belongs to a contact.

    This does not use the energy of contacts at all.
    """
    rods = tilted()
    forces, layout = contact_forces(rods), rods.layout
    inner = sum(term.gradient(rods) for term in elastic_terms(layout))[: 3 * layout.vertices].reshape(-1, 3)
    for c in range(len(rods.contacts)):
        for k in (0, 1):
            segment = rods.contacts.segments[c, k]
            rod = layout.rod_of_segment[segment]
            first, past = layout.offsets[rod], layout.offsets[rod + 1]
            near = first + (layout.ends[segment, 0] - first + np.arange(-3, 5)) % (past - first)
            own = inner[near].sum(axis=0)
            sign = 1.0 if rods.contacts.over[c] == k else -1.0
            assert own == pytest.approx(sign * forces.on_upper[c], abs=1e-4 * np.abs(forces.on_upper).max())


def test_forces_are_the_derivative_by_a_shift_of_one_ribbon():
    rods = crumpled()
    forces = contact_forces(rods, Springs(position=50.0))
    term = contact_position(rods, 50.0)
    shifted = np.zeros(rods.size)
    layout = rods.layout
    shifted[: 3 * layout.vertices].reshape(-1, 3)[layout.rod_of_vertex == 0] = [1e-6, 0.0, 0.0]
    slope = (term.energy(rods.stepped(shifted)) - term.energy(rods.stepped(-shifted))) / 2e-6
    owner = layout.rod_of_segment[rods.contacts.segments]
    total = 0.0
    for c, force in enumerate(forces.on_upper):
        upper = owner[c, rods.contacts.over[c]]
        lower = owner[c, 1 - rods.contacts.over[c]]
        total += (force[0] if upper == 0 else 0.0) - (force[0] if lower == 0 else 0.0)
    assert total == pytest.approx(-slope, rel=1e-6)


def crossed(gap, shift=0.0, over=1):
    """Two bars that cross square, the second higher by a gap and shifted along the first."""
    one, other = bar(4, 1.0), bar(4, 1.0)
    turned = other.points[:, [1, 0, 2]] + np.array([0.5 + shift, -0.5, gap])
    contacts = Contacts([[1, 5]], [[1.0, 1.0]], [over])
    return rods_of([one.points, turned], np.array([0.0, 0.0, 1.0]), contacts=contacts)


def test_ribbons_nearer_than_their_thickness_press_and_farther_ones_pull():
    near, far = contact_forces(crossed(0.004)), contact_forces(crossed(0.02))
    assert near.normals[0].tolist() == [0.0, 0.0, 1.0]
    assert near.separation[0] == pytest.approx(-4 * 1e3 * (0.01 - 0.004))
    assert far.separation[0] == pytest.approx(4 * 1e3 * (0.02 - 0.01))
    assert near.friction[0] == pytest.approx(0.0)
    assert far.friction[0] == np.inf
    # the upper one is the first now, and lies too low by 0.014
    below = contact_forces(crossed(0.004, over=0))
    assert below.normals[0].tolist() == [0.0, 0.0, 1.0]
    assert below.separation[0] == pytest.approx(-4 * 1e3 * 0.014)


def test_friction_is_sliding_over_pressing():
    forces = contact_forces(crossed(0.004, shift=0.003))
    assert forces.sliding[0] == pytest.approx(4 * 1e3 * 0.003)
    assert forces.friction[0] == pytest.approx(0.5)
    assert forces.fasten(0.49).tolist() == [0]
    assert forces.fasten(0.51).tolist() == []
    assert forces.lacking(0.25)[0] == pytest.approx(0.5 * forces.sliding[0])


def made(pairs):
    """Forces with these separations and slidings."""
    apart, along = np.array(pairs, dtype=float).T
    flat = np.zeros_like(apart)
    return ContactForces(np.column_stack([along, flat, -apart]), np.tile([0.0, 0.0, 1.0], (len(apart), 1)))


def test_the_greatest_need_comes_first_and_what_holds_by_itself_is_left_out():
    forces = made([(-1, 0.2), (3, 0), (-1, 5), (0.5, 0), (0, 0)])
    assert forces.friction.tolist() == [0.2, np.inf, 5.0, np.inf, 0.0]
    assert forces.fasten(0.3).tolist() == [2, 1, 3]
    assert forces.fasten(6.0).tolist() == [1, 3]
    assert forces.fasten(0.1).tolist() == [2, 1, 0, 3]
    with pytest.raises(RodError, match="zero or a positive number"):
        forces.fasten(-1.0)


def test_percentiles_count_what_no_friction_holds():
    forces = made([(-1, share) for share in (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)] + [(1, 0)] * 2)
    assert forces.percentiles() == (0.6, 0.8, np.inf)
    assert forces.percentiles(forces.fasten(0.75)) == (0.4, 0.6, 0.7)
    said = forces.document(0.75)
    assert said["needed"] == {"p50": 0.6, "p75": 0.8, "p90": None}
    assert (said["pulled_apart"], said["fasten"], said["contacts"]) == (2, 3, 10)


def test_rods_without_contacts_need_nothing():
    forces = contact_forces(bar(4))
    assert len(forces) == 0
    assert forces.percentiles() == (0.0, 0.0, 0.0)
    assert forces.document()["fasten"] == 0


def test_a_mirror_image_has_the_same_forces():
    """Over and under are exchanged where the thickness directions are turned."""
    rods = tilted()
    flipped = replace(
        rods,
        directors=-rods.directors,
        contacts=replace(rods.contacts, over=1 - rods.contacts.over),
    )
    one, other = contact_forces(rods), contact_forces(flipped)
    np.testing.assert_allclose(one.separation, other.separation, atol=1e-9 * np.abs(one.on_upper).max())


def test_stiffer_contacts_hold_the_same_rods_with_nearly_the_same_forces():
    """The paper's contacts are springs; their give changes the shape at rest, and so the forces, a little."""
    rods = tilted()
    stiff = Springs(position=1e5)
    harder = relax_rods(rods, springs=stiff)
    assert harder.converged
    assert sum(term.energy(harder.rods) for term in relaxing_terms(harder.rods, stiff)) > 0
    one, other = contact_forces(rods), contact_forces(harder.rods, stiff)
    assert np.abs(one.on_upper - other.on_upper).max() < 0.5 * np.abs(other.on_upper).max()
