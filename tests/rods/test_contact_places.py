"""Contacts follow ribbons that slide, unless they hold."""

from dataclasses import replace

import numpy as np
from rodded import grid, ring, rods_of

from geoweave.rods.contact_places import chosen, outermost, replaced_contacts
from geoweave.rods.rods import DERIVED, Contacts


def test_contacts_follow_ribbons_that_slide():
    line = np.linspace(-1, 1, 21)
    one = np.column_stack([line, 0 * line, 0 * line])
    two = np.column_stack([0 * line, line, 0 * line])
    rods = rods_of([one, two], np.array([0, 0, 1.0]), contacts=Contacts([[10, 30]], [[0.0, 0.0]], [1]))
    points = rods.points.copy()
    points[21:] += [0.13, 0.04, 0.0]
    moved = replace(rods, points=points, edges=DERIVED)
    found = replaced_contacts(moved)
    assert found.segments.tolist() == [[11, 29]]
    np.testing.assert_allclose(found.places, [[0.3, 0.6]], atol=1e-9)
    still = replaced_contacts(moved, np.array([True]))
    assert still.segments.tolist() == [[10, 30]]
    assert len(replaced_contacts(ring(5))) == 0


def test_the_outermost_contacts_are_those_at_the_ends_of_open_rods():
    rods = grid()
    # only the one in the middle is neither the first nor the last of a bar
    assert np.flatnonzero(~outermost(rods)).tolist() == [4]
    assert len(chosen(rods.contacts, ~outermost(rods))) == 1
    assert not outermost(ring(5)).any()
