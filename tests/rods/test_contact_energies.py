from dataclasses import replace

import numpy as np
import pytest
from rodded import MATERIAL

from geoweave.rods.contact_energies import KEPT, contact_orientation, contact_position, contact_side
from geoweave.rods.rods import DERIVED, Contacts


def two_bars(height, angle=0.0, *, over=1):
    """Two crossing bars, the second at a height and turned about the first; a contact in the middle."""
    from rodded import rods_of

    line = np.linspace(-1, 1, 4)
    one = np.column_stack([line, 0 * line, 0 * line])
    two = np.column_stack([0 * line, line, 0 * line + height])
    tilt = np.array([np.sin(angle), 0.0, np.cos(angle)])
    normals = np.concatenate([np.tile([0.0, 0, 1], (3, 1)), np.tile(tilt, (3, 1))])
    return rods_of([one, two], normals, contacts=Contacts([[1, 4]], [[0.5, 0.5]], [over]))


def test_a_contact_holds_the_upper_rod_a_thickness_above():
    h = MATERIAL.thickness
    for height, over, gap in ((h, 1, 0), (-h, 0, 0), (0, 1, h), (h, 0, 2 * h), (3 * h, 1, 2 * h)):
        rods = two_bars(height, over=over)
        # the paper's two squares, with no half in front
        assert contact_position(rods, 7.0).energy(rods) == pytest.approx(7.0 * 2 * gap**2, abs=1e-18)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 0.0099, 0.0101, 0.5, 1.2, np.pi - 0.3])
def test_a_contact_makes_ribbons_lie_flush(angle):
    rods = two_bars(0.01, angle)
    # a strip has no upper side: the angle to the nearer of tau and -tau
    least = min(angle, np.pi - angle)
    assert contact_orientation(rods, 5.0).energy(rods) == pytest.approx(5.0 * least**2, rel=1e-9, abs=1e-25)


def test_the_barrier_acts_only_near_a_change_of_sign():
    rods = two_bars(0.01)
    term = contact_side(rods, 2.0)
    assert term.energy(rods) == 0

    def turned(angle):
        """The second bar turned in the plane from a right angle by an angle, as a step would turn it."""
        way = np.linspace(-1, 1, 4)
        second = np.column_stack([way * np.sin(angle), way * np.cos(angle), 0 * way])
        points = np.concatenate([rods.points[:4], second])
        return replace(rods, points=points, edges=DERIVED)

    assert term.energy(turned(1.2)) == 0  # its sine is 0.36
    sine = 0.1
    expected = (KEPT / sine - 1) ** 2
    assert term.energy(turned(np.arccos(sine))) == pytest.approx(expected)
    assert term.energy(turned(np.pi / 2 + 0.01)) == np.inf
