"""Places are told in the unit and with the names of the weave, the worst first."""

from __future__ import annotations

import numpy as np
from laidlines import laid

from geoweave.weave.places import KINDS, places


def test_places_come_worst_first_in_the_unit_of_the_weave() -> None:
    weave = laid([(0, 0.0, 0.02), (90, 0.3, 0.0)], unit=10.0)
    points = np.array([[0.1, 0.2, 0.0], [0.3, 0.0, 0.0]])
    for least_first in (True, False):
        one, other = places(weave, "gap", points, [(0,), (0, 1)], np.array([2.0, 1.0]), least_first)
        assert (one.value < other.value) == least_first
        worst = other if least_first else one
        np.testing.assert_allclose(worst.point, [1.0, 2.0, 0.0])
        assert worst.ribbons == (weave.names[0],)
        assert worst.kind in KINDS
